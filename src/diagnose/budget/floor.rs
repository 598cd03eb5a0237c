//! The noise floor: quantization, repeatability, and the error accepted by the user.

use crate::diagnose::report::{FloorParts, GoodEnough};
use crate::diagnose::segments::{Recording, Segments};
use crate::diagnose::settings::conventions::{REPEATED_SHARE, SAME_COMMAND};
use crate::recording::Run;

/// The parts of these runs' floor that are known before quantization.
pub(crate) fn stated_floor(
    runs: &[Run],
    segments: &Segments,
    said: &[Vec<usize>],
    good_enough: Option<GoodEnough>,
) -> FloorParts {
    FloorParts {
        rounding: 0.0,
        random: None,
        repeats: repeats(runs, segments, said),
        good_enough: good_enough.map(|good| match good {
            GoodEnough::Counts(counts) => counts,
            GoodEnough::Share(share) => share * travel(segments),
        }),
    }
}

/// Travel within a segment in counts, from the lowest to the highest; the median over segments.
pub(crate) fn travel(segments: &Segments) -> f64 {
    let of_segment = |range: std::ops::Range<usize>| {
        let counts = &segments.counts[range];
        let (lo, hi) =
            (counts.iter()).fold((0.0_f64, 0.0_f64), |(lo, hi), n| (lo.min(*n), hi.max(*n)));
        hi - lo
    };
    median(
        segments
            .segments
            .iter()
            .map(|s| of_segment(s.range()))
            .collect(),
    )
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// Repeatability over segments in counts RMS, as one run's share: the median over pairs of repeated runs, which is
/// robust against one pair. Runs repeat each other if commands and known differences are the same, or if stated
/// (`said`: groups of indices).
fn repeats(runs: &[Run], segments: &Segments, said: &[Vec<usize>]) -> Option<f64> {
    let mut by_pair = Vec::new();
    for (i, a) in segments.runs.iter().enumerate() {
        for (j, b) in segments.runs.iter().enumerate().skip(i + 1) {
            let is_said = said
                .iter()
                .any(|group| group.contains(&i) && group.contains(&j));
            if !is_said && (runs[i].known != runs[j].known || !is_repeated(a, b)) {
                continue;
            }
            let (mut squares, mut samples) = (0.0, 0);
            for segment in segments.segments.iter().filter(|segment| segment.run == i) {
                let to = segment.to.min(b.t_s.len());
                let apart = |k: usize| a.counts[k] - b.counts[k];
                for k in segment.from..to {
                    squares += 0.5 * (apart(k) - apart(segment.from)).powi(2);
                    samples += 1;
                }
            }
            if samples > 0 {
                by_pair.push((squares / f64::from(samples)).sqrt());
            }
        }
    }
    (!by_pair.is_empty()).then(|| median(by_pair))
}

/// Whether two runs have the same commands within one sample, the same sample time, and nearly the same length.
fn is_repeated(a: &Recording, b: &Recording) -> bool {
    let (n, m) = (a.command.len(), b.command.len());
    let shorter = n.min(m);
    let is_long = shorter as f64 >= REPEATED_SHARE * n.max(m) as f64;
    let is_timed_alike = (a.sample_time_s / b.sample_time_s - 1.0).abs() < SAME_COMMAND;
    let largest = a.command.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let is_same = |k: usize| {
        let near = k.saturating_sub(1)..(k + 2).min(m);
        b.command[near]
            .iter()
            .any(|u| (u - a.command[k]).abs() <= SAME_COMMAND * largest)
    };
    is_long && is_timed_alike && (0..shorter).all(is_same)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    /// One of at least 100 samples of a segment.
    const ONE_SAMPLE: f64 = 0.01;

    fn floor_of(runs: &[Run], said: &[Vec<usize>]) -> Option<f64> {
        let segments = Segments::new(runs, &Motor::default(), &Settings::default()).expect("runs");
        repeats(runs, &segments, said)
    }

    /// Two runs that differ by 2 counts at every other sample differ by 2/sqrt(2) RMS, of which one run's share is 1
    /// (by hand).
    #[test]
    fn repeats_are_found_by_their_commands() {
        let a = recording(&Motor::default(), 500);
        let mut b = a.clone();
        for count in b.counts.iter_mut().skip(1).step_by(2) {
            *count += 2;
        }
        let found = floor_of(&[a.clone(), b.clone()], &[]).expect("repeats");
        // A segment with an odd number of samples has one more of either kind.
        assert!((found - 1.0).abs() < ONE_SAMPLE, "{found}");
        let mut with_a_disc = a.clone();
        (with_a_disc.known.set("inertia_added_kg_m2", 0.002)).expect("a known key");
        assert_eq!(floor_of(&[a.clone(), with_a_disc], &[]), None);
        b.command.iter_mut().for_each(|u| *u *= 0.9);
        let both = [a, b];
        assert_eq!(floor_of(&both, &[]), None);
        let said = floor_of(&both, &[vec![0, 1]]).expect("said repeats");
        assert!((said - 1.0).abs() < ONE_SAMPLE, "{said}");
    }

    /// One pair with a large difference does not determine the result.
    #[test]
    fn one_outlying_repeat_does_not_set_the_floor() {
        let a = recording(&Motor::default(), 500);
        let mut odd = a.clone();
        for (k, count) in odd.counts.iter_mut().enumerate() {
            *count += 3 * k as i64;
        }
        let found = floor_of(&[a.clone(), a.clone(), a.clone(), a, odd], &[]).expect("repeats");
        assert!(found.abs() < 1e-9, "{found}");
    }
}
