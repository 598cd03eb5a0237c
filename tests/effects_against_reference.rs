//! Every effect, and a few at once, against trajectories that an independent hybrid automaton (SciPy's DOP853 at
//! rtol 1e-12, tests/reference/hybrid.py) made over a 15 s reversing run: within 0.01 count.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use motorlab::motor::{Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::CommandKind;

const SAMPLE_TIME_S: f64 = 0.003;
const SAMPLES: usize = 5000;

/// The command of every sample.
fn drive(folder: &Path) -> (Vec<f64>, Vec<f64>) {
    let text = fs::read_to_string(folder.join("drive.csv")).unwrap();
    let mut commands = vec![0.0; SAMPLES];
    for line in text.lines().skip(2) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        commands[row[0] as usize..].fill(row[2]);
    }
    let times = (0..SAMPLES).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    (times, commands)
}

/// The motor of a reference file's header, and its rows.
fn reference(path: &Path) -> (Motor, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).unwrap();
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

#[test]
fn every_effect_follows_the_independent_reference() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/effects");
    let (t_s, command) = drive(&folder);
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let index = fs::read_to_string(folder.join("index.csv")).unwrap();
    let mut table = String::from("| effect | error in counts |\n| --- | --- |\n");
    let mut worst_name = (0.0, String::new());
    for line in index.lines().skip(1) {
        let mut fields = line.split(',');
        let (file, _, class) = (
            fields.next().unwrap(),
            fields.next(),
            fields.next().unwrap(),
        );
        if class == "random" || file == "missed_counts_rate.csv" {
            continue;
        }
        let (motor, rows) = reference(&folder.join(file));
        let run = simulate(&motor, &drive, &SimulationOptions::default()).unwrap();
        let per_rad = 720.0 / std::f64::consts::TAU;
        let mut worst = 0.0_f64;
        for row in &rows {
            let k = row[0] as usize;
            let off = ((run.measured_angle_rad[k] * per_rad - row[5]).abs())
                .max((run.angle_rad[k] - row[2]).abs() * per_rad);
            worst = worst.max(off);
        }
        let name = file.trim_end_matches(".csv");
        writeln!(table, "| {name} | {worst:.1e}").unwrap();
        if worst > worst_name.0 {
            worst_name = (worst, name.to_owned());
        }
    }
    println!("{table}");
    assert!(worst_name.0 < 0.01, "{worst_name:?}");
}
