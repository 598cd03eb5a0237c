//! Throughput of `import` in bytes per second: a text log, converted and written as a run file.
//!
//! `cargo bench --bench import`: `narrow` is the most common log, three numbers per row; `wide` is a robot's, ten
//! columns of which three are read; `understood` is the analysis of the beginning in an import without a mapping.

use std::fmt::Write as _;

use divan::Bencher;
use divan::counter::BytesCount;
use motorlab::import::{GivenFlags, HEAD_BYTES, Map, import, understand};

fn main() {
    divan::main();
}

const ROWS: usize = 200_000;

fn narrow() -> String {
    let mut text = "time_ms,pwm,counts\n".to_owned();
    for k in 0..ROWS {
        let _ = writeln!(text, "{},{},{}", 3 * k, (k / 500) % 200, 7 * k);
    }
    text
}

/// Ten columns in the usual format of floats.
fn wide() -> String {
    let mut text = "time_ms,pwm,counts,ax,ay,az,gx,gy,gz,temp\n".to_owned();
    for k in 0..ROWS {
        let x = (k as f64 * 0.01).sin();
        let _ = writeln!(
            text,
            "{},{},{},{x:.6},{:.6},{:.6},{:.5},{:.5},{:.5},{:.2}",
            3 * k,
            (k / 500) % 200,
            7 * k,
            2.0 * x,
            3.0 * x,
            4.0 * x,
            5.0 * x,
            6.0 * x,
            20.0 + x
        );
    }
    text
}

const MAP: &str = "counts_per_rev = 720\nsupply_v = 12\n[time]\ncolumn = \"time_ms\"\nunit = \"ms\"\n[command]\ncolumn = \"pwm\"\n\
                   unit = \"pwm\"\nfull = 255\n[position]\ncolumn = \"counts\"\nunit = \"counts\"\n";

#[divan::bench(args = ["narrow", "wide"], sample_count = 10, sample_size = 1)]
fn imported(bencher: Bencher<'_, '_>, log: &str) {
    let text = if log == "narrow" { narrow() } else { wide() };
    let map = Map::from_toml(MAP).expect("a mapping");
    let directory = tempfile::tempdir().expect("a directory");
    let output = directory.path().join("run.csv");
    bencher
        .counter(BytesCount::new(text.len()))
        .bench_local(|| {
            let imported = import(text.as_bytes(), "log.csv", &map, &output).expect("imported");
            assert_eq!((imported.rows, imported.bad_rows), (ROWS as u64, 0));
            std::fs::remove_file(&imported.runs[0].path).expect("its file");
        });
}

#[divan::bench(args = ["narrow", "wide"], sample_count = 10, sample_size = 1)]
fn understood(bencher: Bencher<'_, '_>, log: &str) {
    let text = if log == "narrow" { narrow() } else { wide() };
    let head = &text.as_bytes()[..text.len().min(HEAD_BYTES as usize)];
    let said = GivenFlags {
        supply: Some("12".to_owned()),
        counts_per_rev: Some(720.0),
        pwm_full: Some(255.0),
        ..GivenFlags::default()
    };
    bencher
        .counter(BytesCount::new(head.len()))
        .bench_local(|| {
            let reading = understand(head, false, "log.csv", &said, "motorlab import log.csv");
            assert!(reading.map.is_ok());
        });
}
