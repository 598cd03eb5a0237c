//! Dense output at samples: the engine steps past a sample's time and interpolates the state there.
//!
//! Derivatives at both ends of a step are computed once for all samples in it, and only if there are any; the one at
//! its end is reused by the next step.

use crate::integrator::dense_output::{DenseOutput, Sample, shift};
use crate::integrator::engine::{EndRate, Engine};
use crate::scalar::Scalar;

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// The state at `tick + offset` ticks.
    pub(crate) fn state_at(&mut self, tick: u64, offset: S) -> [S; N] {
        self.reach(tick, offset);
        self.sample(tick, offset).state()
    }

    /// Steps until `tick + offset` ticks is within the last step, without a change of the command up to there. It may
    /// step further ahead; `tick` must not be before the start of the last step.
    #[inline]
    pub(crate) fn reach(&mut self, tick: u64, offset: S) {
        let on_tick = offset.value() <= 0.0;
        while (self.now < tick || (self.now == tick && !on_tick)) && self.steps <= self.most_steps {
            self.step(u64::MAX);
        }
        if self.is_at_end(tick, offset) && offset.is_nought() {
            return;
        }
        if self.before.rate.is_none() {
            let mode = self.before.mode.as_ref().unwrap_or(&self.mode);
            self.before.rate = Some(self.machine.rate(mode, &self.before.y));
        }
        if self.end_rate_now().is_none() {
            let (rate, curved) = self.rate_in_parts();
            let now = self.now;
            self.end_rate = Some(EndRate { now, rate, curved });
        }
    }

    /// State at a sample at `tick + offset` ticks, after [`Self::reach`].
    #[inline]
    pub(crate) fn sample(&self, tick: u64, offset: S) -> Sample<'_, S, N> {
        let at_end = self.is_at_end(tick, offset);
        let (Some(start_rate), Some(end)) = (&self.before.rate, self.end_rate_now()) else {
            return Sample::At(&self.y);
        };
        if at_end {
            if offset.is_nought() {
                return Sample::At(&self.y);
            }
            let mut y = self.y;
            shift(&mut y, &end.rate, offset * self.tick_s());
            return Sample::Moved(y);
        }
        let start = &self.before;
        if tick < start.now {
            // Within the tick of a change of the command, which has been passed; or samples out of order (later than
            // the next one): the nearest known state.
            let mut y = start.y;
            if tick + 1 == start.now {
                shift(&mut y, start_rate, (offset - 1.0) * self.tick_s());
            }
            return Sample::Moved(y);
        }
        let ticks = (self.now - start.now) as f64;
        let at = offset + (tick - start.now) as f64;
        let place = DenseOutput::at(at.value() / ticks, ticks * self.tick_s());
        let (start, end) = ((&start.y, start_rate), (&self.y, &end.rate));
        let by = at - at.value();
        if by.is_nought() {
            Sample::DenseOutput(place, start, end)
        } else {
            Sample::Moved(place.moved(start, end, by * self.tick_s()))
        }
    }

    /// Whether a sample is at the end of the last step, or just beside a change there.
    #[inline(always)]
    fn is_at_end(&self, tick: u64, offset: S) -> bool {
        self.now == tick && (offset.value() == 0.0 || self.before.now == tick)
    }

    /// The derivative at the end of the last step, if known.
    #[inline(always)]
    pub(crate) fn end_rate_now(&self) -> Option<&EndRate<S, N>> {
        self.end_rate.as_ref().filter(|end| end.now == self.now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;
    use crate::chain::Chain;
    use crate::integrator::dynamics::Machine;
    use crate::integrator::engine::TICKS;
    use crate::scalar::Dual;
    use crate::{ActiveEffect, CommandKind, Model, Motor};

    /// The largest difference, in values and derivatives, between samples interpolated with reused and with
    /// recomputed derivatives; a single state variable is bitwise that of the whole state.
    fn apart<const N: usize>(machine: Machine<Dual<4>>) -> f64 {
        let mut engine = Engine::<Dual<4>, N>::new(machine, 0.006);
        let mut largest = 0.0_f64;
        for (n, level) in [4.5, -1.0, 0.1, -4.0, 0.0].into_iter().enumerate() {
            let start = 40 * n as u64 * TICKS;
            engine.go_to(start);
            engine.command(level, Dual::from(0.0));
            for k in 0..100 {
                let (tick, offset) = (start + 400 * k, Dual::from([0.0, 0.3, 0.7][k as usize % 3]));
                engine.reach(tick, offset);
                let mut forgetful = engine.clone();
                (forgetful.before.rate, forgetful.end_rate) = (None, None);
                let anew = forgetful.state_at(tick, offset);
                let sample = engine.sample(tick, offset);
                let kept = sample.state();
                assert_eq!((sample.angle(0), sample.speed(0)), (kept[0], kept[1]));
                for (kept, anew) in kept.into_iter().zip(anew) {
                    let gap = kept - anew;
                    let scale = |k: usize| anew.d[k].abs().max(1.0);
                    largest = gap
                        .d
                        .into_iter()
                        .enumerate()
                        .fold(largest.max(gap.v.abs()), |largest, (k, gap)| {
                            largest.max(gap.abs() / scale(k))
                        });
                }
            }
        }
        largest
    }

    #[test]
    fn cached_rates_equal_recomputed_ones() {
        for effect in catalogue() {
            let mut motor = Motor::default();
            let active = ActiveEffect::from_keys(effect.id, [], &motor.parameters).unwrap();
            motor.effects.set(active);
            let mut number = 0;
            let (model, kind) = (Model::SecondOrder, CommandKind::Voltage);
            let chain = Chain::new(&motor.parameters, &motor.effects, model, kind, |x| {
                number += 1;
                if number <= 4 {
                    Dual::parameter(x, number - 1)
                } else {
                    Dual::from(x)
                }
            });
            let machine = Machine::new(chain);
            let largest = match (machine.two, machine.warms()) {
                (false, false) => apart::<3>(machine),
                (false, true) => apart::<4>(machine),
                (true, _) => apart::<5>(machine),
            };
            assert!(largest < 1e-10, "{}: {largest}", effect.id);
        }
    }
}
