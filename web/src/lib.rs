//! motorlab behind a page: what the page's worker asks, answered by the library.
//!
//! ```text
//! page.js <- messages -> worker.js -> these functions -> motorlab
//! ```
//!
//! Each function takes texts and bytes, and gives a JSON document or an error with its hint. Nothing is kept between two calls but a
//! recording under way: a worker that is stopped loses nothing.

mod answers;
mod bench;
mod dropped;
mod failure;
mod record;
mod serial;

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
unsafe extern "C" {
    /// Tells the page how far something is, as a JSON document.
    #[wasm_bindgen(js_name = motorlabReport)]
    fn report_to_page(document: &str);
    /// Hands bytes to the page's serial port.
    #[wasm_bindgen(js_name = motorlabSend)]
    fn send_to_port(bytes: &[u8]);
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn console_error(text: &str);
}

/// Tells the page how far something is.
fn report(document: &impl serde::Serialize) {
    if let Ok(text) = serde_json::to_string(document) {
        report_to_page(&text);
    }
}

/// An error of the program itself is said in the console, with its place.
#[wasm_bindgen(start)]
fn begin() {
    std::panic::set_hook(Box::new(|error| console_error(&error.to_string())));
}
