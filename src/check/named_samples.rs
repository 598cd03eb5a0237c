//! Samples that findings name as invalid, which no model of the motor has to explain.

use std::collections::BTreeSet;
use std::ops::Range;

use super::misread_position::misread_positions;
use super::off_under_command::{Off, off_intervals};
use super::stale_rows::stale_rows;
use super::subject::has;
use crate::recording::Run;

/// Numbers of the samples with a misread or stale position, and of those in which the drive was off under its
/// command, run-out included; ascending.
///
/// A fit leaves them out, or restarts after them.
pub fn samples_named_by_check(run: &Run) -> Vec<usize> {
    if !has(run, "position") {
        return Vec::new();
    }
    let mut named: BTreeSet<usize> = misread_or_stale(run).into_iter().collect();
    named.extend(off_under_command(run).into_iter().flatten());
    named.into_iter().collect()
}

pub(crate) fn off_under_command(run: &Run) -> Vec<Range<usize>> {
    if !has(run, "position") || !has(run, "command") {
        return Vec::new();
    }
    let of = |off: &Off| off.from..off.to + 1;
    off_intervals(run).iter().map(of).collect()
}

/// Numbers of the samples with a misread or stale position, ascending: single rows, which a fit leaves out.
pub(crate) fn misread_or_stale(run: &Run) -> Vec<usize> {
    if !has(run, "position") {
        return Vec::new();
    }
    let mut named: BTreeSet<usize> = misread_positions(run).into_iter().collect();
    named.extend(stale_rows(run));
    named.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misread_samples_and_those_with_the_drive_off_are_named_together() {
        let mut run = Run {
            counts_per_rev: 100.0,
            t_s: (0..300).map(|k| 0.01 * f64::from(k)).collect(),
            command: vec![6.0; 300],
            counts: (0..300).map(|k| 20 * i64::min(k, 200)).collect(),
            ..Run::default()
        };
        run.counts[50] = -9000;
        let expected: Vec<usize> = [50].into_iter().chain(200..300).collect();
        assert_eq!(samples_named_by_check(&run), expected);
        // Without a recorded command the drive is unknown.
        let header = "[imported]\ncommand = \"not recorded\"\n";
        run.header = header.parse().expect("TOML");
        assert_eq!(samples_named_by_check(&run), [50]);
    }
}
