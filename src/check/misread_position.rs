//! Invalid readings of the position: the count jumps for one or a few samples and returns.
//!
//! A failed read of a servo or an encoder is logged as an ordinary number. A jump that returns and is far larger than
//! any other change within a sample cannot be motion.

use super::finding::{Finding, Kind, Severity};
use super::subject::Subject;
use crate::recording::Run;

/// Most consecutive misread samples. Convention.
const MOST_TOGETHER: usize = 3;
/// The count returns to within this share of the jump. Convention.
const BACK: f64 = 0.1;
/// Least jump as a multiple of the largest change elsewhere. Convention.
const LEAPS: f64 = 5.0;
/// Above this share of the samples, jumps are a property of the log and no misreadings.
const MOST_SHARE: f64 = 0.02;

pub(super) fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let run = subject.run;
    let misread = misread_positions(run);
    let (Some(&first), Some(&last)) = (misread.first(), misread.last()) else {
        return Vec::new();
    };
    vec![subject.finding(
        Kind::MisreadPosition,
        Severity::Warning,
        (first, last),
        format!(
            "the position leaps away and comes back in {} of {} samples, first to {} counts from {} at sample {}: a failed read",
            misread.len(),
            run.len(),
            run.counts[first],
            run.counts[first.saturating_sub(1)],
            first + 1,
        ),
        [
            ("misread_samples", misread.len() as f64),
            ("first_sample", first as f64 + 1.0),
            ("counts_there", run.counts[first] as f64),
        ],
        "diagnose leaves these samples out; read again where a read fails",
    )]
}

pub(crate) fn misread_positions(run: &Run) -> Vec<usize> {
    let n = run.len();
    let change = |from: usize, to: usize| run.counts[to] as f64 - run.counts[from] as f64;
    let mut leaps: Vec<(usize, usize, f64)> = Vec::new();
    let mut k = 1;
    while k + 1 < n {
        let found = (1..=MOST_TOGETHER).find_map(|together| {
            let back = k + together;
            if back >= n {
                return None;
            }
            let (away, returns) = (change(k - 1, k), change(back - 1, back));
            let size = away.abs().min(returns.abs());
            let is_back = change(k - 1, back).abs() <= BACK * size;
            (away * returns < 0.0 && is_back).then_some((k, back, size))
        });
        match found {
            Some(leap) => {
                leaps.push(leap);
                k = leap.1;
            }
            None => k += 1,
        }
    }
    let mut is_leap = vec![false; n];
    for (from, back, _) in &leaps {
        is_leap[*from..=*back]
            .iter_mut()
            .for_each(|leap| *leap = true);
    }
    // A jump at either end cannot be seen to return.
    let elsewhere = (2..n.saturating_sub(1)).filter(|k| !is_leap[*k]);
    let largest = elsewhere.fold(1.0, |most, k| f64::max(most, change(k - 1, k).abs()));
    let misread: Vec<usize> = (leaps.iter())
        .filter(|(_, _, size)| *size > LEAPS * largest)
        .flat_map(|(from, back, _)| *from..*back)
        .collect();
    if misread.len() as f64 > MOST_SHARE * n as f64 {
        return Vec::new();
    }
    misread
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(counts: impl IntoIterator<Item = i64>) -> Run {
        Run {
            counts: counts.into_iter().collect(),
            ..Run::default()
        }
    }

    #[test]
    fn an_isolated_outlying_position_is_misread() {
        let sound: Vec<i64> = (0..400).map(|k| 30 * k).collect();
        assert!(misread_positions(&run(sound.clone())).is_empty());
        let mut failed = sound.clone();
        failed[40] = -2047;
        (200..203).for_each(|k| failed[k] = 65_535);
        failed[399] = 0;
        // A jump at the end cannot be seen to return.
        assert_eq!(misread_positions(&run(failed)), [40, 200, 201, 202]);
        // A shaft that reverses, and one that rests on an edge.
        let turned = (0..400_i64).map(|k| 30 * (200 - (k - 200).abs()));
        assert!(misread_positions(&run(turned)).is_empty());
        assert!(misread_positions(&run((0..400).map(|k| k % 2))).is_empty());
        // Jumps in every other sample are a property of the log.
        let every = (0..400).map(|k| 500 * (k % 2));
        assert!(misread_positions(&run(every)).is_empty());
        assert!(misread_positions(&run([0, 900])).is_empty());
    }
}
