//! Settings and closed loop in the document.

use motorlab::diagnose::{Options, Settings, diagnose};
use motorlab::motor::Motor;

use crate::recorded::{LEVELS, driven, recorded};

/// A controller reads the counts and computes the next command from them.
#[test]
fn a_closed_loop_is_in_the_document_and_in_its_note() {
    let motor = Motor::default();
    let (sample_time_s, mut command) = (0.003, Vec::new());
    for k in 0..600 {
        command.push(0.0);
        let now = driven(&motor, command.clone(), sample_time_s).counts[k] as f64;
        command[k] = (0.05 * (300.0 * (0.002 * k as f64).sin() - now)).clamp(-4.5, 4.5);
    }
    let closed = driven(&motor, command, sample_time_s);
    let open = recorded(&motor, &LEVELS, 0.01, 6.0);
    for (run, is_closed_loop) in [(closed, true), (open, false)] {
        let found = diagnose(&[run], &motor, &Options::default()).expect("a diagnosis");
        assert_eq!(found.scoring.closed_loop, is_closed_loop);
        let has_note = found.note.starts_with("Closed loop:");
        assert_eq!(has_note, is_closed_loop, "{}", found.note);
    }
}

#[test]
fn the_document_has_the_settings_it_was_made_with() {
    let settings = Settings {
        confident: 0.95,
        ..Settings::default()
    };
    let options = Options {
        settings,
        ..Options::default()
    };
    let motor = Motor::default();
    let run = recorded(&motor, &LEVELS, 0.01, 6.0);
    let found = diagnose(&[run], &motor, &options).expect("a diagnosis");
    assert_eq!(found.settings, settings);
    let document = serde_json::to_value(&found).expect("a document");
    assert_eq!(document["settings"]["confident"], 0.95);
}
