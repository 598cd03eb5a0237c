//! motorlab in a web page: the functions that the page's worker calls.
//!
//! ```text
//! page.js <- messages -> worker.js -> these functions -> motorlab
//! ```
//!
//! Each function takes texts and bytes, and returns a JSON document or an error with its hint. There is no state
//! between two calls except a current recording, so that a worker can be stopped at any time.

mod answers;
mod bench;
mod dropped;
mod failure;
mod record;
mod serial;

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
unsafe extern "C" {
    /// Reports progress to the page as a JSON document.
    #[wasm_bindgen(js_name = motorlabReport)]
    fn report_to_page(document: &str);
    /// Writes bytes to the page's serial port.
    #[wasm_bindgen(js_name = motorlabSend)]
    fn send_to_port(bytes: &[u8]);
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn console_error(text: &str);
}

fn report(document: &impl serde::Serialize) {
    if let Ok(text) = serde_json::to_string(document) {
        report_to_page(&text);
    }
}

/// A panic is reported in the console with its location.
#[wasm_bindgen(start)]
fn begin() {
    std::panic::set_hook(Box::new(|error| console_error(&error.to_string())));
}
