//! Consecutive longest steps within one mode: the most frequent case.
//!
//! For affine equations some time after the last event, every step is the longest one with the same contribution of
//! the command, `y <- E y + P n`. This loop takes such steps while every event function stays positive, and leaves
//! the step with an event to [`Engine::step`]. The results are bitwise those of [`Engine::step`], without determining
//! step length, mode and restart state at each step. Samples between the ends of steps are interpolated
//! (`dense_output.rs`).

use crate::integrator::dense_output::{DenseOutput, Sample};
use crate::integrator::dynamics::{Machine, ONE_BODY, W1};
use crate::integrator::engine::{EndRate, Engine, TICKS};
use crate::integrator::event_functions::EventFunction;
use crate::integrator::mode::Mode;
use crate::integrator::propagate::{advance, linear};
use crate::integrator::step_table::add;
use crate::scalar::Scalar;

/// Event functions to check.
enum Watch {
    /// None.
    Nothing,
    /// The speed of a rigid motor falls through 0.
    Speed { direction: f64 },
    /// Breakaway, of a rigid motor at rest.
    Rest,
    /// All of them.
    EventFunctions,
}

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// Takes up to `most` samples, `longest_steps` of the longest step apart, and passes each state to `emit` with
    /// its number; returns how many were taken before an event or shorter steps.
    #[inline]
    pub(crate) fn steady_steps(
        &mut self,
        longest_steps: u64,
        most: usize,
        mut emit: impl FnMut(usize, &Self, &[S; N]),
    ) -> usize {
        if !self.is_steady() {
            return 0;
        }
        let steps_per_sample = longest_steps << self.allowed;
        let holds = |machine: &Machine<S>, m: &Mode<S>, y: &[S; N]| machine.holds(m, y);
        match self.watch() {
            Watch::Nothing => {
                self.repeat_steps(steps_per_sample, most, |_, _, _| true, false, &mut emit)
            }
            Watch::Speed { direction } => {
                let slips =
                    |_: &Machine<S>, _: &Mode<S>, y: &[S; N]| y[W1].value() * direction >= 0.0;
                self.repeat_steps(steps_per_sample, most, slips, false, &mut emit)
            }
            Watch::Rest => self.repeat_steps(steps_per_sample, most, holds, true, &mut emit),
            Watch::EventFunctions => {
                self.repeat_steps(steps_per_sample, most, holds, false, &mut emit)
            }
        }
    }

    /// The same for samples between the ends of steps: sample `n` is at `at(n)`, in ticks and the rest, `None` after
    /// the last or before a change of the command. Their times do not depend on parameters.
    #[inline]
    pub(crate) fn steady_steps_between(
        &mut self,
        at: impl Fn(usize) -> Option<(u64, f64)>,
        mut emit: impl FnMut(usize, &Self, &Sample<'_, S, N>),
    ) -> usize {
        if !self.is_steady() {
            return 0;
        }
        self.read_off(at, self.watch(), &mut emit)
    }

    /// Whether every step is the longest, exact and aligned. A winding that warms up makes the equations nonlinear:
    /// its states of four and six variables are excluded.
    fn is_steady(&self) -> bool {
        let steady = self.straight && self.allowed == self.floor;
        !matches!(N, 4 | 6) && steady && self.now.is_multiple_of(TICKS)
    }

    /// The event functions to check in the current mode.
    fn watch(&self) -> Watch {
        let event_functions = self.machine.event_functions(&self.mode, &self.y);
        match (event_functions[0], event_functions[1]) {
            (None, _) => Watch::Nothing,
            (Some((EventFunction::Stop(0), _)), None) if N <= ONE_BODY => Watch::Speed {
                direction: self.mode.slip[0],
            },
            (Some((EventFunction::Break(0), _)), None) if N <= ONE_BODY => Watch::Rest,
            _ => Watch::EventFunctions,
        }
    }

    /// The loop for one kind of check that the mode `holds`. A fixed point (`may_rest`) is kept.
    #[inline(always)]
    fn repeat_steps(
        &mut self,
        steps_per_sample: u64,
        most: usize,
        holds: impl Fn(&Machine<S>, &Mode<S>, &[S; N]) -> bool,
        may_rest: bool,
        emit: &mut impl FnMut(usize, &Self, &[S; N]),
    ) -> usize {
        let matrices = *self.step_tables.in_force().matrices(self.allowed);
        let forced = *self.forced(self.allowed);
        let mut y = self.y;
        let (mut samples, mut steps, mut at_rest) = (0, 0, false);
        'samples: while samples < most {
            if !at_rest {
                for _ in 0..steps_per_sample {
                    let next = add(advance(&matrices.e, &y), &forced);
                    if !holds(&self.machine, &self.mode, &next) {
                        break 'samples;
                    }
                    at_rest = may_rest && next == y;
                    y = next;
                    steps += 1;
                }
            }
            emit(samples, self, &y);
            samples += 1;
        }
        let steps = steps.max(samples as u64 * steps_per_sample);
        self.y = y;
        self.now += steps * (TICKS >> self.allowed);
        self.steps += steps;
        self.remember();
        samples
    }

    /// The loop for samples between the ends of steps.
    #[inline(always)]
    fn read_off(
        &mut self,
        at: impl Fn(usize) -> Option<(u64, f64)>,
        watch: Watch,
        emit: &mut impl FnMut(usize, &Self, &Sample<'_, S, N>),
    ) -> usize {
        let matrices = *self.step_tables.in_force().matrices(self.allowed);
        let a = self.step_tables.in_force().a;
        let forced = *self.forced(self.allowed);
        let constant = self.constant;
        let rate = |y: &[S; N]| add(linear(&a, y), &constant);
        let step = TICKS >> self.allowed;
        let span_s = step as f64 * self.tick_s();
        // The states at the last two ends, with their derivatives, and the index of the last.
        let mut ends = [(self.y, constant), (self.y, rate(&self.y))];
        let mut last = 1;
        let (mut now, mut samples, mut steps) = (self.now, 0, 0);
        'samples: while let Some((tick, rest)) = at(samples) {
            if steps == 0 && (tick, rest) <= (now, 0.0) {
                break;
            }
            while now < tick || (now == tick && rest > 0.0) {
                let next = add(advance(&matrices.e, &ends[last].0), &forced);
                let holds = match watch {
                    Watch::Nothing => true,
                    Watch::Speed { direction } => next[W1].value() * direction >= 0.0,
                    Watch::Rest | Watch::EventFunctions => self.machine.holds(&self.mode, &next),
                };
                if !holds {
                    break 'samples;
                }
                last = 1 - last;
                ends[last] = (next, rate(&next));
                now += step;
                steps += 1;
            }
            let place = (tick + step - now) as f64 + rest;
            let place = DenseOutput::at(place / step as f64, span_s);
            let ((y0, rate0), (y1, rate1)) = (&ends[1 - last], &ends[last]);
            let sample = Sample::DenseOutput(place, (y0, rate0), (y1, rate1));
            emit(samples, self, &sample);
            samples += 1;
        }
        if steps > 0 {
            self.y = ends[1 - last].0;
            self.now = now - step;
            self.remember();
            (self.y, self.now) = (ends[last].0, now);
            self.end_rate = Some(EndRate {
                now,
                rate: ends[last].1,
                curved: [S::zero(); N],
            });
            self.steps += steps;
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;
    use crate::chain::Chain;
    use crate::{ActiveEffect, CommandKind, Model, Motor};

    const LEVELS_V: [f64; 7] = [4.5, -1.0, 0.1, -4.0, 2.0, 0.0, -0.6];

    /// Every state of a run with a new level every 90 samples, two longest steps apart, with and without this loop.
    fn states<const N: usize>(machine: Machine<f64>, cruising: bool) -> Vec<[u64; N]> {
        let mut engine = Engine::<f64, N>::new(machine, 0.003);
        let mut states = Vec::new();
        for (n, level) in LEVELS_V.iter().enumerate() {
            engine.command(*level, 0.0);
            let mut k = 0;
            while k < 90 {
                k += 1;
                let y = engine.state_at(2 * (90 * n as u64 + k) * TICKS, 0.0);
                states.push(y.map(f64::to_bits));
                if cruising {
                    let left = (90 - k) as usize;
                    let taken =
                        engine.steady_steps(2, left, |_, _, y| states.push(y.map(f64::to_bits)));
                    k += taken as u64;
                }
            }
        }
        states
    }

    #[test]
    fn steady_steps_change_no_bit() {
        let mut sets: Vec<Vec<&str>> = catalogue().iter().map(|kind| vec![kind.id]).collect();
        sets.extend([vec![], vec!["voltage_drop", "current_limit", "inertia"]]);
        sets.push(vec!["backlash", "asymmetric_friction", "load_friction"]);
        for set in sets {
            for model in [Model::FirstOrder, Model::SecondOrder] {
                let mut motor = Motor::default();
                for id in &set {
                    let effect = ActiveEffect::from_keys(id, [], &motor.parameters).unwrap();
                    motor.effects.set(effect);
                }
                for friction in [motor.parameters.coulomb_friction_nm, 0.0] {
                    motor.parameters.coulomb_friction_nm = friction;
                    let kind = CommandKind::Voltage;
                    let chain = Chain::new(&motor.parameters, &motor.effects, model, kind, |x| x);
                    let machine = Machine::new(chain);
                    let same = match (machine.two, machine.warms()) {
                        (false, false) => states::<3>(machine, true) == states::<3>(machine, false),
                        (false, true) => states::<4>(machine, true) == states::<4>(machine, false),
                        (true, _) => states::<5>(machine, true) == states::<5>(machine, false),
                    };
                    assert!(same, "{set:?} {model:?}, friction {friction} N m");
                }
            }
        }
    }

    /// Every angle of a run with jittered sample times, with and without this loop.
    fn uneven<const N: usize>(machine: Machine<f64>, cruising: bool) -> Vec<f64> {
        let mut engine = Engine::<f64, N>::new(machine, 0.003);
        let mut angles = Vec::new();
        for (n, level) in LEVELS_V.iter().enumerate() {
            let place = |k: usize| {
                let sample = 90 * n + k;
                let late: f64 = [0.0, 0.4, 300.2, 7.9, 0.0, 511.5, 2.2][sample % 7];
                (k < 90).then_some((2 * sample as u64 * TICKS + late as u64, late.fract()))
            };
            let change = 180 * n as u64 * TICKS;
            engine.go_to(change);
            engine.command(*level, 0.0);
            let mut k = 0;
            while let Some((tick, rest)) = place(k) {
                angles.push(engine.state_at(tick, rest)[0]);
                k += 1;
                if cruising {
                    let at = |n: usize| place(k + n);
                    k += engine
                        .steady_steps_between(at, |_, _, sample| angles.push(sample.angle(0)));
                }
            }
        }
        angles
    }

    #[test]
    fn samples_read_together_equal_samples_read_singly() {
        for set in catalogue().iter().map(|kind| [kind.id]) {
            let mut motor = Motor::default();
            let effect = ActiveEffect::from_keys(set[0], [], &motor.parameters).unwrap();
            motor.effects.set(effect);
            let (model, kind) = (Model::SecondOrder, CommandKind::Voltage);
            let chain = Chain::new(&motor.parameters, &motor.effects, model, kind, |x| x);
            let machine = Machine::new(chain);
            let [one, other] = [true, false].map(|cruising| match (machine.two, machine.warms()) {
                (false, false) => uneven::<3>(machine, cruising),
                (false, true) => uneven::<4>(machine, cruising),
                (true, _) => uneven::<5>(machine, cruising),
            });
            assert_eq!(one.len(), 630, "{set:?}");
            for (k, (one, other)) in one.iter().zip(other).enumerate() {
                assert!((one - other).abs() < 1e-10, "{set:?}, sample {k}");
            }
        }
    }
}
