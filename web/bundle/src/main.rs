//! Bundles WebAssembly, scripts and styles into one page: `bundle WASM PAGE_FOLDER REPORT_FOLDER OUTPUT_FOLDER`.
//!
//! One file, so that it works from a disk and from a server: a page at `file://` cannot fetch others.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use wasm_bindgen_cli_support::Bindgen;

/// The page's scripts in the order of their dependencies.
const SCRIPTS: [&str; 6] = [
    "ask.js",
    "recordings.js",
    "motor.js",
    "answers.js",
    "record.js",
    "try.js",
];

/// Largest compressed size of the page in bytes.
const MOST_COMPRESSED: usize = 6_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [wasm, page, report, output] = arguments.as_slice() else {
        return Err("usage: bundle WASM PAGE_FOLDER REPORT_FOLDER OUTPUT_FOLDER".into());
    };
    let (page, report, output) = (Path::new(page), Path::new(report), Path::new(output));
    fs::create_dir_all(output)?;
    let work = output.join("bindings");
    Bindgen::new()
        .input_path(wasm)
        .out_name("motorlab")
        .no_modules(true)?
        .typescript(false)
        .remove_producers_section(true)
        .generate(&work)?;
    let read = |folder: &Path, name: &str| {
        fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"))
    };
    let bindings = read(&work, "motorlab.js")?;
    let wasm = fs::read(work.join("motorlab_bg.wasm"))?;
    fs::remove_dir_all(&work)?;

    let worker = format!("{bindings}\n{}", read(page, "worker.js")?);
    let uplot = read(&report.join("uplot"), "uPlot.iife.min.js")?;
    let licence = read(&report.join("uplot"), "LICENSE")?;
    let parts: Vec<String> = SCRIPTS
        .iter()
        .map(|name| read(page, name))
        .collect::<Result<_, _>>()?;
    let script = format!(
        "/*\n{licence}\n*/\n{uplot}\n(() => {{'use strict';\n{}}})();",
        parts.concat()
    );
    // The report's script, as src/report/html.rs writes it: frames inherit the page's Content-Security-Policy.
    let report_script = format!(
        "/*\n{licence}\n*/\n{uplot}\n{}",
        read(report, "explore.js")?
    );
    let style = read(&report.join("uplot"), "uPlot.min.css")? + &read(page, "page.css")?;
    let rules = format!(
        "default-src 'none'; script-src 'wasm-unsafe-eval' blob: '{}' '{}'; worker-src blob:; style-src 'unsafe-inline'; \
         img-src blob: data:; frame-src 'self'; connect-src 'none'; form-action 'none'; base-uri 'none'",
        hash(&script),
        hash(&report_script)
    );
    let compressed = compressed(&wasm)?;
    let html = read(page, "index.html")?
        .replace("{{rules}}", &rules)
        .replace("{{style}}", &style)
        .replace("{{script}}", &script)
        .replace("{{worker}}", &base64(worker.as_bytes()))
        .replace("{{wasm}}", &base64(&compressed));
    fs::write(output.join("index.html"), &html)?;
    let sent = self::compressed(html.as_bytes())?.len();
    println!(
        "{}: {} bytes, {sent} compressed; WebAssembly {} bytes, {} compressed",
        output.join("index.html").display(),
        html.len(),
        wasm.len(),
        compressed.len()
    );
    if sent > MOST_COMPRESSED {
        return Err(format!("it is more than {MOST_COMPRESSED} bytes compressed").into());
    }
    Ok(())
}

/// A script's hash in the format of a Content-Security-Policy.
fn hash(script: &str) -> String {
    format!("sha256-{}", base64(&Sha256::digest(script.as_bytes())))
}

fn compressed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let group = part
            .iter()
            .fold(0_u32, |group, byte| group << 8 | u32::from(*byte))
            << (8 * (3 - part.len()));
        for k in 0..4 {
            let digit = DIGITS[(group >> (18 - 6 * k) & 63) as usize];
            let _ = text.write_char(if k <= part.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}
