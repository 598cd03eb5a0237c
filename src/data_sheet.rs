//! Model parameters from a motor's data sheet.
//!
//! At the nominal voltage `V` a data sheet states stall and no-load values. With the stall current `I = V / R`, `T =
//! Kt I` and `V = R I_0 + Kb w_0` (any text on DC motors, such as Franklin, Powell and Emami-Naeini, Feedback Control
//! of Dynamic Systems, section 2.3). Friction is that of the no-load current, `Kt I_0`, taken as Coulomb friction: a
//! data sheet does not determine its dependence on speed.

use serde::Deserialize;

use crate::motor::Parameters;

/// Values of a data sheet in SI units, of the shaft that the encoder counts.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct DataSheet {
    /// Nominal voltage in V.
    pub voltage_v: f64,
    /// No-load speed in rad/s.
    pub no_load_speed_rad_s: f64,
    /// No-load current in A.
    pub no_load_current_a: f64,
    /// Stall torque in N m.
    pub stall_torque_nm: f64,
    /// Stall current in A.
    pub stall_current_a: f64,
    /// Inertia of rotor, gear and load in kg m^2.
    pub inertia_kg_m2: f64,
    /// Inductance of the winding in H.
    pub inductance_h: f64,
    /// Counts per revolution, all four edges counted.
    pub counts_per_rev: f64,
    /// Supply of the driver in V.
    pub supply_v: f64,
}

/// Errors in the values of a data sheet.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataSheetError {
    /// A value that must be above 0.
    #[error(
        "{what}: it has to be above 0\nhint: take the number from the data sheet, without a sign"
    )]
    NotPositive {
        /// The value.
        what: &'static str,
    },
    /// The no-load current is below the stall current.
    #[error(
        "the current without load, {no_load_a} A, is not below that of the stalled motor, {stall_a} A\n\
         hint: data sheets often state one in mA"
    )]
    Currents {
        /// No-load current in A.
        no_load_a: f64,
        /// Stall current in A.
        stall_a: f64,
    },
}

impl DataSheet {
    /// The parameters.
    ///
    /// # Errors
    /// A value is not possible for a motor.
    pub fn parameters(&self) -> Result<Parameters, DataSheetError> {
        let positive = [
            ("nominal voltage", self.voltage_v),
            ("speed without load", self.no_load_speed_rad_s),
            ("stall torque", self.stall_torque_nm),
            ("stall current", self.stall_current_a),
        ];
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        if let Some((what, _)) = positive.iter().find(|(_, value)| !is_positive(*value)) {
            return Err(DataSheetError::NotPositive { what });
        }
        let stall_a = self.stall_current_a;
        let no_load_a = self.no_load_current_a;
        if !(0.0..stall_a).contains(&no_load_a) {
            return Err(DataSheetError::Currents { no_load_a, stall_a });
        }
        let resistance_ohm = self.voltage_v / stall_a;
        let torque_constant_nm_per_a = self.stall_torque_nm / (stall_a - no_load_a);
        Ok(Parameters {
            resistance_ohm,
            back_emf_v_s_per_rad: (self.voltage_v - resistance_ohm * no_load_a)
                / self.no_load_speed_rad_s,
            torque_constant_nm_per_a,
            viscous_friction_nm_s_per_rad: 0.0,
            inductance_h: self.inductance_h,
            inertia_kg_m2: self.inertia_kg_m2,
            coulomb_friction_nm: torque_constant_nm_per_a * no_load_a,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply_v,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};

    const SHEET: DataSheet = DataSheet {
        voltage_v: 12.0,
        no_load_speed_rad_s: 52.4,
        no_load_current_a: 0.15,
        stall_torque_nm: 0.6,
        stall_current_a: 2.0,
        inertia_kg_m2: 1e-4,
        inductance_h: 0.002,
        counts_per_rev: 1200.0,
        supply_v: 12.0,
    };

    #[test]
    fn the_simulated_motor_has_the_speed_of_its_data_sheet() {
        let parameters = SHEET.parameters().expect("a motor");
        let stall_nm = parameters.torque_constant_nm_per_a * SHEET.stall_current_a
            - parameters.coulomb_friction_nm;
        assert!((stall_nm - SHEET.stall_torque_nm).abs() < 1e-12);
        let motor = Motor {
            parameters,
            ..Motor::default()
        };
        let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.005).collect();
        let command = vec![SHEET.voltage_v; t_s.len()];
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let run = simulate(&motor, &drive, &SimulationOptions::default()).expect("a run");
        let last = run.speed_rad_s.last().expect("a sample");
        assert!(
            (last / SHEET.no_load_speed_rad_s - 1.0).abs() < 1e-6,
            "{last}"
        );
    }

    #[test]
    fn implausible_data_sheets_are_refused() {
        let milliamperes = DataSheet {
            no_load_current_a: 150.0,
            ..SHEET
        };
        let error = milliamperes.parameters().expect_err("no motor").to_string();
        assert!(
            error.contains("150 A") && error.contains("hint:"),
            "{error}"
        );
        let still = DataSheet {
            no_load_speed_rad_s: 0.0,
            ..SHEET
        };
        assert_eq!(
            still.parameters(),
            Err(DataSheetError::NotPositive {
                what: "speed without load"
            })
        );
    }
}
