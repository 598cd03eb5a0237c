//! Next experiment, as plain data and as text.

use serde::{Deserialize, Serialize};

use super::Verdict;
use crate::diagnose::is_parameter_change;
use crate::motor::catalogue::ids;

/// A known change on the bench, as in `differs` and `--with`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownChange {
    /// Its key: `inertia_added_kg_m2`, `gravity_torque_nm` or `supply_v`.
    pub key: String,
    /// Its value in SI.
    pub value: f64,
}

impl KnownChange {
    /// Change on the bench.
    pub fn words(&self) -> String {
        let Self { key, value } = self;
        match key.as_str() {
            "inertia_added_kg_m2" => format!("a disc of {value} kg m^2 on the shaft"),
            "gravity_torque_nm" => format!(
                "a load on an arm that hangs down at the start, {value} N m where it is level"
            ),
            "supply_v" => format!("a supply of {value} V"),
            _ => format!("{key} = {value}"),
        }
    }

    /// Flag of `diagnose` for the run; `None` if the run's header states it.
    pub fn flag(&self, run: &str) -> Option<String> {
        let Self { key, value } = self;
        (key != "supply_v").then(|| format!("--with {run}:{key}={value}"))
    }
}

/// A proposed recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// The profile with its share of the supply and its duration, as for `capture --profile`.
    pub profile: String,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Duration in s.
    pub duration_s: f64,
    /// The command line that records it; `PORT` is the board's.
    pub command: String,
    /// Known change on the bench, if no profile alone separates the effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<KnownChange>,
    /// Effects that it separates.
    pub tells_apart: Vec<String>,
    /// Least separation in standard deviations.
    pub expected_separation: f64,
}

impl NextExperiment {
    /// The effects that it separates; without those of re-identified parameters where these explain the error.
    pub fn named(&self, verdict: Verdict) -> Vec<String> {
        let is_freed = |id: &str| id == ids::INDUCTANCE || is_parameter_change(id);
        let is_named = |id: &&String| verdict != Verdict::Parameters || !is_freed(id);
        let named: Vec<String> = (self.tells_apart.iter())
            .filter(is_named)
            .cloned()
            .collect();
        match named.iter().any(|id| id != "none") {
            true => named,
            false => self.tells_apart.clone(),
        }
    }
}
