//! Change of recordings by each effect beyond re-identified parameters.
//!
//! The commands of the recordings are simulated with the motor and one effect of the catalogue, and the parameters
//! are re-identified from these counts as from recorded ones: the residual above its noise floor is the part of the
//! effect that parameters do not imitate.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::diagnose::inverse::{own_part, shares};
use crate::diagnose::model::Model;
use crate::diagnose::nested::least_squares;
use crate::diagnose::pipeline::Prepared;
use crate::diagnose::relevance::noise_floor;
use crate::diagnose::settings::Settings;
use crate::motor::catalogue::{EffectKind, catalogue};
use crate::motor::{ActiveEffect, Drive, Motor, SimulationOptions, simulate};
use crate::recording::Run;

/// An effect with its change of the recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond {
    /// The effect, at the default magnitude of a virtual board.
    pub effect: &'static str,
    /// Residual RMS in counts of re-identified parameters, above the noise floor.
    pub rms_counts: f64,
}

/// For each effect that the motor file lacks and that can be simulated, in the order of the catalogue. `done`
/// receives the finished share.
pub fn beyond_parameters(
    motor: &Motor,
    runs: &[Run],
    settings: &Settings,
    done: &(dyn Fn(f64) + Sync),
) -> Vec<Beyond> {
    let lacking = |kind: &&EffectKind| motor.effects.get(kind.id).is_none();
    let kinds: Vec<&EffectKind> = catalogue().iter().filter(lacking).collect();
    let made = AtomicUsize::new(0);
    kinds
        .par_iter()
        .map(|kind| {
            let rms_counts = residual(motor, kind, runs, settings)?;
            let effect = kind.id;
            Some(Beyond { effect, rms_counts })
        })
        .inspect(|_| done((made.fetch_add(1, Ordering::Relaxed) + 1) as f64 / kinds.len() as f64))
        .flatten_iter()
        .collect()
}

/// Residual of re-identified parameters for recordings with an effect; `None` if it cannot be simulated.
fn residual(motor: &Motor, kind: &EffectKind, runs: &[Run], settings: &Settings) -> Option<f64> {
    let mut with = motor.clone();
    let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters).ok()?;
    with.effects.set(effect);
    let simulated = runs.iter().map(|run| simulated(&with, run));
    let simulated: Vec<Run> = simulated.collect::<Option<_>>()?;
    let prepared = Prepared::new(&simulated, motor, settings, false).ok()?;
    let (segments, _) = prepared.searched();
    let model = Model::new(&prepared.base, Vec::new());
    let mut starts = vec![model.start()];
    let own = own_part(segments).map(|own| model.start_with(shares(&prepared.base, own)));
    starts.extend(own);
    let fit = least_squares(segments, &model, &starts)?;
    let floor = noise_floor(segments, &fit)?;
    Some((fit.mean_square() - floor).max(0.0).sqrt())
}

/// A motor simulated with the commands of a run.
fn simulated(motor: &Motor, run: &Run) -> Option<Run> {
    let mut motor = run.known.applied_to(motor);
    motor.parameters.counts_per_rev = run.counts_per_rev;
    motor.parameters.supply_v = run.supply_v.unwrap_or(motor.parameters.supply_v);
    let drive = Drive {
        t_s: &run.t_s,
        command: &run.command,
        kind: run.command_kind,
    };
    let found = simulate(&motor, &drive, &SimulationOptions::default()).ok()?;
    Some(Run {
        sample_time_s: run.sample_time_s,
        counts_per_rev: run.counts_per_rev,
        supply_v: run.supply_v,
        command_kind: run.command_kind,
        t_s: run.t_s.clone(),
        command: run.command.clone(),
        known: run.known.clone(),
        counts: found.counts,
        ..Run::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Profile;

    /// For a step to one voltage, a voltage drop is equivalent to another friction; a compliance is not.
    #[test]
    fn parameters_compensate_a_voltage_drop_but_no_compliance() {
        let motor = Motor::default();
        let t_s: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.003).collect();
        let profile = Profile::built_in("step", 4.5, 1.8).expect("built in");
        let run = Run {
            sample_time_s: 0.003,
            counts_per_rev: 720.0,
            supply_v: Some(4.5),
            command: profile.commands(0.003, t_s.len()),
            counts: vec![0; t_s.len()],
            t_s,
            ..Run::default()
        };
        let found = beyond_parameters(&motor, &[run], &Settings::default(), &|_| ());
        assert_eq!(found.len(), catalogue().len());
        let of = |effect: &str| {
            let of = found.iter().find(|one| one.effect == effect);
            of.expect("an effect").rms_counts
        };
        assert!(of("voltage_drop") < 0.1, "{found:?}");
        assert!(of("compliance") > 0.3, "{found:?}");
    }
}
