//! Results and errors for the page.

use std::fmt::Display;

use motorlab::plain::{plain, plain_json};
use serde::Serialize;
use wasm_bindgen::JsError;

/// Result of a call from the page.
pub type Answer = Result<String, JsError>;

/// The error as text, without control characters.
pub fn failed(error: impl Display) -> JsError {
    JsError::new(&plain(&error.to_string()))
}

/// The error with its file.
pub fn failed_in(name: &str) -> impl Fn(&dyn Display) -> JsError {
    move |error| failed(format!("{name}: {error}"))
}

/// A JSON document, as the program prints it.
pub fn document(document: &impl Serialize) -> Answer {
    plain_json(document).map_err(failed)
}
