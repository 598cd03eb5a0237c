//! Splitting of a mode's equations into `y' = A y + n(y)`.
//!
//! `A` is the matrix of the chain without its nonlinear terms: Stribeck friction and presliding, drag, gravity,
//! cogging, ripple, a winding that warms up, discontinuous current. `n(y)` is the rest. If torques and the back EMF
//! are the only nonlinear terms, `n` is the constant term of the linear chain plus these torques over the inertia and
//! that back EMF over the inductance.

use crate::integrator::dynamics::{CUR, HEAT, Machine, ONE_BODY, TH1, W1};
use crate::integrator::mode::{Flow, Mode};
use crate::integrator::step_table::{Matrix, apply};
use crate::scalar::Scalar;

impl<S: Scalar> Machine<S> {
    /// Whether the equations are affine in this mode; at rest nonlinear terms of the angle are constant.
    pub(crate) fn straight<const N: usize>(&self, m: &Mode<S>) -> bool {
        self.affine || (N <= ONE_BODY && m.slip[0] == 0.0 && !self.warms())
    }

    /// The machine without nonlinear terms.
    fn linearised(&self) -> Self {
        let mut other = *self;
        let mechanical = &mut other.chain.mechanical;
        mechanical.stribeck = None;
        mechanical.drag = None;
        mechanical.gravity = None;
        mechanical.cogging = None;
        if mechanical.break_in_angle_rad.take().is_some() {
            mechanical.coulomb_nm = S::zero();
            mechanical.load_friction = None;
        }
        other.chain.electrical.ripple = None;
        if let Some(heating) = &mut other.chain.electrical.heating {
            heating.rise_per_w = S::zero();
        }
        other.chain.electrical.weakening_per_w = None;
        other.chain.driver.freewheel = None;
        other
    }

    /// Matrix of the linear part in this mode.
    #[inline(never)]
    pub(crate) fn matrix<const N: usize>(&self, m: &Mode<S>) -> Matrix<S, N> {
        let mut affine = self.linearised();
        let loss_rate = affine.chain.electrical.heating.take();
        let origin = [S::zero(); N];
        let constant = affine.rate(m, &origin);
        let mut matrix = [[S::zero(); N]; N];
        for column in 0..N {
            let mut y = origin;
            y[column] = S::from(1.0);
            let d = affine.rate(m, &y);
            for row in 0..N {
                matrix[row][column] = d[row] - constant[row];
            }
        }
        if let Some(heating) = loss_rate {
            matrix[HEAT][HEAT] = S::from(-1.0) / heating.time_constant_s;
        }
        matrix
    }

    /// The constant part of `n(y)`, if there is one.
    #[inline(never)]
    pub(crate) fn constant<const N: usize>(&self, m: &Mode<S>) -> [S; N] {
        let origin = [S::zero(); N];
        if self.straight::<N>(m) {
            self.rate(m, &origin)
        } else if self.curved_by_torques {
            self.linearised().rate(m, &origin)
        } else {
            origin
        }
    }

    /// The state-dependent part of `n(y)` for a machine with this matrix.
    #[inline(never)]
    pub(crate) fn curved<const N: usize>(
        &self,
        m: &Mode<S>,
        matrix: &Matrix<S, N>,
        y: &[S; N],
    ) -> [S; N] {
        if self.curved_by_torques {
            let mut n = [S::zero(); N];
            self.bend(m, y, &mut n);
            return n;
        }
        let mut n = self.rate_inline(m, y);
        let linear = apply(matrix, y);
        for k in 0..N {
            n[k] -= linear[k];
        }
        n
    }

    /// The accelerations by nonlinear torques.
    #[inline(always)]
    fn bend<const N: usize>(&self, m: &Mode<S>, y: &[S; N], n: &mut [S; N]) {
        let mechanical = &self.chain.mechanical;
        let (angle, speed) = self.sides(y)[1];
        let (rippling, mut load) = match self.chain.electrical.ripple {
            Some(_) => (self.ripple_torque(m, y, n), S::zero()),
            None => (S::zero(), S::zero()),
        };
        let mut motor = rippling;
        if let Some(cogging) = &mechanical.cogging {
            motor += cogging.at(y[TH1]);
        }
        // Torques on the load act on the total inertia of a rigid motor.
        let driven = if N <= ONE_BODY { &mut motor } else { &mut load };
        if let Some(gravity) = &mechanical.gravity {
            *driven -= gravity.at(angle);
        }
        if let Some(drag) = mechanical.drag {
            *driven -= drag * speed * speed.abs();
        }
        if let Some(friction) = self.curved_friction(m, 0, y[TH1], y[W1], y, rippling) {
            motor -= friction;
        }
        if N <= ONE_BODY {
            if m.slip[0] != 0.0 {
                n[W1] = motor * self.mobility[0];
            }
            return;
        }
        if let Some(friction) = self.curved_friction(m, 1, angle, speed, y, rippling) {
            load -= friction;
        }
        if self.joined(m) {
            if m.slip[0] != 0.0 {
                let acceleration = (motor + load) * self.mobility[2];
                n[W1] = acceleration;
                n[N - 1] = acceleration;
            }
            return;
        }
        if m.slip[0] != 0.0 {
            n[W1] = motor * self.mobility[0];
        }
        if m.slip[1] != 0.0 {
            n[N - 1] = load * self.mobility[1];
        }
    }

    /// The motor's torque due to ripple; the effect of its back EMF on the current is part of `n`.
    #[inline(always)]
    fn ripple_torque<const N: usize>(&self, m: &Mode<S>, y: &[S; N], n: &mut [S; N]) -> S {
        let electrical = &self.chain.electrical;
        let ripple = electrical.factor(y[TH1]) - 1.0;
        let emf = electrical.back_emf_v_s_per_rad * ripple * y[W1];
        let mut torque = ripple * self.current_at(m, y, electrical.back_emf_v_s_per_rad * y[W1]);
        if m.flow == Flow::Free {
            if self.inductive {
                n[CUR] = -emf / electrical.inductance_h;
            } else {
                torque -= (ripple + 1.0) * emf / self.resistance(y);
            }
        }
        electrical.torque_constant_nm_per_a * torque
    }

    /// Part of a side's friction that is neither constant nor proportional to a current without ripple.
    #[inline(always)]
    fn curved_friction<const N: usize>(
        &self,
        m: &Mode<S>,
        side: usize,
        angle: S,
        speed: S,
        y: &[S; N],
        rippling: S,
    ) -> Option<S> {
        let (mechanical, s) = (&self.chain.mechanical, m.slip[side]);
        if s == 0.0 {
            return None;
        }
        let by_speed = match (&mechanical.break_in_angle_rad, &mechanical.stribeck) {
            (Some(break_in), _) => Some(self.dahl(m, side, angle, speed, y, *break_in)),
            (None, Some(stribeck)) => Some(stribeck.at(speed) * self.share[side] * s),
            (None, None) => None,
        };
        match &mechanical.load_friction {
            // Dahl's law has the total torque as its limit.
            Some(load) if mechanical.break_in_angle_rad.is_none() => {
                let share = load.share(s * m.torque_sign);
                let by_torque = share * rippling * m.torque_sign * self.share[side] * s;
                Some(by_speed.map_or(by_torque, |by_speed| by_speed + by_torque))
            }
            _ => by_speed,
        }
    }
}
