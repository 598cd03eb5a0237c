//! Rows after a pause with the position from before it: a buffer that was not emptied, a read that returns an old
//! value.
//!
//! The shaft keeps turning in a pause of the log. Where its rate is similar before and after, the first position
//! after the pause must have advanced by at least the smaller rate times the pause. Rows that have not, followed by
//! one that catches up, are old positions under new times.

use super::finding::{Finding, Kind, Severity};
use super::gap_in_time::pauses;
use super::subject::Subject;
use super::words::time;
use crate::recording::Run;

/// Steps before and after the pause whose median is the rate there, and the fewest.
const RATE_STEPS: usize = 15;
const LEAST_STEPS: usize = 3;
/// A row is stale below this share of the expected advance, and current above the second.
const STALE: f64 = 0.5;
const FRESH: f64 = 0.75;
/// Least advance in counts over the pause: quantization is then 5 % of it.
const LEAST_COUNTS: f64 = 20.0;
/// Most stale rows after a pause. Convention: a serial buffer of 4 kB holds some 100 lines.
const MOST_ROWS: usize = 100;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let stale = stale_rows(run);
    let (Some(&first), Some(&last)) = (stale.first(), stale.last()) else {
        return Vec::new();
    };
    let pauses = 1 + stale
        .windows(2)
        .filter(|pair| pair[1] > pair[0] + 1)
        .count();
    vec![subject.finding(
        Kind::StaleRows,
        Severity::Warning,
        (first, last),
        format!(
            "{} rows after {} hold the position from before it, first at {:.3} s after a pause of {}",
            stale.len(),
            if pauses == 1 { "a pause".to_owned() } else { format!("{pauses} pauses") },
            run.t_s[first],
            time(run.t_s[first] - run.t_s[first.saturating_sub(1)]),
        ),
        [
            ("stale_rows", stale.len() as f64),
            ("pauses", pauses as f64),
            ("first_sample", first as f64 + 1.0),
        ],
        "leave these rows out; stamp a sample on the board when it is taken, or empty the buffer after a pause",
    )]
}

pub(crate) fn stale_rows(run: &Run) -> Vec<usize> {
    let mut found = Vec::new();
    for pause in pauses(run) {
        let before = pause.before;
        let after = before + 1;
        let (Some(rate_before), Some(rate_after)) = (
            rate(run, before.saturating_sub(RATE_STEPS), before),
            rate(run, after, after + RATE_STEPS),
        ) else {
            continue;
        };
        let least = match (rate_before > 0.0, rate_after > 0.0) {
            (true, true) => rate_before.min(rate_after),
            (false, false) => rate_before.max(rate_after),
            _ => continue,
        };
        // Advance of a row since the pause, as a share of the expected one.
        let gone = |k: usize| {
            let counts = run.counts[k] as f64 - run.counts[before] as f64;
            counts / (least * (run.t_s[k] - run.t_s[before]))
        };
        let made = (least * pause.lasts_s).abs();
        let rows = after..run.len().min(after + MOST_ROWS);
        let stale = rows.clone().take_while(|&k| gone(k) < STALE).count();
        let is_made_up = rows.into_iter().skip(stale).any(|k| gone(k) >= FRESH);
        if made >= LEAST_COUNTS && stale > 0 && is_made_up {
            found.extend(after..after + stale);
        }
    }
    found
}

/// Median rate in counts/s.
fn rate(run: &Run, from: usize, to: usize) -> Option<f64> {
    let to = to.min(run.len() - 1);
    let mut rates: Vec<f64> = (from + 1..=to)
        .map(|k| {
            let counts = run.counts[k] as f64 - run.counts[k - 1] as f64;
            counts / (run.t_s[k] - run.t_s[k - 1])
        })
        .collect();
    rates.sort_by(f64::total_cmp);
    (rates.len() >= LEAST_STEPS).then(|| rates[rates.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaft at 1000 counts/s, 10 ms a row, with a pause of 0.4 s before row 200; these rows after it are behind by the pause's counts.
    fn run(stale: usize) -> Run {
        let mut run = Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            ..Run::default()
        };
        for k in 0..400 {
            let pause_s = if k < 200 { 0.0 } else { 0.4 };
            let t_s = 0.01 * k as f64 + pause_s;
            let behind = if (200..200 + stale).contains(&k) {
                400
            } else {
                0
            };
            run.t_s.push(t_s);
            run.counts.push((1000.0 * t_s).round() as i64 - behind);
        }
        run
    }

    #[test]
    fn rows_corrected_by_a_later_row_are_stale() {
        assert_eq!(stale_rows(&run(0)), [0; 0]);
        assert_eq!(stale_rows(&run(1)), [200]);
        assert_eq!(stale_rows(&run(7)), Vec::from_iter(200..207));
        // No row catches up if the shaft rested in the pause.
        assert_eq!(stale_rows(&run(200)), [0; 0]);
    }
}
