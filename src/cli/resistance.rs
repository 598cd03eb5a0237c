//! `--resistance OHM`: the measured resistance, which determines torques from voltages.

use clap::Args;

use crate::motor::Motor;
use crate::motor::plausible;

/// A resistance measured with an ohmmeter.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Resistance {
    /// Resistance of the winding, measured with an ohmmeter: torques, inertia and currents become those of it. Speed per volt, time
    /// constant and friction in volts stay.
    #[arg(long, value_name = "OHM", value_parser = ohm)]
    resistance: Option<f64>,
}

fn ohm(text: &str) -> Result<f64, String> {
    let range = plausible::of_parameter("resistance_ohm");
    match text.parse() {
        Ok(ohm) if ohm > 0.0 && range.holds(ohm) => Ok(ohm),
        _ => Err(format!("expected ohms: {range}\nhint: --resistance 3.1")),
    }
}

impl Resistance {
    pub(super) fn of(self, motor: Motor) -> Motor {
        match self.resistance {
            Some(ohm) => motor.with_resistance(ohm),
            None => motor,
        }
    }
}
