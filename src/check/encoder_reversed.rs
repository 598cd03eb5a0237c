//! Counts that fall under a positive command: two wires are swapped.
//!
//! Evidence in one run: most counts under a command have the opposite sign, or the [`gain`](super::gain) from command
//! to speed is significantly negative. Runs of one motor are also judged together: a load acts in one direction only,
//! and less than a turn in one direction is not conclusive alone.

use super::finding::{Finding, Kind, Severity};
use super::gain::gain;
use super::subject::Subject;
use super::too_short::FEWEST_SAMPLES;

/// Least counts under a command: quantization and one count of dither are then at most 5 % of them.
const FEWEST_COUNTS: f64 = 20.0;
/// Least share of the counts under a command that have the opposite sign. A load that drives the shaft half of the
/// time (an arm that is lifted and lowered) gives 0; delay, coasting and reversals reduce the share of a correct
/// wiring, but not below 0.
const AGAINST: f64 = 0.5;
/// Least share of the counts that agree with the command before the first motion's delay, minus those that oppose it:
/// of a delayed shaft only the deceleration at reversals opposes it (0.92 and more on square waves, delays of 0.35 to
/// 0.7 s).
const DELAYED: f64 = 0.9;
/// Ratio of the initial speed to that before the reversal from which the shaft was braked before it reversed.
const SLOWED: f64 = 2.0;
/// Standard errors below 0 from which a gain is negative. Of 460 valid runs, servos with loads among them, the lowest
/// is at 4.6: a controller's command depends on the position, which biases the estimate.
const BELOW: f64 = 8.0;

/// Counts by the command at which they passed.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    positive: f64,
    negative: f64,
    passed: f64,
    /// Without a command, or while braked.
    resting: f64,
}

pub(super) fn find(subjects: &[Subject<'_>]) -> Vec<Finding> {
    let tallies: Vec<(&Subject<'_>, Tally)> = subjects
        .iter()
        .filter(|subject| {
            subject.run.len() >= FEWEST_SAMPLES && subject.has("command") && subject.has("position")
        })
        .filter(|subject| Tally::of(subject, delay(subject)).share() < DELAYED)
        .map(|subject| (subject, Tally::of(subject, 0)))
        .collect();
    let mut all = Tally::default();
    for (_, tally) in tallies.iter().filter(|(_, tally)| tally.is_conclusive()) {
        all = all.with(tally);
    }
    let together = tallies
        .iter()
        .filter(|(_, tally)| tally.is_conclusive())
        .count();
    let turn = subjects
        .iter()
        .map(|subject| subject.run.counts_per_rev)
        .fold(0.0, f64::max);
    let are_reversed = together > 1 && all.is_against(turn);
    let mut found = Vec::new();
    for (subject, tally) in tallies {
        let gain = gain(subject.run).map(|gain| gain.over_error);
        // A command that is logged long after the motion also gives a negative gain, but most counts agree with it.
        let is_negative = gain.is_some_and(|gain| gain < -BELOW) && tally.share() < AGAINST;
        if tally.is_against(subject.run.counts_per_rev) || is_negative {
            found.push(finding(subject, &tally, gain, None));
        } else if are_reversed && tally.is_conclusive() && tally.share() <= -AGAINST {
            found.push(finding(subject, &tally, gain, Some((together, all))));
        }
    }
    found
}

fn finding(
    subject: &Subject<'_>,
    tally: &Tally,
    gain: Option<f64>,
    together: Option<(usize, Tally)>,
) -> Finding {
    let what = if tally.positive < 0.0 || tally.negative == 0.0 {
        "the counts fall while the command is positive"
    } else if tally.negative > 0.0 {
        "the counts rise while the command is negative"
    } else {
        "a larger command slows the shaft down"
    };
    let as_in_all = together.map_or_else(String::new, |(runs, _)| {
        format!(", as in the {runs} runs together")
    });
    let mut found = subject.finding(
        Kind::EncoderReversed,
        Severity::Fatal,
        subject.whole(),
        format!("{what}{as_in_all}: channels A and B of the encoder, or the motor leads, are swapped"),
        [
            ("counts_under_positive_command", tally.positive),
            ("counts_under_negative_command", tally.negative),
            ("share_along_the_command", tally.share()),
        ],
        match subject.run.header.contains_key("imported") {
            true => {
                "--reverse of the import (scale = -1 under [position] of its mapping), or swap either A and B or the motor leads, not both"
            }
            false => "swap either A and B or the motor leads, not both, and record again",
        },
    );
    if let Some(gain) = gain {
        found.evidence.insert("gain_over_its_error", gain);
    }
    if let Some((runs, all)) = together {
        found.evidence.insert("runs_together", runs as f64);
        (found.evidence).insert("share_along_the_command_together", all.share());
    }
    found
}

impl Tally {
    /// Of counts that follow the command by `delay` samples.
    fn of(subject: &Subject<'_>, delay: usize) -> Self {
        let run = subject.run;
        let from = end_of_deceleration(&run.counts);
        let mut tally = Self {
            resting: (run.counts[..=from].windows(2))
                .map(|pair| pair[0].abs_diff(pair[1]) as f64)
                .sum(),
            ..Self::default()
        };
        let counts = &run.counts[delay..];
        for (pair, &command) in counts.windows(2).zip(&run.command).skip(from) {
            let moved = pair[1].saturating_sub(pair[0]) as f64;
            if command == 0.0 {
                tally.resting += moved.abs();
                continue;
            }
            tally.passed += moved.abs();
            if command > 0.0 {
                tally.positive += moved;
            } else {
                tally.negative += moved;
            }
        }
        tally
    }

    fn with(self, other: &Self) -> Self {
        Self {
            positive: self.positive + other.positive,
            negative: self.negative + other.negative,
            passed: self.passed + other.passed,
            resting: self.resting + other.resting,
        }
    }

    fn is_conclusive(&self) -> bool {
        self.passed >= FEWEST_COUNTS && self.resting <= self.passed
    }

    /// Share of the counts that agrees with the command, minus the share that opposes it.
    fn share(&self) -> f64 {
        if self.passed > 0.0 {
            (self.positive - self.negative) / self.passed
        } else {
            0.0
        }
    }

    /// A load acts in one direction only: motion against commands of both signs is a wiring error. Against one sign a
    /// falling arm moves by half a turn and its oscillation.
    fn is_against(&self, turn: f64) -> bool {
        let is_one_way = !(self.positive < 0.0 && self.negative > 0.0);
        self.is_conclusive() && self.share() <= -AGAINST && !(is_one_way && self.passed < turn)
    }
}

/// Samples from the first command to the first motion where that agrees with it, else 0: a shaft that is delayed by most
/// of a level turns against the command most of the time.
fn delay(subject: &Subject<'_>) -> usize {
    let run = subject.run;
    let is_moved = |counts: &i64| counts.abs_diff(run.counts[0]) as f64 >= FEWEST_COUNTS;
    let commanded = run.command.iter().position(|command| *command != 0.0);
    let moved = run.counts.iter().position(is_moved);
    let (Some(from), Some(to)) = (commanded, moved) else {
        return 0;
    };
    let is_along = (run.counts[to] > run.counts[0]) == (run.command[from] > 0.0);
    if is_along { to.saturating_sub(from) } else { 0 }
}

/// The last sample in which a shaft that turns from the beginning is braked: until then its inertia turns it against
/// the command. 0 if it keeps its speed or begins at rest.
fn end_of_deceleration(counts: &[i64]) -> usize {
    let moved = |from: usize, to: usize| counts[to].saturating_sub(counts[from]) as f64;
    let steps = 1..counts.len();
    let Some(first) = steps.clone().find(|k| moved(k - 1, *k) != 0.0) else {
        return 0;
    };
    let direction = moved(first - 1, first).signum();
    let turned = steps
        .into_iter()
        .find(|k| moved(k - 1, *k) * direction < 0.0);
    let end = turned.map_or(counts.len() - 1, |k| k - 1);
    let window = (end / 10).max(3);
    if end < 2 * window {
        return 0;
    }
    let (begins, ends) = (moved(0, window).abs(), moved(end - window, end).abs());
    if begins > SLOWED * ends { end } else { 0 }
}
