//! Position or command stuck: a position that does not change under a command that exceeds every dead zone.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use crate::recording::CommandKind;

/// Share of the supply above which no dead zone of the catalogue (up to 40 %) holds the shaft; gravity, up to 70 %,
/// does so in one direction at most.
const HELD: f64 = 0.5;
const HELD_ONE_WAY: f64 = 0.7;
const FEWEST_SAMPLES: usize = 20;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let of_motor = subject.motor.map(|motor| motor.parameters.supply_v);
    let Some(supply_v) = run.supply_v.or(of_motor) else {
        return Vec::new();
    };
    if run.command_kind != CommandKind::Voltage
        || !subject.has("command")
        || !subject.has("position")
    {
        return Vec::new();
    }
    // One count: dither on an encoder edge.
    let first = run.counts.first().copied().unwrap_or(0);
    let moved = run.counts.iter().any(|count| count.abs_diff(first) > 1);
    let beyond = |level_v: f64| run.command.iter().filter(|u| **u > level_v).count();
    let below = |level_v: f64| run.command.iter().filter(|u| **u < -level_v).count();
    let both_ways = beyond(HELD * supply_v).min(below(HELD * supply_v));
    let one_way = beyond(HELD_ONE_WAY * supply_v).max(below(HELD_ONE_WAY * supply_v));
    if moved || both_ways.max(one_way) < FEWEST_SAMPLES {
        return Vec::new();
    }
    let largest_v = run
        .command
        .iter()
        .fold(0.0_f64, |most, u| most.max(u.abs()));
    vec![subject.finding(
        Kind::ChannelStuck,
        Severity::Fatal,
        subject.whole(),
        format!("the count stands still throughout, while the command reaches {largest_v:.2} V"),
        [
            ("largest_command_v", largest_v),
            ("supply_v", supply_v),
            ("samples_at_a_large_command", both_ways.max(one_way) as f64),
        ],
        "check that the encoder is connected and powered, that its column is the right one, and that the motor turns",
    )]
}
