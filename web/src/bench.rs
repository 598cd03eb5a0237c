//! Motors and effects for the forms of the page.

use motorlab::board::BUILT_IN;
use motorlab::data_sheet::DataSheet;
use motorlab::effects::{Entry, entries};
use motorlab::motor::{ActiveEffect, Motor, Parameters};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

use crate::failure::{Answer, document, failed};

#[derive(Debug, Serialize)]
struct Offered {
    version: &'static str,
    parameters: Parameters,
    effects: Vec<Entry>,
    profiles: Vec<(&'static str, &'static str)>,
}

/// A motor file, or the handout's motor for an empty text.
pub(crate) fn motor_of(text: &str) -> Result<Motor, JsError> {
    match text {
        "" => Ok(Motor::default()),
        text => Motor::from_toml(text).map_err(failed),
    }
}

/// Parameters of a motor file, effects with their ranges for this motor, and profiles.
#[wasm_bindgen]
pub fn offered(motor: &str) -> Answer {
    let motor = motor_of(motor)?;
    document(&Offered {
        version: env!("CARGO_PKG_VERSION"),
        effects: entries(&motor.parameters),
        parameters: motor.parameters,
        profiles: BUILT_IN.to_vec(),
    })
}

/// The motor file of these parameters in SI, as JSON.
#[wasm_bindgen]
pub fn motor_file(parameters: &str) -> Answer {
    let parameters: Parameters = serde_json::from_str(parameters).map_err(failed)?;
    checked(parameters)
}

/// The motor file from the values of a data sheet in SI, as JSON.
#[wasm_bindgen]
pub fn motor_of_data_sheet(numbers: &str) -> Answer {
    let sheet: DataSheet = serde_json::from_str(numbers).map_err(failed)?;
    checked(sheet.parameters().map_err(failed)?)
}

/// Reads its own output back, so that every value is checked.
fn checked(parameters: Parameters) -> Answer {
    let motor = Motor {
        parameters,
        ..Motor::default()
    };
    let text = motor.to_toml();
    Motor::from_toml(&text).map_err(failed)?;
    Ok(text)
}

#[derive(Debug, Deserialize)]
struct Chosen {
    effect: String,
    #[serde(default)]
    numbers: Vec<(String, f64)>,
}

/// The motor file with these effects, a JSON list; omitted values have their default.
#[wasm_bindgen]
pub fn motor_with_effects(motor: &str, effects: &str) -> Answer {
    let mut motor = motor_of(motor)?;
    let chosen: Vec<Chosen> = serde_json::from_str(effects).map_err(failed)?;
    for one in &chosen {
        let numbers = one
            .numbers
            .iter()
            .map(|(key, value)| (key.as_str(), *value));
        let effect = ActiveEffect::from_keys(&one.effect, numbers, &motor.parameters);
        motor.effects.set(effect.map_err(failed)?);
    }
    let text = motor.to_toml();
    Motor::from_toml(&text).map_err(failed)?;
    Ok(text)
}
