//! Recording, diagnosis, proposed recording, diagnosis: starting from one short step.

use motorlab::board::Profile;
use motorlab::diagnose::{Diagnosis, KnownChange, Options, Verdict, diagnose};
use motorlab::motor::catalogue::ActiveEffect;
use motorlab::motor::{CommandKind, Drive, KnownDifferences, Motor, SimulationOptions, simulate};
use motorlab::recording::Run;

/// Most recordings after the first.
const ROUNDS: usize = 3;
/// Sample time in s.
const SAMPLE_TIME_S: f64 = 0.03;

/// Records a profile with a change on the bench; the initial fraction of a count differs between runs.
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

/// Whether a diagnosis names the truth, or its class, and nothing else.
fn is_right(found: &Diagnosis, truth: &str) -> bool {
    let stands_for = |effect: &str| {
        let classes = found.classes.iter();
        let mut of_it = classes.filter(|class| class.members.contains(&effect));
        effect == truth || of_it.any(|class| class.members.contains(&truth))
    };
    matches!(found.verdict, Verdict::Effect | Verdict::Partial)
        && found.effects.len() == 1
        && found.effects.iter().all(|effect| stands_for(effect))
}

/// The diagnosis after each recording, until the truth is named, nothing is proposed, or the rounds are over.
fn diagnoses(truth: &str, values: &[f64], duration_s: f64) -> Vec<Diagnosis> {
    let nominal = Motor::default();
    let mut motor = nominal.clone();
    motor
        .effects
        .set(ActiveEffect::new(truth, values).expect("an effect"));
    let step = Profile::built_in("step", nominal.parameters.supply_v, duration_s).expect("a step");
    let mut runs = vec![record(&motor, &step, None, 0.37)];
    let mut all = Vec::new();
    for round in 0..=ROUNDS {
        let found = diagnose(&runs, &nominal, &Options::default()).expect("a diagnosis");
        let next = found.next_experiment.clone();
        let is_named = is_right(&found, truth);
        all.push(found);
        let Some(next) = next.filter(|_| !is_named) else {
            break;
        };
        assert!(next.command.contains(&next.profile), "{}", next.command);
        let change = next.change.as_ref();
        let supply_v = change.filter(|change| change.key == "supply_v");
        let supply_v = supply_v.map_or(nominal.parameters.supply_v, |change| change.value);
        let profile = Profile::named(&next.profile, supply_v, next.duration_s).expect("a profile");
        runs.push(record(&motor, &profile, change, 0.11 + 0.23 * round as f64));
    }
    all
}

/// Of eight truths on a first step, most are named in the end, and none is contradicted with confidence.
#[test]
fn proposed_recordings_identify_the_true_effect() {
    let truths: [(&str, &[f64]); 8] = [
        ("transport_delay", &[0.05]),
        ("supply_sag", &[3.0]),
        ("quadratic_drag", &[0.002]),
        ("coast_at_zero", &[]),
        ("encoder_eccentricity", &[0.05, 0.4]),
        ("gravity_load", &[0.03, 0.0]),
        ("cogging", &[0.02, 12.0, 0.3]),
        ("backlash", &[0.05, 0.5, 0.0]),
    ];
    let mut named = Vec::new();
    for (truth, values) in truths {
        let all = diagnoses(truth, values, 2.0);
        for (round, found) in all.iter().enumerate() {
            let claims = matches!(found.verdict, Verdict::Effect | Verdict::Partial)
                && found.probability >= 0.9;
            assert!(
                !claims || is_right(found, truth),
                "{truth}, recording {round}: {}",
                found.sentence
            );
        }
        let last = all.last().expect("a first diagnosis");
        eprintln!("{truth}: {} recordings, {}", all.len(), last.sentence);
        named.extend(is_right(last, truth).then_some(truth));
    }
    assert!(named.len() >= 5, "{named:?}");
}
