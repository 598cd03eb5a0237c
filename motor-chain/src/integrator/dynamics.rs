//! The chain's equations of motion in the current mode.
//!
//! State `[theta1, w1, i]`, then `P` if the winding warms up, then `theta2, w2` of a separate load. Within a mode -
//! direction of the current, directions of slip or sticking, touching flanks - the equations are smooth:
//!
//! ```text
//! L i'    = v - drop sgn(i) - (R (1 + k P) + d^2 Rs) i - Kb f(theta1) w1
//! tau P'  = i^2 R - P
//! J1 w1'  = Kt f(theta1) i + cogging(theta1) - b1 w1 - friction1 - spring
//! J2 w2'  = spring - gravity(theta2) - drag w2 |w2| - b2 w2 - friction2
//! ```
//!
//! A rigid motor and one with touching flanks have the sum of both. Without inductance `i` is algebraic.

use crate::CommandKind;
use crate::chain::Chain;
use crate::integrator::mode::{Anchor, Contact, Flow, Mode};
use crate::scalar::Scalar;

/// Angle of the motor side in rad.
pub(crate) const TH1: usize = 0;
/// Speed of the motor side in rad/s.
pub(crate) const W1: usize = 1;
/// Current in A.
pub(crate) const CUR: usize = 2;
/// Filtered copper loss in W.
pub(crate) const HEAT: usize = 3;
/// A state with more variables ends with angle and speed of the load side.
pub(crate) const ONE_BODY: usize = 4;

/// Upper bound of the number of state variables.
const ALL: usize = 8;

/// State variables of the largest state: two bodies and a winding that warms up.
pub(crate) const LARGEST: usize = 6;

/// Below this, `(1 - exp(-x)) / x` is `1 - x / 2` to nine digits.
const SMALL: f64 = 1e-5;

/// A chain prepared for simulation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Machine<S> {
    pub chain: Chain<S>,
    /// Inertia of motor side, of load side, of both.
    pub inertia: [S; 3],
    /// Inverse of each.
    pub mobility: [S; 3],
    /// Viscous coefficients of motor side and load side.
    pub viscous: [S; 2],
    /// Share of the friction of each side.
    pub share: [S; 2],
    /// Share of the inertia of each side.
    pub mass_share: [S; 2],
    /// Spring k in N m/rad and damper c in N m s/rad.
    pub spring: Option<(S, S)>,
    /// Flanks are rigid, and touching sides move together.
    pub welds: bool,
    /// Two bodies instead of one.
    pub two: bool,
    /// No friction: nothing sticks.
    pub frictionless: bool,
    /// The equations are affine within a mode.
    pub affine: bool,
    /// All other nonlinear terms are torques and the back EMF.
    pub curved_by_torques: bool,
    /// The back EMF is nonlinear, and the current is a state.
    pub bends_current: bool,
    /// Nonlinear terms depend on this many of the first state variables.
    pub bends_by: usize,
    /// The current is a state.
    pub inductive: bool,
    /// Command after delay and dead zone (V, A or N m).
    pub command: f64,
    /// Voltage at the bridge.
    pub voltage: S,
    /// Resistance added by the supply at this command.
    pub added_resistance: S,
}

impl<S: Scalar> Machine<S> {
    pub(crate) fn new(chain: Chain<S>) -> Self {
        let (m, t) = (&chain.mechanical, &chain.transmission);
        let two = t.two_bodies();
        let load = if two { t.load_fraction } else { S::zero() };
        let mass_share = [-load + 1.0, load];
        let rubs = if two {
            t.load_friction_share()
        } else {
            S::zero()
        };
        let share = [-rubs + 1.0, rubs];
        let total = m.inertia_kg_m2;
        let inertia = [mass_share[0] * total, mass_share[1] * total, total];
        let spring = t.spring.map(|(frequency_hz, damping)| {
            let reduced = inertia[0] * inertia[1] / total;
            let rate = frequency_hz * std::f64::consts::TAU;
            (rate * rate * reduced, damping * rate * reduced * 2.0)
        });
        let ripples = chain.electrical.ripple.is_some();
        let warms = chain.electrical.heating.is_some();
        let pulses = chain.driver.freewheel.is_some() && chain.kind == CommandKind::Voltage;
        let friction_torque =
            m.coulomb_nm.value() != 0.0 || m.stribeck.is_some() || m.load_friction.is_some();
        // Direction-dependent terms need the time of reversal.
        let turns = m.viscous_asymmetry.is_some() || m.static_nm.is_some();
        Self {
            inertia,
            mobility: inertia.map(|inertia| S::from(1.0) / inertia),
            viscous: [
                share[0] * m.viscous_nm_s_per_rad,
                share[1] * m.viscous_nm_s_per_rad,
            ],
            share,
            mass_share,
            spring,
            welds: spring.is_none(),
            two,
            frictionless: !two && !friction_torque && !turns,
            affine: m.stribeck.is_none()
                && m.break_in_angle_rad.is_none()
                && m.drag.is_none()
                && m.gravity.is_none()
                && m.cogging.is_none()
                && !ripples
                && !warms
                && !pulses,
            curved_by_torques: !warms && !pulses,
            bends_current: (ripples || pulses) && chain.current_is_state(),
            bends_by: if two || warms || ripples || pulses || m.load_friction.is_some() {
                ALL
            } else if m.stribeck.is_some() || m.drag.is_some() || m.break_in_angle_rad.is_some() {
                W1 + 1
            } else {
                TH1 + 1
            },
            inductive: chain.current_is_state(),
            command: 0.0,
            voltage: S::zero(),
            added_resistance: S::zero(),
            chain,
        }
    }

    /// Whether the winding's loss is a state.
    pub(crate) fn warms(&self) -> bool {
        self.chain.electrical.heating.is_some()
    }

    /// The mode at rest without a command.
    pub(crate) fn initial_mode(&self) -> Mode<S> {
        Mode {
            flow: match self.chain.kind {
                CommandKind::Voltage => Flow::Free,
                CommandKind::Current | CommandKind::Torque => Flow::Held,
            },
            flow_sign: 0.0,
            torque_sign: 1.0,
            slip: [0.0; 2],
            contact: if self.chain.transmission.gap_rad.is_some() {
                Contact::Apart
            } else if self.chain.transmission.clutch_nm.is_some() {
                Contact::Gripped
            } else {
                Contact::NoFlanks
            },
            anchor: [Anchor::at(S::zero()); 2],
        }
    }

    /// Sets the command at the driver.
    pub(crate) fn set_command(&mut self, command: f64) {
        self.command = self.chain.command.pass(command);
        self.voltage = self.chain.driver.voltage(self.command);
        self.added_resistance = self.chain.driver.added_resistance(self.command);
    }

    /// Total resistance of the circuit.
    #[inline(always)]
    pub(crate) fn resistance(&self, y: &[S]) -> S {
        let electrical = &self.chain.electrical;
        let winding = match electrical.heating {
            Some(_) => electrical.resistance(y[HEAT]),
            None => electrical.resistance_ohm,
        };
        winding + self.added_resistance
    }

    /// `Kb f(theta) w`.
    #[inline(always)]
    fn back_emf(&self, y: &[S]) -> S {
        let electrical = &self.chain.electrical;
        let mut emf = electrical.back_emf_v_s_per_rad * y[W1];
        if let Some(per_w) = electrical.weakening_per_w {
            emf = emf * electrical.hot_magnet_factor(per_w, y[HEAT]);
        }
        if electrical.ripple.is_some() {
            emf * electrical.factor(y[TH1])
        } else {
            emf
        }
    }

    /// `v - Kb f(theta) w`: the voltage that drives the current, without the driver's drop.
    #[inline(always)]
    pub(crate) fn excess(&self, y: &[S]) -> S {
        self.drive(self.back_emf(y))
    }

    /// Voltage that drives the current against this back EMF, in V.
    #[inline(always)]
    fn drive(&self, emf: S) -> S {
        match &self.chain.driver.freewheel {
            Some(freewheel) => self.chain.driver.pulsed(freewheel, self.command, emf),
            None => self.voltage - emf,
        }
    }

    /// Current in A.
    #[inline(always)]
    pub(crate) fn current(&self, m: &Mode<S>, y: &[S]) -> S {
        if self.inductive || m.flow != Flow::Free {
            return y[CUR];
        }
        self.current_at(m, y, self.back_emf(y))
    }

    /// Current in A with this back EMF.
    #[inline(always)]
    pub(crate) fn current_at(&self, m: &Mode<S>, y: &[S], emf: S) -> S {
        if self.inductive || m.flow != Flow::Free {
            return y[CUR];
        }
        let mut excess = self.drive(emf);
        if m.flow_sign != 0.0 {
            excess -= self.chain.driver.drop(m.flow_sign) * m.flow_sign;
        }
        excess / self.resistance(y)
    }

    #[inline(always)]
    pub(crate) fn motor_torque(&self, m: &Mode<S>, y: &[S]) -> S {
        let electrical = &self.chain.electrical;
        let mut torque = electrical.torque_constant_nm_per_a * self.current(m, y);
        if let Some(per_w) = electrical.weakening_per_w {
            torque = torque * electrical.hot_magnet_factor(per_w, y[HEAT]);
        }
        if electrical.ripple.is_some() {
            torque * electrical.factor(y[TH1])
        } else {
            torque
        }
    }

    /// Net torque on motor side and load side, without friction, viscous friction and flanks.
    #[inline(always)]
    pub(crate) fn torques(&self, m: &Mode<S>, y: &[S]) -> (S, S) {
        let mechanical = &self.chain.mechanical;
        let mut motor = self.motor_torque(m, y);
        if let Some(cogging) = &mechanical.cogging {
            motor += cogging.at(y[TH1]);
        }
        let (angle, speed) = if y.len() > ONE_BODY {
            (y[y.len() - 2], y[y.len() - 1])
        } else {
            (y[TH1], y[W1])
        };
        let mut load = S::zero();
        if let Some(gravity) = &mechanical.gravity {
            load -= gravity.at(angle);
        }
        if let Some(drag) = mechanical.drag {
            load -= drag * speed * speed.abs();
        }
        if let Some(constant) = mechanical.load_nm {
            load -= constant;
        }
        if self.spring.is_some() && m.contact != Contact::Apart {
            let torque = self.spring_torque(m.contact, y);
            motor -= torque;
            load += torque;
        }
        if let Some(most) = self.chain.transmission.clutch_nm
            && m.contact.slips() != 0.0
        {
            let torque = most * m.contact.slips();
            motor -= torque;
            load += torque;
        }
        (motor, load)
    }

    /// Torque of spring and damper on the load side; with play, of a spring in contact with this flank.
    #[inline(always)]
    pub(crate) fn spring_torque(&self, contact: Contact, y: &[S]) -> S {
        let Some((k, c)) = self.spring else {
            return S::zero();
        };
        let mut twist = y[TH1] - y[y.len() - 2];
        if let Some(gap) = self.chain.transmission.gap_rad {
            twist -= gap * (0.5 * contact.sign());
        }
        k * twist + c * (y[W1] - y[y.len() - 1])
    }

    /// A side's viscous coefficient in its direction of slip.
    #[inline(always)]
    pub(crate) fn damping(&self, m: &Mode<S>, side: usize) -> S {
        match self.chain.mechanical.viscous_asymmetry {
            Some(ratio) => self.viscous[side] * (ratio * m.slip[side] + 1.0),
            None => self.viscous[side],
        }
    }

    /// Whether both sides move together.
    #[inline(always)]
    pub(crate) fn joined(&self, m: &Mode<S>) -> bool {
        self.welds && m.contact.is_in_contact()
    }

    /// Friction torque against the slip of a side (0 or 1; a rigid motor has all of it on side 0).
    #[inline]
    pub(crate) fn friction(&self, m: &Mode<S>, side: usize, angle: S, speed: S, y: &[S]) -> S {
        let s = m.slip[side];
        if s == 0.0 {
            return S::zero();
        }
        match self.chain.mechanical.break_in_angle_rad {
            Some(break_in) => self.dahl(m, side, angle, speed, y, break_in),
            None => self.sliding(m, side, speed, y),
        }
    }

    /// Friction of a side in steady sliding.
    #[inline(always)]
    pub(crate) fn sliding(&self, m: &Mode<S>, side: usize, speed: S, y: &[S]) -> S {
        let (mechanical, s) = (&self.chain.mechanical, m.slip[side]);
        let mut level = mechanical.coulomb(s);
        if let Some(stribeck) = &mechanical.stribeck {
            level += stribeck.at(speed);
        }
        if let Some(load) = &mechanical.load_friction {
            let share = load.share(s * m.torque_sign);
            level += share * self.motor_torque(m, y) * m.torque_sign;
        }
        level * self.share[side] * s
    }

    /// Whether presliding friction follows a sliding friction that is not constant.
    pub(crate) fn follows_sliding(&self) -> bool {
        let mechanical = &self.chain.mechanical;
        let varies = mechanical.stribeck.is_some() || mechanical.load_friction.is_some();
        varies && mechanical.break_in_angle_rad.is_some()
    }

    /// Dahl's friction `dF/dt = sigma (w - |w| F / T)` with stiffness `sigma = Tf / z`, from its last anchor towards
    /// the friction `T` of steady sliding. For constant `T`, `F = T - (T - F0) exp(-x)` with `x = sigma |theta -
    /// theta0| / T` is exact; a `T` that has changed is assumed to be linear in `x`: `F = T - (T0 - F0) exp(-x) - (T
    /// - T0) (1 - exp(-x)) / x`.
    #[inline(never)]
    pub(crate) fn dahl(
        &self,
        m: &Mode<S>,
        side: usize,
        angle: S,
        speed: S,
        y: &[S],
        break_in: S,
    ) -> S {
        let level = self.sliding(m, side, speed, y);
        let (anchor, s) = (&m.anchor[side], m.slip[side]);
        let mut x = (angle - anchor.angle) * s / break_in;
        let dry = self.chain.mechanical.coulomb_nm * self.share[side] * s;
        let mean = (level + anchor.sliding) * 0.5;
        if mean.value() != 0.0 && dry.value() != 0.0 && mean.value() != dry.value() {
            x = x * dry / mean;
        }
        let decay = (-x).exp();
        if !self.follows_sliding() {
            return level - (level - anchor.friction) * decay;
        }
        let lag = if x.value().abs() < SMALL {
            -x * 0.5 + 1.0
        } else {
            (-decay + 1.0) / x
        };
        level - (anchor.sliding - anchor.friction) * decay - (level - anchor.sliding) * lag
    }

    /// Each side's angle and speed.
    #[inline(always)]
    pub(crate) fn sides(&self, y: &[S]) -> [(S, S); 2] {
        let load = if y.len() > ONE_BODY {
            (y[y.len() - 2], y[y.len() - 1])
        } else {
            (y[TH1], y[W1])
        };
        [(y[TH1], y[W1]), load]
    }

    /// Sets the present friction as the anchor of Dahl's law.
    pub(crate) fn anchor(&self, m: &mut Mode<S>, y: &[S]) {
        let Some(break_in) = self.chain.mechanical.break_in_angle_rad else {
            return;
        };
        for (side, (angle, speed)) in self.sides(y).into_iter().enumerate() {
            if m.slip[side] != 0.0 {
                m.anchor[side] = Anchor {
                    angle,
                    friction: self.dahl(m, side, angle, speed, y, break_in),
                    sliding: self.sliding(m, side, speed, y),
                };
            }
        }
    }

    /// Derivative of the state.
    #[inline(always)]
    pub(crate) fn rate<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> [S; N] {
        let mut d = [S::zero(); N];
        self.write_rate(m, y, &mut d);
        d
    }

    /// The same, inlined for the innermost loop.
    #[inline(always)]
    pub(crate) fn rate_inline<const N: usize>(&self, m: &Mode<S>, y: &[S; N]) -> [S; N] {
        let mut d = [S::zero(); N];
        self.write_rate_inline(m, y, &mut d);
        d
    }

    /// Writes the derivative of the state to `d`, which is 0.
    #[inline(never)]
    pub(crate) fn write_rate(&self, m: &Mode<S>, y: &[S], d: &mut [S]) {
        self.write_rate_inline(m, y, d);
    }

    #[inline(always)]
    fn write_rate_inline(&self, m: &Mode<S>, y: &[S], d: &mut [S]) {
        let electrical = &self.chain.electrical;
        if self.inductive && m.flow == Flow::Free {
            let drive = self.excess(y) - self.chain.driver.drop(m.flow_sign) * m.flow_sign;
            d[CUR] = (drive - self.resistance(y) * y[CUR]) / electrical.inductance_h;
        }
        if let Some(heating) = &electrical.heating {
            let current = self.current(m, y);
            d[HEAT] =
                (current * current * electrical.resistance_ohm - y[HEAT]) / heating.time_constant_s;
        }
        let (motor, load) = self.torques(m, y);
        if y.len() <= ONE_BODY {
            if m.slip[0] != 0.0 {
                d[TH1] = y[W1];
                let friction = self.friction(m, 0, y[TH1], y[W1], y);
                d[W1] = (motor + load - self.damping(m, 0) * y[W1] - friction) / self.inertia[0];
            }
        } else {
            let (th2, w2) = (y.len() - 2, y.len() - 1);
            let friction = [
                self.friction(m, 0, y[TH1], y[W1], y),
                self.friction(m, 1, y[th2], y[w2], y),
            ];
            if self.joined(m) {
                if m.slip[0] != 0.0 {
                    d[TH1] = y[W1];
                    d[th2] = y[W1];
                    let viscous = (self.damping(m, 0) + self.damping(m, 1)) * y[W1];
                    d[W1] = (motor + load - viscous - friction[0] - friction[1]) / self.inertia[2];
                    d[w2] = d[W1];
                }
            } else {
                if m.slip[0] != 0.0 {
                    d[TH1] = y[W1];
                    d[W1] = (motor - self.damping(m, 0) * y[W1] - friction[0]) / self.inertia[0];
                }
                if m.slip[1] != 0.0 {
                    d[th2] = y[w2];
                    d[w2] = (load - self.damping(m, 1) * y[w2] - friction[1]) / self.inertia[1];
                }
            }
        }
    }
}
