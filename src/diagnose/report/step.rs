//! Rounds of the search, as plain data, and the table of `--explain`.

use std::fmt;

use serde::Serialize;

use crate::diagnose::settings::conventions::SCREENED_SHOWN;

/// One round of the search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchStep {
    /// The best set before it.
    pub from: Vec<&'static str>,
    /// Best screened sets in addition to it, with their linear score.
    pub screened: Vec<(Vec<&'static str>, f64)>,
    /// The best set after it.
    pub best: Vec<&'static str>,
    /// Its score in nats.
    pub score: f64,
    /// Residual RMS that it leaves, in counts.
    pub rms_counts: f64,
    /// Sets fitted so far.
    pub fitted: usize,
    /// Whether the search ended in it at its limit of simulation time.
    pub limited: bool,
}

impl fmt::Display for SearchStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = |set: &[&str]| match set {
            [] => "no effect".to_owned(),
            _ => set.join(" + "),
        };
        match self.from.as_slice() {
            [] => writeln!(f, "added to the model without effects:")?,
            from => writeln!(f, "added to {}:", named(from))?,
        }
        for (set, worth) in self.screened.iter().take(SCREENED_SHOWN) {
            writeln!(f, "  screened {worth:9.1}  {}", named(set))?;
        }
        writeln!(
            f,
            "  {} fits up to this round, some of one set from several initial values; best set: {} (score {:.1}, {:.3} counts RMS)",
            self.fitted,
            named(&self.best),
            self.score,
            self.rms_counts
        )?;
        match self.limited {
            true => writeln!(
                f,
                "  the search ended here, at its limit of simulation time"
            ),
            false => Ok(()),
        }
    }
}
