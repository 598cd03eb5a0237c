//! The true motor of a case, and its nominal motor.
//!
//! The nominal values have a standard deviation of 5 %: `nominal = true (1 + 0.05 n)`, n standard normal, as from a
//! data sheet or a multimeter.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// Relative standard deviation of the nominal values.
pub const NOMINAL_SIGMA: f64 = 0.05;

/// A brushed DC motor with encoder, in SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// Armature resistance R.
    pub resistance_ohm: f64,
    /// Back-EMF constant Kb.
    pub back_emf_v_s_per_rad: f64,
    /// Torque constant Kt.
    pub torque_constant_nm_per_a: f64,
    /// Viscous friction b.
    pub viscous_friction_nm_s_per_rad: f64,
    /// Armature inductance L.
    pub inductance_h: f64,
    /// Inertia J of rotor and load.
    pub inertia_kg_m2: f64,
    /// Coulomb friction torque Tf.
    pub coulomb_friction_nm: f64,
    /// Encoder counts per revolution, x4 decoded.
    pub counts_per_rev: f64,
    /// Driver supply, the largest command.
    pub supply_v: f64,
}

impl Motor {
    /// The motor of the lab handout.
    pub const HANDOUT: Self = Self {
        resistance_ohm: 10.0,
        back_emf_v_s_per_rad: 0.7,
        torque_constant_nm_per_a: 0.7,
        viscous_friction_nm_s_per_rad: 0.01,
        inductance_h: 0.004,
        inertia_kg_m2: 0.002,
        coulomb_friction_nm: 0.02,
        counts_per_rev: 720.0,
        supply_v: 4.5,
    };

    /// A motor drawn around the handout's: every value with 10 % (one sigma, lognormal), or with `other_motors` by up
    /// to a factor of two, with another encoder and another supply.
    pub(crate) fn draw(rng: &mut impl Rng, other_motors: bool) -> Self {
        let mut motor = Self::HANDOUT;
        for figure in motor.figures_mut() {
            *figure *= if other_motors {
                2.0_f64.powf(rng.random_range(-1.0..1.0))
            } else {
                (0.1 * normal(rng)).exp()
            };
        }
        if other_motors {
            const ENCODERS: [f64; 6] = [360.0, 500.0, 720.0, 1000.0, 1440.0, 2048.0];
            motor.counts_per_rev = ENCODERS[rng.random_range(0..ENCODERS.len())];
            motor.supply_v = [4.5, 5.0, 6.0, 7.4][rng.random_range(0..4)];
            // Kt and Kb are the same constant except for losses.
            motor.torque_constant_nm_per_a =
                motor.back_emf_v_s_per_rad * rng.random_range(0.9..1.05);
        }
        motor
    }

    /// The nominal motor: every value 5 % off, with four digits.
    pub(crate) fn draw_nominal(&self, rng: &mut impl Rng) -> Self {
        let mut nominal = *self;
        for figure in nominal.figures_mut() {
            let factor: f64 = 1.0 + NOMINAL_SIGMA * normal(rng);
            *figure = four_digits(*figure * factor.max(0.5));
        }
        nominal
    }

    /// The values of a data sheet with a tolerance: not encoder and supply.
    pub(crate) fn figures_mut(&mut self) -> [&mut f64; 7] {
        [
            &mut self.resistance_ohm,
            &mut self.back_emf_v_s_per_rad,
            &mut self.torque_constant_nm_per_a,
            &mut self.viscous_friction_nm_s_per_rad,
            &mut self.inductance_h,
            &mut self.inertia_kg_m2,
            &mut self.coulomb_friction_nm,
        ]
    }

    /// Steady speed at the full supply in rad/s: (Kt V / R - Tf) / (b + Kt Kb / R).
    pub fn top_speed_rad_s(&self) -> f64 {
        let per_volt = self.torque_constant_nm_per_a / self.resistance_ohm;
        (per_volt * self.supply_v - self.coulomb_friction_nm)
            / (self.viscous_friction_nm_s_per_rad + per_volt * self.back_emf_v_s_per_rad)
    }

    /// Stall current at the full supply in A.
    pub fn stall_current_a(&self) -> f64 {
        self.supply_v / self.resistance_ohm
    }

    /// Angle of one encoder count in rad.
    pub fn count_rad(&self) -> f64 {
        std::f64::consts::TAU / self.counts_per_rev
    }

    /// The motor file with its tolerance of 5 %.
    pub fn to_toml(&self) -> String {
        self.to_toml_within(Some(NOMINAL_SIGMA))
    }

    /// The motor file with this tolerance, or without a stated one.
    pub(crate) fn to_toml_within(self, tolerance: Option<f64>) -> String {
        let keys = [
            ("resistance_ohm", self.resistance_ohm),
            ("back_emf_v_s_per_rad", self.back_emf_v_s_per_rad),
            ("torque_constant_nm_per_a", self.torque_constant_nm_per_a),
            (
                "viscous_friction_nm_s_per_rad",
                self.viscous_friction_nm_s_per_rad,
            ),
            ("inductance_h", self.inductance_h),
            ("inertia_kg_m2", self.inertia_kg_m2),
            ("coulomb_friction_nm", self.coulomb_friction_nm),
        ];
        let mut text = String::new();
        for (key, value) in keys {
            text += &format!("{key} = {value:?}\n");
        }
        text += &format!("counts_per_rev = {:?}\n", self.counts_per_rev);
        text += &format!("supply_v = {:?}\n", self.supply_v);
        if let Some(tolerance) = tolerance {
            text += "\n[tolerance]\n";
            for (key, _) in keys {
                text += &format!("{key} = {tolerance:?}\n");
            }
        }
        text
    }
}

pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

pub(crate) fn four_digits(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10_f64.powf(3.0 - value.abs().log10().floor());
    (value * scale).round() / scale
}
