//! Moves a [`Machine`] through time.
//!
//! Time is counted in ticks of `H / 2^FINEST`; a step is `H / 2^l` and starts where one of that length may, so that its
//! matrices stand on the [`Ladder`]. Where the mode's equations are affine a step is exact; else the rest `n(y)` beyond
//! the linear part is integrated by Krogstad's exponential Runge-Kutta scheme of order 4, `l` chosen so that its error
//! estimate keeps below [`TOLERANCE`]. A step at whose end a guard is violated is halved down to one tick, in which the
//! instant is found by linear interpolation; the new mode starts right there. Steps grow again as their alignment allows.
//!
//! Krogstad, Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005).

use super::dynamics::{Machine, Mode, W1};
use super::ladder::{FINEST, Ladder, add, apply};
use super::scalar::Scalar;
use super::transitions::Guard;

/// Ticks in the longest step.
pub(super) const TICKS: u64 = 1 << FINEST;

/// Largest estimated error of a step's third-order part, in rad/s and A (and rad of the load); the step's own error,
/// of fifth order, is far smaller.
const TOLERANCE: f64 = 2e-5;

/// What the matrices of a ladder depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Key {
    flow: super::dynamics::Flow,
    touching: bool,
    sticks: [bool; 2],
    load_friction: [f64; 3],
    added_resistance: f64,
}

/// What there was when a step started.
#[derive(Debug, Clone, Copy)]
struct Before<S, const N: usize> {
    now: u64,
    y: [S; N],
    mode: Mode<S>,
    allowed: usize,
}

/// A machine on its way.
#[derive(Debug, Clone)]
pub(super) struct Engine<S, const N: usize> {
    pub(super) machine: Machine<S>,
    pub(super) mode: Mode<S>,
    pub(super) y: [S; N],
    /// Ticks since the start.
    pub(super) now: u64,
    /// Where the last step started, and what was there.
    before: Before<S, N>,
    pub(super) ladders: Vec<(Key, Ladder<S, N>)>,
    pub(super) ladder: usize,
    /// What `y' = A y + n` has for `n`, where it is constant.
    pub(super) constant: [S; N],
    matrix: [[S; N]; N],
    longest_s: f64,
    /// Rung that the error estimate allows, and that caution after a change does.
    pub(super) allowed: usize,
    /// Rung on which steps start after every change, growing from there.
    cautious: usize,
    /// Rung never exceeded.
    pub(super) floor: usize,
    /// Largest error estimate of a step.
    pub(super) tolerance: f64,
    /// Steps tried, for the tests that count work.
    pub(super) steps: u64,
}

/// Events looked for within one tick; what is violated beyond is met in the next.
const MOST_EVENTS_A_TICK: usize = 8;

/// Most ladders kept; beyond, the oldest go.
const MOST_LADDERS: usize = 24;

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// At rest, angle 0, nothing commanded. `longest_s` is the longest step.
    pub(super) fn new(machine: Machine<S>, longest_s: f64) -> Self {
        let mut engine = Self {
            mode: machine.initial_mode(),
            before: Before {
                now: 0,
                y: [S::zero(); N],
                mode: machine.initial_mode(),
                allowed: 0,
            },
            machine,
            y: [S::zero(); N],
            now: 0,
            ladders: Vec::with_capacity(MOST_LADDERS),
            ladder: 0,
            constant: [S::zero(); N],
            matrix: [[S::zero(); N]; N],
            longest_s,
            allowed: 0,
            cautious: 0,
            floor: 0,
            tolerance: TOLERANCE,
            steps: 0,
        };
        engine.pace();
        engine.settle(None);
        engine.remember();
        engine
    }

    /// Starts anew with another machine, keeping the memory.
    pub(super) fn restart(&mut self, machine: Machine<S>, longest_s: f64) {
        self.mode = machine.initial_mode();
        self.machine = machine;
        self.y = [S::zero(); N];
        self.now = 0;
        self.ladders.clear();
        self.longest_s = longest_s;
        self.allowed = 0;
        self.steps = 0;
        self.pace();
        self.settle(None);
        self.remember();
    }

    /// How long steps may be so that nothing happens twice within one: a guard on the current is passed there and back
    /// within the electrical time constant, one on a spring's end within its period.
    fn pace(&mut self) {
        let (machine, longest_s) = (&self.machine, self.longest_s);
        let rung = |most_s: f64| (longest_s / most_s).log2().ceil().clamp(0.0, 8.0) as usize;
        let chain = &machine.chain;
        let guarded = chain.driver.limit_a.is_some()
            || chain.driver.drop_v.is_some()
            || chain.mechanical.load_friction.is_some()
            || chain.electrical.ripple.is_some()
            || chain.electrical.heating.is_some()
            || machine.two;
        self.cautious = if machine.inductive && guarded {
            let electrical = &chain.electrical;
            rung(0.5 * (electrical.inductance_h / electrical.resistance_ohm).value())
        } else {
            0
        };
        self.floor = match chain.transmission.spring {
            Some((frequency_hz, _)) => rung(0.06 / frequency_hz.value()),
            None => 0,
        };
    }

    /// Length of a tick in s.
    pub(super) fn tick_s(&self) -> f64 {
        self.longest_s / TICKS as f64
    }

    /// Takes no step longer than this rung's, and none shorter but for an event.
    #[cfg(test)]
    pub(super) fn hold_step(&mut self, rung: usize) {
        self.tolerance = f64::INFINITY;
        (self.floor, self.cautious, self.allowed) = (rung, rung, rung);
    }

    /// Changes what is commanded, `offset` ticks (0 .. 1) after the tick that has been reached.
    pub(super) fn command(&mut self, command: f64, offset: S) {
        let moved = !offset.is_nought();
        if moved {
            self.drift(offset);
        }
        self.machine.set_command(command);
        self.settle(None);
        if moved {
            // Not further: the rest of the tick is part of this instant's neighbourhood.
            if offset.value() > 0.0 {
                self.cross(-offset + 1.0);
            } else {
                self.drift(-offset);
            }
        }
        self.remember();
    }

    pub(super) fn remember(&mut self) {
        self.before = Before {
            now: self.now,
            y: self.y,
            mode: self.mode,
            allowed: self.allowed,
        };
    }

    /// Goes back to where the last step started.
    fn rewind(&mut self) {
        let Before {
            now,
            y,
            mode,
            allowed,
        } = self.before;
        (self.now, self.y, self.mode, self.allowed) = (now, y, mode, allowed);
        self.select();
    }

    /// Brings the machine to `tick`, from wherever a look ahead has brought it.
    pub(super) fn go_to(&mut self, tick: u64) {
        if self.now > tick {
            self.rewind();
        }
        self.advance(tick);
    }

    /// The state at `tick + offset` ticks, without change of the command up to there. It may look further ahead,
    /// and calls go forward: `tick` is not before the start of the last step.
    pub(super) fn state_at(&mut self, tick: u64, offset: S) -> [S; N] {
        let on_tick = offset.value() == 0.0;
        while self.now < tick || (self.now == tick && !on_tick) {
            self.step(u64::MAX);
        }
        if on_tick && self.now == tick {
            let mut y = self.y;
            if !offset.is_nought() {
                shift(&mut y, &self.rate(), offset * self.tick_s());
            }
            return y;
        }
        let (start, end) = (self.before, self.y);
        if tick < start.now {
            // Samples out of order (later than the next one): as near as the memory reaches back.
            return start.y;
        }
        let span_s = (self.now - start.now) as f64 * self.tick_s();
        let at_s = (offset + (tick - start.now) as f64) * self.tick_s();
        let (rate0, rate1) = (
            self.machine.rate(&start.mode, &start.y),
            self.machine.rate(&self.mode, &end),
        );
        hermite(&start.y, &rate0, &end, &rate1, at_s, span_s)
    }

    /// Advances to `until` (in ticks).
    #[inline]
    pub(super) fn advance(&mut self, until: u64) {
        while self.now < until {
            self.step(until);
        }
    }

    /// One step, to `limit` at most.
    #[inline(never)]
    pub(super) fn step(&mut self, limit: u64) {
        self.remember();
        let room = (limit - self.now).min(TICKS);
        let aligned = (self.now | TICKS).trailing_zeros() as usize;
        let fits = (63 - room.leading_zeros()) as usize;
        let mut l = (FINEST - aligned.min(fits)).max(self.allowed);
        loop {
            self.steps += 1;
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
            if error < self.tolerance / 16.0 && self.allowed >= l && l > self.floor {
                self.allowed = l - 1;
            }
            return;
        }
    }

    /// The state after a step on rung `l`, and an estimate of its error.
    #[inline(always)]
    fn propagate(&self, l: usize) -> ([S; N], f64) {
        if self.machine.affine {
            let rung = self.ladders[self.ladder].1.rung(l);
            let forced = apply(&rung.p1, &self.constant);
            return (add(apply(&rung.e, &self.y), &forced), 0.0);
        }
        self.propagate_curved(l)
    }

    /// The same where the mode's equations are not affine.
    #[inline(never)]
    fn propagate_curved(&self, l: usize) -> ([S; N], f64) {
        let ladder = &self.ladders[self.ladder].1;
        let (rung, half) = (ladder.rung(l), ladder.rung(l + 1));
        let y = &self.y;
        let n0 = self.rest(y);
        let u2 = add(apply(&half.e, y), &apply(&half.p1, &n0));
        let n2 = self.rest(&u2);
        let mut d = [S::zero(); N];
        for k in 0..N {
            d[k] = (n2[k] - n0[k]) * 2.0;
        }
        let u3 = add(u2, &apply(&half.p2, &d));
        let n3 = self.rest(&u3);
        let base = add(apply(&rung.e, y), &apply(&rung.p1, &n0));
        for k in 0..N {
            d[k] = (n3[k] - n0[k]) * 2.0;
        }
        let u4 = add(base, &apply(&rung.p2, &d));
        let n4 = self.rest(&u4);
        let mut bend = [S::zero(); N];
        for k in 0..N {
            let middle = n2[k] + n3[k];
            d[k] = middle * 2.0 - n0[k] * 3.0 - n4[k];
            bend[k] = (n0[k] - middle + n4[k]) * 4.0;
        }
        let curved = apply(&rung.p3, &bend);
        let next = add(add(base, &apply(&rung.p2, &d)), &curved);
        for k in 0..N {
            d[k] = n3[k] - n2[k];
        }
        let gap = apply(&rung.p2, &d);
        let mut error = 0.0_f64;
        for k in W1..N {
            error = error.max(curved[k].value().abs()).max(gap[k].value().abs());
        }
        (next, error)
    }

    /// `n(y)`: the rate beyond the linear part.
    #[inline(never)]
    fn rest(&self, y: &[S; N]) -> [S; N] {
        let mut n = self.machine.rate_inline(&self.mode, y);
        let linear = apply(&self.matrix, y);
        for k in 0..N {
            n[k] -= linear[k];
        }
        n
    }

    /// Whether a guard is violated in a state, and more so than it was.
    #[inline(always)]
    fn violated(&self, next: &[S; N]) -> bool {
        let guards = self.machine.guards_inline(&self.mode, next);
        if guards.iter().all(|(_, value)| value.value() >= 0.0) {
            return false;
        }
        self.first_crossing(next).is_some()
    }

    /// The guard that falls through 0 first on the straight way to a state, and at which share of it.
    #[cold]
    #[inline(never)]
    fn first_crossing(&self, next: &[S; N]) -> Option<(Guard, S)> {
        let now = self.machine.guards(&self.mode, &self.y);
        let then = self.machine.guards(&self.mode, next);
        let mut first: Option<(Guard, S)> = None;
        for ((guard, a), (_, b)) in now.iter().zip(then.iter()) {
            if b.value() < 0.0 && b.value() < a.value() {
                let share = if a.value() <= 0.0 {
                    S::zero()
                } else {
                    a / (a - b)
                };
                if first.is_none_or(|(_, s)| share.value() < s.value()) {
                    first = Some((guard, share));
                }
            }
        }
        first
    }

    /// Runs through the rest of a tick, `left` of it, and through the events in it.
    #[cold]
    #[inline(never)]
    fn cross(&mut self, mut left: S) {
        for _ in 0..MOST_EVENTS_A_TICK {
            self.steps += 1;
            let (mut end, _) = self.propagate(FINEST);
            for (end, y) in end.iter_mut().zip(self.y) {
                *end = y + (*end - y) * left.value();
            }
            let Some((guard, share)) = self.first_crossing(&end) else {
                break;
            };
            self.drift(left * share);
            self.settle(Some(guard));
            left = left * (-share + 1.0);
        }
        self.drift(left);
        self.now += 1;
    }

    /// Moves on by a share of a tick.
    #[inline(never)]
    fn drift(&mut self, share: S) {
        let (next, _) = self.propagate(FINEST);
        self.slide(next, share);
    }

    /// Moves to a share of the way to where a tick ends: the value by linear interpolation, derivatives of the share
    /// along the rate.
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

    /// Picks the mode that follows, and its matrices.
    #[inline(never)]
    fn settle(&mut self, fired: Option<Guard>) {
        self.machine.settle(&mut self.mode, &mut self.y, fired);
        self.select();
        self.allowed = self.allowed.min(2).max(self.cautious).max(self.floor);
    }

    /// Takes up the matrices of the mode in force.
    #[inline(never)]
    fn select(&mut self) {
        let m = &self.mode;
        let load_friction = if self.machine.chain.mechanical.load_friction.is_some() {
            [m.torque_sign, m.slip[0], m.slip[1]]
        } else {
            [0.0; 3]
        };
        let key = Key {
            flow: m.flow,
            touching: m.contact.sign() != 0.0,
            sticks: [m.slip[0] == 0.0, m.slip[1] == 0.0],
            load_friction,
            added_resistance: self.machine.added_resistance.value(),
        };
        self.ladder = match self.ladders.iter().position(|(k, _)| *k == key) {
            Some(k) => k,
            None => {
                if self.ladders.len() == MOST_LADDERS {
                    self.ladders.remove(0);
                }
                let matrix = self.machine.matrix(m);
                self.ladders
                    .push((key, Ladder::new(&matrix, self.longest_s)));
                self.ladders.len() - 1
            }
        };
        if self.machine.affine {
            self.constant = self.machine.rate(m, &[S::zero(); N]);
        } else {
            self.matrix = self.machine.matrix(m);
        }
    }

    /// Rate of change of the state now.
    pub(super) fn rate(&self) -> [S; N] {
        self.machine.rate(&self.mode, &self.y)
    }
}

/// Moves a state along its rate.
fn shift<S: Scalar, const N: usize>(y: &mut [S; N], rate: &[S; N], by_s: S) {
    for (value, slope) in y.iter_mut().zip(rate) {
        *value += *slope * by_s;
    }
}

/// The state inside a step: angles by the quintic through angle, speed and acceleration at both ends, the rest by the
/// cubic through value and rate.
#[inline(never)]
fn hermite<S: Scalar, const N: usize>(
    y0: &[S; N],
    rate0: &[S; N],
    y1: &[S; N],
    rate1: &[S; N],
    at_s: S,
    span_s: f64,
) -> [S; N] {
    let x = at_s / span_s;
    let (x2, x3) = (x * x, x * x * x);
    let rest = -x + 1.0;
    let mut out = *y0;
    for k in 0..N {
        let rise = y1[k] - y0[k];
        let (a, b) = (rate0[k] * span_s - rise, rise - rate1[k] * span_s);
        out[k] = y0[k] + rise * x + x * rest * (a * rest + b * x);
    }
    for (angle, speed) in [(0, 1), (N - 2, N - 1)] {
        if N <= super::dynamics::ONE_BODY && angle != 0 {
            continue;
        }
        let h = span_s;
        let rise = y1[angle] - y0[angle];
        let (v0, v1) = (y0[speed] * h, y1[speed] * h);
        let (a0, a1) = (rate0[speed] * (h * h), rate1[speed] * (h * h));
        // theta = y0 + v0 x + a0 x^2 / 2 + c3 x^3 + c4 x^4 + c5 x^5
        let c3 = rise * 10.0 - v0 * 6.0 - v1 * 4.0 - a0 * 1.5 + a1 * 0.5;
        let c4 = rise * -15.0 + v0 * 8.0 + v1 * 7.0 + a0 * 1.5 - a1;
        let c5 = rise * 6.0 - (v0 + v1) * 3.0 + (a1 - a0) * 0.5;
        out[angle] = y0[angle] + v0 * x + a0 * x2 * 0.5 + x3 * (c3 + c4 * x + c5 * x2);
    }
    out
}
