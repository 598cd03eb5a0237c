//! Torques without a measured winding resistance.
//!
//! Voltage and counts determine the speed per volt, the time constant, friction in volts and L/R. They are invariant
//! under a change of the resistance R if torques, inertia and currents scale with 1/R, and L with R.

use crate::Motor;

/// Exponent of the resistance for a value in this unit: 1, -1 or 0.
fn power(unit: &str) -> i32 {
    match unit {
        "ohm" | "H" | "1/W" => 1,
        "A" | "N m" | "N m s/rad" | "N m s^2/rad^2" | "kg m^2" => -1,
        _ => 0,
    }
}

impl Motor {
    /// The motor with this measured resistance and the same response from voltage to counts.
    #[must_use]
    pub fn with_resistance(&self, resistance_ohm: f64) -> Self {
        let mut motor = self.clone();
        let ratio = resistance_ohm / self.parameters.resistance_ohm;
        let p = &mut motor.parameters;
        p.resistance_ohm = resistance_ohm;
        p.inductance_h *= ratio;
        p.viscous_friction_nm_s_per_rad /= ratio;
        p.inertia_kg_m2 /= ratio;
        p.coulomb_friction_nm /= ratio;
        for effect in motor.effects.iter_mut() {
            let parameters = effect.kind().parameters;
            for (value, parameter) in effect.values.iter_mut().zip(parameters) {
                *value *= ratio.powi(power(parameter.unit));
            }
        }
        motor.resistance_assumed = false;
        motor
    }

    /// Assumed parameters of this motor, and the measurement that replaces each, as lines of a comment.
    pub fn assumptions(&self) -> Vec<String> {
        if !self.resistance_assumed {
            return Vec::new();
        }
        let resistance_ohm = self.parameters.resistance_ohm;
        vec![
            format!(
                "ASSUMED: the resistance R = {resistance_ohm} ohm. Torques, inertia and currents are those of this R: they go with 1/R."
            ),
            "Measured, whatever R is: speed per volt, time constant, friction in volts, L/R.".to_owned(),
            "Measure R with an ohmmeter at the motor's terminals, the shaft held still, and give it: --resistance OHM.".to_owned(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use crate::catalogue::catalogue;
    use crate::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};

    #[test]
    fn voltage_and_counts_do_not_determine_the_resistance() {
        let t_s: Vec<f64> = (0..300).map(|k| f64::from(k) * 0.003).collect();
        let command: Vec<f64> = (0..300)
            .map(|k| [4.5, -1.0, 0.35, -4.0, 0.0][k / 60])
            .collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        for kind in catalogue() {
            let mut motor = Motor::default();
            let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters).unwrap();
            motor.effects.set(effect);
            let other = motor.with_resistance(3.1);
            assert_eq!(other.parameters.resistance_ohm, 3.1);
            assert!(
                other.parameters.coulomb_friction_nm > 3.0 * motor.parameters.coulomb_friction_nm
            );
            let angles = |motor: &Motor| {
                let run = simulate(motor, &drive, &SimulationOptions::default());
                run.unwrap().angle_rad
            };
            for (a, b) in angles(&motor).iter().zip(angles(&other)) {
                assert!((a - b).abs() < 1e-6, "{}: {a} {b}", kind.id);
            }
        }
    }
}
