//! Voltage commands above the driver's supply.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use crate::recording::CommandKind;

/// Tolerance of the supply: commands up to 10 % above it pass, as the contract of `check` states.
const ALLOWED: f64 = 0.1;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let of_motor = subject.motor.map(|motor| motor.parameters.supply_v);
    let Some(stated_v) = run.supply_v.or(of_motor) else {
        return Vec::new();
    };
    if run.command_kind != CommandKind::Voltage || !subject.has("command") {
        return Vec::new();
    }
    // A measured supply above the stated one replaces it.
    let supply_v = |sample: usize| {
        let measured = run.measured_supply_v.as_ref().and_then(|v| v.get(sample));
        measured.map_or(stated_v, |v| v.max(stated_v))
    };
    let is_beyond =
        |sample: &usize| run.command[*sample].abs() > (1.0 + ALLOWED) * supply_v(*sample);
    let beyond: Vec<usize> = (0..run.command.len()).filter(is_beyond).collect();
    let (Some(&first), Some(&last)) = (beyond.first(), beyond.last()) else {
        return Vec::new();
    };
    let largest_v = (beyond.iter()).fold(0.0_f64, |most, k| most.max(run.command[*k].abs()));
    vec![subject.finding(
        Kind::CommandBeyondSupply,
        Severity::Warning,
        (first, last),
        format!("the command reaches {largest_v:.2} V, the supply is {stated_v:.2} V"),
        [
            ("largest_command_v", largest_v),
            ("supply_v", stated_v),
            ("samples", beyond.len() as f64),
        ],
        "give the right supply (supply_v of the mapping, --supply), or the number of full drive (full = 1023)",
    )]
}
