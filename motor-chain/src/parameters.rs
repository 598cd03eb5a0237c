//! The nominal parameters of a DC motor, with the lab handout's values as default.
//!
//! `L di/dt = v - R i - Kb w`, `J dw/dt = Kt i - b w - Tf sgn(w)`.

use serde::{Deserialize, Serialize};

/// Nominal parameters of the motor and its encoder, as in a motor file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Parameters {
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
    /// Inertia of rotor and load J.
    pub inertia_kg_m2: f64,
    /// Coulomb friction torque Tf.
    pub coulomb_friction_nm: f64,
    /// Encoder counts per revolution, x4 decoded.
    pub counts_per_rev: f64,
    /// Driver supply, the largest command.
    pub supply_v: f64,
}

impl Default for Parameters {
    /// The lab handout's motor.
    fn default() -> Self {
        Self {
            resistance_ohm: 10.0,
            back_emf_v_s_per_rad: 0.7,
            torque_constant_nm_per_a: 0.7,
            viscous_friction_nm_s_per_rad: 0.01,
            inductance_h: 0.004,
            inertia_kg_m2: 0.002,
            coulomb_friction_nm: 0.02,
            counts_per_rev: 720.0,
            supply_v: 4.5,
        }
    }
}

impl Parameters {
    /// The keys of a motor file, in its order.
    pub const KEYS: [&str; 9] = [
        "resistance_ohm",
        "back_emf_v_s_per_rad",
        "torque_constant_nm_per_a",
        "viscous_friction_nm_s_per_rad",
        "inductance_h",
        "inertia_kg_m2",
        "coulomb_friction_nm",
        "counts_per_rev",
        "supply_v",
    ];

    /// The value under this key.
    pub fn get(&self, key: &str) -> Option<f64> {
        let mut copy = *self;
        copy.get_mut(key).map(|value| *value)
    }

    /// Mutable value under this key.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut f64> {
        Some(match key {
            "resistance_ohm" => &mut self.resistance_ohm,
            "back_emf_v_s_per_rad" => &mut self.back_emf_v_s_per_rad,
            "torque_constant_nm_per_a" => &mut self.torque_constant_nm_per_a,
            "viscous_friction_nm_s_per_rad" => &mut self.viscous_friction_nm_s_per_rad,
            "inductance_h" => &mut self.inductance_h,
            "inertia_kg_m2" => &mut self.inertia_kg_m2,
            "coulomb_friction_nm" => &mut self.coulomb_friction_nm,
            "counts_per_rev" => &mut self.counts_per_rev,
            "supply_v" => &mut self.supply_v,
            _ => return None,
        })
    }
}
