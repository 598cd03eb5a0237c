//! One recording with a specified motor, effects with magnitudes, command and random load.
//!
//! For series (one effect at increasing strengths, one recording cut to increasing lengths); [`crate::generate`]
//! draws everything.

use serde::Deserialize;

use crate::breadth::PROTOCOLS;
use crate::effect::{CATALOGUE, Effect, LATER};
use crate::motor::Motor;
use crate::profile::{Profile, millivolts};
use crate::random_torque::RandomTorque;
use crate::record::{CaseRun, Conditions, record};
use crate::strength::{beyond_refit, counts_without_noise};
use crate::true_motor::TrueMotor;
use crate::unmodelled::OUTSIDE;

/// Specification of a recording.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chosen {
    /// The motor without effects.
    pub motor: Motor,
    /// Effects with their true parameters.
    pub effects: Vec<Effect>,
    /// Name of the command in the run's header: one of [`PROTOCOLS`].
    pub protocol: String,
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Levels in V, each with its duration in s.
    pub levels: Vec<(f64, f64)>,
    /// Standard deviation of the random load as a share of the stall torque.
    pub load_share: f64,
    /// Correlation time of the random load in s.
    pub load_time_s: f64,
    /// Seed of all random numbers of this recording.
    pub seed: u64,
}

/// The recording of a specification.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenRun {
    /// The recording.
    pub run: CaseRun,
    /// Residual of the effects after re-identified parameters, in counts RMS: a linear estimate, 0 without effects.
    pub beyond_refit_counts: f64,
}

/// The recording.
///
/// # Errors
/// A protocol or an effect that the generator does not have.
pub fn record_chosen(chosen: &Chosen) -> Result<ChosenRun, String> {
    let motor = chosen.motor;
    let name = PROTOCOLS
        .into_iter()
        .find(|name| *name == chosen.protocol)
        .ok_or_else(|| format!("'{}' is no protocol of the generator", chosen.protocol))?;
    let mut hidden = TrueMotor::without_effects(motor);
    for effect in &chosen.effects {
        let known = [&CATALOGUE[..], &LATER, &OUTSIDE].concat();
        if !known.contains(&effect.id.as_str()) {
            return Err(format!("'{}' is no effect of the generator", effect.id));
        }
        effect.apply(&mut hidden);
    }
    let mut command_v = Vec::new();
    for &(level_v, held_s) in &chosen.levels {
        let samples = (held_s / chosen.sample_time_s).round() as usize;
        command_v.extend(std::iter::repeat_n(millivolts(level_v), samples));
    }
    let profile = Profile {
        name,
        sample_time_s: chosen.sample_time_s,
        command_v,
    };
    // The plant has the load in units of the dry friction.
    let stall_nm = motor.torque_constant_nm_per_a * motor.stall_current_a();
    let conditions = Conditions {
        random_torque: RandomTorque {
            sigma: chosen.load_share * stall_nm / motor.coulomb_friction_nm,
            time_s: chosen.load_time_s,
        },
        seed: chosen.seed,
    };
    let run = record(&hidden, &profile, motor.counts_per_rev, conditions).run;
    let beyond_refit_counts = if chosen.effects.is_empty() {
        0.0
    } else {
        let plain = TrueMotor::without_effects(motor);
        let profiles = [profile];
        let with = counts_without_noise(&hidden, &profiles, chosen.seed);
        let without = counts_without_noise(&plain, &profiles, chosen.seed);
        beyond_refit(&plain, &profiles, chosen.seed, &with, &without)
    };
    Ok(ChosenRun {
        run,
        beyond_refit_counts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Chosen {
        Chosen {
            motor: Motor::HANDOUT,
            effects: Vec::new(),
            protocol: "step".to_owned(),
            sample_time_s: 0.01,
            levels: vec![(0.0, 0.3), (4.5, 1.7)],
            load_share: 0.0,
            load_time_s: 1.0,
            seed: 5,
        }
    }

    #[test]
    fn a_chosen_step_reaches_the_steady_speed() {
        let made = record_chosen(&plain()).unwrap();
        assert_eq!(made.beyond_refit_counts, 0.0);
        let run = made.run;
        assert_eq!(run.counts.len(), 200);
        let last = (run.counts[199] - run.counts[99]) as f64 * Motor::HANDOUT.count_rad() / 1.0;
        assert!((last / Motor::HANDOUT.top_speed_rad_s() - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_selected_effect_changes_the_recording_and_an_unknown_one_is_refused() {
        let mut with = plain();
        with.effects = vec![Effect {
            id: "coulomb_friction".to_owned(),
            parameters: [("torque_nm".to_owned(), 0.05)].into(),
        }];
        let (rubbing, plainly) = (
            record_chosen(&with).unwrap(),
            record_chosen(&plain()).unwrap(),
        );
        assert!(rubbing.run.counts[199] < plainly.run.counts[199]);
        assert!(rubbing.beyond_refit_counts > 0.0);
        with.effects[0].id = "magic".to_owned();
        assert!(record_chosen(&with).unwrap_err().contains("magic"));
        let unknown = Chosen {
            protocol: "waltz".to_owned(),
            ..plain()
        };
        assert!(record_chosen(&unknown).is_err());
    }
}
