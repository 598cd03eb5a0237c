//! Two programs, one law: this simulator predicts what the case generator records for the same motor and effect, down
//! to quantization and random load.
//!
//! The two share no code, no integrator and no friction law. Excluded are effects whose laws differ on purpose
//! (backlash with elastic flanks, stick-slip on bristles) or that draw random numbers.

use case_generator::{Effect, Kind, Options, generate_with};
use motorlab::compare::compare;
use motorlab::motor::catalogue::catalogue;
use motorlab::motor::{Model, Motor};
use motorlab::recording::read_run_from;
use rayon::prelude::*;

const BY_OTHER_LAWS: [&str; 4] = ["backlash", "stribeck", "missed_counts", "sample_jitter"];

/// Tolerated difference as a share of the effect's strength: bristles are smooth where Coulomb friction jumps.
const SHARE_OF_STRENGTH: f64 = 0.01;

/// The true motor with its effect, in this project's terms.
fn truth(motor: &case_generator::Motor, effects: &[Effect]) -> Motor {
    let mut text = motor.to_toml();
    for effect in effects {
        text += &format!("[effects.{}]\n", effect.id);
        for (name, value) in &effect.parameters {
            text += &format!("{name} = {value:?}\n");
        }
    }
    Motor::from_toml(&text).expect("a motor file")
}

#[test]
fn the_truth_explains_what_the_generator_records() {
    let options = Options {
        random_torque_scale: 0.03,
        ..Options::default()
    };
    let compared: Vec<&str> = case_generator::CATALOGUE
        .into_iter()
        .chain(case_generator::LATER)
        .filter(|id| !BY_OTHER_LAWS.contains(id))
        .collect();
    let apart: Vec<String> = compared
        .par_iter()
        .filter_map(|id| apart(id, &options))
        .collect();
    assert!(apart.is_empty(), "{}", apart.join("\n"));
}

/// Every effect of the catalogue has a law of the generator, and effects outside the catalogue are none of them.
#[test]
fn unmodelled_effects_are_outside_the_catalogue() {
    let known: Vec<&str> = catalogue().iter().map(|kind| kind.id).collect();
    let mut drawn = [&case_generator::CATALOGUE[..], &case_generator::LATER].concat();
    for id in case_generator::OUTSIDE {
        assert!(!known.contains(&id) && !drawn.contains(&id), "{id}");
    }
    let mut known = known;
    known.sort_unstable();
    drawn.sort_unstable();
    assert_eq!(known, drawn);
}

/// Error of an effect, if any.
fn apart(id: &str, options: &Options) -> Option<String> {
    let kind: Kind = id.parse().expect("an id of the catalogue");
    let case = generate_with(71, &kind, options);
    let csv = case.unseen_run.to_csv();
    let (run, _) = read_run_from(csv.as_bytes(), id).expect("a run file");
    let motor = truth(&case.label.motor, &case.label.effects);
    let overlay = compare(&run, &motor, Model::SecondOrder).expect("simulated");
    let left = overlay.figures.position_rmse_counts;
    let floor = case.label.unseen_floor_counts;
    let strength = case.label.strength_counts[id];
    (left > 1.2 * floor + 0.05 + SHARE_OF_STRENGTH * strength).then(|| {
        format!(
            "{id} ({strength:.1} counts): {left:.3} counts RMS left, the random load leaves {floor:.3}"
        )
    })
}
