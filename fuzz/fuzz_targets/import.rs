//! Arbitrary bytes as a mapping file and a log of another program: no panic, every row of the log is in a run,
//! counted as bad, or counted as one that only sets held values, and the runs are readable run files.
//!
//! A line `----` separates mapping and log.
#![no_main]

use std::fs;

use motorlab::import::{Map, import};
use motorlab::recording::read_run;

const BETWEEN: &[u8] = b"\n----\n";

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let found = bytes
        .windows(BETWEEN.len())
        .position(|window| window == BETWEEN);
    let Some(at) = found else {
        return;
    };
    let Ok(map) = Map::from_toml(&String::from_utf8_lossy(&bytes[..at])) else {
        return;
    };
    let folder = std::env::temp_dir().join(format!("import-fuzz-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let imported = import(
        &bytes[at + BETWEEN.len()..],
        "log.csv",
        &map,
        &folder.join("run.csv"),
    );
    if let Ok(imported) = imported {
        let samples: u64 = imported.runs.iter().map(|run| run.samples).sum();
        let told = samples + imported.bad_rows + imported.rows_without_position;
        assert_eq!(told, imported.rows);
        assert_eq!(imported.rejected.is_some(), imported.bad_rows > 0);
        for run in &imported.runs {
            let (read, _) = read_run(&run.path).expect("a run file of our own");
            assert_eq!(read.len() as u64, run.samples);
        }
    }
    fs::remove_dir_all(&folder).expect("a folder of our own");
});
