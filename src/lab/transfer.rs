//! The handout's transfer functions with numerical values: poles, time constants, steady speed, step response.
//!
//! `G(s) = w(s) / V(s) = Kt / (L J s^2 + (J R + L b) s + (R b + Kt Kb))`; the first order has L = 0.

use serde::Serialize;

use crate::motor::Parameters;

/// Poles nearer than this, relative to their mean, are treated as a double pole with a small split.
const NEARLY_DOUBLE: f64 = 1e-4;

/// A constant over a polynomial of second degree or less.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TransferFunction {
    /// Numerator: Kt in N m/A.
    pub numerator: f64,
    /// Coefficients of s^2, s and 1 in the denominator; that of s^2 is 0 at first order.
    pub denominator: [f64; 3],
}

/// A pole in 1/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pole {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl TransferFunction {
    /// From voltage to speed with the winding's inductance.
    pub fn second_order(p: &Parameters) -> Self {
        let (r, l, j) = (p.resistance_ohm, p.inductance_h, p.inertia_kg_m2);
        let b = p.viscous_friction_nm_s_per_rad;
        Self {
            numerator: p.torque_constant_nm_per_a,
            denominator: [
                l * j,
                j * r + l * b,
                r * b + p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad,
            ],
        }
    }

    /// From voltage to speed with the inductance neglected.
    pub fn first_order(p: &Parameters) -> Self {
        Self::second_order(&Parameters {
            inductance_h: 0.0,
            ..*p
        })
    }

    /// The poles, the slowest first.
    pub fn poles(&self) -> Vec<Pole> {
        let [a, b, c] = self.denominator;
        let real = |re: f64| Pole { re, im: 0.0 };
        if a == 0.0 {
            return vec![real(-c / b)];
        }
        let discriminant = b * b - 4.0 * a * c;
        if discriminant < 0.0 {
            let (re, im) = (-b / (2.0 * a), (-discriminant).sqrt() / (2.0 * a));
            return vec![Pole { re, im }, Pole { re, im: -im }];
        }
        // The larger root first; the other from their product, without cancellation.
        let q = -0.5 * (b + discriminant.sqrt());
        vec![real(c / q), real(q / a)]
    }

    /// Time constants `-1 / Re(pole)` in s, the slowest first; none for a pole at 0.
    pub fn time_constants_s(&self) -> Vec<f64> {
        let poles = self.poles();
        let decaying = poles.iter().filter(|pole| pole.re < 0.0);
        decaying.map(|pole| -1.0 / pole.re).collect()
    }

    /// Steady speed over voltage in rad/s per V; `None` if the speed is unlimited.
    pub fn steady_gain(&self) -> Option<f64> {
        let constant = self.denominator[2];
        (constant > 0.0).then(|| self.numerator / constant)
    }

    /// Speed in rad/s at `t_s` after a step of `volts` from rest.
    pub fn step_speed(&self, volts: f64, t_s: f64) -> f64 {
        let [a, b, c] = self.denominator;
        let drive = self.numerator * volts;
        if c == 0.0 {
            // b w + a w' = drive t: a ramp delayed by a / b.
            let held_back = if a == 0.0 {
                0.0
            } else {
                -(a / b) * (-t_s * b / a).exp_m1()
            };
            return drive / b * (t_s - held_back);
        }
        let steady = drive / c;
        if a == 0.0 {
            return -steady * (-t_s * c / b).exp_m1();
        }
        let mean = -0.5 * b / a;
        let split_squared = mean * mean - c / a;
        let split = split_squared.abs().sqrt();
        if split_squared > 0.0 && split > -NEARLY_DOUBLE * mean {
            let (slow, fast) = (c / (a * (mean - split)), mean - split);
            let left = (fast * (slow * t_s).exp() - slow * (fast * t_s).exp()) / (slow - fast);
            return steady * (1.0 + left);
        }
        let x = split * t_s;
        let (even, odd) = if split == 0.0 {
            (1.0, t_s)
        } else if split_squared > 0.0 {
            (x.cosh(), x.sinh() / split)
        } else {
            (x.cos(), x.sin() / split)
        };
        steady * (1.0 - (mean * t_s).exp() * (even - mean * odd))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_inductance(inductance_h: f64) -> TransferFunction {
        TransferFunction::second_order(&Parameters {
            inductance_h,
            ..Parameters::default()
        })
    }

    #[test]
    fn the_handouts_transfer_function_has_its_documented_numbers() {
        // By hand: L J = 8e-6, J R + L b = 0.02004, R b + Kt Kb = 0.59.
        let second = with_inductance(0.004);
        for (found, expected) in second.denominator.into_iter().zip([8e-6, 0.02004, 0.59]) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
        let first = TransferFunction::first_order(&Parameters::default());
        assert!((first.time_constants_s()[0] - 0.02 / 0.59).abs() < 1e-15);
        assert!((first.steady_gain().unwrap() - 0.7 / 0.59).abs() < 1e-15);
    }

    #[test]
    fn poles_are_roots_with_the_right_sum_and_product() {
        // From well separated real poles to a complex pair (the double pole is near L = 0.093 H).
        for inductance_h in [1e-9, 0.004, 0.09, 0.1, 0.5, 5.0] {
            let function = with_inductance(inductance_h);
            let [a, b, c] = function.denominator;
            let poles = function.poles();
            let sum = poles[0].re + poles[1].re;
            let product = poles[0].re * poles[1].re - poles[0].im * poles[1].im;
            assert!((sum * a / b + 1.0).abs() < 1e-12, "{inductance_h}");
            assert!((product * a / c - 1.0).abs() < 1e-12, "{inductance_h}");
            assert!(poles[0].re >= poles[1].re);
        }
    }

    #[test]
    fn the_step_response_solves_the_equation_and_starts_at_rest() {
        let double = {
            // b^2 = 4 a c: (J R + L b)^2 = 4 L J c is quadratic in L; solved here by bisection.
            let [mut low, mut high] = [0.01, 1.0];
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                let [a, b, c] = with_inductance(middle).denominator;
                if b * b > 4.0 * a * c {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            low
        };
        for inductance_h in [
            0.004,
            0.05,
            double * (1.0 - 1e-9),
            double,
            double * (1.0 + 1e-9),
            0.5,
        ] {
            let function = with_inductance(inductance_h);
            let [a, b, c] = function.denominator;
            let w = |t: f64| function.step_speed(4.5, t);
            assert!(w(0.0).abs() < 1e-12);
            for t in [0.002, 0.02, 0.1] {
                let h = 1e-5;
                let first = (w(t + h) - w(t - h)) / (2.0 * h);
                let second = (w(t + h) - 2.0 * w(t) + w(t - h)) / (h * h);
                let left = a * second + b * first + c * w(t);
                assert!(
                    (left / (0.7 * 4.5) - 1.0).abs() < 1e-4,
                    "L = {inductance_h}, {t} s"
                );
            }
            assert!((w(60.0) - function.steady_gain().unwrap() * 4.5).abs() < 1e-9);
        }
    }

    #[test]
    fn without_damping_the_speed_rises_without_limit() {
        let undamped = Parameters {
            back_emf_v_s_per_rad: 0.0,
            viscous_friction_nm_s_per_rad: 0.0,
            ..Parameters::default()
        };
        let function = TransferFunction::second_order(&undamped);
        assert_eq!(function.steady_gain(), None);
        // Kt V / (J R) = 157.5 rad/s^2, later by L / R.
        let found = function.step_speed(4.5, 1.0);
        assert!((found - 157.5 * (1.0 - 0.0004)).abs() < 1e-9, "{found}");
    }
}
