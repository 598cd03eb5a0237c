//! Exported motors with each effect of the catalogue, and the error of another program's angle against the
//! simulator's.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use motorlab::motor::catalogue::{Stage, catalogue};
use motorlab::motor::{ActiveEffect, CommandKind, Drive, Motor, SimulationOptions, simulate};

use crate::support::command::run;

/// Largest error at any sample, in counts of the handout's encoder, over a whole run.
const MOST_COUNTS: f64 = 0.01;
/// Step of the programs, in s.
pub const STEP_S: f64 = 0.001;

/// Effects that interact in the equations, in addition to single ones.
const PAIRS: [&[&str]; 9] = [
    &["backlash", "compliance"],
    &["backlash", "static_friction"],
    &["compliance", "load_friction"],
    &["presliding", "backlash"],
    &["presliding", "stribeck"],
    &["slipping_clutch", "voltage_drop"],
    &["stribeck", "voltage_drop"],
    &["voltage_drop", "current_limit"],
    &["winding_heating", "magnet_weakening"],
];

/// A motor's folder, with the commands for the program and the simulator's angles.
pub struct Case {
    pub folder: PathBuf,
    name: String,
    angles_rad: Vec<f64>,
}

/// Steps and a stop, each held for `hold_s`, then reversals of decreasing amplitude.
fn command(t_s: f64, hold_s: f64) -> f64 {
    const LEVELS_V: [f64; 8] = [4.5, -1.0, 0.0, 0.7, -4.5, 0.25, 0.0, 2.0];
    let k = (t_s / hold_s + 1e-9).floor() as usize;
    match LEVELS_V.get(k) {
        Some(level) => *level,
        None => {
            let along = (t_s / hold_s - LEVELS_V.len() as f64) / 4.0;
            let direction = if ((2.0 * t_s / hold_s + 1e-9).floor() as u64).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            direction * 4.0 * (1.0 - along) * (1.0 + 0.2 * (40.0 * along).sin())
        }
    }
}

/// Whether an effect is the motor's rather than the recording's.
fn is_the_motors(stage: Stage, id: &str) -> bool {
    !matches!(stage, Stage::Sensor | Stage::Timing) && id != "command_offset"
}

/// Every motor in its folder below `directory`, exported with `arguments` after `motorlab export`.
pub fn cases(directory: &Path, hold_s: f64, arguments: &[&str]) -> Vec<Case> {
    let kinds = catalogue()
        .iter()
        .filter(|kind| is_the_motors(kind.stage, kind.id));
    let mut sets: Vec<Vec<&str>> = kinds.map(|kind| vec![kind.id]).collect();
    sets.extend(PAIRS.iter().map(|pair| pair.to_vec()));
    sets.push(Vec::new());
    assert!(sets.len() > 40, "{sets:?}");
    sets.iter()
        .map(|set| case(directory, set, hold_s, arguments))
        .collect()
}

fn case(directory: &Path, set: &[&str], hold_s: f64, arguments: &[&str]) -> Case {
    let name = set.join("+");
    let folder = directory.join(format!("motor_{}", set.join("_and_")));
    std::fs::create_dir(&folder).expect("a folder");
    let mut motor = Motor::default();
    for id in set {
        let effect = ActiveEffect::from_keys(id, [], &motor.parameters);
        motor
            .effects
            .set(effect.expect("an effect of the catalogue"));
    }
    let samples = (12.0 * hold_s / STEP_S).round() as usize;
    let t_s: Vec<f64> = (0..=samples).map(|k| k as f64 * STEP_S).collect();
    let commands: Vec<f64> = t_s.iter().map(|t| command(*t, hold_s)).collect();
    let drive = Drive {
        t_s: &t_s,
        command: &commands,
        kind: CommandKind::Voltage,
    };
    let simulated = simulate(&motor, &drive, &SimulationOptions::default()).expect("a run");
    let mut text = String::new();
    for volts in &commands[..samples] {
        let _ = writeln!(text, "{volts:?}");
    }
    std::fs::write(folder.join("commands.txt"), text).expect("commands");
    std::fs::write(folder.join("motor.toml"), motor.to_toml()).expect("a motor file");
    let asked = [&["export"], arguments, &["--motor", "motor.toml"]].concat();
    let exported = run(&folder, &asked);
    assert_eq!(exported.status, Some(0), "{name}: {}", exported.messages);
    Case {
        folder,
        name,
        angles_rad: simulated.angle_rad[1..].to_vec(),
    }
}

/// Compares the angles of a program in `angles.txt` of each folder.
pub fn compare(cases: &[Case]) {
    let counts_per_rad = Motor::default().parameters.counts_per_rev / std::f64::consts::TAU;
    let (mut table, mut failed) = (String::new(), false);
    for case in cases {
        let text = std::fs::read_to_string(case.folder.join("angles.txt")).expect("angles");
        let angles: Vec<f64> = text
            .split_whitespace()
            .map(|word| word.parse().expect("a number"))
            .collect();
        assert_eq!(angles.len(), case.angles_rad.len(), "{}", case.name);
        let errors = angles
            .iter()
            .zip(&case.angles_rad)
            .map(|(a, b)| (a - b).abs() * counts_per_rad);
        // NaN is a mismatch.
        let worst = errors.fold(0.0, |worst: f64, e| {
            if e.is_nan() {
                f64::INFINITY
            } else {
                worst.max(e)
            }
        });
        let travel = case
            .angles_rad
            .iter()
            .fold(0.0, |most: f64, a| most.max(a.abs()))
            * counts_per_rad;
        assert!(travel > 1.0, "{}: the motor hardly moves", case.name);
        failed |= worst > MOST_COUNTS;
        let _ = writeln!(table, "{:<36} {worst:.5}", case.name);
    }
    println!("largest error in counts:\n{table}");
    assert!(
        !failed,
        "errors in counts, of which {MOST_COUNTS} are allowed:\n{table}"
    );
}
