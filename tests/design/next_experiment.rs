//! Record, diagnose, record what was asked for, diagnose: what one short step leaves open, the recording asked for settles.
//!
//! Every case is a pair of effects that look alike on one step: the first diagnosis must leave the truth open, the recordings asked for
//! must be to tell the rival from something, and the last diagnosis names the truth. Not from every first step: docs/decisions/0005 counts.

use motorlab::board::Profile;
use motorlab::diagnose::{KnownChange, Options, Verdict, diagnose};
use motorlab::motor::catalogue::ActiveEffect;
use motorlab::motor::{CommandKind, Drive, KnownDifferences, Motor, SimulationOptions, simulate};
use motorlab::recording::Run;

/// Most recordings that are asked for.
const ROUNDS: usize = 3;
/// Sample time in s.
const SAMPLE_TIME_S: f64 = 0.03;

/// Records a profile with what is changed on the bench; where in a count the shaft starts differs from run to run.
fn record(motor: &Motor, profile: &Profile, change: Option<&KnownChange>, fraction: f64) -> Run {
    let mut known = KnownDifferences::default();
    if let Some(change) = change {
        known
            .set(&change.key, change.value)
            .expect("a known change");
    }
    let samples = (profile.duration_s() / SAMPLE_TIME_S).round() as usize;
    let t_s: Vec<f64> = (0..samples).map(|k| k as f64 * SAMPLE_TIME_S).collect();
    let command = profile.commands(SAMPLE_TIME_S, samples);
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let options = SimulationOptions {
        start_count_fraction: fraction,
        ..SimulationOptions::default()
    };
    let counts = simulate(&known.applied_to(motor), &drive, &options)
        .expect("a motor")
        .counts;
    Run {
        sample_time_s: SAMPLE_TIME_S,
        counts_per_rev: motor.parameters.counts_per_rev,
        supply_v: Some(known.supply_v().unwrap_or(motor.parameters.supply_v)),
        complete: true,
        t_s,
        command,
        counts,
        known,
        ..Run::default()
    }
}

/// Whether the truth is named from a first step of so many seconds, and not before what was asked for was recorded.
fn is_settled(truth: &str, values: &[f64], rival: &str, duration_s: f64) -> bool {
    let nominal = Motor::default();
    let mut motor = nominal.clone();
    motor
        .effects
        .set(ActiveEffect::new(truth, values).expect("an effect"));
    let step = Profile::built_in("step", nominal.parameters.supply_v, duration_s).expect("a step");
    let mut runs = vec![record(&motor, &step, None, 0.37)];
    let mut told: Vec<String> = Vec::new();
    for round in 0..=ROUNDS {
        let found = diagnose(&runs, &nominal, &Options::default()).expect("a diagnosis");
        eprintln!("{round}: {}", found.sentence);
        let is_named = found.verdict == Verdict::Effect && found.effects == [truth];
        if is_named {
            assert!(round > 0, "{truth} was never open");
            assert!(told.iter().any(|id| id == rival), "{rival}: {told:?}");
            return true;
        }
        let Some(next) = found.next_experiment else {
            return false;
        };
        assert!(next.command.contains(&next.profile), "{}", next.command);
        assert!(next.expected_separation >= 1.0, "{next:?}");
        let change = next.change.as_ref();
        let supply_v = change.filter(|change| change.key == "supply_v");
        let supply_v = supply_v.map_or(nominal.parameters.supply_v, |change| change.value);
        let profile = Profile::named(&next.profile, supply_v, next.duration_s).expect("a profile");
        runs.push(record(&motor, &profile, change, 0.11 + 0.23 * round as f64));
        told.extend(next.tells_apart);
    }
    false
}

macro_rules! cases {
    ($($name:ident: $truth:literal, $values:expr, $rival:literal, $duration_s:literal;)*) => {
        $(#[test]
        fn $name() {
            let is_settled = is_settled($truth, &$values, $rival, $duration_s);
            assert!(is_settled, "{} is not named after {ROUNDS} further recordings", $truth);
        })*
    };
}

cases! {
    a_voltage_drop_is_told_from_other_numbers: "voltage_drop", [0.5], "none", 2.0;
    a_delay_is_told_from_inductance: "transport_delay", [0.012], "inductance", 0.8;
    a_gravity_load_is_told_from_an_eccentric_encoder: "gravity_load", [0.01, 0.0], "encoder_eccentricity", 1.0;
    quadratic_drag_is_told_from_lost_edges: "quadratic_drag", [0.002], "edge_rate_loss", 2.0;
    a_sagging_supply_is_told_from_friction_of_the_load: "supply_sag", [3.0], "load_friction", 2.0;
    a_dead_zone_is_told_from_static_friction: "dead_zone", [0.8], "static_friction", 2.0;
    static_friction_is_told_from_a_dead_zone: "static_friction", [0.05], "dead_zone", 3.0;
}

/// Of five first steps two at least: the others end beside something that is not there (docs/decisions/0005).
#[test]
fn friction_is_told_from_a_voltage_drop() {
    let settled = [1.0, 1.5, 2.0, 3.0, 4.0]
        .map(|duration_s| is_settled("coulomb_friction", &[0.06], "voltage_drop", duration_s));
    let count = settled.iter().filter(|is_settled| **is_settled).count();
    assert!(count >= 2, "{settled:?}");
}
