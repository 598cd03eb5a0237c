//! Throughput of the recorder in samples per second, and its memory over a million of them.
//!
//! `cargo bench --bench recorder`: virtual board -> pseudo-terminal -> reader thread -> frames -> samples -> run
//! file, with `items/s` samples per second (a board at 3 ms sends 333). `pty_alone` is the upper bound: the same
//! bytes through a pseudo-terminal, discarded. `cargo bench --bench recorder -- --memory` records 10,000 to 3,000,000
//! samples and prints the process's peak memory for each.

#[path = "support/mod.rs"]
mod support;

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::time::Instant;

use divan::Bencher;
use divan::counter::ItemsCount;
use motorlab::board::pty::Pty;
use motorlab::board::{BoardSide, IdealBench, Port};
use motorlab::motor::{Motor, Plant};
use motorlab::recording::CommandKind;
use support::record;

fn main() {
    if std::env::args().any(|argument| argument == "--memory") {
        memory();
    } else {
        divan::main();
    }
}

const SAMPLES: u32 = 20_000;
const FRAME: usize = 18;

#[divan::bench(sample_count = 10, sample_size = 1)]
fn with_the_simulated_motor(bencher: Bencher<'_, '_>) {
    let directory = tempfile::tempdir().expect("a directory");
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let plant = Plant::new(&Motor::default(), CommandKind::Voltage, 1).expect("a motor");
        let captured = record(plant, SAMPLES, &directory.path().join("run.csv"));
        assert_eq!(
            (captured.statistics.samples, captured.statistics.lost),
            (u64::from(SAMPLES), 0)
        );
    });
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn with_an_ideal_motor(bencher: Bencher<'_, '_>) {
    let directory = tempfile::tempdir().expect("a directory");
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let bench = IdealBench::new(100.0);
        let captured = record(bench, SAMPLES, &directory.path().join("run.csv"));
        assert_eq!(captured.statistics.lost, 0);
    });
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn pty_alone(bencher: Bencher<'_, '_>) {
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut pty = Pty::open().expect("a pseudo-terminal");
        let mut port = Port::open(pty.path(), 115_200).expect("openable");
        let all = SAMPLES as usize * FRAME;
        std::thread::scope(|scope| {
            let sender = scope.spawn(move || {
                let block = [0x55; 256];
                let mut sent = 0;
                while sent < all {
                    let ready = pty.wait(std::time::Duration::from_millis(20), true);
                    ready.expect("a line");
                    sent += pty
                        .write_some(&block[..block.len().min(all - sent)])
                        .expect("a line");
                }
                pty
            });
            let mut buffer = [0; 4096];
            let mut read = 0;
            while read < all {
                read += match port.read(&mut buffer) {
                    Ok(count) => count,
                    Err(error) if error.kind() == ErrorKind::TimedOut => 0,
                    Err(error) => panic!("after {read} bytes: {error}"),
                };
            }
            // Closing the near end drops unread bytes.
            drop(sender.join());
        });
    });
}

/// Peak resident memory since the last reset in kB, from `/proc`.
fn peak_kb() -> Option<u64> {
    let mut status = String::new();
    let mut file = File::open("/proc/self/status").ok()?;
    file.read_to_string(&mut status).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

fn memory() {
    println!("samples    lost  peak memory  time    samples/s");
    for samples in [10_000, 10_000, 100_000, 1_000_000, 1_000_000, 3_000_000] {
        let reset = File::options().write(true).open("/proc/self/clear_refs");
        let reset = reset.and_then(|mut file| file.write_all(b"5"));
        if let Err(error) = reset {
            println!("the peak cannot be reset here: {error}");
        }
        let directory = tempfile::tempdir().expect("a directory");
        let begun = Instant::now();
        let plant = Plant::new(&Motor::default(), CommandKind::Voltage, 1).expect("a motor");
        let captured = record(plant, samples, &directory.path().join("run.csv"));
        let took_s = begun.elapsed().as_secs_f64();
        println!(
            "{samples:<9} {lost:>5}  {peak:>8} kB  {took_s:>5.1} s {rate:>9.0}",
            lost = captured.statistics.lost,
            peak = peak_kb().map_or("?".to_owned(), |kb| kb.to_string()),
            rate = f64::from(samples) / took_s,
        );
    }
}
