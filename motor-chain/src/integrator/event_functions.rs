//! Event functions, positive within a mode, and the torques that they compare.

use crate::CommandKind;
use crate::integrator::dynamics::{CUR, Machine, ONE_BODY, TH1, W1};
use crate::integrator::mode::{Contact, Flow, Mode};
use crate::scalar::Scalar;

/// Events that end a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EventFunction {
    CurrentZero,
    Unblock,
    Limit,
    Unlimit,
    TorqueZero,
    /// A side's speed reaches 0 (0: motor side or a rigid motor, 1: load side).
    Stop(usize),
    /// A side leaves rest.
    Break(usize),
    TouchUpper,
    TouchLower,
    /// Flanks in contact would have to pull.
    Part,
    /// A clutch would exceed its capacity.
    Give,
    /// The sides of a slipping clutch have reached the same speed.
    Grip,
    StopJoint,
    BreakJoint,
}

/// The event functions of a mode with their values, `None` after the last.
pub(crate) type EventFunctions<S> = [Option<(EventFunction, S)>; MOST_EVENTS];

/// Most event functions of a mode.
const MOST_EVENTS: usize = 8;

/// Relative excess over static friction at breakaway. A body that creeps into equilibrium comes to rest exactly at
/// the level, where rounding would alternate sticking and slipping for ever.
pub(crate) const BREAKAWAY_SLACK: f64 = 1e-9;

fn min<S: Scalar>(a: S, b: S) -> S {
    if b.value() < a.value() { b } else { a }
}

fn max<S: Scalar>(a: S, b: S) -> S {
    if b.value() > a.value() { b } else { a }
}

/// Torque limit between two sides at rest: a side's friction, or the capacity of a flank or a clutch.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Holder {
    Motor,
    Load,
    Flank,
}

impl<S: Scalar> Machine<S> {
    /// The event functions of the current mode.
    #[inline(never)]
    pub(crate) fn event_functions(&self, m: &Mode<S>, y: &[S]) -> EventFunctions<S> {
        let (mut event_functions, mut len) = ([None; MOST_EVENTS], 0);
        self.each_event_function(m, y, &mut |event_function, value| {
            event_functions[len] = Some((event_function, value));
            len += 1;
        });
        event_functions
    }

    /// Whether every event function is positive; derivatives are not computed.
    #[inline(never)]
    pub(crate) fn holds(&self, m: &Mode<S>, y: &[S]) -> bool {
        let mut holds = true;
        self.each_event_function(m, y, &mut |_, value| holds &= value.value() >= 0.0);
        holds
    }

    /// Whether an event function is negative in `next`, and more than in `y`.
    #[cold]
    #[inline(never)]
    pub(crate) fn falls(&self, m: &Mode<S>, y: &[S], next: &[S]) -> bool {
        let (now, then) = (self.event_functions(m, y), self.event_functions(m, next));
        now.into_iter().zip(then).any(|pair| match pair {
            (Some((_, now)), Some((_, then))) => then.value() < 0.0 && then.value() < now.value(),
            _ => false,
        })
    }

    /// Passes each event function of the current mode to `see`.
    #[inline(always)]
    fn each_event_function(&self, m: &Mode<S>, y: &[S], see: &mut impl FnMut(EventFunction, S)) {
        self.current_event_functions(m, y, see);
        if y.len() <= ONE_BODY {
            if self.frictionless && !self.presliding() {
                return;
            }
            self.side_event_function(m, 0, y[W1], || self.sum_of_torques(m, y), y, see);
        } else if self.joined(m) {
            if m.slip[0] != 0.0 {
                see(EventFunction::StopJoint, y[W1] * m.slip[0]);
                let carried = self.flank_torque(m, y);
                match self.chain.transmission.clutch_nm {
                    Some(most) => see(EventFunction::Give, most - carried.abs()),
                    None => see(EventFunction::Part, carried * m.contact.sign()),
                }
            } else {
                let (low, high) = self.stuck_flank_range(m, y);
                see(EventFunction::BreakJoint, high.0 - low.0);
            }
        } else {
            if let Some(gap) = self.chain.transmission.gap_rad {
                self.play_event_functions(m, gap, y, see);
            } else if m.contact.slips() != 0.0 {
                see(
                    EventFunction::Grip,
                    (y[W1] - y[y.len() - 1]) * m.contact.slips(),
                );
            }
            self.side_event_function(m, 0, y[W1], || self.torques(m, y).0, y, see);
            self.side_event_function(m, 1, y[y.len() - 1], || self.torques(m, y).1, y, see);
        }
    }

    #[inline(always)]
    fn play_event_functions(
        &self,
        m: &Mode<S>,
        gap: S,
        y: &[S],
        see: &mut impl FnMut(EventFunction, S),
    ) {
        if m.contact.sign() != 0.0 {
            let push = self.spring_torque(m.contact, y) * m.contact.sign();
            see(EventFunction::Part, push);
            return;
        }
        let apart = y[TH1] - y[y.len() - 2];
        let (mut upper, mut lower) = (gap * 0.5 - apart, gap * 0.5 + apart);
        if !self.welds {
            // A spring that recovers more slowly than the sides separate touches again when it would push.
            upper = max(upper, -self.spring_torque(Contact::Upper, y));
            lower = max(lower, self.spring_torque(Contact::Lower, y));
        }
        see(EventFunction::TouchUpper, upper);
        see(EventFunction::TouchLower, lower);
    }

    #[inline(always)]
    fn current_event_functions(
        &self,
        m: &Mode<S>,
        y: &[S],
        see: &mut impl FnMut(EventFunction, S),
    ) {
        if self.chain.kind == CommandKind::Voltage {
            let driver = &self.chain.driver;
            match m.flow {
                Flow::Free => {
                    if m.flow_sign != 0.0 {
                        let through = if self.inductive {
                            y[CUR] * m.flow_sign
                        } else {
                            self.excess(y) * m.flow_sign - driver.drop(m.flow_sign)
                        };
                        see(EventFunction::CurrentZero, through);
                    }
                    if let Some(limit) = driver.limit_a {
                        see(EventFunction::Limit, limit - self.current(m, y).abs());
                    }
                }
                Flow::Blocked => {
                    let excess = self.excess(y);
                    let slack = min(driver.drop(1.0) - excess, driver.drop(-1.0) + excess);
                    see(EventFunction::Unblock, slack);
                }
                Flow::Held => see(EventFunction::Unlimit, self.pull(m, y)),
                Flow::Open => {}
            }
        }
        if self.chain.mechanical.load_friction.is_some()
            && m.flow == Flow::Free
            && (m.slip[0] != 0.0 || m.slip[1] != 0.0)
        {
            see(
                EventFunction::TorqueZero,
                self.current(m, y) * m.torque_sign,
            );
        }
    }

    #[inline(always)]
    fn side_event_function(
        &self,
        m: &Mode<S>,
        side: usize,
        speed: S,
        net: impl Fn() -> S,
        y: &[S],
        see: &mut impl FnMut(EventFunction, S),
    ) {
        if m.slip[side] != 0.0 {
            see(EventFunction::Stop(side), speed * m.slip[side]);
        } else {
            let (net, (up, down)) = (net(), self.levels(m, side, y));
            let slack = (up + down) * BREAKAWAY_SLACK;
            see(
                EventFunction::Break(side),
                min(up - net, down + net) + slack,
            );
        }
    }

    /// Voltage that would increase a current at its limit, in V.
    #[inline(always)]
    pub(crate) fn pull(&self, m: &Mode<S>, y: &[S]) -> S {
        let limit = self.chain.driver.limit_a.unwrap_or_else(S::zero);
        self.excess(y) * m.flow_sign
            - self.chain.driver.drop(m.flow_sign)
            - self.resistance(y) * limit
    }

    pub(crate) fn presliding(&self) -> bool {
        self.chain.mechanical.break_in_angle_rad.is_some()
    }

    #[inline(always)]
    pub(crate) fn sum_of_torques(&self, m: &Mode<S>, y: &[S]) -> S {
        let (motor, load) = self.torques(m, y);
        motor + load
    }

    /// A side's breakaway levels forward and back.
    #[inline(always)]
    pub(crate) fn levels(&self, m: &Mode<S>, side: usize, y: &[S]) -> (S, S) {
        let torque = match self.chain.mechanical.load_friction {
            Some(_) => self.motor_torque(m, y),
            None => S::zero(),
        };
        let level = |s| self.chain.mechanical.breakaway(s, torque) * self.share[side];
        (level(1.0), level(-1.0))
    }

    /// Torque of the motor side on the load while both move together.
    #[inline(always)]
    pub(crate) fn flank_torque(&self, m: &Mode<S>, y: &[S]) -> S {
        let (motor, load) = self.torques(m, y);
        let speed = y[W1];
        let friction1 = self.friction(m, 0, y[TH1], speed, y);
        let friction2 = self.friction(m, 1, y[y.len() - 2], speed, y);
        let viscous = (self.damping(m, 0) + self.damping(m, 1)) * speed;
        let acceleration = (motor + load - viscous - friction1 - friction2) / self.inertia[2];
        self.inertia[1] * acceleration + self.damping(m, 1) * speed + friction2 - load
    }

    /// Lowest and highest flank torque that keeps both sides at rest in contact, and what limits it.
    #[inline(always)]
    pub(crate) fn stuck_flank_range(&self, m: &Mode<S>, y: &[S]) -> ((S, Holder), (S, Holder)) {
        let (motor, load) = self.torques(m, y);
        let (up1, down1) = self.levels(m, 0, y);
        let (up2, down2) = self.levels(m, 1, y);
        let mut low = (motor - up1, Holder::Motor);
        let mut high = (motor + down1, Holder::Motor);
        let mut raise = |torque: S, by| {
            if torque.value() > low.0.value() {
                low = (torque, by);
            }
        };
        raise(-down2 - load, Holder::Load);
        match (m.contact, self.chain.transmission.clutch_nm) {
            (Contact::Upper, _) => raise(S::zero(), Holder::Flank),
            (Contact::Gripped, Some(most)) => raise(-most, Holder::Flank),
            _ => {}
        }
        let mut lower = |torque: S, by| {
            if torque.value() < high.0.value() {
                high = (torque, by);
            }
        };
        lower(up2 - load, Holder::Load);
        match (m.contact, self.chain.transmission.clutch_nm) {
            (Contact::Lower, _) => lower(S::zero(), Holder::Flank),
            (Contact::Gripped, Some(most)) => lower(most, Holder::Flank),
            _ => {}
        }
        (low, high)
    }
}
