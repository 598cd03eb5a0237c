//! Parameters for rigid-body simulators: constant coefficients, and the effects that change only them.
//!
//! Without inductance the motor's torque on its shaft is `Kt (g u - Kb w) / R - b w - Tf sgn(w)`, with the supply's
//! gain `g`.

use crate::motor::catalogue::ids;
use crate::motor::{ActiveEffect, Motor, Parameters};

/// Errors of an export.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// Effects of the model that the format has no element for.
    #[error(
        "{format} has no element for {}\nhint: --leave-out writes the motor without {} and says so in the file",
        listed(.effects),
        if .effects.len() == 1 { "it" } else { "them" }
    )]
    Inexpressible {
        /// The format.
        format: &'static str,
        /// Id and equation of each effect.
        effects: Vec<(&'static str, &'static str)>,
    },
}

fn listed(effects: &[(&'static str, &'static str)]) -> String {
    let named: Vec<String> = effects
        .iter()
        .map(|(id, equation)| format!("'{id}' ({equation})"))
        .collect();
    named.join(", ")
}

/// A motor after folding in the effects that only change a coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// Parameters, with replaced values.
    pub parameters: Parameters,
    /// Voltage at the motor over voltage commanded.
    pub gain: f64,
    /// Largest current in A, if it is limited.
    pub current_limit_a: Option<f64>,
    /// Effects folded into these values.
    pub folded: Vec<&'static str>,
    /// Effects that the format cannot express: id and equation.
    pub left_out: Vec<(&'static str, &'static str)>,
}

impl Linear {
    /// Folds those effects of `motor` whose id is in `expressed` into coefficients; the others are left out.
    ///
    /// # Errors
    /// [`ExportError::Inexpressible`] if effects would be left out without `leave_out`.
    pub fn of(
        motor: &Motor,
        format: &'static str,
        expressed: &[&str],
        leave_out: bool,
    ) -> Result<Self, ExportError> {
        let mut linear = Self {
            parameters: motor.parameters,
            gain: 1.0,
            current_limit_a: None,
            folded: Vec::new(),
            left_out: Vec::new(),
        };
        for effect in motor.effects.iter() {
            let kind = effect.kind();
            if expressed.contains(&kind.id) && linear.fold(effect) {
                linear.folded.push(kind.id);
            } else {
                linear.left_out.push((kind.id, kind.equation));
            }
        }
        if linear.left_out.is_empty() || leave_out {
            Ok(linear)
        } else {
            Err(ExportError::Inexpressible {
                format,
                effects: linear.left_out,
            })
        }
    }

    /// Folds one effect into the coefficients; returns whether it has one.
    fn fold(&mut self, effect: &ActiveEffect) -> bool {
        let value = effect.values[0];
        match effect.kind().id {
            ids::COULOMB_FRICTION => self.parameters.coulomb_friction_nm = value,
            ids::VISCOUS_FRICTION => self.parameters.viscous_friction_nm_s_per_rad = value,
            ids::INERTIA => self.parameters.inertia_kg_m2 = value,
            ids::SUPPLY_ERROR => self.gain = value,
            ids::CURRENT_LIMIT => self.current_limit_a = Some(value),
            _ => return false,
        }
        true
    }

    /// Lines of a comment: folded and missing effects.
    pub fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.folded.is_empty() {
            lines.push(format!(
                "Effects in these numbers: {}.",
                self.folded.join(", ")
            ));
        }
        for (id, equation) in &self.left_out {
            lines.push(format!("LEFT OUT, no element for it: {id}: {equation}."));
        }
        let p = &self.parameters;
        if p.inductance_h > 0.0 {
            lines.push(format!(
                "The inductance L = {} H is left out (L/R = {} s): the current follows the voltage at once.",
                p.inductance_h,
                p.inductance_h / p.resistance_ohm
            ));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_on_coefficients_are_folded_and_others_are_named() {
        let mut motor = Motor::default();
        for (id, values) in [
            ("inertia", &[0.004][..]),
            ("stribeck", &[0.03, 0.5]),
            ("supply_error", &[0.9]),
        ] {
            motor.effects.set(ActiveEffect::new(id, values).unwrap());
        }
        let refused = Linear::of(&motor, "URDF", &["inertia"], false).unwrap_err();
        let message = refused.to_string();
        assert!(message.contains("'stribeck'") && message.contains("'supply_error'"));
        assert!(!message.contains("'inertia'"), "{message}");
        let linear = Linear::of(&motor, "URDF", &["inertia"], true).unwrap();
        assert_eq!(linear.parameters.inertia_kg_m2, 0.004);
        assert_eq!(linear.left_out.len(), 2);
    }
}
