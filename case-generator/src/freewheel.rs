//! The winding behind a pulsed bridge whose current decays through diodes between the pulses.
//!
//! Within a pulse, between pulses, and without current, the winding is a resistance, an inductance and a constant
//! voltage: solved exactly between switching instants.

use crate::motor::Motor;
use crate::true_motor::Pulses;

/// One step of the plant, during which supply, back EMF and resistance are constant.
pub(crate) struct WindingStep {
    pub(crate) volts: f64,
    pub(crate) emf: f64,
    pub(crate) resistance: f64,
    pub(crate) duty: f64,
    /// Begin of the step since the first pulse, in s.
    pub(crate) now_s: f64,
    /// Its length in s.
    pub(crate) h: f64,
}

impl WindingStep {
    /// The current in A at the end of the step, and its mean over the step.
    pub(crate) fn freewheel(&self, pulses: Pulses, m: &Motor, current: f64) -> (f64, f64) {
        let (s, duty) = (self.duty.signum(), self.duty.abs().min(1.0));
        let (on_v, against_v) = (self.volts * s / duty, self.emf * s);
        let rate = self.resistance / m.inductance_h;
        let period = pulses.period_ratio * m.inductance_h / m.resistance_ohm;
        let mut current = current * s;
        let (mut left, mut passed) = (self.h, 0.0);
        let mut phase_s = (self.now_s / period).fract() * period;
        while left > 0.0 {
            let is_on = phase_s < duty * period;
            let edge = if is_on { duty * period } else { period };
            let mut dt = left.min(edge - phase_s).max(f64::EPSILON * period);
            // The supply, the drop of a diode, or the back EMF.
            let terminal_v = if is_on || current < 0.0 || against_v > on_v {
                on_v
            } else if pulses.into_supply {
                -on_v
            } else {
                0.0
            };
            let goal = (terminal_v - against_v) / self.resistance;
            let reaches_zero = !is_on && current * goal < 0.0;
            let blocked = !is_on && current == 0.0 && goal < 0.0 && against_v <= on_v;
            if reaches_zero {
                // The diode blocks when the current reaches 0.
                dt = dt.min((1.0 - current / goal).ln() / rate);
            }
            if blocked {
                current = 0.0;
            } else {
                let fade = (-rate * dt).exp();
                let next = goal + (current - goal) * fade;
                passed += goal * dt + (current - goal) * (1.0 - fade) / rate;
                current = if reaches_zero && next * goal >= -1e-12 * goal * goal {
                    0.0
                } else {
                    next
                };
            }
            left -= dt;
            phase_s = if phase_s + dt >= period {
                0.0
            } else {
                phase_s + dt
            };
        }
        (current * s, passed / self.h * s)
    }
}
