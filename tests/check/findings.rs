//! Findings about the drive, the rows and the counter: each on logs with the fault, in several forms, and none on
//! valid ones, with any effect of the catalogue.

use motorlab::board::Profile;
use motorlab::check::{Finding, Kind, Severity, check, samples_named_by_check};
use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{ActiveEffect, Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::Run;
use rand::{RngExt as _, SeedableRng as _};

/// The kinds tested in this file.
const KINDS: [Kind; 7] = [
    Kind::CounterReset,
    Kind::StaleRows,
    Kind::OffUnderCommand,
    Kind::SpeedZeroBetweenEdges,
    Kind::SpeedKept,
    Kind::MovingAverage,
    Kind::LossInOneDirection,
];

const COUNTS_PER_REV: f64 = 720.0;

fn empty(step_s: f64) -> Run {
    Run {
        sample_time_s: step_s,
        counts_per_rev: COUNTS_PER_REV,
        supply_v: Some(6.0),
        complete: true,
        ..Run::default()
    }
}

/// A first-order motor (16.7 RPM per V, 80 ms, friction of 0.5 V) every `step_s`, under `command` with the drive
/// switched by `is_on`: its positions in counts, not quantized.
fn turning(
    step_s: f64,
    samples: usize,
    command: impl Fn(f64) -> f64,
    is_on: impl Fn(f64) -> bool,
) -> (Run, Vec<f64>) {
    const FINE: usize = 50;
    let mut run = empty(step_s);
    let mut positions = Vec::new();
    let (mut speed, mut position) = (0.0_f64, 0.0_f64);
    for k in 0..samples {
        let t_s = k as f64 * step_s;
        run.t_s.push(t_s);
        run.command.push(command(t_s));
        run.counts.push(position.round() as i64);
        positions.push(position);
        let h = step_s / FINE as f64;
        for _ in 0..FINE {
            let drive = if is_on(t_s) { command(t_s) } else { 0.0 };
            let friction = 0.5;
            let torque = if speed == 0.0 && drive.abs() <= friction {
                0.0
            } else {
                let against = if speed == 0.0 { drive } else { speed };
                drive - friction * against.signum()
            };
            let next = speed + h / 0.08 * (200.0 * torque - speed);
            speed = if speed * next < 0.0 && drive.abs() <= friction {
                0.0
            } else {
                next
            };
            position += h * speed;
        }
    }
    (run, positions)
}

fn of_kind(run: &Run, kind: Kind) -> Vec<Finding> {
    let mut found = check(std::slice::from_ref(run), None);
    found.retain(|finding| finding.id == kind);
    found
}

fn one(run: &Run, kind: Kind) -> Finding {
    let found = of_kind(run, kind);
    let all = check(std::slice::from_ref(run), None);
    assert_eq!(found.len(), 1, "{kind:?}: {all:#?}");
    found.into_iter().next().expect("one")
}

/// Rest, then these commands in V for 1.5 s each.
fn levels<const N: usize>(levels: [f64; N]) -> impl Fn(f64) -> f64 {
    move |t_s: f64| {
        let place = ((t_s - 0.5) / 1.5).floor();
        if place < 0.0 {
            return 0.0;
        }
        levels.get(place as usize).copied().unwrap_or(0.0)
    }
}

#[test]
fn a_drive_that_is_off_under_its_command_is_named_with_its_interval() {
    for step_s in [0.002, 0.01, 0.03] {
        let samples = (4.0 / step_s) as usize;
        for volts in [6.0, -6.0] {
            let command = levels([volts, volts, volts]);
            let (run, _) = turning(step_s, samples, &command, |t_s| t_s < 2.0);
            let found = one(&run, Kind::OffUnderCommand);
            assert_eq!(found.severity, Severity::Warning);
            assert!((found.from_s - 2.0).abs() <= 0.08, "{found:?}");
            assert!((found.to_s - (samples - 1) as f64 * step_s).abs() < 1e-6);
            let named = samples_named_by_check(&run);
            assert_eq!(named.last(), Some(&(samples - 1)));
            assert!((run.t_s[named[0]] - found.from_s).abs() < 1e-9);
        }
        // Off for a while and on again.
        let command = levels([6.0, 6.0]);
        let (run, _) = turning(step_s, samples, &command, |t_s| !(1.5..2.5).contains(&t_s));
        let found = one(&run, Kind::OffUnderCommand);
        assert!((found.from_s - 1.5).abs() <= 0.1, "{found:?}");
        assert!((found.to_s - 2.5).abs() <= 0.1, "{found:?}");
        // On throughout, with levels up and down.
        let (run, _) = turning(step_s, samples, levels([6.0, 0.4, 3.0]), |_| true);
        assert_eq!(of_kind(&run, Kind::OffUnderCommand), []);
    }
}

#[test]
fn a_dead_time_of_many_samples_is_a_warning_with_its_length() {
    for (step_s, dead_s) in [(0.005, 0.1), (0.01, 0.25), (0.002, 0.06)] {
        let levels = levels([6.0, 0.0, 4.0, 0.0]);
        let late = |t_s: f64| levels(t_s - dead_s);
        let (mut run, _) = turning(step_s, (6.0 / step_s) as usize, late, |_| true);
        run.command = run.t_s.iter().map(|t_s| levels(*t_s)).collect();
        let found = one(&run, Kind::CommandEarly);
        assert_eq!(found.severity, Severity::Warning, "{found:?}");
        let error_s = (found.evidence["dead_time_s"] - dead_s).abs();
        assert!(error_s <= 2.0 * step_s, "{found:?}");
    }
}

/// A log of speeds alone, integrated backward as by an import.
fn of_speeds(run: &Run, speeds: &[f64]) -> Run {
    let header = "[imported]\nposition = \"integrated from speeds, backward\"\n";
    let mut run = Run {
        header: header.parse().expect("TOML"),
        ..run.clone()
    };
    let mut sum = 0.0;
    for (k, speed) in speeds.iter().enumerate().take(run.len()) {
        let step_s = if k == 0 {
            0.0
        } else {
            run.t_s[k] - run.t_s[k - 1]
        };
        sum += speed * step_s;
        run.counts[k] = f64::round(sum) as i64;
    }
    run
}

/// Speeds in counts/s as differences of positions.
fn speeds(run: &Run, positions: &[f64]) -> Vec<f64> {
    (0..positions.len())
        .map(|k| match k {
            0 => 0.0,
            _ => (positions[k] - positions[k - 1]) / (run.t_s[k] - run.t_s[k - 1]),
        })
        .collect()
}

#[test]
fn speeds_between_edges_are_named_whether_0_or_held() {
    let (run, positions) = turning(0.01, 400, levels([6.0, 0.0]), |_| true);
    let speeds = speeds(&run, &positions);
    assert_eq!(
        of_kind(&of_speeds(&run, &speeds), Kind::SpeedZeroBetweenEdges),
        []
    );
    for every in [2, 3, 4] {
        let zero: Vec<f64> = (speeds.iter().enumerate())
            .map(|(k, v)| if k % every == 0 { *v } else { 0.0 })
            .collect();
        let found = one(&of_speeds(&run, &zero), Kind::SpeedZeroBetweenEdges);
        let share = found.evidence["zero_share"];
        assert!(
            (share - (1.0 - 1.0 / every as f64)).abs() < 0.05,
            "{found:?}"
        );
    }
    // The last speed before rest is repeated.
    let mut last = 0.0;
    let kept: Vec<f64> = (speeds.iter())
        .map(|v| {
            if last == 0.0 || *v > 100.0 {
                last = *v;
            }
            last
        })
        .collect();
    let found = one(&of_speeds(&run, &kept), Kind::SpeedKept);
    assert!(found.from_s > 2.0 && found.to_s > 3.8, "{found:?}");
}

#[test]
fn rows_that_are_stale_after_a_pause_are_named() {
    for (pause_s, stale) in [(0.2, 1), (0.5, 4)] {
        let (mut run, positions) = turning(0.01, 500, levels([6.0, 6.0, 6.0]), |_| true);
        // The rows of the pause are missing; those after it have the values from its start.
        let (from, rows) = (200, (pause_s / 0.01) as usize);
        for k in 0..stale {
            run.counts[from + rows + k] = positions[from - 1].round() as i64;
        }
        let gone: Vec<usize> = (from..from + rows).collect();
        let run = run.without(&gone);
        let found = one(&run, Kind::StaleRows);
        assert_eq!(
            found.evidence["stale_rows"],
            f64::from(stale as u32),
            "{found:?}"
        );
        let named: Vec<usize> = (from..from + stale).collect();
        assert_eq!(samples_named_by_check(&run), named);
    }
}

#[test]
fn a_moving_average_is_named_with_its_rows() {
    for (step_s, rows) in [(0.01, 10), (0.01, 20)] {
        let (run, positions) = turning(step_s, 800, levels([6.0, 0.0, 4.0]), |_| true);
        let speeds = speeds(&run, &positions);
        let mean: Vec<f64> = (0..speeds.len())
            .map(|k| {
                let last = &speeds[(k + 1).saturating_sub(rows)..=k];
                last.iter().sum::<f64>() / rows as f64
            })
            .collect();
        assert_eq!(of_kind(&of_speeds(&run, &speeds), Kind::MovingAverage), []);
        let found = one(&of_speeds(&run, &mean), Kind::MovingAverage);
        assert!(
            (found.evidence["rows"] - rows as f64).abs() <= 1.0,
            "{found:?}"
        );
        // A filter with one time constant is no moving average.
        let keep = (-1.0 / rows as f64 * 2.0).exp();
        let mut last = 0.0;
        let filtered: Vec<f64> = (speeds.iter())
            .map(|v| {
                last = keep * last + (1.0 - keep) * v;
                last
            })
            .collect();
        assert_eq!(
            of_kind(&of_speeds(&run, &filtered), Kind::MovingAverage),
            []
        );
    }
}

#[test]
fn fewer_counts_in_one_direction_are_named_with_their_share() {
    let both = levels([6.0, -6.0, 4.0, -4.0, 6.0, -5.0]);
    let (run, positions) = turning(0.005, 2000, &both, |_| true);
    assert_eq!(of_kind(&run, Kind::LossInOneDirection), []);
    for (share, sign) in [(0.8, -1.0), (0.85, 1.0), (0.5, -1.0), (-1.0, -1.0)] {
        let mut lossy = run.clone();
        let mut sum = 0.0;
        for k in 1..run.len() {
            let step = positions[k] - positions[k - 1];
            sum += if step * sign > 0.0 {
                share * step
            } else {
                step
            };
            lossy.counts[k] = f64::round(sum) as i64;
        }
        let found = one(&lossy, Kind::LossInOneDirection);
        let lost = found.evidence["lost_share"];
        assert!((lost - (1.0 - share.abs())).abs() < 0.02, "{found:?}");
        let expected = if share < 0.0 {
            Severity::Warning
        } else {
            Severity::Note
        };
        assert_eq!(found.severity, expected, "{found:?}");
    }
}

/// Each edge of one direction is lost with the same probability. A motor that is slower by the same share, or a shaft
/// that is rough in both directions, is distinguished from it.
#[test]
fn edges_lost_at_random_in_one_direction_are_named_with_their_share() {
    let mut random = rand_pcg::Pcg64::seed_from_u64(61);
    let held = levels([6.0, -6.0, 4.0, -4.0, 6.0, -6.0]);
    let square = |t_s: f64| {
        if ((t_s / 0.4) as u64).is_multiple_of(2) {
            5.0
        } else {
            -5.0
        }
    };
    let sine = |t_s: f64| 6.0 * (2.0 * t_s).sin();
    let commands: [(&str, &dyn Fn(f64) -> f64); 3] =
        [("held", &held), ("square", &square), ("sine", &sine)];
    for (name, command) in commands {
        for step_s in [0.005, 0.02] {
            let (run, positions) = turning(step_s, (10.0 / step_s) as usize, command, |_| true);
            for (backward, forward) in [
                (0.9, 1.0),
                (0.85, 1.0),
                (0.8, 1.0),
                (1.0, 0.8),
                (0.85, 0.85),
            ] {
                let (mut lossy, mut smooth) = (run.clone(), run.clone());
                let (mut counter, mut sum) = (0, 0.0);
                for k in 1..run.len() {
                    let edges = positions[k].floor() as i64 - positions[k - 1].floor() as i64;
                    let kept = if edges > 0 { forward } else { backward };
                    let counted = (0..edges.abs())
                        .filter(|_| random.random_bool(kept))
                        .count() as i64;
                    counter += counted * edges.signum();
                    lossy.counts[k] = counter;
                    sum += kept * (positions[k] - positions[k - 1]);
                    smooth.counts[k] = f64::floor(sum) as i64;
                }
                let is_random = |run: &Run| {
                    let found = of_kind(run, Kind::LossInOneDirection);
                    let one = found.into_iter().find(|f| f.severity == Severity::Warning);
                    one.map(|found| found.evidence["lost_share"])
                };
                let at = format!("{name} at {step_s} s: {backward}, {forward}");
                assert_eq!(is_random(&smooth), None, "{at}");
                let lost = 1.0 - f64::min(backward, forward);
                match is_random(&lossy) {
                    Some(share) if backward != forward => {
                        assert!((share - lost).abs() < 0.04, "{at}: {share}");
                    }
                    None if backward == forward => {}
                    found => panic!("{at}: {found:?}"),
                }
            }
        }
    }
}

#[test]
fn a_counter_that_is_set_to_0_during_the_run_is_fatal() {
    for volts in [0.55, 1.0, 6.0, -6.0] {
        let (mut run, _) = turning(0.003, 1300, levels([volts, volts, volts]), |_| true);
        assert_eq!(of_kind(&run, Kind::CounterReset), [], "{volts}");
        let before = run.counts[700];
        run.counts[700..].iter_mut().for_each(|n| *n -= before);
        let found = one(&run, Kind::CounterReset);
        assert_eq!(found.severity, Severity::Fatal);
        assert!((found.to_s - 2.1).abs() < 1e-9, "{found:?}");
        let error = found.evidence["leap_counts"] + before as f64;
        assert!(
            error.abs() <= found.evidence["largest_step_beside_counts"],
            "{found:?}"
        );
    }
}

/// No effect of the catalogue at its default strength is a fault of the recording.
#[test]
fn no_effect_of_the_catalogue_has_one_of_these_findings() {
    let mut alarms = Vec::new();
    let motors = catalogue().iter().map(|kind| {
        let mut motor = Motor::default();
        let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters);
        motor.effects.set(effect.expect("its id"));
        (kind.id, motor)
    });
    for (id, motor) in motors.chain([("nominal", Motor::default())]) {
        for step_s in [0.005, 0.03] {
            for profile in ["reversing", "coasts", "staircase", "chirp"] {
                let samples = (12.0 / step_s) as usize;
                let of = Profile::built_in(profile, motor.parameters.supply_v, 12.0);
                let of = of.expect("a profile");
                let mut run = Run {
                    counts_per_rev: motor.parameters.counts_per_rev,
                    supply_v: Some(motor.parameters.supply_v),
                    ..empty(step_s)
                };
                run.t_s = (0..samples).map(|k| k as f64 * step_s).collect();
                run.command = run.t_s.iter().map(|&t| of.command_at(t)).collect();
                let drive = Drive {
                    t_s: &run.t_s,
                    command: &run.command,
                    kind: run.command_kind,
                };
                let simulated = simulate(&motor, &drive, &SimulationOptions::default());
                run.counts = simulated.expect("it runs").counts;
                for finding in check(std::slice::from_ref(&run), None) {
                    let dead = finding.id == Kind::CommandEarly
                        && finding.severity == Severity::Warning
                        && id != "transport_delay";
                    // A motor that differs by direction is noted.
                    let differs = finding.id == Kind::LossInOneDirection
                        && finding.severity == Severity::Note;
                    if (KINDS.contains(&finding.id) && !differs) || dead {
                        alarms.push(format!(
                            "{id}, {profile} at {step_s} s: {}",
                            finding.message
                        ));
                    }
                }
            }
        }
    }
    assert_eq!(alarms, Vec::<String>::new());
}
