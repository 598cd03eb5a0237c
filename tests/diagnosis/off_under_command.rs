//! A drive that was off under its command: the interval is named and left out, and no model explains it.

use motorlab::check::Kind;
use motorlab::diagnose::{Diagnosis, Options, Settings, Verdict, diagnose, nominal_fit};
use motorlab::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::Run;

const SAMPLE_TIME_S: f64 = 0.01;
const SAMPLES: usize = 1200;

/// A run of the motor, whose driver is off in some samples while the command continues.
fn run(motor: &Motor, is_off: impl Fn(usize) -> bool) -> Run {
    let level = |k: usize| [0.0, 4.5, -3.5, 4.0, 2.5][(k / 100) % 5];
    let t_s: Vec<f64> = (0..SAMPLES).map(|k| SAMPLE_TIME_S * k as f64).collect();
    let command: Vec<f64> = (0..SAMPLES).map(level).collect();
    let driven: Vec<f64> = (0..SAMPLES)
        .map(|k| if is_off(k) { 0.0 } else { level(k) })
        .collect();
    let drive = Drive {
        t_s: &t_s,
        command: &driven,
        kind: CommandKind::Voltage,
    };
    let made = simulate(motor, &drive, &SimulationOptions::default());
    Run {
        sample_time_s: SAMPLE_TIME_S,
        counts_per_rev: 720.0,
        counts: made.expect("a motor").counts,
        t_s,
        command,
        ..Run::default()
    }
}

fn found(run: Run, motor: &Motor) -> Diagnosis {
    diagnose(&[run], motor, &Options::default()).expect("a diagnosis")
}

/// At the end, in the middle, and without a known motor.
#[test]
fn a_perfect_motor_whose_drive_was_off_is_perfect() {
    let motor = Motor::default();
    let mut other = motor.clone();
    other.parameters.inertia_kg_m2 *= 1.7;
    other.parameters.coulomb_friction_nm *= 0.6;
    let intervals: [fn(usize) -> bool; 2] = [
        |k| k >= 1130,
        |k| (610..690).contains(&k) || (1110..1190).contains(&k),
    ];
    for is_off in intervals {
        let diagnosis = found(run(&motor, is_off), &motor);
        assert_eq!(diagnosis.verdict, Verdict::NoGap, "{}", diagnosis.sentence);
        let note = &diagnosis.note;
        assert!(note.contains("off_under_command"), "{note}");
        assert!(note.contains("stands still under a command"), "{note}");
        let is_off_found = |finding: &motorlab::check::Finding| finding.id == Kind::OffUnderCommand;
        assert!(diagnosis.data.iter().any(is_off_found));
        // Nothing is predicted for samples in which the drive was off.
        let predicted = &diagnosis.predicted[0];
        assert!(predicted.gap_counts[0][1160].is_nan());
        let unknown = run(&other, is_off);
        let fit = nominal_fit(std::slice::from_ref(&unknown), &motor, &Settings::default())
            .expect("a fit");
        let diagnosis = found(unknown, &fit.motor);
        let verdict = diagnosis.verdict;
        assert!(
            matches!(verdict, Verdict::NoGap | Verdict::Parameters),
            "{}",
            diagnosis.sentence
        );
        assert!(fit.left_counts < 0.5, "{}", fit.left_counts);
    }
    let whole = found(run(&motor, |_| false), &motor);
    assert!(!whole.note.contains("off_under_command"), "{}", whole.note);
}
