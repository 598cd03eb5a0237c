//! How a search went, level by level: plain data, and the table of `--explain`.

use std::fmt;

use serde::Serialize;

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

/// A term of the inverse form.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Term {
    /// Effects that take it.
    pub effects: Vec<&'static str>,
    /// Cycles in a turn, of a term that repeats with the angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<usize>,
    /// Share of what the motor alone leaves that it takes, on folds not fitted.
    pub gain: f64,
    /// Standard error of that, by pieces.
    pub error: f64,
    /// Whether it is not told from the best.
    pub is_tied: bool,
}

/// One step of the search: every rival of one more effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// Which level of the search it is.
    pub name: String,
    /// The effects so far.
    pub from: Vec<&'static str>,
    /// Position error that they leave, in counts RMS.
    pub left_counts: f64,
    /// Rivals, best first.
    pub rivals: Vec<Rival>,
    /// What each effect promised before it was fitted, in nats.
    pub screened: Vec<(&'static str, f64)>,
    /// Terms of the inverse form, most first; of that step alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Term>,
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
    /// Why, in words.
    pub why: String,
}

/// The step that asks what is kept once more.
pub(crate) const PREDICTION: &str = "prediction";
/// The step that looks without any simulation.
pub(crate) const INVERSE_FORM: &str = "inverse form";

/// Rivals of a step that are shown.
const SHOWN: usize = 8;

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: beside {} ({:.2} counts)",
            self.name,
            named(&self.from),
            self.left_counts
        )?;
        for rival in self.rivals.iter().take(SHOWN) {
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
        for term in &self.terms {
            let order = term
                .order
                .map_or(String::new(), |order| format!(" of order {order}"));
            writeln!(
                f,
                "  {} takes {:5.2} +- {:4.2} of the squares  {}{order}",
                if term.is_tied { '=' } else { ' ' },
                term.gain,
                term.error,
                term.effects.join(" | ")
            )?;
        }
        if self.name == PREDICTION || self.name == INVERSE_FORM {
            let is_kept = if self.is_kept { "kept" } else { "not kept" };
            return writeln!(f, "  {is_kept}: {}", self.why);
        }
        writeln!(
            f,
            "  promised {:.1} nats, {:.1} by chance at most (p {:.2}); closes {:.0} %; {}: {}",
            self.gain,
            self.chance,
            self.p_value,
            100.0 * self.closes,
            if self.is_kept { "kept" } else { "not kept" },
            self.why
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
