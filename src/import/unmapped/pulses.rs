//! Servo pulses: a command as the width of a pulse in µs, around 1500 for two directions or from 1000 on for one.

use super::decide::Decision;
use crate::plain::short;

/// Range of pulse widths in µs of receivers and speed controllers: 1000 to 2000 with a margin.
const WIDTHS_US: (f64, f64) = (800.0, 2200.0);
/// Least range of a command in µs: a tenth of the full range.
const LEAST_RANGE_US: f64 = 100.0;
/// Below this width in µs a pulse around 1500 would be far backwards: the usual dead band is 1475 to 1525.
const BACKWARDS_US: f64 = 1400.0;
/// Words of such columns.
const WORDS: [&str; 8] = [
    "us",
    "usec",
    "micros",
    "microseconds",
    "servo",
    "esc",
    "pulse",
    "throttle",
];

/// Width at standstill and its distance to full drive, in µs.
pub(super) fn pulse(unit: &str) -> Option<(f64, f64)> {
    match unit {
        "servo" => Some((1500.0, 500.0)),
        "esc" => Some((1000.0, 1000.0)),
        _ => None,
    }
}

impl Decision<'_> {
    /// Whether a column contains pulses, by name and numbers.
    pub(super) fn is_pulses(&self, at: usize) -> bool {
        let column = self.column(at);
        let (lowest, highest) = (column.lowest(), column.highest());
        let has_word =
            (self.name_facts[at].words.iter()).any(|word| WORDS.contains(&word.as_str()));
        let is_in_us = self.name_facts[at].unit == Some("us");
        column.is_numeric()
            && !self.used.contains(&at)
            && (has_word || is_in_us)
            && lowest >= WIDTHS_US.0
            && highest <= WIDTHS_US.1
            && highest - lowest >= LEAST_RANGE_US
    }

    /// Requests the kind of pulses in a column; returns the proposed unit.
    pub(super) fn ask_pulses(&mut self, at: usize) -> &'static str {
        let (lowest, highest) = (self.column(at).lowest(), self.column(at).highest());
        // For one direction the lowest is standstill; for two it is far below the middle.
        let unit = match lowest < 1000.0 || (lowest > 1000.0 && lowest < BACKWARDS_US) {
            true => "servo",
            false => "esc",
        };
        let why = format!(
            "{} is a pulse of {} to {} µs: servo (1500 is standstill, 1000 and 2000 are full drive either way) or \
             esc (1000 is standstill, 2000 full drive)",
            self.name(at),
            short(lowest),
            short(highest)
        );
        let flag = self.flag_name(at);
        self.ask("--command", format!("{flag}:{unit}"), why);
        unit
    }
}
