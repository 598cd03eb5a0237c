//! A measured supply that varies: with the command it is sag, else a property of the supply.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;

/// Least standard deviation as a share of the mean: a tenth of the usual tolerance of supplies, 10 %.
const VARIES: f64 = 0.01;
/// Sag: the absolute command explains at least this share of the variance.
const FOLLOWS: f64 = 0.25;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let Some(column) = run.measured_supply_v.as_ref() else {
        return Vec::new();
    };
    // Samples may lack the measured value.
    let pairs: Vec<(f64, f64)> = (column.iter().zip(&run.command))
        .filter(|(supply_v, _)| supply_v.is_finite())
        .map(|(supply_v, command)| (*supply_v, command.abs()))
        .collect();
    let samples = pairs.len().max(1) as f64;
    let mean_v = pairs.iter().map(|pair| pair.0).sum::<f64>() / samples;
    let mean_command = pairs.iter().map(|pair| pair.1).sum::<f64>() / samples;
    let (mut vv, mut uv, mut uu) = (0.0, 0.0, 0.0);
    let (mut least_v, mut most_v, mut largest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for &(supply_v, command) in &pairs {
        let (dv, du) = (supply_v - mean_v, command - mean_command);
        (vv, uv, uu) = (vv + dv * dv, uv + du * dv, uu + du * du);
        (least_v, most_v) = (least_v.min(supply_v), most_v.max(supply_v));
        largest = largest.max(command);
    }
    let deviation_v = (vv / samples).sqrt();
    if pairs.is_empty() || deviation_v <= VARIES * mean_v {
        return Vec::new();
    }
    let explained = if uu > 0.0 { uv * uv / (uu * vv) } else { 0.0 };
    let sags = explained > FOLLOWS && uv < 0.0;
    let falls_v = if sags { -uv / uu * largest } else { 0.0 };
    let how = if sags {
        format!(
            "it falls by {falls_v:.2} V at the largest command, which explains {:.0} % of that",
            100.0 * explained
        )
    } else {
        format!(
            "the size of the command explains {:.0} % of that: it is no sag under load",
            100.0 * explained
        )
    };
    vec![subject.finding(
        Kind::SupplyVaries,
        Severity::Note,
        subject.whole(),
        format!(
            "the measured supply is {mean_v:.2} V and varies by {deviation_v:.2} V (standard deviation; \
             {least_v:.1} to {most_v:.1} V); {how}"
        ),
        [
            ("mean_v", mean_v),
            ("deviation_v", deviation_v),
            ("falls_at_largest_command_v", falls_v),
            ("explained_by_command", explained),
        ],
        "record from a supply that holds, or keep the column: it tells a sag from the motor's own faults",
    )]
}
