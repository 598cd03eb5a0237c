//! A motor or a run in other programs' formats.
//!
//! | format | what is written | effects included |
//! | --- | --- | --- |
//! | [`matlab`] | `Motor_Parameters.m` in the lab handout's names | all, as numbers with their equations |
//! | [`mat5`] | a run as a MAT-file of version 5 | none: it is data |
//! | `parquet`, `mcap` | a run for PlotJuggler, Foxglove, pandas (features of the build) | none: it is data |
//! | [`mujoco`] | a hinge and a general actuator (MJCF) | those that change one of its coefficients |
//! | [`urdf`] | a joint with `<dynamics>` | friction and inertia |
//! | [`json`] | parameters and effects with units and equations | all |
//! | [`actuator`] | the motor as a function in C, Python, MATLAB, torch, for MuJoCo | all of the motor's, none of the recording's |

pub mod actuator;
pub mod json;
pub mod mat5;
pub mod matlab;
#[cfg(feature = "mcap")]
pub mod mcap;
pub mod mujoco;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod urdf;

mod linear;

pub use linear::{ExportError, Linear};

use crate::motor::Parameters;

/// A parameter of the motor file with the lab handout's name for it.
#[derive(Debug, Clone, Copy)]
pub struct Named {
    /// Key in the motor file.
    pub key: &'static str,
    /// Variable in the handout's script.
    pub handout: &'static str,
    /// Symbol in its equations.
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Name.
    pub meaning: &'static str,
}

/// The parameters in the order of the handout's script.
pub const PARAMETERS: [Named; 9] = [
    named("resistance_ohm", "Rm", "R", "ohm", "armature resistance"),
    named(
        "back_emf_v_s_per_rad",
        "Kb",
        "Kb",
        "V s/rad",
        "back EMF constant",
    ),
    named(
        "torque_constant_nm_per_a",
        "Kt",
        "Kt",
        "N m/A",
        "torque constant",
    ),
    named(
        "viscous_friction_nm_s_per_rad",
        "Bm",
        "b",
        "N m s/rad",
        "viscous friction",
    ),
    named("inductance_h", "Lm", "L", "H", "armature inductance"),
    named(
        "inertia_kg_m2",
        "Jm",
        "J",
        "kg m^2",
        "inertia of rotor and load",
    ),
    named(
        "coulomb_friction_nm",
        "Tf",
        "Tf",
        "N m",
        "Coulomb friction torque",
    ),
    named(
        "counts_per_rev",
        "encoder_counts",
        "N",
        "counts/rev",
        "encoder counts a revolution, all edges counted",
    ),
    named(
        "supply_v",
        "Vsupply",
        "V",
        "V",
        "driver supply, the largest command",
    ),
];

const fn named(
    key: &'static str,
    handout: &'static str,
    symbol: &'static str,
    unit: &'static str,
    meaning: &'static str,
) -> Named {
    Named {
        key,
        handout,
        symbol,
        unit,
        meaning,
    }
}

impl Named {
    /// Its value in these parameters.
    pub fn value(&self, parameters: &Parameters) -> f64 {
        parameters.get(self.key).unwrap_or(f64::NAN)
    }
}

/// The handout's equations of motion, one per line.
pub const EQUATIONS: [&str; 2] = [
    "L di/dt = v - R i - Kb w",
    "J dw/dt = Kt i - b w - Tf sgn(w)",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_of_a_motor_file_has_a_name_in_the_handout() {
        let mut keys: Vec<_> = PARAMETERS.iter().map(|named| named.key).collect();
        let mut known = Parameters::KEYS.to_vec();
        keys.sort_unstable();
        known.sort_unstable();
        assert_eq!(keys, known);
    }
}
