//! The plain first-order fit in open loop is never worse than SciPy's, nor than the motor it starts from; and
//! `--nominal fit`, which is measured over segments, is never worse there than the motor of such a fit.

use std::path::Path;

use crate::support;
use motorlab::diagnose::{NominalFit, Settings, nominal_fit};
use motorlab::import::{Map, import};
use motorlab::least_squares::{
    FirstOrder, FirstOrderMotor, Record, counts_from_first, fit_runs, plain_fit,
};
use motorlab::motor::{CommandKind, Motor};
use motorlab::recording::{Run, read_run};

/// Largest ratio to the error of SciPy's plain least squares.
const AS_GOOD: f64 = 1.05;

/// Error in counts RMS of SciPy: `first_order_fits.py run` of the two cases as imported, `ev3` and `three_levels`.
const SCIPY_P4: f64 = 0.28537;
const SCIPY_SYN_OK: f64 = 1.11152;
const SCIPY_EV3: f64 = 7.4622;
const SCIPY_THREE_LEVELS: f64 = 453.257;

fn imported(source: &Path, map: &Path) -> Vec<Run> {
    let scratch = tempfile::tempdir().expect("a directory");
    let map = Map::read(map).expect("a mapping");
    let file = std::fs::File::open(source).expect("a recording");
    let found = import(file, "log", &map, &scratch.path().join("run.csv")).expect("a run");
    let read = |run: &motorlab::import::ImportedRun| read_run(&run.path).expect("it reads back").0;
    found.runs.iter().map(read).collect()
}

fn fit(runs: &[Run]) -> NominalFit {
    nominal_fit(runs, &Motor::default(), &Settings::default()).unwrap_or_else(|error| {
        panic!(
            "{error}: {:?} every {} s, {} a turn",
            runs[0].counts, runs[0].sample_time_s, runs[0].counts_per_rev
        )
    })
}

/// Position error over segments of another motor.
fn rms_over_segments(runs: &[Run], motor: FirstOrderMotor) -> f64 {
    let given = motor.in_place_of(&Motor::default(), CommandKind::Voltage);
    let fit = nominal_fit(runs, &given, &Settings::default()).expect("it turns");
    fit.given_left_counts.expect("a motor")
}

/// The plain fit's motor has this error in open loop, and the nominal one no larger error over segments than any
/// plain fit.
fn check_against(runs: &[Run], scipy_counts: f64) {
    let plain = fit_runs(runs, &[]).expect("it turns");
    assert!(plain.left_counts <= AS_GOOD * scipy_counts, "{plain:?}");
    check_over_segments(runs);
}

/// Parts of about this length in s, at least 40 samples.
fn cut(run: &Run, length_s: f64) -> Vec<Run> {
    let n = run.t_s.len();
    let least = ((length_s / run.sample_time_s).round() as usize).max(40);
    let count = (n / least).max(1);
    let part = |k: usize| {
        let range = k * n / count..(k + 1) * n / count;
        Run {
            t_s: run.t_s[range.clone()].to_vec(),
            command: run.command[range.clone()].to_vec(),
            counts: run.counts[range].to_vec(),
            ..run.clone()
        }
    };
    (0..count).map(part).collect()
}

/// The nominal motor has no larger error over segments than the plain fit to parts of any length.
fn check_over_segments(runs: &[Run]) {
    let nominal = fit(runs);
    for length_s in [1.0, 2.0, 4.0, f64::MAX] {
        let parts: Vec<Run> = runs.iter().flat_map(|run| cut(run, length_s)).collect();
        let plain = fit_runs(&parts, &[]).expect("it turns");
        let yardstick = rms_over_segments(runs, plain.motor);
        assert!(
            nominal.left_counts <= AS_GOOD * yardstick,
            "{length_s} s: {nominal:?} leaves more than {yardstick} of {plain:?}"
        );
    }
}

/// Two recordings on which a regression alone once had errors of 2378 and 1777 counts; both are exact first-order
/// steps.
#[test]
fn residuals_of_a_first_order_step_are_within_a_count() {
    let folder = Path::new("fixtures/cases/diagnosis/fit_wrong_valley");
    // The speed of the second is rounded to 0.0001 rad/s and its counts are computed from that.
    for (log, map, scipy) in [
        ("p4.csv", "p4.toml", SCIPY_P4),
        ("syn_ok.csv", "syn.toml", SCIPY_SYN_OK),
    ] {
        let runs = imported(&folder.join(log), &folder.join(map));
        check_against(&runs, scipy);
        let found = fit(&runs);
        assert!(
            (found.given_left_counts).is_some_and(|given| given > 10.0 * found.left_counts),
            "{found:?}"
        );
    }
}

/// A drawn motor's step from rest, and SciPy's error.
struct Drawn {
    motor: FirstOrderMotor,
    run: Run,
    scipy_counts: f64,
}

/// `first_order_fits.py` draws and counts them: theta = K (u - F) (t - T (1 - exp(-t/T))).
fn drawn() -> Vec<Drawn> {
    let table = include_str!("../reference/fits/first_order.csv");
    let of_row = |row: &str| {
        let numbers = row.split(',').map(|cell| cell.parse().expect("a number"));
        let numbers: Vec<f64> = numbers.collect();
        let [
            gain,
            time_constant_s,
            friction,
            volts,
            per_rev,
            phase,
            step_s,
            samples,
            left,
        ] = numbers[..]
        else {
            panic!("{row}");
        };
        let t_s: Vec<f64> = (0..samples as usize).map(|k| k as f64 * step_s).collect();
        let turned = |t: f64| t + time_constant_s * (-t / time_constant_s).exp_m1();
        let per_rad = per_rev / std::f64::consts::TAU;
        let count = |t: &f64| (gain * (volts - friction) * turned(*t) * per_rad + phase).floor();
        Drawn {
            motor: FirstOrderMotor {
                gain,
                shape: FirstOrder {
                    time_constant_s,
                    friction,
                },
            },
            run: Run {
                sample_time_s: step_s,
                counts_per_rev: per_rev,
                supply_v: Some(volts),
                complete: true,
                command: vec![volts; t_s.len()],
                counts: t_s.iter().map(|t| count(t) as i64).collect(),
                t_s,
                ..Run::default()
            },
            scipy_counts: left,
        }
    };
    table.lines().skip(1).map(of_row).collect()
}

/// Among them are fast motors that are nearly at steady speed at the second sample, without a start in motion.
#[test]
fn drawn_motors_are_fitted_as_well_as_by_scipy() {
    let all = drawn();
    assert_eq!(all.len(), 200);
    let mut worse = Vec::new();
    for (k, drawn) in all.iter().enumerate() {
        let runs = std::slice::from_ref(&drawn.run);
        let plain = fit_runs(runs, &[]).expect("it turns").left_counts;
        let nominal = fit(runs).left_counts;
        let truth = rms_over_segments(runs, drawn.motor);
        for (left, most) in [(plain, drawn.scipy_counts), (nominal, truth)] {
            if left > AS_GOOD * most {
                worse.push((k, left, most));
            }
        }
    }
    assert!(worse.is_empty(), "{worse:?}");
}

/// Root mean square of counts minus those of a motor, by the textbook's step response and not the fit's.
fn left_of_step(run: &Run, motor: FirstOrderMotor) -> f64 {
    let shape = motor.shape;
    let driven = (run.command[0] - shape.friction).max(0.0);
    let per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let turned = |t: f64| t + shape.time_constant_s * (-t / shape.time_constant_s).exp_m1();
    let pairs = run.t_s.iter().zip(&run.counts);
    let raw: Vec<f64> = pairs
        .map(|(t, n)| *n as f64 + 0.5 - motor.gain * driven * turned(*t) * per_rad)
        .collect();
    let start = (raw.iter().sum::<f64>() / raw.len() as f64).clamp(0.0, 1.0);
    (raw.iter().map(|r| (r - start).powi(2)).sum::<f64>() / raw.len() as f64).sqrt()
}

/// The motor of the run and others as starts: the fit has no larger error than any of them.
#[test]
fn a_fit_is_never_worse_than_its_initial_motor() {
    for (k, drawn) in drawn().iter().enumerate().step_by(4) {
        let FirstOrderMotor { gain, shape } = drawn.motor;
        let beside = |factor: f64| FirstOrderMotor {
            gain: gain * factor,
            shape: FirstOrder {
                time_constant_s: shape.time_constant_s / factor,
                friction: shape.friction * factor,
            },
        };
        let starts = [beside(1.0), beside(1.001), beside(0.97), beside(4.0)];
        let found = fit_runs(std::slice::from_ref(&drawn.run), &starts).expect("it turns");
        for start in starts {
            let left = left_of_step(&drawn.run, start);
            assert!(
                found.left_counts <= left * (1.0 + 1e-9),
                "{k}: {found:?} leaves more than {left} of {start:?}"
            );
        }
        let own = left_of_step(&drawn.run, found.motor);
        assert!(
            (found.left_counts / own - 1.0).abs() < 1e-9,
            "{k}: {own}, {found:?}"
        );
    }
}

/// A recording of several levels that begins in motion: the parameters are found, with the initial speed and without.
#[test]
fn a_start_in_motion_is_detected() {
    let truth = FirstOrder {
        time_constant_s: 0.15,
        friction: 0.5,
    };
    let (gain, counts_per_rev) = (2.5, 4000.0);
    let t_s: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.01).collect();
    let command: Vec<f64> = (0..600)
        .map(|k| [6.0, -4.0, 2.5, 8.0, -6.0][k / 120])
        .collect();
    let begins_rad_s = 9.0;
    let per_rad = counts_per_rev / std::f64::consts::TAU;
    let angles = truth.angles(&t_s, &command, begins_rad_s / gain);
    let counted = |angle: &f64| (gain * angle * per_rad + 0.3).floor() as i64;
    let run = Run {
        sample_time_s: 0.01,
        counts_per_rev,
        supply_v: Some(8.0),
        complete: true,
        counts: angles.iter().map(counted).collect(),
        command,
        t_s,
        ..Run::default()
    };
    let counts = counts_from_first(&run);
    let record = Record::from_rest(&run.t_s, &run.command, &counts, counts_per_rev);
    let told = plain_fit(&[record.starting(begins_rad_s * per_rad)], &[]).expect("it turns");
    assert!(told.left_counts < 0.31, "{told:?}");
    assert!((told.motor.gain / gain - 1.0).abs() < 1e-3, "{told:?}");
    let found = fit_runs(std::slice::from_ref(&run), &[]).expect("it turns");
    let shape = found.motor.shape;
    assert!(
        (shape.time_constant_s / 0.15 - 1.0).abs() < 0.02,
        "{found:?}"
    );
    assert!((shape.friction - 0.5).abs() < 0.1, "{found:?}");
}

/// A step from rest of a real motor, from its command on.
fn step(counts_per_rev: f64, volts: f64, t_s: Vec<f64>, counts: Vec<i64>) -> Run {
    Run {
        sample_time_s: t_s[t_s.len() - 1] / (t_s.len() - 1) as f64,
        counts_per_rev,
        supply_v: Some(volts.abs()),
        complete: true,
        command: vec![volts; t_s.len()],
        t_s,
        counts,
        ..Run::default()
    }
}

/// Numeric rows of every file of a folder, with the command in its name.
fn tables(folder: &Path) -> Vec<(f64, Vec<Vec<f64>>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("a file").path();
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let level = name
            .split('_')
            .nth(1)
            .expect("a level")
            .trim_end_matches('V');
        let text = std::fs::read_to_string(&path).expect("text");
        // A line of names is no row.
        let row = |line: &str| -> Option<Vec<f64>> {
            let cells = line
                .split([',', ' ', '\t'])
                .filter(|cell| !cell.trim().is_empty());
            cells.map(|cell| cell.trim().parse().ok()).collect()
        };
        let rows = text
            .lines()
            .filter_map(row)
            .filter(|row| !row.is_empty())
            .collect();
        found.push((level.parse().expect("a number"), rows));
    }
    found
}

/// Error of SciPy on the same steps: `first_order_fits.py ev3` and `three_levels`.
#[test]
fn real_motors_are_fitted_as_well_as_by_scipy() {
    let Some(folder) = support::real_recordings("real_motors_are_fitted_as_well_as_by_scipy")
    else {
        return;
    };
    let ev3 = tables(&folder.join("ev3")).into_iter().map(|(duty, rows)| {
        let t_s = rows.iter().map(|row| row[0] - rows[0][0]).collect();
        let counts = rows
            .iter()
            .map(|row| (row[1] - rows[0][1]) as i64)
            .collect();
        step(360.0, 7.5 * duty / 100.0, t_s, counts)
    });
    check_against(&ev3.collect::<Vec<_>>(), SCIPY_EV3);
    let three_levels = tables(&folder.join("three_levels"))
        .into_iter()
        .map(|(volts, rows)| {
            let driven = rows
                .iter()
                .position(|row| row[0] > 1.9999)
                .expect("two seconds");
            let mut turned = 0.0;
            let (mut t_s, mut counts) = (Vec::new(), Vec::new());
            for row in &rows[driven..] {
                t_s.push(row[0] - rows[driven][0]);
                counts.push(f64::round(turned) as i64);
                // The speed of the next row is the mean over the step to it.
                turned += rows[(driven + t_s.len()).min(rows.len() - 1)][1] * 32000.0 / 60.0 * 0.01;
            }
            step(32000.0, volts, t_s, counts)
        });
    check_against(&three_levels.collect::<Vec<_>>(), SCIPY_THREE_LEVELS);
}

/// The staircase's columns.
const BRIDGE: &str = r#"
counts_per_rev = 2400
supply_v = 12

[time]
column = "time"
unit = "s"

[command]
column = "voltage"
unit = "V"

[speed]
column = "rpm"
unit = "rpm"
"#;

/// A staircase of a minute whose speed creeps, of a real motor behind a bridge: over a minute in open loop the creep
/// hides the time constant, over segments it does not, in the whole and in its parts. The author's model of the same
/// motor is 35.25 rpm/V, 0.28 s and 2 V.
#[test]
fn a_staircase_of_a_minute_has_its_published_parameters() {
    let Some(folder) =
        support::real_recordings("a_staircase_of_a_minute_has_its_published_parameters")
    else {
        return;
    };
    let log = std::fs::File::open(folder.join("l298n/run_minimal.csv")).expect("a recording");
    let scratch = tempfile::tempdir().expect("a directory");
    let map = Map::from_toml(BRIDGE).expect("a mapping");
    let found = import(log, "log", &map, &scratch.path().join("run.csv")).expect("a run");
    let run = read_run(&found.runs[0].path).expect("it reads back").0;
    check_over_segments(std::slice::from_ref(&run));
    for parts in [3, 5, 10] {
        let length_s = run.t_s[run.t_s.len() - 1] / f64::from(parts);
        let turns = |part: &Run| {
            part.counts
                .iter()
                .any(|n| (n - part.counts[0]).abs() > 1000)
        };
        let turning: Vec<Run> = cut(&run, length_s).into_iter().filter(turns).collect();
        for first in 0..2 {
            let some: Vec<Run> = turning.iter().skip(first).step_by(2).cloned().collect();
            check_over_segments(&some);
        }
    }
    let found = FirstOrderMotor::of(&fit(&[run]).motor, CommandKind::Voltage).expect("a motor");
    let rpm_per_v = found.gain * 60.0 / std::f64::consts::TAU;
    assert!((rpm_per_v / 35.25 - 1.0).abs() < 0.05, "{rpm_per_v}");
    // The author has an additional delay of 30 to 55 ms, which a first-order motor has in its time constant.
    let times = found.shape.time_constant_s / 0.28;
    assert!((0.5..2.0).contains(&times), "{found:?}");
    assert!((found.shape.friction / 2.0 - 1.0).abs() < 0.1, "{found:?}");
}
