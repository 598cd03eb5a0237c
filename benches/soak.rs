//! Long recordings: samples lost, memory, processor time, fit of the board's clock.
//!
//! `cargo bench --bench soak` takes three minutes; words after `--` select rows by name. The board is a separate
//! process (`motorlab virtual`), so that the figures are the recorder's alone.

#[path = "../tests/support/process.rs"]
mod process;

use std::error::Error;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Rows of the table: name, board, sample time in s, duration in s.
const ROWS: [(&str, &str, &str, &str); 4] = [
    // micros() wraps after 55 minutes.
    (
        "hour",
        "virtual:?speed=max&micros_start=994967296",
        "0.003",
        "3600",
    ),
    ("minute+200ppm", "virtual:?clock_ppm=200", "0.003", "60"),
    ("minute-200ppm", "virtual:?clock_ppm=-200", "0.003", "60"),
    // 18 bytes of 10 bits each at 115200 baud take 1562.5 us.
    ("limit", "virtual:", "0.001563", "60"),
];

fn motorlab(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motorlab"));
    command.current_dir(directory).stdout(Stdio::piped());
    command
}

/// A board process, killed on drop.
struct Board(Child);

impl Drop for Board {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn plug_in(board: &str, directory: &Path) -> Result<(Board, String), Box<dyn Error>> {
    let mut child = motorlab(directory).args(["virtual", board]).spawn()?;
    let output = child.stdout.take().ok_or("no pipe")?;
    let board = Board(child);
    let mut port = String::new();
    BufReader::new(output).read_line(&mut port)?;
    Ok((board, port.trim().to_owned()))
}

fn record(board: &str, sample_time: &str, duration: &str) -> Result<String, Box<dyn Error>> {
    let directory = tempfile::tempdir()?;
    let (_board, port) = plug_in(board, directory.path())?;
    let started = Instant::now();
    let child = motorlab(directory.path())
        .args(["capture", &port, "--ts", sample_time])
        .args(["--duration", duration, "--json"])
        .spawn()?;
    let pid = child.id();
    let (mut first_kb, mut peak_kb, mut cpu_s) = (0, 0, 0.0);
    let watch = std::thread::spawn(move || {
        while let Some(now_kb) = process::peak_memory_kb(pid) {
            peak_kb = now_kb;
            cpu_s = process::cpu_s(pid).unwrap_or(cpu_s);
            if first_kb == 0 && started.elapsed() > Duration::from_secs(1) {
                first_kb = now_kb;
            }
            sleep(Duration::from_millis(20));
        }
        (first_kb, peak_kb, cpu_s)
    });
    // The measurement reads the process's memory until it ends.
    let (first_kb, peak_kb, cpu_s) = watch.join().map_err(|_| "the watch failed")?;
    let elapsed_s = started.elapsed().as_secs_f64();
    let output = child.wait_with_output()?;
    let json: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let clock = &json["statistics"]["clock"];
    let fit = match clock["device_fast_ppm"].as_f64() {
        Some(ppm) => format!(
            "{ppm:+.2} ppm, residual {:.2} ms",
            clock["residual_rms_s"].as_f64().unwrap_or(f64::NAN) * 1e3
        ),
        None => "not in real time".to_owned(),
    };
    Ok(format!(
        "{:>9} {:>6} {elapsed_s:>9.1} {first_kb:>9} {peak_kb:>9} {cpu_s:>8.2} {:>7.2}  {fit}",
        json["samples"],
        json["lost"],
        100.0 * cpu_s / elapsed_s,
    ))
}

fn main() -> Result<(), Box<dyn Error>> {
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    println!(
        "{:<14} {:>9} {:>6} {:>9} {:>9} {:>9} {:>8} {:>7}  board's clock",
        "run", "samples", "lost", "elapsed s", "kB at 1 s", "peak kB", "cpu s", "cpu %"
    );
    for (name, board, sample_time, duration) in ROWS {
        if wanted.is_empty() || wanted.iter().any(|word| word == name) {
            println!("{name:<14} {}", record(board, sample_time, duration)?);
        }
    }
    Ok(())
}
