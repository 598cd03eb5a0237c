//! Time integration of a [`Machine`].
//!
//! Time is counted in ticks of `H / 2^FINEST`; a step (`propagate.rs`) is `H / 2^l` and is aligned to its length, so
//! that its matrices are in a step table (`step_table.rs`). If the mode's equations are affine a step is exact; else
//! `l` keeps the error estimate below [`TOLERANCE`]. A step that violates an event function at its end is halved down
//! to one tick, in which the event is located by linear interpolation; the new mode starts there. Steps grow again as
//! their alignment allows, and are then taken in a tight loop (`steady_steps.rs`).

use crate::integrator::dense_output::shift;
use crate::integrator::dynamics::{HEAT, Machine, ONE_BODY, TH1, W1};
use crate::integrator::event_functions::EventFunction;
use crate::integrator::mode::{Anchor, Mode};
use crate::integrator::schedule::Skipped;
use crate::integrator::step_table::FINEST;
use crate::integrator::step_tables::{Key, StepTables};
use crate::reading::encoder_shaft;
use crate::scalar::Scalar;

/// Ticks in the longest step.
pub(crate) const TICKS: u64 = 1 << FINEST;

/// Ticks in a part of a longest step: in a fit, the interval of uniform samples is a multiple of it.
pub(crate) const PART: u64 = TICKS / 4;

/// Largest estimated error of a step's third-order part, in rad/s and A (and rad of the load); the step's own error,
/// of fifth order, is far smaller.
const TOLERANCE: f64 = 2e-5;

/// Longest step in s within which samples are interpolated for a torque periodic in the angle.
const READ_OFF_S: f64 = 0.006;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Before<S, const N: usize> {
    pub(crate) now: u64,
    pub(crate) y: [S; N],
    allowed: usize,
    /// The mode, if it has changed since.
    pub(crate) mode: Option<Mode<S>>,
    /// The derivative, if known.
    pub(crate) rate: Option<[S; N]>,
}

/// The derivative at the end of a step without events, and its nonlinear part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EndRate<S, const N: usize> {
    pub(crate) now: u64,
    pub(crate) rate: [S; N],
    pub(crate) curved: [S; N],
}

/// Integrator of a machine.
#[derive(Debug, Clone)]
pub(crate) struct Engine<S, const N: usize> {
    pub(crate) machine: Machine<S>,
    pub(crate) mode: Mode<S>,
    pub(crate) y: [S; N],
    /// Ticks since the start.
    pub(crate) now: u64,
    /// Start of the last step, and the state there.
    pub(crate) before: Before<S, N>,
    /// The matrices of the modes, including the current one.
    pub(crate) step_tables: StepTables<S, N>,
    /// `n` of `y' = A y + n`, or its constant part.
    pub(crate) constant: [S; N],
    /// Its contribution to a step of each length, computed on demand.
    pub(crate) forced: [Option<[S; N]>; FINEST + 2],
    /// Whether `n` is constant.
    pub(crate) straight: bool,
    /// Derivative at the end of the last step, if known.
    pub(crate) end_rate: Option<EndRate<S, N>>,
    longest_s: f64,
    /// Halvings of the step that the error estimate allows, including caution after a change.
    pub(crate) allowed: usize,
    /// Halvings of the first step after a change, decreasing from there.
    cautious: usize,
    /// Fewest halvings.
    pub(crate) floor: usize,
    /// Largest error estimate of a step.
    pub(crate) tolerance: f64,
    /// Halvings of the first step after a change, if longest steps are longer than in a simulation: in a fit. A change near a part of one then
    /// leaves the engine there, so that the next steps are few.
    pub(crate) coarsened: usize,
    /// Steps attempted: the cost of a simulation.
    pub(crate) steps: u64,
    /// Steps after which it stops: the caller ends there.
    pub(crate) most_steps: u64,
    /// Steps of equations that are not affine among them.
    pub(crate) curved_steps: u64,
}

/// Most events within one tick; later violations are found in the next.
const MOST_EVENTS_A_TICK: usize = 8;

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// At rest at angle 0 without a command. `longest_s` is the longest step.
    pub(crate) fn new(machine: Machine<S>, longest_s: f64) -> Self {
        let mut engine = Self {
            mode: machine.initial_mode(),
            before: Before {
                now: 0,
                y: [S::zero(); N],
                allowed: 0,
                mode: None,
                rate: None,
            },
            machine,
            y: [S::zero(); N],
            now: 0,
            step_tables: StepTables::new(longest_s),
            constant: [S::zero(); N],
            forced: [None; FINEST + 2],
            straight: true,
            end_rate: None,
            longest_s,
            allowed: 0,
            cautious: 0,
            floor: 0,
            tolerance: TOLERANCE,
            coarsened: 0,
            steps: 0,
            most_steps: u64::MAX,
            curved_steps: 0,
        };
        engine.pace();
        engine.settle(None);
        engine.remember();
        engine
    }

    /// Restarts with another machine, reusing the memory.
    pub(crate) fn restart(&mut self, machine: Machine<S>, longest_s: f64) {
        self.mode = machine.initial_mode();
        self.machine = machine;
        self.y = [S::zero(); N];
        self.now = 0;
        self.step_tables.restart(longest_s);
        self.longest_s = longest_s;
        self.allowed = 0;
        self.steps = 0;
        self.curved_steps = 0;
        self.pace();
        self.settle(None);
        self.remember();
    }

    /// Starts at this angle and speed instead of at rest at 0, both sides together, without a command.
    pub(crate) fn start(&mut self, angle_rad: f64, speed_rad_s: f64) {
        (self.y[TH1], self.y[W1]) = (S::from(angle_rad), S::from(speed_rad_s));
        if N > ONE_BODY {
            (self.y[N - 2], self.y[N - 1]) = (S::from(angle_rad), S::from(speed_rad_s));
        }
        self.mode.slip = [0.0; 2];
        self.mode.anchor = [Anchor::at(S::from(angle_rad)); 2];
        self.settle(None);
        self.remember();
    }

    /// Longest steps without two events in one: an event function of the current is crossed twice within the
    /// electrical time constant, one of a spring's end within its period.
    fn pace(&mut self) {
        let (machine, longest_s) = (&self.machine, self.longest_s);
        let halvings = |most_s: f64| (longest_s / most_s).log2().ceil().clamp(0.0, 8.0) as usize;
        let chain = &machine.chain;
        let monitored = chain.driver.limit_a.is_some()
            || chain.driver.drops_v.is_some()
            || chain.mechanical.load_friction.is_some()
            || chain.electrical.ripple.is_some()
            || chain.electrical.heating.is_some()
            || chain.driver.freewheel.is_some()
            || machine.two;
        self.cautious = if machine.inductive && monitored {
            let electrical = &chain.electrical;
            halvings(0.5 * (electrical.inductance_h / electrical.resistance_ohm).value())
        } else {
            0
        };
        let repeats = chain.mechanical.cogging.is_some() || chain.electrical.ripple.is_some();
        self.floor = match chain.transmission.spring {
            Some((frequency_hz, _)) => halvings(0.06 / frequency_hz.value()),
            None if repeats => halvings(READ_OFF_S),
            None => 0,
        };
    }

    /// Length of a tick in s.
    pub(crate) fn tick_s(&self) -> f64 {
        self.longest_s / TICKS as f64
    }

    /// Fixes the step to this length, except for events.
    #[cfg(test)]
    pub(crate) fn hold_step(&mut self, halvings: usize) {
        self.tolerance = f64::INFINITY;
        (self.floor, self.cautious, self.allowed) = (halvings, halvings, halvings);
    }

    /// Changes the command `offset` ticks (0 .. 1, or a few to either side of a part) after the present tick.
    pub(crate) fn command(&mut self, command: f64, offset: S) {
        self.within_tick(offset, |engine| engine.machine.set_command(command));
    }

    /// Sets the shaft to this angle and speed of the encoder `offset` ticks (0 .. 1) after the present tick. The
    /// other side of a transmission is moved along, so that the twist and the current are unchanged; so is the heat,
    /// except for an omitted interval just before. Returns the shaft's angle and speed.
    pub(crate) fn put(
        &mut self,
        angle_rad: f64,
        speed_rad_s: f64,
        offset: S,
        left_out: &[Skipped],
    ) -> (S, S) {
        let chain = self.machine.chain;
        let (angle_rad, speed_rad_s) =
            (chain.sensor).shaft(chain.stated_counts_per_rev, angle_rad, speed_rad_s);
        // The encoder's speed is measured by the board's clock.
        let speed_rad_s = speed_rad_s / chain.timing.clock_scale;
        self.within_tick(offset, |engine| {
            if let Some(heating) = engine.machine.chain.electrical.heating {
                let chain = engine.machine.chain;
                for interval in left_out {
                    let before_w = engine.y[HEAT];
                    let loss_w = (chain.electrical).mean_loss(chain.kind, interval.means, before_w);
                    let kept = (S::from(-interval.span_s) / heating.time_constant_s).exp();
                    engine.y[HEAT] = loss_w + (before_w - loss_w) * kept;
                }
            }
            let shaft = encoder_shaft::<N>(engine.machine.chain.transmission.encoder_on_load);
            let (by, faster) = (
                angle_rad - engine.y[shaft],
                speed_rad_s - engine.y[shaft + 1],
            );
            engine.y[TH1] += by;
            engine.y[W1] += faster;
            if N > ONE_BODY {
                engine.y[N - 2] += by;
                engine.y[N - 1] += faster;
            }
            for anchor in &mut engine.mode.anchor {
                anchor.angle += by;
            }
            engine.mode.slip = [0.0; 2];
        });
        (angle_rad, speed_rad_s)
    }

    /// Applies a change `offset` ticks (0 .. 1) after the present tick, and determines the mode that follows.
    #[inline]
    fn within_tick(&mut self, offset: S, change: impl FnOnce(&mut Self)) {
        let moved = !offset.is_nought();
        let stays = self.coarsened > 0 && self.now.is_multiple_of(PART);
        if moved && stays {
            self.drift_near(offset);
        } else if moved {
            self.drift(offset);
        }
        self.machine.anchor(&mut self.mode, &self.y);
        change(self);
        self.settle(None);
        if moved {
            // No further: the rest of the tick belongs to this event.
            if stays {
                self.drift_near(-offset);
            } else if offset.value() > 0.0 {
                self.cross(-offset + 1.0);
            } else {
                self.drift(-offset);
            }
        }
        self.remember();
    }

    pub(crate) fn remember(&mut self) {
        self.before.now = self.now;
        self.before.y = self.y;
        self.before.allowed = self.allowed;
        self.before.mode = None;
        self.before.rate = match &self.end_rate {
            Some(end) if end.now == self.now => Some(end.rate),
            _ => None,
        };
    }

    /// Returns to the start of the last step.
    fn rewind(&mut self) {
        (self.now, self.y) = (self.before.now, self.before.y);
        self.allowed = self.before.allowed;
        self.end_rate = None;
        if let Some(mode) = self.before.mode.take() {
            self.mode = mode;
            self.select();
        }
    }

    /// Moves the machine to `tick`, from a position after it.
    pub(crate) fn go_to(&mut self, tick: u64) {
        if self.now > tick {
            self.rewind();
        }
        self.advance(tick);
    }

    /// Advances to `until` (in ticks).
    #[inline]
    pub(crate) fn advance(&mut self, until: u64) {
        while self.now < until && self.steps <= self.most_steps {
            self.step(until);
        }
    }

    #[inline(never)]
    pub(crate) fn step(&mut self, limit: u64) {
        self.remember();
        let room = (limit - self.now).min(TICKS);
        let aligned = (self.now | TICKS).trailing_zeros() as usize;
        let fits = (63 - room.leading_zeros()) as usize;
        let mut l = (FINEST - aligned.min(fits)).max(self.allowed);
        loop {
            self.steps += 1;
            self.curved_steps += u64::from(!self.straight);
            let (next, error) = self.propagate(l);
            if l < FINEST && (!error.is_finite() || error > self.tolerance) {
                l += 1;
                self.allowed = l;
                continue;
            }
            if self.violated(&next) {
                if l < FINEST {
                    l += 1;
                    continue;
                }
                self.cross(S::from(1.0));
                return;
            }
            self.y = next;
            self.now += TICKS >> l;
            if self.machine.follows_sliding() {
                self.before.mode.get_or_insert(self.mode);
                self.machine.anchor(&mut self.mode, &self.y);
            }
            if error < self.tolerance / 16.0 && self.allowed >= l && l > self.floor {
                self.allowed = l - 1;
            }
            return;
        }
    }

    /// Whether an event function is violated in a state, and more than before.
    #[inline(always)]
    fn violated(&self, next: &[S; N]) -> bool {
        !self.machine.holds(&self.mode, next) && self.machine.falls(&self.mode, &self.y, next)
    }

    /// The event function that first crosses 0 on the straight line to a state, and the share of the line.
    #[cold]
    #[inline(never)]
    fn first_crossing(&self, next: &[S; N]) -> Option<(EventFunction, S)> {
        let now = self.machine.event_functions(&self.mode, &self.y);
        let then = self.machine.event_functions(&self.mode, next);
        let mut first: Option<(EventFunction, S)> = None;
        for (now, then) in now.into_iter().zip(then) {
            let (Some((event_function, a)), Some((_, b))) = (now, then) else {
                break;
            };
            if b.value() < 0.0 && b.value() < a.value() {
                let share = if a.value() <= 0.0 {
                    S::zero()
                } else {
                    a / (a - b)
                };
                if first.is_none_or(|(_, s)| share.value() < s.value()) {
                    first = Some((event_function, share));
                }
            }
        }
        first
    }

    /// Advances through the rest of a tick, `left` of it, and its events.
    #[cold]
    #[inline(never)]
    fn cross(&mut self, mut left: S) {
        for _ in 0..MOST_EVENTS_A_TICK {
            self.steps += 1;
            self.curved_steps += u64::from(!self.straight);
            let (mut end, _) = self.propagate(FINEST);
            for (end, y) in end.iter_mut().zip(self.y) {
                *end = y + (*end - y) * left.value();
            }
            let Some((event_function, share)) = self.first_crossing(&end) else {
                break;
            };
            self.drift(left * share);
            self.settle(Some(event_function));
            left = left * (-share + 1.0);
        }
        self.drift(left);
        self.now += 1;
    }

    /// Advances by a share of a tick.
    #[inline(never)]
    fn drift(&mut self, share: S) {
        let (next, _) = self.propagate(FINEST);
        self.slide(next, share);
    }

    /// Moves by some ticks, to either side, without an event: to second order.
    #[inline(never)]
    fn drift_near(&mut self, ticks: S) {
        let (next, _) = self.propagate(FINEST);
        let (rate, by) = (self.rate(), ticks.value());
        for ((y, next), rate) in self.y.iter_mut().zip(next).zip(rate) {
            let first = rate * self.longest_s * (1.0 / TICKS as f64);
            *y += first * by + (next - *y - first) * (by * by);
        }
        if S::DERIVATIVES > 0 {
            let by_s = (ticks - by) * self.tick_s();
            let rate = self.rate();
            shift(&mut self.y, &rate, by_s);
        }
    }

    /// Advances to a share of a tick with this end: the value by linear interpolation, derivatives of the share along
    /// the rate.
    fn slide(&mut self, end: [S; N], share: S) {
        for (y, end) in self.y.iter_mut().zip(end) {
            *y += (end - *y) * share.value();
        }
        if S::DERIVATIVES > 0 {
            let by_s = (share - share.value()) * self.tick_s();
            let rate = self.rate();
            shift(&mut self.y, &rate, by_s);
        }
    }

    /// Determines the mode that follows, and its matrices.
    #[inline(never)]
    fn settle(&mut self, fired: Option<EventFunction>) {
        self.before.mode.get_or_insert(self.mode);
        self.end_rate = None;
        self.machine.settle(&mut self.mode, &mut self.y, fired);
        self.select();
        let least = self.coarsened.max(self.cautious).max(self.floor);
        self.allowed = self.allowed.min(2).max(least);
    }

    /// Selects the matrices of the current mode.
    #[inline(never)]
    fn select(&mut self) {
        let m = &self.mode;
        let mechanical = &self.machine.chain.mechanical;
        let directions = if mechanical.load_friction.is_some() {
            [m.torque_sign, m.slip[0], m.slip[1]]
        } else if mechanical.viscous_asymmetry.is_some() {
            [0.0, m.slip[0], m.slip[1]]
        } else {
            [0.0; 3]
        };
        let key = Key {
            flow: m.flow,
            touching: m.contact.is_in_contact(),
            sticks: [m.slip[0] == 0.0, m.slip[1] == 0.0],
            directions,
            added_resistance: self.machine.added_resistance.value(),
        };
        // All modes of a key are affine, or none is.
        self.straight = self.machine.straight::<N>(m);
        self.step_tables
            .select(key, self.straight, || self.machine.matrix(m));
        self.constant = self.machine.constant(m);
        self.forced = [None; FINEST + 2];
    }

    /// Derivative of the present state.
    pub(crate) fn rate(&self) -> [S; N] {
        self.machine.rate(&self.mode, &self.y)
    }
}
