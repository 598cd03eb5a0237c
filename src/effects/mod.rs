//! The catalogue of effects for readers: description, values for a motor, and an experiment for each.
//!
//! Equation, ranges and similar effects are the catalogue's (`motor::catalogue`). This module adds recordings:
//! [`experiment`] names the profile in which the default strength is visible, [`not_identifiable`] the effects that
//! no recording separates from parameters of the motor file. `tests/effects/shown.rs` measures both.

mod experiment;

use serde::Serialize;

pub use experiment::{Experiment, experiment, not_identifiable};

use crate::motor::Parameters;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior, Stage, catalogue};

/// One parameter of an effect, for one motor and sample time, in SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Key in a motor file.
    pub key: &'static str,
    /// Unit; empty for a dimensionless value.
    pub unit: &'static str,
    /// Smallest plausible value.
    pub lo: f64,
    /// Largest plausible value.
    pub hi: f64,
    /// The plausible values, if they are discrete.
    pub one_of: Option<&'static [f64]>,
    /// The value if a file or a virtual board omits the key.
    pub default: f64,
}

/// One effect, for one motor.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// Its id in files.
    pub effect: &'static str,
    /// Its stage.
    pub stage: Stage,
    /// Description in one line.
    pub summary: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Source of the equation.
    pub source: &'static str,
    /// Whether it differs between two runs with the same command.
    pub random: bool,
    /// Its parameters.
    pub parameters: Vec<Number>,
    /// Commands that excite it.
    pub excited_by: &'static str,
    /// Effects and parameters of the motor file with a similar response.
    pub confused_with: &'static [&'static str],
    /// The experiment in which its default strength is visible.
    pub experiment: Experiment,
    /// Why no experiment separates it from parameters of the motor file; `None` if one does.
    #[serde(rename = "twin")]
    pub not_identifiable: Option<&'static str>,
}

/// Every effect for this motor, in the order of the signal chain.
pub fn entries(parameters: &Parameters) -> Vec<Entry> {
    let entry = |kind: &'static EffectKind| {
        let experiment = experiment(kind);
        let number = |p| number(p, parameters, experiment.sample_time_s);
        Entry {
            effect: kind.id,
            stage: kind.stage,
            summary: kind.summary,
            equation: kind.equation,
            source: kind.source,
            random: kind.random,
            parameters: kind.parameters.iter().map(number).collect(),
            excited_by: kind.excited_by,
            confused_with: kind.confounded_with,
            experiment,
            not_identifiable: not_identifiable(kind),
        }
    };
    catalogue().iter().map(entry).collect()
}

fn number(p: &EffectParameter, parameters: &Parameters, sample_time_s: f64) -> Number {
    let (lo, hi) = p.range(parameters, sample_time_s);
    Number {
        key: p.key,
        unit: p.unit,
        lo,
        hi,
        one_of: match p.prior {
            Prior::OneOf(values) => Some(values),
            _ => None,
        },
        default: p.default(parameters, sample_time_s),
    }
}

/// Significant digits of printed values.
const DIGITS: i32 = 4;

/// A value rounded to the printed digits.
pub fn rounded(value: f64) -> f64 {
    if value == 0.0 {
        return value;
    }
    let unit = 10f64.powi(DIGITS - 1 - value.abs().log10().floor() as i32);
    (value * unit).round() / unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Profile;
    use crate::motor::catalogue::find;

    #[test]
    fn a_number_is_rounded_to_four_digits() {
        for (value, short) in [
            (0.0, 0.0),
            (0.387_298_33, 0.3873),
            (-754.851_9, -754.9),
            (6e-4, 6e-4),
        ] {
            assert_eq!(rounded(value), short);
        }
    }

    #[test]
    fn every_row_is_of_an_effect_and_every_profile_is_built_in() {
        for entry in entries(&Parameters::default()) {
            let Experiment {
                profile,
                duration_s,
                ..
            } = entry.experiment;
            let played = Profile::named(profile, 4.5, duration_s).expect("a built-in profile");
            assert!((played.duration_s() - duration_s).abs() < 1e-9, "{profile}");
        }
        for id in experiment::ids() {
            assert!(find(id).is_some(), "{id}");
        }
    }
}
