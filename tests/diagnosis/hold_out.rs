//! Held-out runs, runs that begin in motion, and a fitted nominal motor.

use case_generator::generate;
use motorlab::diagnose::{Diagnosis, Options, Settings, Verdict, diagnose, nominal_fit};
use motorlab::motor::fit::{Simulator, Workspace};
use motorlab::motor::{CommandKind, Drive, Model, Motor, SimulationOptions, simulate};
use motorlab::recording::{Run, read_run_from};

/// The part of a run from sample `from` on, with its times and counts.
fn tail(run: &Run, from: usize) -> Run {
    Run {
        sample_time_s: run.sample_time_s,
        counts_per_rev: run.counts_per_rev,
        supply_v: run.supply_v,
        complete: true,
        t_s: run.t_s[from..].to_vec(),
        command: run.command[from..].to_vec(),
        counts: run.counts[from..].to_vec(),
        ..Run::default()
    }
}

fn case(seed: u64, kind: &str) -> (Vec<Run>, Motor) {
    let case = generate(seed, &kind.parse().unwrap());
    let texts = case.runs.iter().map(|run| run.to_csv());
    let runs = texts.map(|text| read_run_from(text.as_bytes(), "case").unwrap().0);
    let motor = Motor::from_toml(&case.nominal.to_toml()).unwrap();
    (runs.collect(), motor)
}

/// Half a second at rest, then levels that change every 0.4 s.
fn levels(samples: usize, sample_time_s: f64) -> (Vec<f64>, Vec<f64>) {
    const LEVELS: [f64; 6] = [4.5, -2.0, 3.0, -4.5, 1.5, 4.0];
    let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * sample_time_s).collect();
    let level = |t: &f64| {
        let place = ((t - 0.5) / 0.4).floor();
        LEVELS.get(place as usize).filter(|_| place >= 0.0).copied()
    };
    let command = t_s.iter().map(|t| level(t).unwrap_or(0.0)).collect();
    (t_s, command)
}

fn recorded(motor: &Motor) -> Run {
    let (t_s, command) = levels(900, 0.003);
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let simulated = simulate(motor, &drive, &SimulationOptions::default());
    Run {
        sample_time_s: 0.003,
        counts_per_rev: motor.parameters.counts_per_rev,
        counts: simulated.unwrap().counts,
        t_s,
        command,
        complete: true,
        ..Run::default()
    }
}

fn with_held_out(runs: &[Run], motor: &Motor, held_out: &[Run]) -> Diagnosis {
    let options = Options {
        held_out,
        ..Options::default()
    };
    diagnose(runs, motor, &options).unwrap()
}

/// The motor file is right for the fitted run, and the axis of the other run turns with more friction.
#[test]
fn a_model_that_misses_the_held_out_run_explains_nothing() {
    let motor = Motor::default();
    let mut other = motor.clone();
    other.parameters.coulomb_friction_nm *= 4.0;
    let fitted = [recorded(&motor)];
    let alike = with_held_out(&fitted, &motor, &fitted);
    assert_eq!(alike.verdict, Verdict::NoGap, "{}", alike.sentence);
    let missed = with_held_out(&fitted, &motor, &[recorded(&other)]);
    let verdict = missed.verdict;
    assert_eq!(verdict, Verdict::OutsideCatalogue, "{}", missed.sentence);
    assert!(missed.unexplained.share > 0.9, "{}", missed.sentence);
}

/// Parameters imitate a clock error: where they reach the noise floor on the held-out runs too, it removes nothing.
#[test]
fn an_effect_that_removes_nothing_on_the_held_out_runs_is_not_named() {
    let (runs, motor) = case(32, "clock_error");
    let found = with_held_out(&runs, &motor, &[]);
    assert_eq!(found.effects, ["clock_error"], "{}", found.sentence);
    let found = with_held_out(&runs, &motor, &runs);
    assert_eq!(found.verdict, Verdict::Parameters, "{}", found.sentence);
}

#[test]
fn a_run_that_starts_in_motion_identifies_no_effect() {
    let (runs, motor) = case(8, "none");
    let turning = |run: &Run| {
        let travel = |k: usize| (run.counts[k + 1] - run.counts[k - 1]).abs();
        (1..run.len() - 1).max_by_key(|&k| (travel(k), run.len() - k))
    };
    let run = runs.iter().max_by_key(|run| run.len()).unwrap();
    let from = turning(run).unwrap();
    assert!(run.len() - from > 200, "{from} of {}", run.len());
    let parts = [tail(run, from)];
    let found = with_held_out(&parts, &motor, &runs);
    assert!(
        matches!(found.verdict, Verdict::NoGap | Verdict::Parameters),
        "{}",
        found.sentence
    );
    // Held-out data is predicted as well as by a refit.
    assert!(found.gap.after_parameters <= 1.5 * found.gap.before.max(1.0));
}

/// `w = w0 exp(-t/tau)`, `theta = theta0 + w0 tau (1 - exp(-t/tau))` with `tau = J/b`.
#[test]
fn a_start_in_motion_coasts_as_in_closed_form() {
    let mut motor = Motor::default();
    motor.parameters.coulomb_friction_nm = 0.0;
    let p = &motor.parameters;
    let tau = p.inertia_kg_m2 / p.viscous_friction_nm_s_per_rad;
    let t_s: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.004).collect();
    let command = vec![0.0; t_s.len()];
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Torque,
    };
    let (start_rad, start_rad_s) = (3.0, -12.0);
    let simulator = Simulator::new(&drive, Model::SecondOrder)
        .unwrap()
        .with_start(start_rad, start_rad_s);
    let mut angles = vec![0.0; t_s.len()];
    simulator
        .angles(&motor, &mut Workspace::default(), &mut angles)
        .unwrap();
    for (t, angle) in t_s.iter().zip(&angles) {
        let exact = start_rad + start_rad_s * tau * (1.0 - (-t / tau).exp());
        assert!((angle - exact).abs() < 1e-6, "{angle} for {exact} at {t} s");
    }
}

#[test]
fn a_nominal_motor_is_fitted_where_nothing_is_known() {
    let mut truth = Motor::default();
    truth.parameters.inertia_kg_m2 *= 3.0;
    truth.parameters.back_emf_v_s_per_rad *= 0.4;
    truth.parameters.coulomb_friction_nm *= 2.5;
    truth.parameters.inductance_h = 0.0;
    let run = recorded(&truth);
    let found = nominal_fit(
        std::slice::from_ref(&run),
        &Motor::default(),
        &Settings::default(),
    )
    .unwrap();
    let (found, truth) = (found.motor.parameters, truth.parameters);
    for (name, found, truth) in [
        ("J", found.inertia_kg_m2, truth.inertia_kg_m2),
        ("Kb", found.back_emf_v_s_per_rad, truth.back_emf_v_s_per_rad),
        ("Tf", found.coulomb_friction_nm, truth.coulomb_friction_nm),
    ] {
        assert!(
            (found / truth - 1.0).abs() < 0.15,
            "{name}: {found} for {truth}"
        );
    }
    let still = Run {
        counts: vec![0; run.len()],
        ..run
    };
    assert!(nominal_fit(&[still], &Motor::default(), &Settings::default()).is_err());
}
