//! When a mode ends, and which one follows.
//!
//! A guard is positive while its mode holds. The laws: a side sticks when its speed is 0 and the net torque without
//! friction is within the breakaway level, and leaves when it is not; current that reaches 0 stays there while the
//! voltage drop exceeds what drives it; current at its limit stays there while it would be driven further; flanks meet
//! plastically, part when they would have to pull, and at rest stay while some pushing torque holds either side.

use super::dynamics::{CUR, Contact, Flow, Machine, Mode, ONE_BODY, TH1, W1};
use super::scalar::Scalar;
use crate::CommandKind;

/// What a mode can end with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Guard {
    CurrentZero,
    Unblock,
    Limit,
    Unlimit,
    TorqueZero,
    /// A side's speed reaches 0 (0: motor side or the whole of a rigid motor, 1: load side).
    Stop(usize),
    /// A side leaves rest.
    Break(usize),
    TouchUpper,
    TouchLower,
    /// Flanks that move as one would have to pull.
    Part,
    StopJoint,
    BreakJoint,
}

/// The guards of a mode with their values.
pub(super) struct Guards<S> {
    items: [(Guard, S); 8],
    len: usize,
}

/// By how much of its level a load must exceed static friction to break away. A body that creeps into its equilibrium
/// comes to rest exactly on the level, where rounding alone would make it stick and slip for ever.
const BREAKAWAY_SLACK: f64 = 1e-9;

impl<S: Scalar> Guards<S> {
    fn new() -> Self {
        Self {
            items: [(Guard::Part, S::zero()); 8],
            len: 0,
        }
    }

    #[inline(always)]
    fn push(&mut self, guard: Guard, value: S) {
        self.items[self.len] = (guard, value);
        self.len += 1;
    }

    /// Guards and values.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Guard, S)> + '_ {
        self.items[..self.len].iter().copied()
    }
}

fn min<S: Scalar>(a: S, b: S) -> S {
    if b.value() < a.value() { b } else { a }
}

fn max<S: Scalar>(a: S, b: S) -> S {
    if b.value() > a.value() { b } else { a }
}

/// What holds a limit of the flank torque of two sides at rest.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Holder {
    Motor,
    Load,
    Flank,
}

impl<S: Scalar> Machine<S> {
    /// The guards of the mode in force.
    #[inline(never)]
    pub(super) fn guards<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> Guards<S> {
        self.guards_inline(m, y)
    }

    /// The same, for the innermost loop.
    #[inline(always)]
    pub(super) fn guards_inline<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> Guards<S> {
        let mut g = Guards::new();
        self.current_guards(m, y, &mut g);
        if N <= ONE_BODY {
            if self.frictionless && !self.presliding() {
                return g;
            }
            self.side_guard(m, 0, y[W1], || self.sum_of_torques(m, y), y, &mut g);
        } else if self.joined(m) {
            if m.slip[0] != 0.0 {
                g.push(Guard::StopJoint, y[W1] * m.slip[0]);
                g.push(Guard::Part, self.flank_torque(m, y) * m.contact.sign());
            } else {
                let (low, high) = self.stuck_flank_range(m, y);
                g.push(Guard::BreakJoint, high.0 - low.0);
            }
        } else {
            if let Some(gap) = self.chain.transmission.gap_rad {
                self.play_guards(m, gap, y, &mut g);
            }
            self.side_guard(m, 0, y[W1], || self.torques(m, y).0, y, &mut g);
            self.side_guard(m, 1, y[N - 1], || self.torques(m, y).1, y, &mut g);
        }
        g
    }

    #[inline]
    fn play_guards<const N: usize>(&self, m: &Mode<S>, gap: S, y: &[S; N], g: &mut Guards<S>) {
        if m.contact.sign() != 0.0 {
            let push = self.spring_torque(m.contact, y) * m.contact.sign();
            g.push(Guard::Part, push);
            return;
        }
        let apart = y[TH1] - y[N - 2];
        let (mut upper, mut lower) = (gap * 0.5 - apart, gap * 0.5 + apart);
        if !self.welds {
            // A spring beyond its flank that springs back slower than the sides part touches again when it would push.
            upper = max(upper, -self.spring_torque(Contact::Upper, y));
            lower = max(lower, self.spring_torque(Contact::Lower, y));
        }
        g.push(Guard::TouchUpper, upper);
        g.push(Guard::TouchLower, lower);
    }

    #[inline(always)]
    fn current_guards<const N: usize>(&self, m: &Mode<S>, y: &[S; N], g: &mut Guards<S>) {
        if self.chain.kind == CommandKind::Voltage {
            let driver = &self.chain.driver;
            match m.flow {
                Flow::Free => {
                    if m.flow_sign != 0.0 {
                        let through = if self.inductive {
                            y[CUR] * m.flow_sign
                        } else {
                            self.excess(y) * m.flow_sign - driver.drop()
                        };
                        g.push(Guard::CurrentZero, through);
                    }
                    if let Some(limit) = driver.limit_a {
                        g.push(Guard::Limit, limit - self.current(m, y).abs());
                    }
                }
                Flow::Blocked => g.push(Guard::Unblock, driver.drop() - self.excess(y).abs()),
                Flow::Held => g.push(Guard::Unlimit, self.pull(m, y)),
                Flow::Open => {}
            }
        }
        if self.chain.mechanical.load_friction.is_some()
            && m.flow == Flow::Free
            && (m.slip[0] != 0.0 || m.slip[1] != 0.0)
        {
            g.push(Guard::TorqueZero, self.current(m, y) * m.torque_sign);
        }
    }

    #[inline(always)]
    fn side_guard<const N: usize>(
        &self,
        m: &Mode<S>,
        side: usize,
        speed: S,
        net: impl Fn() -> S,
        y: &[S; N],
        g: &mut Guards<S>,
    ) {
        if m.slip[side] != 0.0 {
            g.push(Guard::Stop(side), speed * m.slip[side]);
        } else {
            let (net, (up, down)) = (net(), self.levels(m, side, y));
            let slack = (up + down) * BREAKAWAY_SLACK;
            g.push(Guard::Break(side), min(up - net, down + net) + slack);
        }
    }

    /// By how much current at the limit would be driven further, in V.
    fn pull<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> S {
        let limit = self.chain.driver.limit_a.unwrap_or_else(S::zero);
        self.excess(y) * m.flow_sign - self.chain.driver.drop() - self.resistance(y) * limit
    }

    fn presliding(&self) -> bool {
        self.chain.mechanical.break_in_angle_rad.is_some()
    }

    fn sum_of_torques<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> S {
        let (motor, load) = self.torques(m, y);
        motor + load
    }

    /// A side's breakaway levels forward and back.
    fn levels<const N: usize>(&self, m: &Mode<S>, side: usize, y: &[S; N]) -> (S, S) {
        let torque = self.motor_torque(m, y);
        let level = |s| self.chain.mechanical.breakaway(s, torque) * self.share[side];
        (level(1.0), level(-1.0))
    }

    /// Torque by which the motor side pushes the load while both move as one.
    fn flank_torque<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> S {
        let (motor, load) = self.torques(m, y);
        let speed = y[W1];
        let friction1 = self.friction(m, 0, y[TH1], speed, y);
        let friction2 = self.friction(m, 1, y[N - 2], speed, y);
        let viscous = (self.viscous[0] + self.viscous[1]) * speed;
        let acceleration = (motor + load - viscous - friction1 - friction2) / self.inertia[2];
        self.inertia[1] * acceleration + self.viscous[1] * speed + friction2 - load
    }

    /// The flank torques that keep both sides at rest while they touch: lowest and highest, and what sets them.
    fn stuck_flank_range<const N: usize>(
        &self,
        m: &Mode<S>,
        y: &[S; N],
    ) -> ((S, Holder), (S, Holder)) {
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
        if m.contact == Contact::Upper {
            raise(S::zero(), Holder::Flank);
        }
        let mut lower = |torque: S, by| {
            if torque.value() < high.0.value() {
                high = (torque, by);
            }
        };
        lower(up2 - load, Holder::Load);
        if m.contact == Contact::Lower {
            lower(S::zero(), Holder::Flank);
        }
        (low, high)
    }

    /// Changes mode and state after a guard fell through 0, or after a change of the command.
    pub(super) fn settle<const N: usize>(
        &self,
        m: &mut Mode<S>,
        y: &mut [S; N],
        fired: Option<Guard>,
    ) {
        let before = *m;
        self.settle_current(m, y, fired);
        if fired == Some(Guard::TorqueZero) {
            m.torque_sign = -m.torque_sign;
        } else {
            let current = self.current(m, y);
            m.torque_sign = if current.value() != 0.0 {
                current.sign()
            } else {
                self.excess(y).sign()
            };
        }
        if N <= ONE_BODY {
            self.settle_rigid(m, y, fired);
        } else {
            self.settle_two(m, y, fired);
        }
        if let (Some(break_in), angles) = (
            self.chain.mechanical.break_in_angle_rad,
            [y[TH1], if N > ONE_BODY { y[N - 2] } else { y[TH1] }],
        ) {
            for (side, angle) in angles.into_iter().enumerate() {
                if m.slip[side] != before.slip[side] {
                    let torque = if before.slip[side] == 0.0 {
                        before.anchor[side].1
                    } else {
                        self.dahl(&before, side, angle, break_in)
                    };
                    m.anchor[side] = (angle, torque);
                }
            }
        }
    }

    fn settle_rigid<const N: usize>(&self, m: &mut Mode<S>, y: &mut [S; N], fired: Option<Guard>) {
        if self.frictionless && !self.presliding() {
            m.slip[0] = 1.0;
            return;
        }
        if fired == Some(Guard::Stop(0)) {
            y[W1] = S::zero();
        }
        let net = self.sum_of_torques(m, y);
        m.slip[0] = self.slip_after(m, 0, y[TH1], y[W1], net, fired, y);
    }

    /// The direction in which a side slips from here on; 0 where it sticks.
    #[allow(clippy::too_many_arguments)]
    fn slip_after<const N: usize>(
        &self,
        m: &Mode<S>,
        side: usize,
        angle: S,
        speed: S,
        net: S,
        fired: Option<Guard>,
        y: &[S; N],
    ) -> f64 {
        if speed.value() != 0.0 {
            return speed.sign();
        }
        if let Some(break_in) = self.chain.mechanical.break_in_angle_rad {
            // Friction builds up from here: the side never sticks.
            if fired == Some(Guard::Stop(side)) {
                return -m.slip[side];
            }
            let friction = if m.slip[side] == 0.0 {
                m.anchor[side].1
            } else {
                self.dahl(m, side, angle, break_in)
            };
            let left = net - friction;
            return if left.value() != 0.0 {
                left.sign()
            } else {
                self.excess(y).sign()
            };
        }
        if fired == Some(Guard::Break(side)) {
            return net.sign();
        }
        let (up, down) = self.levels(m, side, y);
        // A side that broke away at this very instant still has speed 0 and sits on its level to rounding.
        let edge = if m.slip[side] > 0.0 {
            net - up
        } else {
            -down - net
        };
        let stopped = fired == Some(Guard::Stop(side));
        if !stopped && m.slip[side] != 0.0 && edge.value().abs() < 1e-13 {
            return m.slip[side];
        }
        let slack = (up.value() + down.value()) * BREAKAWAY_SLACK;
        if net.value() > up.value() + slack {
            1.0
        } else if net.value() < -down.value() - slack {
            -1.0
        } else {
            0.0
        }
    }

    fn settle_two<const N: usize>(&self, m: &mut Mode<S>, y: &mut [S; N], fired: Option<Guard>) {
        let (th2, w2) = (N - 2, N - 1);
        match fired {
            Some(Guard::TouchUpper | Guard::TouchLower) => {
                m.contact = if fired == Some(Guard::TouchUpper) {
                    Contact::Upper
                } else {
                    Contact::Lower
                };
            }
            Some(Guard::Part) if !self.welds => m.contact = Contact::Apart,
            _ => {}
        }
        match fired {
            Some(Guard::TouchUpper | Guard::TouchLower) if self.welds => {
                let speed = self.share[0] * y[W1] + self.share[1] * y[w2];
                (y[W1], y[w2]) = (speed, speed);
                let gap = self.chain.transmission.gap_rad.unwrap_or_else(S::zero);
                y[th2] = y[TH1] - gap * (0.5 * m.contact.sign());
            }
            Some(Guard::StopJoint) => (y[W1], y[w2]) = (S::zero(), S::zero()),
            _ => {}
        }
        if self.joined(m) {
            self.settle_contact(m, y, fired);
        }
        if !self.joined(m) {
            match fired {
                Some(Guard::Stop(0)) => y[W1] = S::zero(),
                Some(Guard::Stop(1)) => y[w2] = S::zero(),
                _ => {}
            }
            let (motor, load) = self.torques(m, y);
            m.slip[0] = self.slip_after(m, 0, y[TH1], y[W1], motor, fired, y);
            m.slip[1] = self.slip_after(m, 1, y[th2], y[w2], load, fired, y);
        }
    }

    fn settle_contact<const N: usize>(
        &self,
        m: &mut Mode<S>,
        y: &mut [S; N],
        fired: Option<Guard>,
    ) {
        if y[W1].value() != 0.0 || self.presliding() {
            let direction = if y[W1].value() != 0.0 {
                y[W1].sign()
            } else if fired == Some(Guard::StopJoint) {
                -m.slip[0]
            } else {
                self.sum_of_torques(m, y).sign()
            };
            m.slip = [direction; 2];
            if fired == Some(Guard::Part) || self.parts(m, y) {
                m.contact = Contact::Apart;
            }
            return;
        }
        let ((low, low_by), (high, high_by)) = self.stuck_flank_range(m, y);
        m.slip = [0.0; 2];
        if fired != Some(Guard::BreakJoint) && low.value() <= high.value() {
            return;
        }
        // The two binding limits say what gives way. A flank cannot pull: a side bound against it leaves alone.
        if low_by == Holder::Flank || high_by == Holder::Flank {
            m.contact = Contact::Apart;
            if low_by == Holder::Motor || high_by == Holder::Motor {
                m.slip[0] = if low_by == Holder::Motor { 1.0 } else { -1.0 };
            } else {
                m.slip[1] = if high_by == Holder::Load { 1.0 } else { -1.0 };
            }
        } else {
            m.slip = [if low_by == Holder::Motor { 1.0 } else { -1.0 }; 2];
        }
    }

    /// Whether sides that touch and slip as one would have to pull; at no torque, its rate of change decides.
    fn parts<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> bool {
        let mut push = self.flank_torque(m, y).value() * m.contact.sign();
        if push.abs() < 1e-12 {
            let rate = self.rate(m, y);
            let mut ahead = *y;
            for (value, slope) in ahead.iter_mut().zip(rate) {
                *value += slope * 1e-7;
            }
            push = self.flank_torque(m, &ahead).value() * m.contact.sign();
        }
        push < 0.0
    }

    fn settle_current<const N: usize>(
        &self,
        m: &mut Mode<S>,
        y: &mut [S; N],
        fired: Option<Guard>,
    ) {
        let driver = &self.chain.driver;
        if self.chain.kind != CommandKind::Voltage {
            let mut current = self.voltage;
            if self.chain.kind == CommandKind::Torque {
                current = current / self.chain.electrical.torque_constant_nm_per_a;
            }
            if let Some(limit) = driver.limit_a.filter(|l| l.value() < current.value().abs()) {
                current = limit * current.sign();
            }
            (m.flow, y[CUR]) = (Flow::Held, current);
            return;
        }
        if driver.coast && self.command == 0.0 {
            (m.flow, m.flow_sign, y[CUR]) = (Flow::Open, 0.0, S::zero());
            return;
        }
        if !self.inductive {
            self.settle_algebraic_current(m, y, fired);
            return;
        }
        let drop = driver.drop();
        if fired == Some(Guard::Limit) {
            let limit = driver.limit_a.unwrap_or_else(S::zero);
            (m.flow, m.flow_sign) = (Flow::Held, y[CUR].sign());
            y[CUR] = limit * m.flow_sign;
            return;
        }
        if m.flow == Flow::Held {
            if fired == Some(Guard::Unlimit) || self.pull(m, y).value() < 0.0 {
                m.flow = Flow::Free;
                if driver.drop_v.is_none() {
                    m.flow_sign = 0.0;
                }
            }
            return;
        }
        if driver.drop_v.is_none() {
            (m.flow, m.flow_sign) = (Flow::Free, 0.0);
            return;
        }
        if fired == Some(Guard::CurrentZero) {
            y[CUR] = S::zero();
        }
        let excess = self.excess(y);
        if fired == Some(Guard::Unblock) {
            (m.flow, m.flow_sign) = (Flow::Free, excess.sign());
        } else if y[CUR].value() != 0.0 {
            (m.flow, m.flow_sign) = (Flow::Free, y[CUR].sign());
        } else if m.flow == Flow::Free
            && m.flow_sign != 0.0
            && !matches!(fired, None | Some(Guard::CurrentZero))
        {
            // Current has just begun to flow: still 0 at this instant.
        } else if excess.value().abs() > drop.value() {
            (m.flow, m.flow_sign) = (Flow::Free, excess.sign());
        } else {
            (m.flow, m.flow_sign) = (Flow::Blocked, 0.0);
        }
    }

    /// Without inductance the current follows at once: which branch holds is read off the voltages.
    fn settle_algebraic_current<const N: usize>(
        &self,
        m: &mut Mode<S>,
        y: &mut [S; N],
        fired: Option<Guard>,
    ) {
        let driver = &self.chain.driver;
        let excess = self.excess(y);
        let sign = excess.sign();
        let over = excess.value().abs() - driver.drop().value();
        let limit = driver.limit_a;
        let blocked = match fired {
            Some(Guard::CurrentZero) => true,
            Some(Guard::Unblock) => false,
            _ => driver.drop_v.is_some() && over <= 0.0,
        };
        let limited = match (fired, limit) {
            (_, None) => false,
            (Some(Guard::Limit), _) => true,
            (Some(Guard::Unlimit), _) => false,
            (_, Some(limit)) => over > limit.value() * self.resistance(y).value(),
        };
        (m.flow, m.flow_sign, y[CUR]) = if blocked {
            (Flow::Blocked, 0.0, S::zero())
        } else if limited {
            (Flow::Held, sign, limit.unwrap_or_else(S::zero) * sign)
        } else {
            let kept = if driver.drop_v.is_some() { sign } else { 0.0 };
            (Flow::Free, kept, S::zero())
        };
    }
}
