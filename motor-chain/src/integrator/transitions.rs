//! Transitions between modes.
//!
//! An event function is positive within its mode. The laws: a side sticks at speed 0 if the net torque without
//! friction is within the breakaway level; current that reaches 0 stays there while the voltage drop exceeds the
//! driving voltage; current at its limit stays there while it would be increased further; flanks meet plastically,
//! separate when they would have to pull, and at rest stay in contact while a pushing torque holds either side; a
//! clutch slips beyond its capacity, and grips again when its sides have reached the same speed.

use crate::CommandKind;
use crate::integrator::dynamics::{CUR, LARGEST, Machine, ONE_BODY, TH1, W1};
use crate::integrator::event_functions::{BREAKAWAY_SLACK, EventFunction, Holder};
use crate::integrator::mode::{Contact, Flow, Mode};
use crate::scalar::Scalar;

impl<S: Scalar> Machine<S> {
    /// Changes mode and state after an event function crossed 0, or after a change of the command.
    pub(crate) fn settle(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
        if self.follows_sliding() {
            self.anchor(m, y);
        }
        let before = *m;
        self.settle_current(m, y, fired);
        if fired == Some(EventFunction::TorqueZero) {
            m.torque_sign = -m.torque_sign;
        } else {
            let current = self.current(m, y);
            m.torque_sign = if current.value() != 0.0 {
                current.sign()
            } else {
                self.excess(y).sign()
            };
        }
        if y.len() <= ONE_BODY {
            self.settle_rigid(m, y, fired);
        } else {
            self.settle_two(m, y, fired);
        }
        if let Some(break_in) = self.chain.mechanical.break_in_angle_rad {
            for (side, (angle, speed)) in self.sides(y).into_iter().enumerate() {
                if m.slip[side] != before.slip[side] {
                    let anchor = &before.anchor[side];
                    let friction = if before.slip[side] == 0.0 {
                        anchor.friction
                    } else {
                        self.dahl(&before, side, angle, speed, y, break_in)
                    };
                    m.anchor[side].angle = angle;
                    m.anchor[side].friction = friction;
                }
                m.anchor[side].sliding = self.sliding(m, side, speed, y);
            }
        }
    }

    fn settle_rigid(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
        if self.frictionless && !self.presliding() {
            m.slip[0] = 1.0;
            return;
        }
        if fired == Some(EventFunction::Stop(0)) {
            y[W1] = S::zero();
        }
        let net = self.sum_of_torques(m, y);
        m.slip[0] = self.slip_after(m, 0, y[TH1], y[W1], net, fired, y);
    }

    /// The direction in which a side begins to slip; 0 if it sticks.
    #[allow(clippy::too_many_arguments)]
    fn slip_after(
        &self,
        m: &Mode<S>,
        side: usize,
        angle: S,
        speed: S,
        net: S,
        fired: Option<EventFunction>,
        y: &[S],
    ) -> f64 {
        if speed.value() != 0.0 {
            return speed.sign();
        }
        if let Some(break_in) = self.chain.mechanical.break_in_angle_rad {
            // Presliding: friction builds up from here, and the side never sticks.
            if fired == Some(EventFunction::Stop(side)) {
                return -m.slip[side];
            }
            let friction = if m.slip[side] == 0.0 {
                m.anchor[side].friction
            } else {
                self.dahl(m, side, angle, speed, y, break_in)
            };
            let left = net - friction;
            return if left.value() != 0.0 {
                left.sign()
            } else {
                self.excess(y).sign()
            };
        }
        if fired == Some(EventFunction::Break(side)) {
            return net.sign();
        }
        let (up, down) = self.levels(m, side, y);
        // A side that has just broken away has speed 0 and is at its level up to rounding.
        let edge = if m.slip[side] > 0.0 {
            net - up
        } else {
            -down - net
        };
        let stopped = fired == Some(EventFunction::Stop(side));
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

    fn settle_two(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
        let (th2, w2) = (y.len() - 2, y.len() - 1);
        match fired {
            Some(EventFunction::TouchUpper | EventFunction::TouchLower) => {
                m.contact = if fired == Some(EventFunction::TouchUpper) {
                    Contact::Upper
                } else {
                    Contact::Lower
                };
            }
            Some(EventFunction::Part) if !self.welds => m.contact = Contact::Apart,
            _ => {}
        }
        match fired {
            Some(EventFunction::TouchUpper | EventFunction::TouchLower) if self.welds => {
                let speed = self.mass_share[0] * y[W1] + self.mass_share[1] * y[w2];
                (y[W1], y[w2]) = (speed, speed);
                let gap = self.chain.transmission.gap_rad.unwrap_or_else(S::zero);
                y[th2] = y[TH1] - gap * (0.5 * m.contact.sign());
            }
            Some(EventFunction::Grip) => {
                let speed = self.mass_share[0] * y[W1] + self.mass_share[1] * y[w2];
                (y[W1], y[w2]) = (speed, speed);
                m.contact = Contact::Gripped;
            }
            Some(EventFunction::StopJoint) => (y[W1], y[w2]) = (S::zero(), S::zero()),
            Some(EventFunction::Stop(0)) => y[W1] = S::zero(),
            Some(EventFunction::Stop(1)) => y[w2] = S::zero(),
            _ => {}
        }
        let rests = y[W1].value() == 0.0 && y[w2].value() == 0.0;
        if m.contact.slips() != 0.0 && rests && !matches!(fired, Some(EventFunction::Break(_))) {
            m.contact = Contact::Gripped;
        }
        if self.joined(m) {
            self.settle_contact(m, y, fired);
        }
        if !self.joined(m) {
            let (motor, load) = self.torques(m, y);
            m.slip[0] = self.slip_after(m, 0, y[TH1], y[W1], motor, fired, y);
            m.slip[1] = self.slip_after(m, 1, y[th2], y[w2], load, fired, y);
        }
    }

    fn settle_contact(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
        if y[W1].value() != 0.0 || self.presliding() {
            let direction = if y[W1].value() != 0.0 {
                y[W1].sign()
            } else if fired == Some(EventFunction::StopJoint) {
                -m.slip[0]
            } else {
                self.sum_of_torques(m, y).sign()
            };
            m.slip = [direction; 2];
            if fired == Some(EventFunction::Give) {
                m.contact = slipping(self.flank_torque(m, y).sign());
            } else if m.contact == Contact::Gripped {
                self.give(m, y);
            } else if fired == Some(EventFunction::Part) || self.parts(m, y) {
                m.contact = Contact::Apart;
            }
            return;
        }
        let ((low, low_by), (high, high_by)) = self.stuck_flank_range(m, y);
        m.slip = [0.0; 2];
        if fired != Some(EventFunction::BreakJoint) && low.value() <= high.value() {
            return;
        }
        // The two active limits determine the transition. A flank cannot pull, nor a clutch exceed its capacity: a
        // side held by either moves alone.
        if low_by == Holder::Flank || high_by == Holder::Flank {
            m.contact = match self.chain.transmission.clutch_nm {
                Some(_) => slipping(if high_by == Holder::Flank { 1.0 } else { -1.0 }),
                None => Contact::Apart,
            };
            if low_by == Holder::Motor || high_by == Holder::Motor {
                m.slip[0] = if low_by == Holder::Motor { 1.0 } else { -1.0 };
            } else {
                m.slip[1] = if high_by == Holder::Load { 1.0 } else { -1.0 };
            }
        } else {
            m.slip = [if low_by == Holder::Motor { 1.0 } else { -1.0 }; 2];
            self.give(m, y);
        }
    }

    /// Lets a clutch beyond its capacity slip, with both sides in motion.
    fn give(&self, m: &mut Mode<S>, y: &[S]) {
        if let Some(most) = self.chain.transmission.clutch_nm {
            let carried = self.flank_torque(m, y);
            if carried.value().abs() > most.value() {
                m.contact = slipping(carried.sign());
            }
        }
    }

    /// Whether sides in contact that slip together would have to pull; at zero torque its derivative decides.
    fn parts(&self, m: &Mode<S>, y: &[S]) -> bool {
        let mut push = self.flank_torque(m, y).value() * m.contact.sign();
        if push.abs() < 1e-12 {
            let mut ahead = [S::zero(); LARGEST];
            let ahead = &mut ahead[..y.len()];
            self.write_rate(m, y, ahead);
            for (slope, value) in ahead.iter_mut().zip(y) {
                *slope = *value + *slope * 1e-7;
            }
            push = self.flank_torque(m, ahead).value() * m.contact.sign();
        }
        push < 0.0
    }

    fn settle_current(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
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
        if fired == Some(EventFunction::Limit) {
            let limit = driver.limit_a.unwrap_or_else(S::zero);
            (m.flow, m.flow_sign) = (Flow::Held, y[CUR].sign());
            y[CUR] = limit * m.flow_sign;
            return;
        }
        if m.flow == Flow::Held {
            if fired == Some(EventFunction::Unlimit) || self.pull(m, y).value() < 0.0 {
                m.flow = Flow::Free;
                if driver.drops_v.is_none() {
                    m.flow_sign = 0.0;
                }
            }
            return;
        }
        if driver.drops_v.is_none() {
            (m.flow, m.flow_sign) = (Flow::Free, 0.0);
            return;
        }
        if fired == Some(EventFunction::CurrentZero) {
            y[CUR] = S::zero();
        }
        let excess = self.excess(y);
        if fired == Some(EventFunction::Unblock) {
            (m.flow, m.flow_sign) = (Flow::Free, excess.sign());
        } else if y[CUR].value() != 0.0 {
            (m.flow, m.flow_sign) = (Flow::Free, y[CUR].sign());
        } else if m.flow == Flow::Free
            && m.flow_sign != 0.0
            && !matches!(fired, None | Some(EventFunction::CurrentZero))
        {
            // The current has just begun to flow: still 0.
        } else if excess.value().abs() > driver.drop(excess.sign()).value() {
            (m.flow, m.flow_sign) = (Flow::Free, excess.sign());
        } else {
            (m.flow, m.flow_sign) = (Flow::Blocked, 0.0);
        }
    }

    /// Without inductance the current is algebraic: its branch follows from the voltages.
    fn settle_algebraic_current(&self, m: &mut Mode<S>, y: &mut [S], fired: Option<EventFunction>) {
        let driver = &self.chain.driver;
        let excess = self.excess(y);
        let sign = excess.sign();
        let over = excess.value().abs() - driver.drop(sign).value();
        let limit = driver.limit_a;
        let blocked = match fired {
            Some(EventFunction::CurrentZero) => true,
            Some(EventFunction::Unblock) => false,
            _ => driver.drops_v.is_some() && over <= 0.0,
        };
        let limited = match (fired, limit) {
            (_, None) => false,
            (Some(EventFunction::Limit), _) => true,
            (Some(EventFunction::Unlimit), _) => false,
            (_, Some(limit)) => over > limit.value() * self.resistance(y).value(),
        };
        (m.flow, m.flow_sign, y[CUR]) = if blocked {
            (Flow::Blocked, 0.0, S::zero())
        } else if limited {
            (Flow::Held, sign, limit.unwrap_or_else(S::zero) * sign)
        } else {
            let kept = if driver.drops_v.is_some() { sign } else { 0.0 };
            (Flow::Free, kept, S::zero())
        };
    }
}

/// A clutch that slips in this direction.
fn slipping(direction: f64) -> Contact {
    if direction > 0.0 {
        Contact::SlipsAhead
    } else {
        Contact::SlipsBack
    }
}
