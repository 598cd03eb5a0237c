//! The diagnosis on cases of the independent generator.

use case_generator::{Case, generate};
use motorlab::board::Profile;
use motorlab::diagnose::{DiagnoseError, Diagnosis, Options, Verdict, diagnose};
use motorlab::motor::Motor;
use motorlab::recording::{Run, read_run_from};

use crate::recorded::{driven, with};

fn runs(case: &Case) -> Vec<Run> {
    let texts = case.runs.iter().map(|run| run.to_csv());
    texts
        .map(|text| read_run_from(text.as_bytes(), "case").unwrap().0)
        .collect()
}

fn diagnosed(runs: &[Run], motor: &Motor) -> Diagnosis {
    let found = diagnose(runs, motor, &Options::default());
    found.unwrap()
}

fn diagnosis(seed: u64, kind: &str) -> (Case, Diagnosis) {
    let case = generate(seed, &kind.parse().unwrap());
    let motor = Motor::from_toml(&case.nominal.to_toml()).unwrap();
    let found = diagnosed(&runs(&case), &motor);
    (case, found)
}

#[test]
fn a_motor_without_an_effect_has_no_false_alarm() {
    let (_, found) = diagnosis(8, "none");
    assert!(found.effects.is_empty(), "{}", found.sentence);
    assert!(matches!(
        found.verdict,
        Verdict::NoGap | Verdict::Parameters
    ));
}

#[test]
fn uninformative_runs_are_errors() {
    let motor = Motor::default();
    assert!(matches!(
        diagnose(&[], &motor, &Options::default()),
        Err(DiagnoseError::NoRuns)
    ));
    let short = Run {
        sample_time_s: 0.003,
        counts_per_rev: 720.0,
        t_s: vec![0.0, 0.003],
        command: vec![0.0, 4.5],
        counts: vec![0, 1],
        ..Run::default()
    };
    let error = diagnose(&[short], &motor, &Options::default()).unwrap_err();
    assert!(error.to_string().contains("at least 20"), "{error}");
}

/// Counts of a motor by the simulator's encoder on a profile of the board.
fn simulated(motor: &Motor, profile: &str, sample_time_s: f64, duration_s: f64) -> Run {
    let samples = (duration_s / sample_time_s).round() as u32;
    let profile = Profile::named(profile, 4.5, duration_s).unwrap();
    let at = |k: u32| profile.command_at(f64::from(k) * sample_time_s);
    driven(motor, (0..samples).map(at).collect(), sample_time_s)
}

/// A run of the lab handout's motor with arrival times only: late by 1 to 3 ms, in bursts of 4 ms.
fn timed_by_arrival(duration_s: f64) -> Run {
    let run = simulated(&Motor::default(), "reversing", 0.005, duration_s);
    let (mut late, mut before) = (0.0_f64, f64::NEG_INFINITY);
    let arrivals = run.t_s.iter().map(|t_s| {
        // A non-periodic sequence: the fractions of the squares of pi's multiples.
        late += 1.0;
        let line_s = t_s + 0.001 + 0.002 * (late * late * std::f64::consts::PI).fract();
        before = ((line_s / 0.004).ceil() * 0.004).max(before + 1e-6);
        before
    });
    let arrivals: Vec<f64> = arrivals.collect();
    Run {
        t_s: arrivals.iter().map(|t_s| t_s - arrivals[0]).collect(),
        ..run
    }
}

#[test]
fn arrival_times_and_their_scatter_name_no_effect() {
    const TIMING: [&str; 3] = ["sample_jitter", "clock_error", "transport_delay"];
    let motor = Motor::default();
    for duration_s in [3.0, 12.0] {
        let mut run = timed_by_arrival(duration_s);
        // As the board's times, they have a scatter that no true model reproduces.
        let believed = diagnosed(std::slice::from_ref(&run), &motor);
        let is_nothing = matches!(believed.verdict, Verdict::NoGap | Verdict::Parameters);
        assert!(!is_nothing, "{}", believed.sentence);
        run.header.insert("timing".to_owned(), "host".into());
        let found = diagnosed(&[run], &motor);
        let mut sets = found.sets.iter().flat_map(|set| &set.effects);
        assert!(sets.all(|effect| !TIMING.contains(effect)));
        // From 3 s a compliance has a probability of one half.
        if duration_s > 3.0 {
            assert!(found.effects.is_empty(), "{}", found.sentence);
        }
    }
}

/// Effects that a verdict names, each with its class.
fn named(found: &Diagnosis) -> Vec<Vec<&str>> {
    let class_of = |id: &&'static str| -> Vec<&str> {
        let class = (found.classes.iter()).find(|class| class.members.contains(id));
        class.map_or_else(|| vec![*id], |class| class.members.clone())
    };
    found.effects.iter().map(class_of).collect()
}

#[test]
fn stribeck_friction_is_identified_and_removes_the_error() {
    let (case, found) = diagnosis(5, "stribeck");
    println!("{}", found.sentence);
    // Static friction separate from sliding friction is similar: at most one class of them.
    let named = named(&found);
    assert_eq!(named.len(), 1, "{named:?}");
    assert!(named[0].contains(&"stribeck"), "{named:?}");
    let is_start = |id: &&str| ["stribeck", "static_friction"].contains(id);
    assert!(named[0].iter().all(is_start), "{named:?}");
    assert_eq!(found.place.stage.as_deref(), Some("mechanical"));
    assert!(found.gap.after_effect < 0.5 * found.gap.after_parameters);
    assert!(found.gap.closed > 0.9, "{:?}", found.gap);
    let cause = found.causes.iter().find(|cause| cause.effect == "stribeck");
    let extra = cause.expect("it is weighed").parameters["extra_torque_nm"];
    let truth = case.label.effects[0].parameters["extra_torque_nm"];
    assert!(
        (extra.value / truth - 1.0).abs() < 0.3,
        "{extra:?} for {truth}"
    );
}

/// In addition to the best pair every other effect is tried.
#[test]
fn a_third_effect_is_identified_where_two_leave_a_residual() {
    let truth: [(&str, &[f64]); 3] = [
        ("coast_at_zero", &[]),
        ("cogging", &[0.01, 12.0, 1.0]),
        ("inductance", &[0.1]),
    ];
    let motor = with(&truth);
    let runs = [
        ("step", 0.03, 4.0),
        ("step", 0.003, 4.0),
        ("reversing", 0.003, 15.0),
    ]
    .map(|(name, sample_time_s, duration_s)| simulated(&motor, name, sample_time_s, duration_s));
    let found = diagnosed(&runs, &Motor::default());
    println!("{found}");
    // Each of the three is identified, alone or by its class, and no others.
    let named = named(&found);
    assert_eq!(named.len(), truth.len(), "{named:?}");
    for (id, _) in truth {
        let entries = named.iter().filter(|class| class.contains(&id));
        assert_eq!(entries.count(), 1, "{id}: {named:?}");
    }
    assert!(found.gap.after_effect < 0.4, "{:?}", found.gap);
}

/// Its samples are late together from then on, unlike with lost edges or late samples.
#[test]
fn gaps_in_the_time_stamps_are_no_effect_of_the_catalogue() {
    let (_, found) = diagnosis(31, "clock_stall");
    assert!(
        found.effects.is_empty() || found.verdict == Verdict::Partial,
        "{}",
        found.sentence
    );
    // A clock with a rate error has no gap.
    let (_, found) = diagnosis(32, "clock_error");
    assert_eq!(found.effects, ["clock_error"], "{}", found.sentence);
}
