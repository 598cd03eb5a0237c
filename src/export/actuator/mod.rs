//! The motor with its effects as a function for other programs: voltage in, torque on the output shaft out.
//!
//! One description of the equations (`equations`) is rendered in each language; a template adds the integration loop:
//! Runge-Kutta steps of fourth order within a mode (current flow, directions of slip, touching flanks), cut at the
//! event that ends the mode. The constants are at the top of each file, with units.

use crate::motor::catalogue::ids;
mod constants;
mod equations;
mod language;
mod templates;

pub use constants::output_inertia;
pub use templates::Target;

use crate::hint::Hinted;
use crate::motor::Motor;
use crate::motor::catalogue::Stage;

/// An effect of the recording rather than of the actuator, which no such file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct NotPart {
    /// Its id.
    pub effect: &'static str,
    /// Reason.
    pub why: &'static str,
}

/// The motor's effects that an actuator has, and those of the recording.
pub fn divided(motor: &Motor) -> (Vec<&'static str>, Vec<NotPart>) {
    let (mut part, mut not_part) = (Vec::new(), Vec::new());
    for effect in motor.effects.iter() {
        let kind = effect.kind();
        let why = match kind.stage {
            Stage::Sensor => Some("it changes what the encoder says, not how the motor moves"),
            Stage::Timing => Some("it changes when a sample is taken, not how the motor moves"),
            _ if kind.id == ids::COMMAND_OFFSET => {
                Some("it shifts the recorded column of the commands, not the command")
            }
            _ => None,
        };
        match why {
            Some(why) => not_part.push(NotPart {
                effect: kind.id,
                why,
            }),
            None => part.push(kind.id),
        }
    }
    (part, not_part)
}

/// Most delayed commands in a state: a hundred seconds at a step of 1 ms.
const MOST_DELAYED: f64 = 1e5;

/// Checks the motor for steps of this length.
///
/// # Errors
/// The transport delay exceeds the steps that a state holds.
pub fn check(motor: &Motor, step_s: f64) -> Result<(), Hinted> {
    let delay_s = motor
        .effects
        .get(ids::TRANSPORT_DELAY)
        .map_or(0.0, |effect| effect.values[0]);
    if delay_s / step_s <= MOST_DELAYED {
        return Ok(());
    }
    Err(Hinted::new(
        format!(
            "the transport delay of {delay_s} s is more than {MOST_DELAYED} steps of {step_s} s"
        ),
        format!("--step-time {}", delay_s / MOST_DELAYED),
    ))
}
