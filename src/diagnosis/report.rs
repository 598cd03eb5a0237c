//! What a search found: plain data.

use std::fmt;

use serde::Serialize;

use crate::motor::Motor;

/// The kind of thing that was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Found {
    /// Nothing beyond the motor's own numbers.
    Nothing,
    /// One set of effects.
    Effects,
    /// Several sets, which these runs do not tell apart.
    Several,
    /// Effects, and something more.
    Partial,
    /// Something that no effect explains.
    Unknown,
}

/// One rival of a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// Its effects.
    pub effects: Vec<&'static str>,
    /// Nats that it gains on pieces not fitted, prior included.
    pub gains: f64,
    /// Nats that it is behind the best, and the standard error of that.
    pub behind: f64,
    /// Standard error of `behind`.
    pub error: f64,
    /// Whether it is not told from the best.
    pub is_tied: bool,
    /// Position error that it leaves, in counts RMS.
    pub left_counts: f64,
    /// Strength of the wandering load that it leaves, one sigma as a share of the stall torque.
    pub wander: f64,
}

/// One step of the search: every rival of one more effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// The effects so far.
    pub from: Vec<&'static str>,
    /// Position error that they leave, in counts RMS.
    pub left_counts: f64,
    /// Rivals, best first.
    pub rivals: Vec<Rival>,
    /// What each effect promised before it was fitted, in nats.
    pub screened: Vec<(&'static str, f64)>,
    /// The largest promise under the noise that the best leaves.
    pub gain: f64,
    /// The largest of simulated recordings.
    pub chance: f64,
    /// Share of simulated recordings that promise as much.
    pub p_value: f64,
    /// Share of the mean square above rounding that the best closes.
    pub closes: f64,
    /// Whether the best was kept.
    pub is_kept: bool,
}

/// What a search found; displayed it is a table of its steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// The kind of thing.
    pub found: Found,
    /// Sets of effects that are not told apart, best first.
    pub sets: Vec<Vec<&'static str>>,
    /// Probability that one of them is right, where there is one.
    pub probability: f64,
    /// Position error that the best leaves, in counts RMS.
    pub left_counts: f64,
    /// Strength of the wandering load, one sigma as a share of the stall torque.
    pub wander: f64,
    /// Nats that a flexible torque gains beside the best.
    pub unknown_gain: f64,
    /// The largest that it gains on simulated recordings.
    pub unknown_chance: f64,
    /// The motor that was found.
    pub motor: Motor,
    /// Pieces that were predicted.
    pub pieces: usize,
    /// How it went.
    pub steps: Vec<Step>,
}

/// Rivals of a step that are shown.
const SHOWN: usize = 8;

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for step in &self.steps {
            writeln!(
                f,
                "beside {} ({:.2} counts)",
                named(&step.from),
                step.left_counts
            )?;
            for rival in step.rivals.iter().take(SHOWN) {
                writeln!(
                    f,
                    "  {} {:9.1} nats, behind {:7.1} +- {:6.1}, leaves {:8.2} counts  {}",
                    if rival.is_tied { '=' } else { ' ' },
                    rival.gains,
                    rival.behind,
                    rival.error,
                    rival.left_counts,
                    named(&rival.effects)
                )?;
            }
            writeln!(
                f,
                "  promised {:.1} nats, {:.1} by chance at most (p {:.2}); closes {:.0} %: {}",
                step.gain,
                step.chance,
                step.p_value,
                100.0 * step.closes,
                if step.is_kept { "kept" } else { "not kept" }
            )?;
        }
        writeln!(
            f,
            "a flexible torque gains {:.1} nats, {:.1} by chance at most",
            self.unknown_gain, self.unknown_chance
        )?;
        let sets: Vec<String> = self.sets.iter().map(|set| named(set)).collect();
        let sets = sets.join(" or ");
        match self.found {
            Found::Nothing => write!(f, "nothing")?,
            Found::Unknown => write!(f, "something unknown")?,
            Found::Effects | Found::Several => write!(f, "{sets}")?,
            Found::Partial => write!(f, "{sets}, and something unknown")?,
        }
        writeln!(
            f,
            " ({:.0} % sure, {} pieces); leaves {:.2} counts, the load wanders by {:.2} % of the stall torque",
            100.0 * self.probability,
            self.pieces,
            self.left_counts,
            100.0 * self.wander
        )
    }
}

fn named(set: &[&str]) -> String {
    if set.is_empty() {
        "none".to_owned()
    } else {
        set.join("+")
    }
}
