//! Counts that fall while the command is positive: two wires are swapped.
//!
//! Two kinds of evidence in one run: most counts that pass under a command go against it, or the [`gain`](super::gain) from command
//! to speed is negative beyond doubt. Runs of one motor that are given together are also judged together: a load pushes one way
//! only, and a run that turns less than a turn one way says nothing alone.

use super::finding::{Finding, Kind, Severity};
use super::gain::gain;
use super::subject::Subject;
use super::too_short::FEWEST_SAMPLES;

/// Counts that must have passed under a command, so that rounding and one count of dither are at most 5 % of them.
const FEWEST_COUNTS: f64 = 20.0;
/// Share of the counts passed under a command that must go the wrong way. A load that drives the shaft half of the time
/// (an arm that is lifted and lowered) stays at 0; a delay, coasting and reversals pull a right wiring towards 0, never past it.
const AGAINST: f64 = 0.5;
/// A shaft that is this many times as fast at the beginning as before it turns back was braked on the way.
const SLOWED: f64 = 2.0;
/// A gain is negative where it lies so many standard errors below 0. Of 460 sound runs, servos with loads among them, the lowest
/// lies 4.6 below: a controller's command depends on the position, which pulls the estimate down.
const BELOW: f64 = 8.0;

/// Counts that passed, by what was commanded.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    /// Under a positive command, with their sign.
    positive: f64,
    /// Under a negative command, with their sign.
    negative: f64,
    /// Under a command, without signs.
    passed: f64,
    /// Without a command, or while the shaft is braked, without signs.
    resting: f64,
}

/// Everything of this kind in runs of one motor.
pub(super) fn find(subjects: &[Subject<'_>]) -> Vec<Finding> {
    let told: Vec<(&Subject<'_>, Tally)> = subjects
        .iter()
        .filter(|subject| {
            subject.run.len() >= FEWEST_SAMPLES && subject.has("command") && subject.has("position")
        })
        .map(|subject| (subject, Tally::of(subject)))
        .collect();
    let mut all = Tally::default();
    for (_, tally) in told.iter().filter(|(_, tally)| tally.tells()) {
        all = all.with(tally);
    }
    let together = told.iter().filter(|(_, tally)| tally.tells()).count();
    let turn = subjects
        .iter()
        .map(|subject| subject.run.counts_per_rev)
        .fold(0.0, f64::max);
    let are_reversed = together > 1 && all.is_against(turn);
    let mut found = Vec::new();
    for (subject, tally) in told {
        let gain = gain(subject.run).map(|gain| gain.over_error);
        // A command that is logged long after the motion has a negative gain too, but most counts go along with it.
        let is_negative = gain.is_some_and(|gain| gain < -BELOW) && tally.share() < AGAINST;
        if tally.is_against(subject.run.counts_per_rev) || is_negative {
            found.push(finding(subject, &tally, gain, None));
        } else if are_reversed && tally.tells() && tally.share() <= -AGAINST {
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
        format!("{what}{as_in_all}: A and B (or the motor leads) are swapped"),
        [
            ("counts_under_positive_command", tally.positive),
            ("counts_under_negative_command", tally.negative),
            ("share_along_the_command", tally.share()),
        ],
        match subject.run.header.contains_key("imported") {
            true => {
                "--reverse of the import (scale = -1 under [position] of its mapping), or swap the two wires"
            }
            false => "swap the two wires and record again",
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
    fn of(subject: &Subject<'_>) -> Self {
        let run = subject.run;
        let from = braked(&run.counts);
        let mut tally = Self {
            resting: (run.counts[..=from].windows(2))
                .map(|pair| pair[0].abs_diff(pair[1]) as f64)
                .sum(),
            ..Self::default()
        };
        for (pair, &command) in run.counts.windows(2).zip(&run.command).skip(from) {
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

    /// A shaft that moves as much without a command, or while braked, is driven externally.
    fn tells(&self) -> bool {
        self.passed >= FEWEST_COUNTS && self.resting <= self.passed
    }

    /// Share of the counts that goes along with the command, less that which goes against it.
    fn share(&self) -> f64 {
        if self.passed > 0.0 {
            (self.positive - self.negative) / self.passed
        } else {
            0.0
        }
    }

    /// A load pushes one way only: against both signs of the command nothing but the wires turns the shaft. Against one sign an arm
    /// that falls does, by half a turn and a swing.
    fn is_against(&self, turn: f64) -> bool {
        let is_one_way = !(self.positive < 0.0 && self.negative > 0.0);
        self.tells() && self.share() <= -AGAINST && !(is_one_way && self.passed < turn)
    }
}

/// The sample up to which a shaft that turns from the beginning is braked: its own inertia turns it against the command. 0 where it
/// keeps its speed or begins at rest.
fn braked(counts: &[i64]) -> usize {
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
