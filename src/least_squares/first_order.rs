//! The first-order motor in closed form.
//!
//! `T w' + w = K (u - F sgn w)` while the shaft turns; at rest it stays for `|u| <= F`, and else turns in the
//! direction of `u`. `K` is the gain in rad/s per unit of the command, `T` the time constant in s, `F` Coulomb
//! friction in units of the command: volts for a voltage-driven motor. With a command that is constant between
//! samples
//!
//! `w(t) = w_e + (w_0 - w_e) exp(-t/T)`, `theta(t) = w_e t + (w_0 - w_e) T (1 - exp(-t/T))`, `w_e = K (u - F sgn w)`,
//!
//! and the shaft comes to rest at `t = T ln(1 - w_0/w_e)` if `w_e` has the opposite sign. The solution is
//! proportional to `K`, so that it is computed once for all gains. Source: the lab handout's motor without
//! inductance; for the step response any control textbook (Ogata, Modern Control Engineering, first-order systems).

/// Parameters of a first-order motor besides its gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrder {
    /// Time constant in s.
    pub time_constant_s: f64,
    /// Coulomb friction in units of the command.
    pub friction: f64,
}

/// Speed and angle for a gain of one: in units of the command, and that times s.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    speed: f64,
    angle: f64,
}

impl FirstOrder {
    /// The angle at each sample for a gain of one, relative to the first sample; `start` is the initial speed.
    pub fn angles(&self, t_s: &[f64], command: &[f64], start: f64) -> Vec<f64> {
        let mut state = State {
            speed: start,
            angle: 0.0,
        };
        let mut angles = Vec::with_capacity(t_s.len());
        angles.push(state.angle);
        for (pair, u) in t_s.windows(2).zip(command) {
            self.advance(&mut state, *u, pair[1] - pair[0]);
            angles.push(state.angle);
        }
        angles
    }

    /// One step with a constant command.
    fn advance(&self, state: &mut State, command: f64, span_s: f64) {
        let mut left_s = span_s;
        // At most to rest and away from it, after which the command drives in the direction of motion.
        for _ in 0..2 {
            let direction = if state.speed != 0.0 {
                state.speed.signum()
            } else if command.abs() > self.friction {
                command.signum()
            } else {
                return;
            };
            let end = command - self.friction * direction;
            let rests_s = if end * direction < 0.0 {
                self.time_constant_s * (-state.speed / end).ln_1p()
            } else {
                f64::INFINITY
            };
            if rests_s >= left_s {
                self.turn(state, end, left_s);
                return;
            }
            self.turn(state, end, rests_s);
            state.speed = 0.0;
            left_s -= rests_s;
        }
    }

    /// Motion in one direction, towards the speed `end`.
    fn turn(&self, state: &mut State, end: f64, span_s: f64) {
        let settled = -(-span_s / self.time_constant_s).exp_m1();
        let off = state.speed - end;
        state.angle += end * span_s + off * self.time_constant_s * settled;
        state.speed -= off * settled;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor with simple values in the closed form.
    const MOTOR: FirstOrder = FirstOrder {
        time_constant_s: 0.5,
        friction: 1.0,
    };

    #[test]
    fn a_step_response_is_the_textbook_solution() {
        let t_s: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.07).collect();
        let angles = MOTOR.angles(&t_s, &vec![3.0; t_s.len()], 0.0);
        for (t, angle) in t_s.iter().zip(angles) {
            let expected = 2.0 * (t - 0.5 * (1.0 - (-t / 0.5).exp()));
            assert!((angle - expected).abs() < 1e-12, "{angle} at {t}");
        }
    }

    /// Switched off at speed 2: `w = -1 + 3 exp(-t/T)` is 0 at `T ln 3`, where `theta = T (2 - ln 3)`; it stays
    /// there.
    #[test]
    fn friction_stops_the_shaft_within_a_step_and_holds_it() {
        let angles = MOTOR.angles(&[0.0, 1.0, 2.0], &[0.0, 0.9, 0.0], 2.0);
        let expected = 0.5 * (2.0 - 3.0_f64.ln());
        assert!((angles[1] - expected).abs() < 1e-12, "{angles:?}");
        assert_eq!(angles[1], angles[2]);
    }

    /// Reversed at speed 2 by a command of -3: to rest at `T ln(1 + 2/4)`, then a step of -2.
    #[test]
    fn a_reversal_passes_through_rest() {
        let angles = MOTOR.angles(&[0.0, 1.0], &[-3.0, 0.0], 2.0);
        let rests_s = 0.5 * 1.5_f64.ln();
        let there = -4.0 * rests_s + 6.0 * 0.5 * (1.0 - 1.0 / 1.5);
        let left_s = 1.0 - rests_s;
        let back = -2.0 * (left_s - 0.5 * (1.0 - (-left_s / 0.5).exp()));
        assert!((angles[1] - there - back).abs() < 1e-12, "{angles:?}");
    }

    #[test]
    fn a_shaft_below_breakaway_stays_at_rest() {
        assert_eq!(MOTOR.angles(&[0.0, 1.0, 2.0], &[1.0; 3], 0.0), [0.0; 3]);
    }
}
