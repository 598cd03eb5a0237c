//! Arbitrary bytes as a log of another program without a mapping: no panic for any format, and every mapping found
//! can be written as a mapping file.
#![no_main]

use std::io::Read as _;

use motorlab::import::{Form, Map, GivenFlags, understand, understand_table};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let given = GivenFlags {
        counts_per_rev: Some(720.0),
        supply: Some("6".to_owned()),
        ..GivenFlags::default()
    };
    let reading = match Form::of(bytes) {
        Some(form) => {
            let Ok(table) = form.read(bytes) else { return };
            let mut text = String::new();
            table.text().read_to_string(&mut text).expect("memory");
            understand_table(&table, "log.csv", &given, "motorlab import log.csv")
        }
        None => understand(bytes, true, "log.csv", &given, "motorlab import log.csv"),
    };
    if let Ok(ready) = reading.map {
        Map::from_toml(&ready.toml).expect("a mapping of our own");
    }
});
