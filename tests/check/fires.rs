//! Findings of `check` by case: every kind on a case of its own, and nothing above a note on valid recordings. Real
//! ones: tests/check/real.rs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use crate::support::command;
use crate::support::fires::{above_a_note, grouped, is_reversed, negated, words};
use motorlab::board::Profile;
use motorlab::check::{Finding, Kind, check};
use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{ActiveEffect, Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::{Run, read_run};

/// Sample times around those of the lab.
const STEPS_S: [f64; 5] = [0.001, 0.003, 0.01, 0.03, 0.06];

/// A profile through motor and encoder; `uneven` is the jitter of sample times as a share.
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
    let command = t_s.iter().map(|&t| profile.command_at(t)).collect();
    let run = Run {
        sample_time_s: step_s,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: Some(motor.parameters.supply_v),
        complete: true,
        t_s,
        command,
        ..Run::default()
    };
    driven(motor, run)
}

/// The counts of a motor for a run's times and commands.
fn driven(motor: &Motor, mut run: Run) -> Run {
    let drive = Drive {
        t_s: &run.t_s,
        command: &run.command,
        kind: run.command_kind,
    };
    let options = SimulationOptions::default();
    run.counts = simulate(motor, &drive, &options).expect("it runs").counts;
    run
}

/// Longer than half a level of the profile, it turns the shaft against the command most of the time.
#[test]
fn a_long_delay_is_no_swapped_wire() {
    for delay_s in [0.35, 0.5, 0.7] {
        let mut motor = Motor::default();
        motor
            .effects
            .set(ActiveEffect::new("transport_delay", &[delay_s]).expect("an effect"));
        let run = simulated(&motor, "reversing", 0.005, 1000, 0.0);
        let found = check(std::slice::from_ref(&run), Some(&Motor::default()));
        let is_fatal = found
            .iter()
            .any(|finding| finding.id == Kind::EncoderReversed);
        assert!(!is_fatal, "{delay_s} s: {found:?}");
    }
}

fn fine_encoder() -> Motor {
    let mut motor = Motor::default();
    motor.parameters.counts_per_rev = 32_000.0;
    motor
}

fn handout(profile: &str, step_s: f64) -> Run {
    simulated(&Motor::default(), profile, step_s, 1000, 0.0)
}

/// A case: its name, the expected kind, the runs, and whether the motor file is given.
type Case = (&'static str, Kind, Vec<Run>, bool);

fn changed(run: Run, change: impl Fn(&mut Run)) -> Vec<Run> {
    let mut run = run;
    change(&mut run);
    vec![run]
}

/// The command column delayed (for a negative number, advanced) by this many rows.
fn shifted(run: Run, rows: isize) -> Vec<Run> {
    changed(run, |run| {
        let last = run.command.len() as isize - 1;
        let before = run.command.clone();
        for (k, command) in run.command.iter_mut().enumerate() {
            *command = before[(k as isize - rows).clamp(0, last) as usize];
        }
    })
}

/// Steps of a motor whose counter loses edges beyond some 8,500 a second.
fn losing(command_v: f64) -> Run {
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
        counted += 0.005 * speed / (1.0 + (speed / 8500.0_f64).powi(8));
        speed += 0.005 / 0.3 * (1000.0 * command - speed);
    }
    run
}

fn cases() -> Vec<Case> {
    let negated = |run: Run| changed(run, |run| run.counts.iter_mut().for_each(|n| *n = -*n));
    let scaled = |run: Run, by: f64| {
        changed(run, |run| {
            let times = |n: &mut i64| *n = (*n as f64 * by).round() as i64;
            run.counts.iter_mut().for_each(times);
        })
    };
    let slower = |run: Run, by: f64| {
        changed(run, |run| {
            run.t_s.iter_mut().for_each(|t| *t *= by);
            run.sample_time_s *= by;
        })
    };
    let paused = |run: Run, header: &str| {
        let header: toml::Table = header.parse().expect("TOML");
        changed(run, |run| {
            run.t_s[500..].iter_mut().for_each(|t| *t += 1.5);
            run.header = header.clone();
        })
    };
    let mut brief = handout("step", 0.003);
    brief.t_s.truncate(12);
    brief.command.truncate(12);
    brief.counts.truncate(12);
    vec![
        (
            "counts negated, both ways",
            Kind::EncoderReversed,
            negated(handout("reversing", 0.003)),
            false,
        ),
        (
            "counts negated, levels one way, less than a turn",
            Kind::EncoderReversed,
            negated(simulated(&fine_encoder(), "staircase", 0.001, 900, 0.0)),
            false,
        ),
        (
            "counts negated, short steps of both signs in two runs",
            Kind::EncoderReversed,
            [4.5, -4.5]
                .into_iter()
                .flat_map(|v| {
                    let mut run = handout("step", 0.003);
                    run.command.iter_mut().for_each(|u| *u = v);
                    let mut run = driven(&Motor::default(), run);
                    run.t_s.truncate(200);
                    run.command.truncate(200);
                    run.counts.truncate(200);
                    negated(run)
                })
                .collect(),
            false,
        ),
        (
            "every count four times",
            Kind::CountsScale,
            scaled(handout("reversing", 0.003), 4.0),
            false,
        ),
        (
            "twice as far as the motor file says",
            Kind::CountsScale,
            scaled(handout("step", 0.003), 2.0),
            true,
        ),
        (
            "degrees told as radians",
            Kind::PositionUnit,
            scaled(handout("reversing", 0.003), 360.0 / std::f64::consts::TAU),
            true,
        ),
        (
            "milliseconds told as seconds",
            Kind::TimeUnit,
            slower(handout("reversing", 0.003), 1e3),
            false,
        ),
        (
            "seconds told as milliseconds",
            Kind::TimeUnit,
            slower(handout("reversing", 0.003), 1e-3),
            false,
        ),
        (
            "command two rows late at 30 ms",
            Kind::CommandLate,
            shifted(handout("reversing", 0.03), 2),
            false,
        ),
        (
            "command a row late at 30 ms",
            Kind::CommandLate,
            shifted(handout("reversing", 0.03), 1),
            false,
        ),
        // The shaft passes a twelfth of a count in the first 3 ms: the whole response is needed.
        (
            "command two rows late at 3 ms",
            Kind::CommandLate,
            shifted(
                simulated(&Motor::default(), "reversing", 0.003, 5000, 0.0),
                2,
            ),
            false,
        ),
        (
            "command a row late at 10 ms",
            Kind::CommandLate,
            shifted(simulated(&Motor::default(), "coasts", 0.01, 1500, 0.0), 1),
            false,
        ),
        (
            "command two rows early at 30 ms",
            Kind::CommandEarly,
            shifted(handout("reversing", 0.03), -2),
            false,
        ),
        (
            "command 0 throughout",
            Kind::CommandConstant,
            changed(handout("step", 0.003), |run| run.command.fill(0.0)),
            false,
        ),
        (
            "one command throughout",
            Kind::CommandConstant,
            changed(handout("step", 0.003), |run| run.command.fill(4.5)),
            false,
        ),
        (
            "command of 1023 for 255",
            Kind::CommandBeyondSupply,
            changed(handout("step", 0.003), |run| {
                run.command.iter_mut().for_each(|u| *u *= 1023.0 / 255.0)
            }),
            false,
        ),
        (
            "a signed counter of 8 bits",
            Kind::CounterWrap,
            changed(handout("step", 0.003), |run| {
                run.counts
                    .iter_mut()
                    .for_each(|n| *n = (*n + 128).rem_euclid(256) - 128)
            }),
            false,
        ),
        (
            "a counter of 8 bits over a pause",
            Kind::WrapOverGap,
            paused(handout("step", 0.003), "[imported]\nwrap_counts = 256"),
            false,
        ),
        (
            "two failed reads of three samples",
            Kind::MisreadPosition,
            changed(handout("step", 0.003), |run| {
                (100..102).chain([170]).for_each(|k| run.counts[k] = -2047)
            }),
            false,
        ),
        (
            "a pause",
            Kind::GapInTime,
            paused(handout("step", 0.003), ""),
            false,
        ),
        (
            "a slow counter under a held command",
            Kind::EdgesLostAtSpeed,
            vec![losing(12.0)],
            false,
        ),
        (
            "a slow counter at the highest of six levels",
            Kind::EdgesLostAtSpeed,
            (4..=9).map(|v| losing(f64::from(v))).collect(),
            false,
        ),
        (
            "an edge at rest",
            Kind::DitherAtRest,
            changed(handout("step", 0.003), |run| {
                (0..100).for_each(|k| run.counts[k] = k as i64 % 2)
            }),
            false,
        ),
        (
            "stated as 2 ms, sampled at 3 ms",
            Kind::SampleTimeContradicts,
            changed(handout("step", 0.003), |run| run.sample_time_s = 0.002),
            false,
        ),
        (
            "the board's second lasts 1.05 s",
            Kind::ClockRate,
            changed(handout("step", 0.003), |run| {
                run.host_t_s = Some(run.t_s.iter().map(|t| 1.05 * t).collect())
            }),
            false,
        ),
        (
            "the count stands still at 4.5 V",
            Kind::ChannelStuck,
            changed(handout("step", 0.003), |run| run.counts.fill(7)),
            false,
        ),
        (
            "the supply sags under load",
            Kind::SupplyVaries,
            changed(handout("reversing", 0.003), |run| {
                run.measured_supply_v =
                    Some(run.command.iter().map(|u| 4.5 - 0.1 * u.abs()).collect())
            }),
            false,
        ),
        (
            "the shaft turns before the step",
            Kind::StartsInMotion,
            changed(handout("step", 0.003), |run| {
                (0..100).for_each(|k| run.counts[k] = k as i64 - 99)
            }),
            false,
        ),
        ("12 samples", Kind::TooShort, vec![brief], false),
        (
            "a shaft that moves by 4 counts",
            Kind::TooShort,
            changed(handout("step", 0.003), |run| {
                run.command.iter_mut().for_each(|u| *u *= 0.1);
                let far = run.counts[999];
                run.counts.iter_mut().for_each(|n| *n = *n * 4 / far);
            }),
            false,
        ),
    ]
}

#[test]
fn every_kind_fires_on_a_case_of_its_own() {
    let motor = Motor::default();
    let mut table = String::new();
    let mut missed = Vec::new();
    let mut kinds: Vec<String> = Vec::new();
    for (name, kind, runs, is_given) in cases() {
        let findings = check(&runs, is_given.then_some(&motor));
        if !findings.iter().any(|finding| finding.id == kind) {
            missed.push(format!("{name}: {}", words(&findings)));
        }
        kinds.extend(findings.iter().filter(|f| f.id == kind).map(Finding::id));
        let _ = writeln!(table, "{name}: {}", words(&findings));
    }
    assert!(missed.is_empty(), "{missed:#?}");
    kinds.sort();
    kinds.dedup();
    // As many as the contract lists; those of the drive, the rows and logged speeds are in findings.rs.
    assert_eq!(kinds.len(), 20, "{kinds:?}");
    insta::assert_snapshot!("cases", table);
}

/// Runs of the project's raw logs, and its cases of valid recordings.
fn fixtures() -> Vec<(String, Run)> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let directory = tempfile::tempdir().expect("a directory");
    let mut found = Vec::new();
    for name in [
        "step3",
        "step30",
        "reversing3",
        "plain_sketch",
        "uno_step3",
        "uno_reversing3",
        "mega_step30",
    ] {
        let log = fixtures.join(format!("{name}.log")).display().to_string();
        let file = format!("{name}.csv");
        command::run(directory.path(), &["replay", &log, "-o", &file]);
        let (mut run, _) = read_run(&directory.path().join(&file)).expect("a run");
        // The emulated board's time was held: the host's clock is meaningless.
        if name.starts_with("uno") || name.starts_with("mega") {
            run.host_t_s = None;
        }
        found.push((name.to_owned(), run));
    }
    for name in [
        "diagnosis/clean_step_alarm/virtual_default.csv",
        "recorder/sim30.csv",
    ] {
        let (run, _) = read_run(&fixtures.join("cases").join(name)).expect("a run");
        found.push((name.to_owned(), run));
    }
    found
}

#[test]
fn nothing_above_a_note_fires_on_sound_recordings() {
    let mut groups: BTreeMap<String, Vec<Vec<Finding>>> = BTreeMap::new();
    let mut sound = Vec::new();
    for (motor_name, motor) in [
        ("handout", Motor::default()),
        ("32,000 counts", fine_encoder()),
    ] {
        for profile in [
            "step",
            "staircase",
            "reversing",
            "square",
            "ramp",
            "coasts",
            "jog",
            "chirp",
            "brakes",
        ] {
            for step_s in STEPS_S {
                for uneven in [0.0, 0.1] {
                    let run = simulated(&motor, profile, step_s, 900, uneven);
                    for given in [None, Some(&motor)] {
                        let findings = check(std::slice::from_ref(&run), given);
                        let name = format!("{motor_name}, {profile}");
                        groups.entry(name).or_default().push(findings);
                    }
                    sound.push(run);
                }
            }
        }
    }
    for (name, run) in fixtures() {
        let findings = check(std::slice::from_ref(&run), None);
        groups
            .entry(format!("fixture {name}"))
            .or_default()
            .push(findings);
        sound.push(run);
    }
    assert_eq!(above_a_note(&groups), Vec::<String>::new());
    let negated = reversed_are_found(&sound);
    insta::assert_snapshot!("sound", format!("{}{negated}", grouped(&groups)));
}

/// A first-order motor with a coarse encoder: counts of a revolution, revolutions per second per volt, time constant
/// in s.
fn coarse(
    profile: &str,
    (counts_per_rev, rev_s_per_v, tau_s): (f64, f64, f64),
    step_s: f64,
    samples: usize,
) -> Run {
    /// Integration steps per sample.
    const FINE: usize = 20;
    let supply_v = 6.0;
    let profile = Profile::built_in(profile, supply_v, step_s * samples as f64).expect("a profile");
    let mut run = Run {
        sample_time_s: step_s,
        counts_per_rev,
        supply_v: Some(supply_v),
        complete: true,
        ..Run::default()
    };
    let fine_s = step_s / FINE as f64;
    let follow = -f64::exp_m1(-fine_s / tau_s);
    let (mut speed, mut position) = (0.0, 0.0_f64);
    for k in 0..samples {
        let t_s = k as f64 * step_s;
        let command = profile.command_at(t_s);
        run.t_s.push(t_s);
        run.command.push(command);
        run.counts.push((position * counts_per_rev).floor() as i64);
        for _ in 0..FINE {
            speed += follow * (rev_s_per_v * command - speed);
            position += fine_s * speed;
        }
    }
    run
}

/// A coarse encoder shows no motion at a reversal, under the command that reverses the shaft.
#[test]
fn a_coarse_encoder_under_a_chirp_is_not_reported_as_a_drive_that_is_off() {
    let mut found = String::new();
    let mut runs = 0;
    for profile in ["chirp", "square", "reversing"] {
        for counts_per_rev in [12.0, 20.0, 32.0, 50.0] {
            for rev_s_per_v in [0.3, 1.0, 4.0] {
                for tau_s in [0.03, 0.08, 0.2, 0.5] {
                    for step_s in [0.001, 0.002, 0.005, 0.01] {
                        let motor = (counts_per_rev, rev_s_per_v, tau_s);
                        let run = coarse(profile, motor, step_s, (8.0 / step_s) as usize);
                        runs += 1;
                        for finding in check(&[run], None) {
                            if finding.id == Kind::OffUnderCommand {
                                let message = finding.message;
                                let _ = writeln!(found, "{profile} {motor:?} {step_s}: {message}");
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(found.is_empty(), "of {runs} runs:\n{found}");
}

/// Number of these runs that are found to be reversed once their counts are negated; at least nineteen in twenty.
fn reversed_are_found(sound: &[Run]) -> String {
    let found = sound
        .iter()
        .filter(|run| is_reversed(&[negated(run)]))
        .count();
    assert!(20 * found >= 19 * sound.len(), "{found} of {}", sound.len());
    format!(
        "counts negated: encoder_reversed in {found} of {}\n",
        sound.len()
    )
}

/// A load behind play or a soft coupling lets the motor start earlier; only a late column is a late command.
#[test]
fn no_effect_is_reported_as_a_late_command() {
    let late = |run: &Run| {
        let findings = check(std::slice::from_ref(run), None);
        findings.iter().any(|f| f.id == Kind::CommandLate)
    };
    for kind in catalogue()
        .iter()
        .filter(|kind| kind.id != "command_offset")
    {
        let mut motor = Motor::default();
        let effect = ActiveEffect::from_keys(kind.id, [], &motor.parameters);
        motor.effects.set(effect.expect("its id"));
        for step_s in [0.003, 0.01, 0.03] {
            let samples = (12.0 / step_s) as usize;
            for profile in ["reversing", "coasts"] {
                let run = simulated(&motor, profile, step_s, samples, 0.0);
                assert!(!late(&run), "{}, {profile} at {step_s} s", kind.id);
            }
        }
    }
}
