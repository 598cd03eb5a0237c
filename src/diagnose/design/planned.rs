//! A planned recording, simulated, and comparison of models on it.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::change::differences;
use crate::board::Profile;
use crate::diagnose::fit::gram;
use crate::diagnose::model::{Base, Model, dot, predict, sensitivities};
use crate::diagnose::noise::{LinearPlant, Noise, Whitener};
use crate::diagnose::report::KnownChange;
use crate::diagnose::score::plant_of;
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::solver::{DIFFERENCE, LEAST_PRECISION};
use crate::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
use crate::recording::Run;

#[derive(Debug, Clone, Copy)]
pub(super) struct Sampling {
    pub sample_time_s: f64,
    pub samples: usize,
    pub counts_per_rev: f64,
    pub supply_v: f64,
}

/// Units of a difference of two predictions.
#[derive(Debug, Clone, Copy)]
pub(super) enum Errors {
    /// Quantization and a random load torque: whitened innovations.
    Noise(Noise),
    /// A model error larger than noise: corrected squares, each with this weight in 1/counts^2.
    ScaleFree(f64),
}

/// A planned run: simulated counts on a profile, cut into segments.
#[derive(Debug)]
pub(super) struct Planned {
    pub segments: Segments,
    kind: CommandKind,
    /// A disc or a load that is known in it and in no run so far, so that `R/Kt` becomes identifiable.
    new_torque: Option<KnownChange>,
    plant: LinearPlant,
    errors: Errors,
    /// `None` for scale-free errors.
    whitener: Option<Whitener>,
}

/// A model's prediction of a planned run, in units of the error.
#[derive(Debug)]
pub(super) struct Prediction {
    prediction: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Of `J'J + P`; `None` for a model that is used as the truth only.
    solver: Option<Cholesky<f64, Dyn>>,
    /// Innovation variances of a stochastic effect.
    variances: Option<Vec<f64>>,
}

impl Planned {
    /// The simulated run of a motor on a profile with known differences; `None` if it cannot be simulated.
    pub fn new(
        base: &Base,
        motor: &Motor,
        profile: &Profile,
        at: Sampling,
        errors: Errors,
        change: Option<&KnownChange>,
    ) -> Option<Self> {
        if at.samples < 2 {
            return None;
        }
        let t_s: Vec<f64> = (0..at.samples)
            .map(|k| k as f64 * at.sample_time_s)
            .collect();
        let command = profile.commands(at.sample_time_s, at.samples);
        let known = differences(change)?;
        let supply_v = known.supply_v().unwrap_or(at.supply_v);
        let mut motor = motor.clone();
        motor.parameters.counts_per_rev = at.counts_per_rev;
        motor.parameters.supply_v = supply_v;
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions::default();
        let counts = simulate(&known.applied_to(&motor), &drive, &options)
            .ok()?
            .counts;
        let has_new_torque = known.has_torque() && !base.torque_identifiable;
        let run = Run {
            sample_time_s: at.sample_time_s,
            counts_per_rev: at.counts_per_rev,
            supply_v: Some(supply_v),
            command_kind: CommandKind::Voltage,
            counts,
            t_s,
            command,
            known,
            ..Run::default()
        };
        let segments = Segments::new(&[run], &motor, &base.settings).ok()?;
        let plant = plant_of(&segments, &motor, base.kind);
        let whitener = match errors {
            Errors::Noise(noise) => Some(Whitener::new(&segments, &plant, noise)),
            Errors::ScaleFree(_) => None,
        };
        Some(Self {
            kind: base.kind,
            new_torque: change.filter(|_| has_new_torque).cloned(),
            plant,
            errors,
            whitener,
            segments,
        })
    }

    /// A column of counts in units of the error.
    fn measured(&self, column: &[f64]) -> Vec<f64> {
        match (&self.whitener, self.errors) {
            (Some(whitener), _) => whitener.whiten(column),
            (None, Errors::ScaleFree(weight)) => {
                let mut column = self.segments.corrected(column);
                column.iter_mut().for_each(|x| *x *= weight.sqrt());
                column
            }
            (None, Errors::Noise(_)) => column.to_vec(),
        }
    }

    /// A model with this precision of its parameters, or one that is used as the truth only.
    pub fn prediction(
        &self,
        (model, x): (&Model, &[f64]),
        precision: Option<&DMatrix<f64>>,
    ) -> Option<Prediction> {
        let motor = model.motor(x);
        let (prediction, mut columns) = match precision {
            Some(_) => sensitivities(&self.segments, model, x)?,
            None => (predict(&self.segments, &motor)?, Vec::new()),
        };
        let mut precision = precision.cloned();
        if let (Some(known), Some(torque), true) =
            (&mut precision, &self.new_torque, model.scale > 0.0)
        {
            let moved = |by: f64| predict(&self.with_torque(torque, by)?, &motor);
            let pairs = moved(-DIFFERENCE)?.into_iter().zip(moved(DIFFERENCE)?);
            columns.push(pairs.map(|(a, b)| (b - a) / (2.0 * DIFFERENCE)).collect());
            let n = known.nrows();
            *known = known.clone().resize(n + 1, n + 1, 0.0);
            known[(n, n)] = model.scale.powi(-2);
        }
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| self.measured(c)).collect();
        let solver = match precision {
            Some(precision) => Some(solver(&columns, precision)?),
            None => None,
        };
        Some(Prediction {
            prediction: self.measured(&prediction),
            solver,
            columns,
            variances: self.variances(&motor),
        })
    }

    /// The segments with a known disc or load that is larger by this share. A larger resistance with all other
    /// torques and inertias smaller is the same equation, so that the ratio `R/Kt` is not identifiable from runs
    /// without a known torque.
    fn with_torque(&self, known: &KnownChange, by: f64) -> Option<Segments> {
        let mut segments = self.segments.clone();
        let value = known.value * (1.0 + by);
        let known = differences(Some(&KnownChange {
            value,
            ..known.clone()
        }))?;
        let simulator = segments.runs[0].simulator.clone();
        Arc::make_mut(&mut segments.runs)[0].simulator = simulator.with_known(known);
        Some(segments)
    }

    /// Innovation variances of a motor with late samples or lost edges.
    fn variances(&self, motor: &Motor) -> Option<Vec<f64>> {
        let Errors::Noise(noise) = self.errors else {
            return None;
        };
        let LinearPlant { jitter_s, loss, .. } = plant_of(&self.segments, motor, self.kind);
        let plant = LinearPlant {
            jitter_s,
            loss,
            ..self.plant
        };
        let own = || Whitener::new(&self.segments, &plant, noise);
        (plant != self.plant).then(|| own().variances().collect())
    }

    /// The separation of a truth from a rival in standard deviations.
    pub fn separation(&self, truth: &Prediction, rival: &Prediction) -> f64 {
        let pairs = truth.prediction.iter().zip(&rival.prediction);
        let difference: Vec<f64> = pairs.map(|(x, y)| x - y).collect();
        let residual = residual_norm(&difference, &rival.columns, rival.solver.as_ref());
        residual.hypot(self.scatter(truth, rival).sqrt())
    }

    /// Contribution of the variances: twice the Kullback-Leibler divergence of the innovations.
    fn scatter(&self, truth: &Prediction, rival: &Prediction) -> f64 {
        let (None, None) = (&truth.variances, &rival.variances) else {
            let plain: Vec<f64> = self.whitener.iter().flat_map(Whitener::variances).collect();
            let of = |prediction: &Prediction| {
                prediction
                    .variances
                    .clone()
                    .unwrap_or_else(|| plain.clone())
            };
            let ratios = of(truth).into_iter().zip(of(rival));
            let known = ratios.filter(|(_, r)| *r > 0.0).map(|(s, r)| s / r);
            return known.map(|rho| rho - 1.0 - rho.ln()).sum::<f64>().max(0.0);
        };
        0.0
    }
}

fn solver(columns: &[Vec<f64>], precision: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let mut sum = precision + gram(columns);
    (0..columns.len()).for_each(|i| sum[(i, i)] += LEAST_PRECISION);
    sum.cholesky()
}

/// Norm of a difference after a fit of the parameters of some columns.
fn residual_norm(
    difference: &[f64],
    columns: &[Vec<f64>],
    solver: Option<&Cholesky<f64, Dyn>>,
) -> f64 {
    let along = DVector::from_fn(columns.len(), |k, _| dot(&columns[k], difference));
    let gain = solver.map_or(0.0, |solver| solver.solve(&along).dot(&along));
    (dot(difference, difference) - gain).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::design::isolability::base_of;
    use crate::diagnose::settings::Settings;

    /// A known disc is not invariant under the scaling that voltage and counts leave open: a larger resistance with
    /// smaller torques and inertias is equivalent to the motor with a disc larger by the same factor.
    #[test]
    fn a_known_disc_identifies_the_scale_of_torques() {
        let disc = KnownChange {
            key: "inertia_added_kg_m2".to_owned(),
            value: 0.002,
        };
        let at = Sampling {
            sample_time_s: 0.01,
            samples: 600,
            counts_per_rev: 720.0,
            supply_v: 4.5,
        };
        let motor = Motor::default();
        let base = base_of(&motor, 0.01, &Settings::default());
        let profile = Profile::built_in("reversing", 4.5, 6.0).expect("built in");
        let errors = Errors::Noise(Noise::of_a_clean_bench(&base.settings));
        let planned = Planned::new(&base, &motor, &profile, at, errors, Some(&disc));
        let planned = planned.expect("a motor");
        let mut other = motor.clone();
        let p = &mut other.parameters;
        p.resistance_ohm *= 1.05;
        p.inductance_h *= 1.05;
        p.inertia_kg_m2 /= 1.05;
        p.coulomb_friction_nm /= 1.05;
        p.viscous_friction_nm_s_per_rad /= 1.05;
        let larger = planned.with_torque(&disc, 0.05).expect("a disc");
        let predicted = |segments: &Segments, motor: &Motor| predict(segments, motor).expect("one");
        let own = predicted(&planned.segments, &motor);
        let off = |column: Vec<f64>| {
            let off = own.iter().zip(column).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max)
        };
        let (a, b) = (
            predicted(&planned.segments, &other),
            predicted(&larger, &motor),
        );
        let apart = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(apart < 0.01, "{apart}");
        assert!(off(a) > 0.5);
    }

    /// Components outside the columns remain; of a component of length `a` along a column of length 1 whose parameter
    /// has the precision `p`, `a^2 p/(1 + p)` remains (by hand).
    #[test]
    fn free_parameters_reduce_the_separation() {
        let columns = [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0]];
        let residual = |precision: f64| {
            let known = DMatrix::from_diagonal_element(2, 2, precision);
            let solver = solver(&columns, known);
            residual_norm(&[3.0, 4.0, 12.0], &columns, solver.as_ref())
        };
        assert!((residual(0.0) - 12.0).abs() < 1e-6);
        assert!((residual(1e12) - 13.0).abs() < 1e-6);
        assert!((residual(3.0) - (144.0_f64 + 25.0 * 0.75).sqrt()).abs() < 1e-9);
    }
}
