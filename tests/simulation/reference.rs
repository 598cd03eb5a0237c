//! Every effect, and some combinations, against trajectories of an independent hybrid automaton (SciPy's DOP853 at
//! rtol 1e-12, tests/reference/hybrid.py) over a 15 s reversing run: within 0.01 count; random ones against exact
//! mean and variance.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::table;
use motorlab::motor::{Drive, Motor, SimulationOptions, Trajectory, simulate};
use motorlab::recording::CommandKind;

const SAMPLE_TIME_S: f64 = 0.003;
const SAMPLES: usize = 5000;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/effects")
}

/// The command of every sample.
fn command() -> Vec<f64> {
    let text = fs::read_to_string(folder().join("drive.csv")).unwrap();
    let mut commands = vec![0.0; SAMPLES];
    for line in text.lines().skip(2) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        commands[row[0] as usize..].fill(row[2]);
    }
    commands
}

/// The motor of a reference file's header, and its rows.
fn reference(file: &str) -> (Motor, Vec<Vec<f64>>) {
    let text = fs::read_to_string(folder().join(file)).unwrap();
    let toml: String = text
        .lines()
        .filter_map(|line| line.strip_prefix("# "))
        .skip(1)
        .fold(String::new(), |all, line| all + line + "\n");
    let rows = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    (Motor::from_toml(&toml).unwrap(), rows)
}

fn run(motor: &Motor, seed: u64) -> Trajectory {
    let t_s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &command(),
        kind: CommandKind::Voltage,
    };
    let options = SimulationOptions {
        seed,
        ..SimulationOptions::default()
    };
    simulate(motor, &drive, &options).unwrap()
}

#[test]
fn every_effect_follows_the_independent_reference() {
    let index = fs::read_to_string(folder().join("index.csv")).unwrap();
    let per_rad = 720.0 / std::f64::consts::TAU;
    let mut table =
        String::from("| effects | error of the encoder's angle in counts |\n| --- | --- |\n");
    for line in index.lines().skip(1) {
        let mut fields = line.split(',');
        let file = fields.next().unwrap();
        if fields.nth(1) == Some("random") || file == "missed_counts_rate.csv" {
            continue;
        }
        let (motor, rows) = reference(file);
        let run = run(&motor, 1);
        let mut worst = 0.0_f64;
        for row in &rows {
            let k = row[0] as usize;
            let measured = (run.measured_angle_rad[k] * per_rad - row[5]).abs();
            worst = worst
                .max(measured)
                .max((run.angle_rad[k] - row[2]).abs() * per_rad);
            let exact = row[5] + 0.5;
            if (exact - exact.round()).abs() > 0.01 {
                assert_eq!(run.counts[k], exact.floor() as i64, "{file}, sample {k}");
            }
        }
        let name = file.trim_end_matches(".csv");
        assert!(worst < 0.01, "{name}: {worst} counts");
        writeln!(table, "| {name} | {} |", table::decade(worst)).unwrap();
    }
    insta::assert_snapshot!(table);
    table::documented(&table);
}

/// Mean and variance of the counts over seeds against the exact ones, row by row.
fn check_statistics(file: &str) {
    const SEEDS: u64 = 400;
    let (motor, rows) = reference(file);
    let mut sums = vec![(0.0, 0.0); rows.len()];
    let mut mean_rad = Vec::new();
    for seed in 0..SEEDS {
        let run = run(&motor, seed);
        for (row, sum) in rows.iter().zip(&mut sums) {
            let off = run.counts[row[0] as usize] as f64 - row[2];
            *sum = (sum.0 + off, sum.1 + off * off);
        }
        mean_rad = run.measured_angle_rad;
    }
    for (row, (sum, squares)) in rows.iter().zip(sums) {
        let n = SEEDS as f64;
        let sample = row[0];
        // Five standard errors, and half a count for the quantization that the mean angle does not have.
        let tolerance = 5.0 * (row[3] / n).sqrt() + 1e-9;
        assert!(
            (sum / n).abs() <= tolerance + 0.02,
            "{file}: mean at {sample} is off by {}",
            sum / n
        );
        let variance = squares / n;
        let spread = 5.0 * row[3] * (2.0 / n).sqrt() + 0.05;
        assert!(
            (variance - row[3]).abs() <= spread,
            "{file}: variance at {sample} is {variance}, exact {}",
            row[3]
        );
        let angle = mean_rad[sample as usize] * 720.0 / std::f64::consts::TAU;
        assert!(
            (angle - row[2]).abs() <= 0.6,
            "{file}: mean angle at {sample}"
        );
    }
}

#[test]
fn lost_edges_have_the_exact_mean_and_variance() {
    check_statistics("missed_counts.csv");
}

#[test]
fn late_samples_have_the_exact_mean_and_variance() {
    check_statistics("sample_jitter.csv");
}

#[test]
fn edges_above_the_rate_are_lost_and_no_others() {
    let (motor, rows) = reference("missed_counts_rate.csv");
    let run = run(&motor, 1);
    for row in rows {
        let k = row[0] as usize;
        // An edge within a sample time of the crossing may be on either side: 1 in some 40 crossings of the limit.
        assert!(
            (run.counts[k] as f64 - row[2]).abs() <= 2.0,
            "sample {k}: {} against {}",
            run.counts[k],
            row[2]
        );
    }
}
