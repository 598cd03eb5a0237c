//! Any bytes through the decoder and both parsers: nothing panics, and what is parsed can be written.
#![no_main]

#[path = "../../tests/swallow/mod.rs"]
mod swallow;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| swallow::swallow(bytes));
