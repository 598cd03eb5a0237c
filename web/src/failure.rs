//! An answer, or why there is none.

use std::fmt::Display;

use motorlab::plain::{plain, plain_json};
use serde::Serialize;
use wasm_bindgen::JsError;

/// Result of a question of the page.
pub type Answer = Result<String, JsError>;

/// The failure in words; what steers a terminal or cannot be seen is taken out.
pub fn failed(error: impl Display) -> JsError {
    JsError::new(&plain(&error.to_string()))
}

/// The failure with the file that it is of.
pub fn failed_in(name: &str) -> impl Fn(&dyn Display) -> JsError {
    move |error| failed(format!("{name}: {error}"))
}

/// A JSON document, as the program prints it.
pub fn document(document: &impl Serialize) -> Answer {
    plain_json(document).map_err(failed)
}
