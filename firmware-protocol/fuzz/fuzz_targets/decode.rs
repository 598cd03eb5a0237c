//! Arbitrary bytes through the decoder and both parsers: no panic, and every parsed message can be encoded.
#![no_main]

#[path = "../../tests/swallow/mod.rs"]
mod swallow;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| swallow::swallow(bytes));
