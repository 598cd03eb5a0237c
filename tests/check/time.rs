//! Findings of `motorlab check` about time and the counter: each kind on a table of cases, and nothing on valid
//! simulations.

use motorlab::board::Profile;
use motorlab::check::{Finding, Kind, Severity, check};
use motorlab::motor::{Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::{Flags, Run};

/// A built-in profile through motor and encoder; `uneven` is the jitter of sample times as a share.
fn simulated(motor: &Motor, profile: &str, step_s: f64, samples: usize, uneven: f64) -> Run {
    let duration_s = step_s * samples as f64;
    let profile =
        Profile::built_in(profile, motor.parameters.supply_v, duration_s).expect("a profile");
    let t_s: Vec<f64> = (0..samples)
        .map(|k| {
            let scatter = ((k * k) as f64 * std::f64::consts::PI).fract() - 0.5;
            let late = if k == 0 { 0.0 } else { uneven * scatter };
            (k as f64 + late) * step_s
        })
        .collect();
    let command: Vec<f64> = t_s.iter().map(|&t| profile.command_at(t)).collect();
    let mut run = Run {
        sample_time_s: step_s,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: Some(motor.parameters.supply_v),
        complete: true,
        t_s,
        command,
        ..Run::default()
    };
    let drive = Drive {
        t_s: &run.t_s,
        command: &run.command,
        kind: run.command_kind,
    };
    run.counts = simulate(motor, &drive, &SimulationOptions::default())
        .expect("it runs")
        .counts;
    run
}

fn handout(profile: &str, step_s: f64, samples: usize) -> Run {
    simulated(&Motor::default(), profile, step_s, samples, 0.0)
}

fn of_kind(run: &Run, kind: Kind) -> Vec<Finding> {
    let mut found = check(std::slice::from_ref(run), None);
    found.retain(|finding| finding.id == kind);
    found
}

#[test]
fn a_time_unit_wrong_by_1000_is_fatal_in_both_directions() {
    for step_s in [0.003, 0.01, 0.03] {
        for profile in ["step", "reversing"] {
            for factor in [1e3, 1e6, 1e-3, 1e-6] {
                let mut run = handout(profile, step_s, 600);
                run.t_s.iter_mut().for_each(|t| *t *= factor);
                run.sample_time_s *= factor;
                let name = format!("{step_s} {profile} {factor}");
                let found = of_kind(&run, Kind::TimeUnit);
                assert_eq!(found.len(), 1, "{name}");
                assert_eq!(found[0].severity, Severity::Fatal);
                let ratio = found[0].evidence["factor"] / factor;
                assert!((ratio - 1.0).abs() < 1e-9, "{name}: {}", found[0].message);
            }
            assert!(of_kind(&handout(profile, step_s, 600), Kind::TimeUnit).is_empty());
        }
    }
}

#[test]
fn a_stated_sample_time_is_compared_with_the_times_and_their_median_is_not() {
    for ratio in [0.1, 0.97, 1.03, 2.0] {
        let mut run = handout("step", 0.004, 500);
        run.sample_time_s *= ratio;
        assert_eq!(
            of_kind(&run, Kind::SampleTimeContradicts).len(),
            1,
            "{ratio}"
        );
    }
    assert!(of_kind(&handout("step", 0.004, 500), Kind::SampleTimeContradicts).is_empty());
}

#[test]
fn a_clock_rate_error_relative_to_the_host_is_found() {
    for rate in [-0.05, -0.01, 0.02, 0.08] {
        let mut run = handout("step", 0.005, 1000);
        let host = run.t_s.iter().map(|t| 7.0 + t * (1.0 + rate)).collect();
        run.host_t_s = Some(host);
        let found = of_kind(&run, Kind::ClockRate);
        assert_eq!(found.len(), 1, "{rate}");
        assert!((found[0].evidence["board_second_s"] - 1.0 - rate).abs() < 1e-3);
    }
    let mut run = handout("step", 0.005, 1000);
    run.host_t_s = Some(run.t_s.clone());
    assert!(of_kind(&run, Kind::ClockRate).is_empty());
}

#[test]
fn a_counter_that_wraps_is_found_for_every_width_and_sign() {
    for bits in [8_u32, 12, 16, 24, 32] {
        let range = 1_i64 << bits;
        for sign in [1, -1] {
            for signed in [false, true] {
                for near in [0, range / 2, range - 100] {
                    let mut run = handout("step", 0.003, 400);
                    for counts in &mut run.counts {
                        let raw = (near + sign * *counts).rem_euclid(range);
                        let below = signed && raw >= range / 2;
                        *counts = if below { raw - range } else { raw };
                    }
                    let leaps = (run.counts.windows(2))
                        .filter(|pair| pair[1].abs_diff(pair[0]) > 100)
                        .count();
                    let found = of_kind(&run, Kind::CounterWrap);
                    let name = format!("{bits} {sign} {signed} {near}");
                    assert_eq!(found.len(), usize::from(leaps > 0), "{name}");
                    if leaps > 0 {
                        assert_eq!(found[0].evidence["range_counts"], range as f64, "{name}");
                        assert_eq!(found[0].evidence["leaps"], leaps as f64, "{name}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_counter_that_was_reset_once_did_not_wrap() {
    let mut run = handout("step", 0.003, 800);
    let reached = run.counts[500];
    run.counts[500..].iter_mut().for_each(|n| *n -= reached);
    assert!(of_kind(&run, Kind::CounterWrap).is_empty());
}

#[test]
fn a_pause_is_found_and_is_fatal_where_the_counter_may_wrap_in_it() {
    for (range, fatal) in [(256, true), (65_536, false)] {
        let mut run = handout("step", 0.003, 900);
        for k in 300..run.len() {
            run.t_s[k] += 1.5;
        }
        let imported = format!("[imported]\nwrap_counts = {range}");
        run.header = imported.parse().expect("TOML");
        assert_eq!(of_kind(&run, Kind::GapInTime).len(), 1);
        let found = of_kind(&run, Kind::WrapOverGap);
        assert_eq!(found.len(), usize::from(fatal), "{range}");
        for finding in found {
            assert_eq!(finding.severity, Severity::Fatal);
            assert_eq!(finding.evidence["first_after_sample"], 300.0);
        }
    }
}

#[test]
fn a_flag_of_the_recorder_after_a_pause_is_fatal() {
    for (flagged, fatal) in [(None, false), (Some(300), true), (Some(400), false)] {
        let mut run = handout("step", 0.003, 900);
        run.counts.iter_mut().for_each(|count| *count *= 60);
        for k in 300..run.len() {
            run.t_s[k] += 3.0;
        }
        let flags = (0..run.len()).map(|k| Flags {
            counts_leap: Some(k) == flagged,
            ..Flags::default()
        });
        run.flags = Some(flags.collect());
        let found = of_kind(&run, Kind::WrapOverGap);
        assert_eq!(found.len(), usize::from(fatal), "{flagged:?}");
    }
}

/// A first-order shaft whose counter loses edges beyond `rate_hz`: `f / (1 + (f / rate)^8)` are counted.
fn losing(command_v: f64, rate_hz: f64) -> Run {
    let mut run = Run {
        sample_time_s: 0.005,
        counts_per_rev: 720.0,
        complete: true,
        ..Run::default()
    };
    let (mut speed, mut counted) = (0.0, 0.0_f64);
    for k in 0..1000 {
        run.t_s.push(f64::from(k) * 0.005);
        let command = if k < 50 { 0.0 } else { command_v };
        run.command.push(command);
        run.counts.push(counted as i64);
        counted += 0.005 * speed / (1.0 + (speed / rate_hz).powi(8));
        speed += 0.005 / 0.3 * (1000.0 * command - speed);
    }
    run
}

#[test]
fn edges_lost_at_high_speed_are_found_within_and_across_runs() {
    let one = of_kind(&losing(12.0, 8000.0), Kind::EdgesLostAtSpeed);
    assert_eq!(one.len(), 1);
    assert!(
        one[0].message.contains("command holds"),
        "{}",
        one[0].message
    );
    for command_v in [4.0, 12.0, -12.0] {
        assert!(of_kind(&losing(command_v, 1e9), Kind::EdgesLostAtSpeed).is_empty());
    }
    let runs: Vec<Run> = (4..=9).map(|v| losing(f64::from(v), 8500.0)).collect();
    let found = check(&runs, None);
    let lost: Vec<&str> = (found.iter())
        .filter(|finding| finding.id == Kind::EdgesLostAtSpeed)
        .map(|finding| finding.run.as_str())
        .collect();
    assert!(lost.contains(&"6"), "{lost:?}");
    assert!(!lost.contains(&"1") && !lost.contains(&"2"), "{lost:?}");
}

/// A driver at its limit gives a shaft the same voltage at every higher command, or a little less as its supply sags.
#[test]
fn a_saturated_driver_is_not_edges_lost_at_speed() {
    for sag_v in [0.0, 0.08] {
        let runs: Vec<Run> = (4..=12)
            .map(|v| {
                let command = f64::from(v);
                let over_v = (command - 8.0).max(0.0);
                let mut run = losing(command - over_v - sag_v * over_v, 1e9);
                let held = run.command.iter_mut().filter(|v| **v > 0.0);
                held.for_each(|v| *v = command);
                run
            })
            .collect();
        let found = check(&runs, None);
        let lost = found
            .iter()
            .filter(|found| found.id == Kind::EdgesLostAtSpeed);
        assert_eq!(lost.count(), 0, "{sag_v}");
    }
}

#[test]
fn sound_simulations_have_no_finding_about_time_or_counter() {
    let mine = [
        Kind::TimeUnit,
        Kind::SampleTimeContradicts,
        Kind::ClockRate,
        Kind::CounterWrap,
        Kind::WrapOverGap,
        Kind::GapInTime,
        Kind::EdgesLostAtSpeed,
    ];
    let mut fine = Motor::default();
    fine.parameters.counts_per_rev = 32_000.0;
    let mut wrong = Vec::new();
    for (name, motor) in [("handout", Motor::default()), ("32,000 counts", fine)] {
        for profile in ["step", "reversing", "square", "staircase"] {
            for step_s in [0.001, 0.01, 0.06] {
                for uneven in [0.0, 0.1] {
                    let run = simulated(&motor, profile, step_s, 600, uneven);
                    for given in [None, Some(&motor)] {
                        let found = check(std::slice::from_ref(&run), given);
                        let mine = found.iter().filter(|found| mine.contains(&found.id));
                        wrong.extend(mine.map(|found| {
                            format!("{name} {profile} {step_s} {uneven}: {}", found.message)
                        }));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
