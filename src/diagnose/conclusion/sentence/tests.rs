//! Every verdict's sentences side by side, in short sentences, with the document's own figures and no others.

use std::fmt::Write;

use super::*;
use crate::diagnose::conclusion::samples::{diagnosis, gap};
use crate::diagnose::conclusion::words::{counts, digits, three};
use crate::diagnose::report::{NextExperiment, NominalSource, SeenMotor, Verdict};
use crate::diagnose::settings::FEW_PIECES;
use crate::units::rpm_from_rad_s;

const VERDICTS: [Verdict; 7] = [
    Verdict::NoGap,
    Verdict::Parameters,
    Verdict::Effect,
    Verdict::Partial,
    Verdict::Ambiguous,
    Verdict::OutsideCatalogue,
    Verdict::NoChange,
];
const TIED: [&[&str]; 3] = [
    &["dead_zone"],
    &["stribeck"],
    &["backlash", "encoder_eccentricity"],
];
const MANY: [&[&str]; 2] = [
    &[
        "asymmetric_voltage_drop",
        "asymmetric_dead_zone",
        "encoder_eccentricity",
    ],
    &[
        "asymmetric_voltage_drop",
        "asymmetric_dead_zone",
        "edge_rate_loss",
    ],
];
const ASKED: &str = "motorlab diagnose a.csv b.csv --motor motor.toml";

fn beside(sets: &[&[&'static str]]) -> Beside {
    Beside {
        tied: sets.iter().map(|set| set.to_vec()).collect(),
        bent: vec![("inertia_kg_m2", 1.7), ("coulomb_friction_nm", 0.41)],
        wander_share: 0.0123,
        pieces: FEW_PIECES,
        all_pieces: FEW_PIECES,
        unknown: 0.3,
        asked: ASKED.to_owned(),
        ..Beside::default()
    }
}

/// The sets that a verdict is about.
fn sets(verdict: Verdict) -> &'static [&'static [&'static str]] {
    match verdict {
        Verdict::Effect | Verdict::Partial => &TIED[..1],
        Verdict::Ambiguous => &TIED,
        _ => &[],
    }
}

fn said(verdict: Verdict) -> Diagnosis {
    let names = matches!(verdict, Verdict::Effect | Verdict::Partial);
    diagnosis(verdict, sets(verdict).first().filter(|_| names))
}

fn next() -> NextExperiment {
    NextExperiment {
        profile: "prbs:0.3,12".to_owned(),
        sample_time_s: 0.003,
        duration_s: 12.0,
        command: "motorlab capture PORT --profile prbs:0.3,12 --ts 0.003 -o next.csv".to_owned(),
        change: None,
        tells_apart: vec!["dead_zone".to_owned(), "unknown".to_owned()],
        expected_separation: 4.2,
    }
}

/// Every number in a text is one of the document's, as it is rounded for reading.
fn check_numbers(said: &Diagnosis, beside: &Beside, text: &str) {
    let gap = &said.gap;
    let fitted = &gap.fitted;
    let mut known: Vec<String> = [
        gap.before,
        gap.after_parameters,
        gap.after_effect,
        gap.floor,
        gap.wander,
        fitted.before,
        fitted.after_parameters,
        fitted.after_effect,
    ]
    .map(counts)
    .to_vec();
    known.push(digits(100.0 * gap.before / gap.travel));
    known.push(digits(100.0 * beside.wander_share));
    known.push(format!("{:.0}", 100.0 * said.probability));
    known.push(format!("{:.0}", (100.0 * gap.closed).floor()));
    known.extend(
        said.place
            .regions
            .iter()
            .map(|r| format!("{:.0}", 100.0 * r.share)),
    );
    known.extend(beside.bent.iter().map(|(_, ratio)| format!("{ratio:.2}")));
    // How many more are not named.
    known.extend((1..beside.tied.len()).map(|more| more.to_string()));
    if let Some(seen) = &said.fitted_nominal {
        known.push(three(rpm_from_rad_s(seen.steady_rad_s_per_unit)));
        known.push(three(seen.time_constant_s));
        known.push(three(seen.friction));
    }
    // What stands between backticks is a command.
    for part in text.split('`').step_by(2) {
        for word in part.split_whitespace() {
            let word = word.trim_matches(|c: char| "(),.;:%".contains(c));
            if word.parse::<f64>().is_ok() {
                assert!(known.contains(&word.to_owned()), "{word} in {text}");
            }
        }
    }
}

/// No sentence has more than 25 words beside its command.
fn check_length(text: &str) {
    for sentence in text.split(". ") {
        let outside: String = sentence.split('`').step_by(2).collect();
        let words = outside.split_whitespace().count();
        assert!(words <= 25, "{words} words: {sentence}");
    }
}

/// The sentences of a verdict.
fn sentence(said: &Diagnosis, beside: &Beside) -> String {
    parts(said, beside).join(" ")
}

/// The four parts in their order, the last with a command.
fn check_parts(said: &Diagnosis, beside: &Beside, text: &str) {
    let parts = parts(said, beside);
    assert!(parts.iter().all(|part| !part.is_empty()));
    assert!(
        parts[0].contains(&counts(said.gap.before)) && parts[0].contains(&counts(said.gap.floor))
    );
    assert_eq!(text.matches(" sure").count(), 1, "{text}");
    assert!(parts[1].contains(" sure"), "{text}");
    assert!(parts[3].contains("`motorlab "), "{text}");
    for bad in ["cannot tell", "not told", "cannot_show", "closed -", "_"] {
        let outside: String = text.split('`').step_by(2).collect();
        assert!(!outside.contains(bad), "{bad}: {text}");
    }
}

fn check(said: &Diagnosis, beside: &Beside) -> String {
    let text = sentence(said, beside);
    check_numbers(said, beside, &text);
    check_length(&text);
    check_parts(said, beside, &text);
    let note = note(said, beside);
    check_length(&note);
    text
}

/// What all verdicts say, as people read it.
#[test]
fn all_verdicts_side_by_side() {
    let mut all = String::new();
    let mut add = |name: &str, text: &str| {
        let parts = text.replace(". ", ".\n  ");
        writeln!(all, "{name}\n  {parts}\n").expect("room");
    };
    let recording = crate::diagnose::BadRecording::of(crate::check::check(
        &[crate::recording::Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            t_s: vec![0.0, 0.01],
            command: vec![1.0, 1.0],
            counts: vec![0, 1],
            path: Some("a.csv".into()),
            ..Default::default()
        }],
        None,
    ));
    add("bad_recording", &recording.sentence);
    for verdict in VERDICTS {
        let name = serde_json::to_value(verdict).expect("a word");
        let name = name.as_str().expect("a word");
        let mut said = said(verdict);
        let mut beside = beside(sets(verdict));
        if verdict == Verdict::NoChange {
            beside.since = Some(Since::default());
        }
        if verdict == Verdict::OutsideCatalogue {
            beside.unknown = said.probability;
        }
        if matches!(verdict, Verdict::NoGap | Verdict::NoChange) {
            said.gap = gap([0.33, 0.32, 0.32], 0.31);
        }
        said.gap.wander = 0.0;
        if matches!(verdict, Verdict::Ambiguous | Verdict::OutsideCatalogue) {
            said.next_experiment = Some(next());
        }
        add(name, &check(&said, &beside));
    }
    let mut wanders = said(Verdict::NoGap);
    wanders.gap = gap([0.83, 0.82, 0.82], 0.31);
    add(
        "no_gap, with a load that wanders",
        &check(&wanders, &beside(&[])),
    );
    let mut bent = said(Verdict::OutsideCatalogue);
    bent.gap = gap([14.2, 0.32, 0.32], 0.33);
    add(
        "outside_catalogue, which other numbers explain",
        &check(&bent, &beside(&[])),
    );
    let mut fitted = said(Verdict::Effect);
    fitted.nominal_source = NominalSource::Fit;
    fitted.fitted_nominal = Some(SeenMotor {
        steady_rad_s_per_unit: 1.418,
        time_constant_s: 0.028_57,
        friction: 0.2857,
        load_per_nm: None,
        command_unit: "V",
    });
    add(
        "effect, without a motor file",
        &check(&fitted, &beside(sets(Verdict::Effect))),
    );
    let mut by_chance = said(Verdict::NoGap);
    by_chance.gap = gap([1.83, 1.32, 1.32], 0.31);
    add(
        "no_gap, where chance makes more than the load",
        &check(&by_chance, &beside(&[])),
    );
    let mut unsure = said(Verdict::OutsideCatalogue);
    unsure.probability = 0.45;
    add(
        "outside_catalogue, where a known effect may be part of it",
        &check(
            &unsure,
            &Beside {
                unknown: 0.9,
                ..beside(&[])
            },
        ),
    );
    let mut worse = said(Verdict::Ambiguous);
    (worse.probability, worse.gap.closed, worse.gap.after_effect) = (0.38, -0.389, 14.2);
    add(
        "ambiguous, that shrinks nothing",
        &check(&worse, &beside(&TIED)),
    );
    let since = Beside {
        since: Some(Since {
            changed: vec!["Since the reference dead zone is new, with 0.44 V.".to_owned()],
            alike: vec![vec!["cogging"]],
        }),
        ..beside(sets(Verdict::Effect))
    };
    let changed = said(Verdict::Effect);
    add("effect, against a reference", &check(&changed, &since));
    insta::assert_snapshot!(all);
}

/// Other circumstances: by the floor, held out, few pieces, many effects, much wander.
#[test]
fn sentences_say_the_figures_of_the_document() {
    for verdict in VERDICTS {
        for sets in [sets(verdict), &TIED[..], &MANY[..], &MANY[..1]] {
            for k in 0..6 {
                let mut said = said(verdict);
                if !said.effects.is_empty() {
                    said.effects = sets.first().map_or_else(Vec::new, |set| set.to_vec());
                }
                let mut beside = beside(sets);
                beside.is_by_direction = true;
                beside.is_by_floor = k == 0;
                beside.is_held_out = k == 1;
                beside.is_doubtful = k == 1;
                beside.pieces = if k == 2 { FEW_PIECES - 1 } else { FEW_PIECES };
                if k == 3 {
                    beside.since = Some(Since::default());
                }
                if k == 4 {
                    said.gap.wander = 1.5;
                    said.gap.floor_parts.repeats = Some(said.gap.floor);
                }
                if k == 5 {
                    said.gap.floor_parts.good_enough = Some(said.gap.floor);
                    said.nominal_source = NominalSource::Handout;
                }
                let text = check(&said, &beside);
                assert_eq!(text.contains("of the runs held out"), k == 1, "{text}");
                assert_eq!(text.contains("too short to keep"), k == 2, "{text}");
                let note = note(&said, &beside);
                assert_eq!(note.contains("Visible below the floor"), k == 0, "{note}");
                assert_eq!(note.contains("Something fatal"), k == 1, "{note}");
                assert_eq!(note.contains("lab handout's motor"), k == 5, "{note}");
                let is_dropped = verdict == Verdict::OutsideCatalogue && !sets.is_empty();
                assert_eq!(note.contains("The search kept"), is_dropped, "{note}");
                assert!(note.contains("inertia is 1.70 times"), "{note}");
                assert!(note.contains("1.2 % of the stall torque"), "{note}");
            }
        }
    }
}

/// Where the inverse form decides, the gap is not said to shrink with what no simulation has.
#[test]
fn what_no_simulation_has_shrinks_nothing() {
    let mut said = said(Verdict::Partial);
    let beside = Beside {
        inverse_gain: Some(0.6),
        ..beside(&TIED[..1])
    };
    let text = sentence(&said, &beside);
    assert!(
        text.contains("It takes 60 % of what a plain motor leaves there."),
        "{text}"
    );
    assert!(text.contains("Other numbers alone leave"), "{text}");
    said.gap.after_effect = said.gap.after_parameters;
    let text = sentence(&said, &beside);
    assert!(
        text.contains("no simulation with it leaves less than other numbers do"),
        "{text}"
    );
    assert!(!text.contains("shrinks"), "{text}");
}

/// The next recording is named with its command, and how to ask again with it.
#[test]
fn what_is_next_is_a_command_to_copy() {
    let mut said = said(Verdict::Ambiguous);
    said.next_experiment = Some(next());
    let text = check(&said, &beside(&TIED));
    assert!(text.contains(&format!("`{}`", next().command)), "{text}");
    assert!(
        text.contains("`motorlab diagnose next.csv a.csv b.csv --motor motor.toml`"),
        "{text}"
    );
    let long = Beside {
        asked: format!("motorlab diagnose {}", "a.csv ".repeat(100)),
        ..beside(&TIED)
    };
    let text = sentence(&said, &long);
    assert!(
        text.contains("the same command with next.csv among the runs"),
        "{text}"
    );
}
