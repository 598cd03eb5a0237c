//! Known differences of one run from the motor: a disc on the shaft, a load on an arm, another winding.
//!
//! Voltage and counts alone do not separate inertia, torque constant and resistance: the equations of motion are
//! invariant under a common factor. Runs of one axis with a known inertia or load between them determine it (Gautier,
//! Identification of robot dynamics, 1986; the payload method of Khalil, Gautier and Lemoine, ICRA 2007).

use crate::catalogue::MAX_PARAMETERS;
use crate::catalogue::ids;
use crate::plausible::{Range, of_parameter};
use crate::synonyms::nearest_name;
use crate::{ActiveEffect, Motor, ParameterId, Parameters};

/// Added inertia in kg m^2.
const ADDED_INERTIA: &str = "inertia_added_kg_m2";
/// Torque in N m of a load on an arm, `torque sin(angle + phase)`, with the angle relative to count 0.
const GRAVITY: &str = "gravity_torque_nm";

/// An invalid difference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KnownError {
    /// An unknown key.
    #[error(
        "'{key}' is nothing that a run can differ in\nhint: {}give {ADDED_INERTIA}, {GRAVITY}, or a key of the motor file",
        crate::active::did_you_mean(nearest)
    )]
    UnknownKey {
        /// The given key.
        key: String,
        /// The most similar known key.
        nearest: Option<&'static str>,
    },
    /// A value outside the plausible range.
    #[error(
        "{key} = {value} cannot be: expected {expected}\nhint: the key's name states its unit; convert the value to it"
    )]
    Value {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// Accepted values.
        expected: String,
    },
}

/// Fixed-point iterations for the shaft's angle behind an eccentric encoder. Each reduces the error by the factor of
/// the amplitude, some hundredths.
const FIXED_POINT_STEPS: usize = 8;

/// Known differences of one run from the motor that all runs share.
///
/// ```
/// use motor_chain::{KnownDifferences, Motor};
///
/// let mut known = KnownDifferences::default();
/// known.set("inertia_added_kg_m2", 0.001)?;
/// let motor = Motor::default();
/// let with_disc = known.applied_to(&motor);
/// assert_eq!(with_disc.parameters.inertia_kg_m2, motor.parameters.inertia_kg_m2 + 0.001);
/// # Ok::<(), motor_chain::KnownError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KnownDifferences {
    inertia_added_kg_m2: f64,
    gravity_torque_nm: Option<f64>,
    /// Indices in [`Parameters::KEYS`] with the value in this run.
    parameters: Vec<(usize, f64)>,
}

impl KnownDifferences {
    /// Adds the difference under this key, in SI.
    ///
    /// # Errors
    /// An unknown key, or a value outside the plausible range.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), KnownError> {
        let within = |range: Range| {
            if range.holds(value) {
                Ok(value)
            } else {
                Err(KnownError::Value {
                    key: key.to_owned(),
                    value,
                    expected: range.to_string(),
                })
            }
        };
        // An added inertia or load of 0 is a difference as well.
        let from_none = |key| Range {
            lo: 0.0,
            ..of_parameter(key)
        };
        match key {
            ADDED_INERTIA => self.inertia_added_kg_m2 = within(from_none("inertia_kg_m2"))?,
            GRAVITY => self.gravity_torque_nm = Some(within(from_none("coulomb_friction_nm"))?),
            _ => {
                let number = Parameters::KEYS.iter().position(|known| *known == key);
                let Some(number) = number else {
                    let keys = Parameters::KEYS.into_iter();
                    return Err(KnownError::UnknownKey {
                        key: key.to_owned(),
                        nearest: nearest_name(key, keys.chain([ADDED_INERTIA, GRAVITY])),
                    });
                };
                within(of_parameter(key))?;
                self.parameters.retain(|(known, _)| *known != number);
                self.parameters.push((number, value));
            }
        }
        Ok(())
    }

    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it includes a load or a disc: a torque known in N m, which makes `Kt/R` identifiable.
    pub fn has_torque(&self) -> bool {
        self.inertia_added_kg_m2 > 0.0 || self.gravity_torque_nm.is_some_and(|torque| torque != 0.0)
    }

    /// Torque in N m of its load and its disc at an angle in rad and an acceleration in rad/s^2; the arm hangs at 0.
    pub fn torque_nm(&self, angle_rad: f64, acceleration_rad_s2: f64) -> f64 {
        let load_nm = self.gravity_torque_nm.unwrap_or(0.0);
        self.inertia_added_kg_m2 * acceleration_rad_s2 + load_nm * angle_rad.sin()
    }

    /// Whether its load is known, and so the whole torque of gravity.
    pub fn has_load(&self) -> bool {
        self.gravity_torque_nm.is_some()
    }

    /// The supply in V, if it differs.
    pub fn supply_v(&self) -> Option<f64> {
        let supply = Parameters::KEYS.iter().position(|key| *key == "supply_v");
        self.parameters
            .iter()
            .find(|(number, _)| Some(*number) == supply)
            .map(|(_, value)| *value)
    }

    /// Whether it replaces a parameter of the motor, whose fitted value then has no effect on this run.
    pub fn overrides(&self, id: ParameterId) -> bool {
        match id {
            ParameterId::Nominal(number) => {
                self.parameters.iter().any(|(known, _)| *known == number)
            }
            ParameterId::Effect(..) => {
                self.gravity_torque_nm.is_some()
                    && ParameterId::effect(ids::GRAVITY_LOAD, "torque_nm") == Some(id)
            }
        }
    }

    /// The motor of this run. A known load replaces the torque of `gravity_load`, whose phase is kept (0 if the motor
    /// does not have the effect); an added inertia is also added to that of the effect.
    pub fn applied_to(&self, motor: &Motor) -> Motor {
        let mut motor = motor.clone();
        for &(number, value) in &self.parameters {
            ParameterId::Nominal(number).set(&mut motor, value);
        }
        if self.inertia_added_kg_m2 > 0.0 {
            motor.parameters.inertia_kg_m2 += self.inertia_added_kg_m2;
            let inertia = ParameterId::effect(ids::INERTIA, "inertia_kg_m2");
            if let Some((id, own)) = inertia.and_then(|id| Some((id, id.get(&motor)?))) {
                id.set(&mut motor, own + self.inertia_added_kg_m2);
            }
        }
        if let Some(torque_nm) = self.gravity_torque_nm {
            let values = motor
                .effects
                .get(ids::GRAVITY_LOAD)
                .map_or([0.0; MAX_PARAMETERS], |effect| effect.values);
            if let Ok(load) = ActiveEffect::new(ids::GRAVITY_LOAD, &[torque_nm, values[1]]) {
                motor.effects.set(load);
            }
        }
        motor
    }
}

impl Motor {
    /// The motor for a run whose first encoder angle is `shown_rad`: simulations begin at 0, so that the phase of
    /// everything periodic in the angle is advanced.
    #[must_use]
    pub fn with_phase_from(&self, shown_rad: f64) -> Self {
        let mut motor = self.clone();
        // An eccentric encoder reads `theta + e sin(theta + phi)`, which is solved for the shaft's angle.
        let mut angle_rad = shown_rad;
        if let Some(off_axis) = self.effects.get(ids::ENCODER_ECCENTRICITY) {
            let [amplitude_rad, phase_rad, ..] = off_axis.values;
            for _ in 0..FIXED_POINT_STEPS {
                angle_rad = shown_rad - amplitude_rad * (angle_rad + phase_rad).sin();
            }
        }
        for effect in motor.effects.iter_mut() {
            let keys = effect.kind().parameters.iter();
            let place = |key: &str| keys.clone().position(|parameter| parameter.key == key);
            if let Some(phase) = place("phase_rad") {
                let cycles = place("cycles_per_rev").map_or(1.0, |k| effect.values[k]);
                let advanced = effect.values[phase] + cycles * angle_rad;
                effect.values[phase] = advanced.rem_euclid(std::f64::consts::TAU);
            }
        }
        motor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;

    #[test]
    fn a_stated_difference_changes_only_its_parameter() {
        let mut motor = Motor::default();
        motor
            .effects
            .set(ActiveEffect::new("gravity_load", &[0.05, 1.25]).unwrap());
        let mut known = KnownDifferences::default();
        assert!(known.is_empty());
        assert_eq!(known.applied_to(&motor), motor);
        known.set("gravity_torque_nm", 0.2).unwrap();
        known.set("resistance_ohm", 12.0).unwrap();
        known.set("inertia_added_kg_m2", 0.003).unwrap();
        let applied = known.applied_to(&motor);
        assert_eq!(
            applied.effects.get("gravity_load").unwrap().values[..2],
            [0.2, 1.25]
        );
        assert_eq!(applied.parameters.resistance_ohm, 12.0);
        assert!((applied.parameters.inertia_kg_m2 - 0.005).abs() < 1e-15);
        assert_eq!(
            applied.parameters.coulomb_friction_nm,
            motor.parameters.coulomb_friction_nm
        );
        assert!(known.overrides(ParameterId::nominal("resistance_ohm").unwrap()));
        assert!(!known.overrides(ParameterId::nominal("inertia_kg_m2").unwrap()));
        known.set("gravity_torque_nm", 0.0).unwrap();
        let unloaded = known.applied_to(&motor);
        assert_eq!(unloaded.effects.get("gravity_load").unwrap().values[0], 0.0);
    }

    #[test]
    fn an_unknown_key_suggests_the_nearest_key() {
        let mut known = KnownDifferences::default();
        let error = known
            .set("inertia_aded_kg_m2", 1.0)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("did you mean 'inertia_added_kg_m2'?"),
            "{error}"
        );
        for (key, value) in [
            ("gravity_torque_nm", f64::NAN),
            ("inertia_added_kg_m2", -1.0),
        ] {
            assert!(known.set(key, value).is_err());
        }
        assert!(known.is_empty());
    }

    #[test]
    fn every_phase_of_the_catalogue_is_advanced() {
        for kind in catalogue() {
            let Some(phase) = kind.parameters.iter().position(|p| p.key == "phase_rad") else {
                continue;
            };
            let mut motor = Motor::default();
            let effect = ActiveEffect::from_keys(kind.id, [("phase_rad", 0.5)], &motor.parameters);
            motor.effects.set(effect.unwrap());
            let begun = motor.with_phase_from(0.25);
            let before = motor.effects.iter().next().unwrap();
            let after = begun.effects.iter().next().unwrap();
            let cycles = match kind
                .parameters
                .iter()
                .position(|p| p.key == "cycles_per_rev")
            {
                Some(k) => before.values[k],
                None => 1.0,
            };
            // The reading of an eccentric encoder is not the angle of the shaft.
            let stands_rad = if kind.id == "encoder_eccentricity" {
                let stands_rad = after.values[phase] - 0.5;
                let shown_rad = stands_rad + before.values[0] * (stands_rad + 0.5).sin();
                assert!((shown_rad - 0.25).abs() < 1e-12, "{shown_rad}");
                stands_rad
            } else {
                0.25
            };
            let expected = (0.5 + stands_rad * cycles).rem_euclid(std::f64::consts::TAU);
            assert!(
                (after.values[phase] - expected).abs() < 1e-12,
                "{}",
                kind.id
            );
        }
    }
}
