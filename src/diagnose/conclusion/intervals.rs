//! What is known of a fitted number: 95 % intervals.
//!
//! By the curvature of the cost, where the response depends on the number smoothly; else by the profile of the cost, which rises by
//! half the 95 % point of chi-squared with one degree of freedom (Venzon and Moolgavkar, 1988). Elsewhere along the profile the other
//! numbers follow to first order.
//!
//! Voltage and angle tell torques, inertias and currents only relative to `R` and `Kt`, which are held: how well the motor file knows
//! these is a part of the interval. A phase is one of the shaft's angle, which an encoder knows to a count where a run begins.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fit::{Fit, dot, residual, response};
use crate::diagnose::noise::Whitener;
use crate::diagnose::pieces::Pieces;
use crate::diagnose::report::Interval;
use crate::diagnose::settings::ROUNDING;
use crate::motor::catalogue::kind;
use crate::motor::fit::ParameterId;

/// Standard deviations of a normal distribution's 95 %.
pub(super) const WITHIN_95: f64 = 1.96;
/// Rise of the cost at the ends: half the square of that.
const RISE: f64 = 0.5 * WITHIN_95 * WITHIN_95;
/// Steps of a doubling walk to beyond an end, and of the bisection back to it.
const WALKS: usize = 12;
const HALVINGS: usize = 10;

/// Ends of number `k` of a fit, in the units in which it is fitted.
pub(crate) fn ends(pieces: &Pieces, fit: &Fit, k: usize) -> (f64, f64) {
    let number = &fit.model.numbers[k];
    let sd = deviation(&fit.hessian, k);
    if !number.smooth
        && let Some(profile) = Profile::new(pieces, fit, k)
    {
        let range = (number.hi - number.lo).min(10.0);
        let step = (WITHIN_95 * sd).clamp(1e-4 * range, range);
        return (profile.end(number.lo, -step), profile.end(number.hi, step));
    }
    let x = fit.x[k];
    let (lo, hi) = (x - WITHIN_95 * sd, x + WITHIN_95 * sd);
    (lo.max(number.lo), hi.min(number.hi))
}

/// Number `k` of a fit in SI with its interval.
pub(crate) fn interval(pieces: &Pieces, fit: &Fit, k: usize, unit: &'static str) -> Interval {
    let (lo, hi) = ends(pieces, fit, k);
    let number = &fit.model.numbers[k];
    if number.lo.is_infinite() {
        // A phase is an angle: it is said within one turn.
        let turn = std::f64::consts::TAU;
        let turns = turn * (fit.x[k] / turn).floor();
        let ends = (lo - turns, hi - turns);
        return widened(fit.x[k] - turns, ends, of_zero(pieces, fit, k), unit);
    }
    let value = number.value(fit.x[k]);
    let is_scaled = unit.starts_with("N m") || ["kg m^2", "ohm", "H", "A"].contains(&unit);
    let scale = if is_scaled { fit.model.scale } else { 0.0 };
    widened(
        value,
        (number.value(lo), number.value(hi)),
        scale * value,
        unit,
    )
}

/// Relative step either way of a central difference, far above what a simulation rounds.
const DIFFERENCE: f64 = 1e-3;

/// A number that was chosen among a few values, such as a resolution: by the curvature that the cost would have, were it fitted.
pub(crate) fn chosen(
    pieces: &Pieces,
    fit: &Fit,
    id: ParameterId,
    unit: &'static str,
) -> Option<Interval> {
    let motor = fit.model.motor(&fit.x);
    let value = id.get(&motor)?;
    let at = |times: f64| {
        let mut moved = motor.clone();
        id.set(&mut moved, times * value);
        response(pieces, &moved, &fit.starts)
    };
    let (up, down) = (at(1.0 + DIFFERENCE)?, at(1.0 - DIFFERENCE)?);
    let slopes = up
        .iter()
        .zip(&down)
        .map(|(a, b)| (a - b) / (2.0 * DIFFERENCE));
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    let column = whitener.whiten(&slopes.collect::<Vec<f64>>());
    let cross = DVector::from_fn(fit.x.len(), |k, _| dot(&fit.columns[k], &column));
    let others = fit.hessian.clone().cholesky()?.solve(&cross);
    // What the other numbers do not do as well.
    let own = dot(&column, &column) - cross.dot(&others);
    (own > 0.0).then(|| widened(value, (value, value), value / own.sqrt(), unit))
}

/// Standard deviation in rad by which a phase is off because an encoder's zero is anywhere within a count, in each run anew.
fn of_zero(pieces: &Pieces, fit: &Fit, k: usize) -> f64 {
    let motor = fit.model.motor(&fit.x);
    let cycles_per_rev = match fit.model.numbers[k].id {
        ParameterId::Effect(index, _) => (kind(index).parameters.iter())
            .position(|parameter| parameter.key == "cycles_per_rev")
            .and_then(|k| ParameterId::Effect(index, k).get(&motor)),
        ParameterId::Nominal(_) => None,
    };
    let runs = &pieces.runs;
    let squares: f64 = runs.iter().map(|run| ROUNDING * run.rad * run.rad).sum();
    cycles_per_rev.unwrap_or(1.0) * squares.sqrt() / runs.len() as f64
}

/// An interval widened by the standard deviation of what the number is relative to.
pub(crate) fn widened(
    value: f64,
    (lo, hi): (f64, f64),
    deviation: f64,
    unit: &'static str,
) -> Interval {
    let by = WITHIN_95 * deviation;
    Interval {
        value,
        lo95: value - (value - lo).hypot(by),
        hi95: value + (hi - value).hypot(by),
        unit,
        reference: None,
    }
}

/// Standard deviation of number `k`, the others free.
fn deviation(hessian: &DMatrix<f64>, k: usize) -> f64 {
    let n = hessian.nrows();
    let unit = DVector::from_fn(n, |i, _| f64::from(u8::from(i == k)));
    let solved = (hessian.clone().cholesky()).map(|c| c.solve(&unit)[k]);
    solved.map_or(f64::INFINITY, |variance| variance.max(0.0).sqrt())
}

/// The cost along one number.
struct Profile<'a> {
    pieces: &'a Pieces,
    fit: &'a Fit,
    k: usize,
    whitener: Whitener,
    /// Numbers that follow.
    others: Vec<usize>,
    /// Inverse of their part of the curvature.
    inverse: DMatrix<f64>,
    least: f64,
}

impl<'a> Profile<'a> {
    fn new(pieces: &'a Pieces, fit: &'a Fit, k: usize) -> Option<Self> {
        let others: Vec<usize> = (0..fit.x.len())
            .filter(|&j| j != k && fit.model.numbers[j].smooth)
            .collect();
        let n = others.len();
        let part = DMatrix::from_fn(n, n, |i, j| fit.hessian[(others[i], others[j])]);
        let mut profile = Self {
            pieces,
            fit,
            k,
            whitener: Whitener::new(pieces, &fit.around, fit.noise),
            others,
            inverse: part.try_inverse()?,
            least: 0.0,
        };
        profile.least = profile.cost(fit.x[k])?;
        Some(profile)
    }

    /// Cost with the number at `at` and the others where it is least, to first order.
    fn cost(&self, at: f64) -> Option<f64> {
        let mut x = self.fit.x.clone();
        x[self.k] = at;
        let model = &self.fit.model;
        let predicted = response(self.pieces, &model.motor(&x), &self.fit.starts)?;
        let white = self.whitener.whiten(&residual(self.pieces, &predicted));
        let pull = &model.precision * (DVector::from_column_slice(&x) - &model.mean);
        let gradient = DVector::from_fn(self.others.len(), |i, _| {
            let j = self.others[i];
            dot(&self.fit.columns[j], &white) - pull[j]
        });
        let gained = 0.5 * gradient.dot(&(&self.inverse * &gradient));
        Some(0.5 * dot(&white, &white) + model.normal_prior(&x) - gained)
    }

    /// Whether a value is beyond the interval.
    fn is_beyond(&self, at: f64) -> bool {
        self.cost(at).is_none_or(|cost| cost > self.least + RISE)
    }

    /// The end of the interval towards `limit`, looked for from a first step on.
    fn end(&self, limit: f64, step: f64) -> f64 {
        let within = |at: f64| {
            if step < 0.0 {
                at.max(limit)
            } else {
                at.min(limit)
            }
        };
        let (mut inside, mut by) = (self.fit.x[self.k], step);
        let mut beyond = None;
        for _ in 0..WALKS {
            let at = within(self.fit.x[self.k] + by);
            if self.is_beyond(at) {
                beyond = Some(at);
                break;
            }
            inside = at;
            if at == limit {
                break;
            }
            by *= 2.0;
        }
        // What the walk does not get beyond reaches as far as is plausible.
        let Some(mut beyond) = beyond else {
            return limit;
        };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + beyond);
            if self.is_beyond(middle) {
                beyond = middle;
            } else {
                inside = middle;
            }
        }
        beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::{Base, Member, Model, Most, fit};
    use crate::diagnose::samples::{SAMPLE_TIME_S, base_of, fitted, member, motor_with, recording};
    use crate::diagnose::settings::DEFAULT_TOLERANCE;
    use crate::motor::catalogue::find;
    use crate::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};

    /// The interval of an effect's first number where it is fitted to a recording of this truth, by a motor of so much more resistance.
    fn of(id: &str, truth: f64, resistance: f64) -> Interval {
        let mut motor = motor_with(&[(id, &[truth])]);
        motor.parameters.resistance_ohm *= resistance;
        let run = recording(&motor, 1500);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let base = Base {
            motor: Motor::default(),
            kind: CommandKind::Voltage,
            sample_time_s: SAMPLE_TIME_S,
            clock: None,
            is_host_timed: false,
            knows_torque: false,
            then: None,
        };
        let (index, kind) = find(id).expect("an effect");
        let values = vec![0.8 * truth];
        let model = Model::new(&base, vec![Member { index, values }]);
        // Several starts, as the search has: a threshold between other levels is another optimum.
        let is_log = model.numbers.last().expect("a number").log;
        let starts = [0.6, 0.9, 1.1, 1.4].map(|times| {
            let mut start = model.start();
            let value: f64 = times * truth;
            *start.last_mut().expect("a number") = if is_log { value.ln() } else { value };
            start
        });
        let fit = fit(&pieces, &model, base.kind, &starts, Most::anything()).expect("a fit");
        interval(&pieces, &fit, fit.x.len() - 1, kind.parameters[0].unit)
    }

    /// A phase is known no better than where in a count the encoder stood when the run began.
    #[test]
    fn a_phase_is_known_to_a_part_of_a_count() {
        let (cycles, phase) = (12.0, 1.0);
        let motor = motor_with(&[("cogging", &[0.03, cycles, phase])]);
        let index = find("cogging").expect("an effect").0;
        let fractions = [0.02, 0.25, 0.5, 0.75, 0.98];
        let covering = fractions.iter().filter(|fraction| {
            let mut run = recording(&motor, 1500);
            let drive = Drive {
                t_s: &run.t_s,
                command: &run.command,
                kind: CommandKind::Voltage,
            };
            let options = SimulationOptions {
                start_count_fraction: **fraction,
                ..SimulationOptions::default()
            };
            run.counts = simulate(&motor, &drive, &options).expect("a motor").counts;
            let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
            let started = Member {
                index,
                values: vec![0.025, cycles, 0.9],
            };
            let fit = fitted(&pieces, &base_of(&pieces), &[started]);
            let id = ParameterId::effect("cogging", "phase_rad");
            let k = fit.model.numbers.iter().position(|n| Some(n.id) == id);
            let found = interval(&pieces, &fit, k.expect("a phase"), "rad");
            // A count either way is 12 times a 720th of a turn.
            let count_rad = cycles * std::f64::consts::TAU / 720.0;
            assert!(found.hi95 - found.lo95 < 2.0 * count_rad, "{found:?}");
            (found.lo95..=found.hi95).contains(&phase)
        });
        // Without what the encoder does not know two of the five have it.
        assert!(covering.count() >= 4);
    }

    /// A resolution that is none of the common ones lies in the interval of the nearest: other motor constants in that ratio do the same.
    #[test]
    fn a_resolution_is_known_as_well_as_the_motor_constant() {
        let run = recording(&motor_with(&[("resolution_error", &[620.0])]), 1500);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let fit = fitted(
            &pieces,
            &base_of(&pieces),
            &[member("resolution_error", 600.0)],
        );
        let id = ParameterId::effect("resolution_error", "counts_per_rev").expect("an effect");
        let found = chosen(&pieces, &fit, id, "1/rev").expect("a curvature");
        assert!(found.lo95 < 620.0 && 620.0 < found.hi95, "{found:?}");
        // No worse than the motor constant is: the other numbers that go with it tell something as well.
        let deviation = (found.hi95 - found.lo95) / (2.0 * WITHIN_95 * 600.0);
        assert!(deviation <= DEFAULT_TOLERANCE, "{deviation}");
    }

    /// Intervals of known numbers cover them in nine of ten at least, by curvature and by profile, and are narrow.
    #[test]
    fn intervals_cover_what_was_simulated() {
        let volts = |k: u32| 0.3 + 0.13 * f64::from(k);
        let torque = |k: u32| 0.004 + 0.0013 * f64::from(k);
        // The resistance that is held is off by as much as its tolerance allows.
        let off = |k: u32| 0.95 + 0.025 * f64::from(k);
        let drops = (0..5).map(|k| (of("voltage_drop", volts(k), 1.0), volts(k)));
        let loads = (0..5).map(|k| (of("constant_load", torque(k), off(k)), torque(k)));
        let zones = (0..10).map(|k| (of("dead_zone", volts(k), 1.0), volts(k)));
        let all: Vec<(Interval, f64)> = drops.chain(loads).chain(zones).collect();
        let covers =
            |(found, truth): &&(Interval, f64)| found.lo95 <= *truth && *truth <= found.hi95;
        let covered = all.iter().filter(covers).count();
        assert!(covered >= 18, "{covered} of 20: {all:?}");
        // The thresholds lie between levels that the recording commands: no narrower than that, and no wider.
        for (found, truth) in &all {
            assert!(
                found.hi95 - found.lo95 < 0.5 * truth + 0.4,
                "{found:?} {truth}"
            );
            assert!(
                found.lo95 <= found.value && found.value <= found.hi95,
                "{found:?}"
            );
        }
    }
}
