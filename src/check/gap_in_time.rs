//! Missing samples: by sequence numbers, by the device's times, or by the host's clock.

use super::finding::{Finding, Kind, Severity};
use super::host_clock::{host_pauses, time_gaps};
use super::subject::Subject;
use crate::recording::{Run, Steps};

#[derive(Debug, Clone, Copy)]
pub(super) struct Pause {
    /// Number of the sample before it.
    pub before: usize,
    /// Samples that are missing there.
    pub lost: u64,
    /// How long it lasts in s.
    pub lasts_s: f64,
}

pub(super) fn pauses(run: &Run) -> Vec<Pause> {
    let Some(intervals) = Steps::of(run).filter(|_| !run.is_host_timed()) else {
        return Vec::new();
    };
    let longest_s = intervals.longest_usual_s();
    let median_s = intervals.median_s();
    let mut found = Vec::new();
    for (before, pair) in run.t_s.windows(2).enumerate() {
        let lasts_s = pair[1] - pair[0];
        let numbers = run.seq.as_ref();
        let by_number = numbers.map_or(0, |seq| {
            seq[before + 1]
                .saturating_sub(seq[before])
                .saturating_sub(1)
        });
        let by_time = if lasts_s > longest_s {
            (lasts_s / median_s - 1.0).round().max(1.0) as u64
        } else {
            0
        };
        let lost = by_number.max(by_time);
        if lost > 0 {
            found.push(Pause {
                before,
                lost,
                lasts_s,
            });
        }
    }
    found
}

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut found = Vec::new();
    let pauses = pauses(subject.run);
    if let (Some(first), Some(longest)) = (
        pauses.first(),
        pauses.iter().max_by(|a, b| a.lasts_s.total_cmp(&b.lasts_s)),
    ) {
        let lost = (pauses.iter()).fold(0_u64, |sum, pause| sum.saturating_add(pause.lost));
        let host_pauses = host_pauses(subject.run);
        // Bytes that wait for a blocked reader are lost once the buffers are full.
        let is_hosts = |pause: &Pause| {
            (host_pauses.iter()).any(|held| {
                let since_s = subject.run.t_s[pause.before] - subject.run.t_s[held.sample - 1];
                (0.0..=held.lasts_s).contains(&since_s)
            })
        };
        let remedy = match pauses.iter().all(is_hosts) {
            true => {
                "the program that recorded read nothing for a while before (suspended, or a machine under load), not the board: record again"
            }
            false => {
                "send fewer bytes per sample, raise the baud rate or the sample time, and record again; what was commanded in a pause is not known"
            }
        };
        let places = if pauses.len() == 1 { "place" } else { "places" };
        found.push(subject.finding(
            Kind::GapInTime,
            Severity::Warning,
            (first.before, pauses[pauses.len() - 1].before + 1),
            format!(
                "{lost} samples are missing in {} {places}; the longest pause is {:.4} s, after sample {} at {:.3} s",
                pauses.len(),
                longest.lasts_s,
                longest.before + 1,
                subject.run.t_s[longest.before],
            ),
            [
                ("lost_samples", lost as f64),
                ("pauses", pauses.len() as f64),
                ("longest_s", longest.lasts_s),
                ("longest_after_sample", longest.before as f64 + 1.0),
            ],
            remedy,
        ));
    }
    let time_gaps = time_gaps(subject.run);
    if let Some(first) = time_gaps.first() {
        let lost_s: f64 = time_gaps.iter().map(|gap| gap.lost_s).sum();
        let last = time_gaps[time_gaps.len() - 1];
        found.push(subject.finding(
            Kind::GapInTime,
            Severity::Warning,
            (first.sample, last.sample),
            match time_gaps.len() {
                1 => format!(
                    "the board's time stamps have one gap of {:.0} ms (compared with the host clock)",
                    1e3 * lost_s
                ),
                times => format!(
                    "the board's time stamps have {times} gaps, {:.0} ms in all (compared with the host clock), first {:.0} ms",
                    1e3 * lost_s,
                    1e3 * first.lost_s,
                ),
            },
            [
                ("stands", time_gaps.len() as f64),
                ("lost_s", lost_s),
                ("first_lost_s", first.lost_s),
            ],
            "look for what holds up the board's timer: interrupts switched off, a long `print`, a sampling timer that misses its match",
        ));
    }
    found
}
