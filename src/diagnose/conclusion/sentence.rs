//! The verdict in plain sentences, and what else is to be known.

use super::place::largest_regime;
use super::since::{self, Since};
use super::words::{counts, digits, rivals, sure, words};
use crate::diagnose::report::{Diagnosis, Verdict};
use crate::diagnose::settings::{FEW_PIECES, FEW_PIECES_SURE, NAMED_REGIME};

/// What a sentence says that is not in the document's own figures.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beside {
    /// Sets that are not told apart.
    pub tied: Vec<Vec<&'static str>>,
    /// Whether the same by direction is not told from one of them.
    pub is_by_direction: bool,
    /// Base numbers beyond their tolerances: key, times the file's.
    pub bent: Vec<(&'static str, f64)>,
    /// Strength of a load that wanders, one sigma as a share of the stall torque.
    pub wander_share: f64,
    /// Pieces that were searched, and all.
    pub pieces: usize,
    pub all_pieces: usize,
    /// Whether the floor says so, with something significant below it.
    pub is_by_floor: bool,
    /// Whether the predicted rungs are those of runs held out.
    pub is_held_out: bool,
    /// Whether something fatal was found in the recordings.
    pub is_doubtful: bool,
    /// Probability of something unknown.
    pub unknown: f64,
    /// What is said of the reference, where the runs are held against one.
    pub since: Option<Since>,
}

impl Beside {
    /// What the runs are held against, before what follows of it.
    fn nominal(&self) -> &'static str {
        match self.since {
            Some(_) => "The reference's motor",
            None => "The nominal model",
        }
    }
}

/// The sentences.
pub(crate) fn sentence(said: &Diagnosis, beside: &Beside) -> String {
    let mut sentences = vec![match beside.since {
        Some(_) => since::lead(said, &beside.tied, beside.is_by_floor)
            .unwrap_or_else(|| lead(said, beside)),
        None => lead(said, beside),
    }];
    sentences.extend(beside.since.iter().flat_map(|since| since.changed.clone()));
    sentences.extend(by_direction(said, beside));
    sentences.push(rungs(said, beside));
    sentences.extend(held_out(said, beside));
    sentences.extend(closed(said));
    sentences.extend(region(said));
    sentences.extend(bent(beside));
    sentences.extend(wander(said, beside));
    sentences.join(" ")
}

/// What else is to be known; empty where there is nothing.
pub(crate) fn note(said: &Diagnosis, beside: &Beside) -> String {
    let mut notes: Vec<String> = Vec::new();
    notes.extend(visible(beside));
    notes.extend(beside.since.as_ref().and_then(since::alike));
    notes.extend(bent(beside));
    notes.extend(wander(said, beside));
    if beside.pieces < FEW_PIECES {
        let pieces = match beside.pieces {
            1 => "one piece".to_owned(),
            n => format!("{n} pieces"),
        };
        notes.push(format!(
            "The runs are {pieces}, fewer than {FEW_PIECES}: nothing is said with more than {:.0} %.",
            100.0 * FEW_PIECES_SURE
        ));
    }
    if beside.pieces < beside.all_pieces {
        notes.push(format!(
            "Searched were {} of {} pieces, drawn evenly over what the motor does; the rungs are those of all.",
            beside.pieces, beside.all_pieces
        ));
    }
    if beside.is_doubtful {
        notes.push(format!(
            "Something fatal is found in the recordings: nothing is said with more than {:.0} %.",
            100.0 * FEW_PIECES_SURE
        ));
    }
    notes.join(" ")
}

/// What the verdict says.
fn lead(said: &Diagnosis, beside: &Beside) -> String {
    let sure = sure(said.probability);
    match said.verdict {
        Verdict::NoGap if beside.is_by_floor => {
            let floor = said.gap.floor_parts.words();
            format!("The gap is below {floor} ({sure}), so there is nothing to explain.")
        }
        Verdict::NoGap if said.gap.wander > said.gap.floor => {
            format!("There is no gap that repeats, only a load that wanders ({sure}).")
        }
        Verdict::NoGap => format!("There is no gap to explain ({sure})."),
        Verdict::Parameters if beside.is_by_floor => {
            let floor = said.gap.floor_parts.words();
            format!("Other numbers in the same model bring the gap below {floor} ({sure}).")
        }
        Verdict::Parameters if said.gap.after_parameters >= said.gap.before => {
            format!("The model is right within the tolerances of its numbers ({sure}).")
        }
        Verdict::Parameters => {
            format!("The model is right, and its numbers are a little off ({sure}).")
        }
        Verdict::Effect => format!("The gap is {} ({sure}).", words(&said.effects)),
        Verdict::Partial if beside.tied.len() > 1 => format!(
            "There is {} ({sure}). These runs cannot tell which. Something more is there that no named effect explains.",
            rivals(&beside.tied)
        ),
        Verdict::Partial => format!(
            "There is {} ({sure}). Something more is there that no named effect explains.",
            words(&said.effects)
        ),
        Verdict::Ambiguous if beside.tied.len() < 2 => format!(
            "It may be {} ({sure}). These runs do not tell it from other causes.",
            rivals(&beside.tied)
        ),
        Verdict::Ambiguous if said.probability <= 0.5 => format!(
            "It may be {} ({sure}). These runs cannot tell which.",
            rivals(&beside.tied)
        ),
        Verdict::Ambiguous => format!(
            "It is {} ({sure}). These runs cannot tell which.",
            rivals(&beside.tied)
        ),
        Verdict::OutsideCatalogue => {
            format!("Something is there that no known effect explains ({sure}).")
        }
        Verdict::NoChange => format!("These runs do as the reference did ({sure})."),
        Verdict::BadRecording => "The recording has to be mended first.".to_owned(),
    }
}

/// What takes from the probability of an effect that may differ by direction.
fn by_direction(said: &Diagnosis, beside: &Beside) -> Option<String> {
    (beside.is_by_direction && !said.effects.is_empty())
        .then(|| "These runs cannot tell whether it differs by direction.".to_owned())
}

/// How large the gap is, and what is left of it.
fn rungs(said: &Diagnosis, beside: &Beside) -> String {
    let gap = &said.gap;
    let share = match gap.travel {
        travel if travel > 0.0 => {
            format!(
                ", {} % of a piece's travel",
                digits(100.0 * gap.before / travel)
            )
        }
        _ => String::new(),
    };
    let nominal = format!(
        "{} leaves {} counts{share}",
        beside.nominal(),
        counts(gap.before)
    );
    let floor = format!("the floor is {}", counts(gap.floor));
    let refitted = counts(gap.after_parameters);
    match said.verdict {
        Verdict::NoGap | Verdict::NoChange => format!("{nominal}; {floor}."),
        Verdict::Effect | Verdict::Partial | Verdict::Ambiguous => {
            let with = match (said.effects.len(), beside.tied.len()) {
                (_, 2..) => "the likeliest",
                (1, _) => "the effect",
                _ => "the effects",
            };
            format!(
                "{nominal}. Refitted it leaves {refitted}, with {with} {}; {floor}.",
                counts(gap.after_effect)
            )
        }
        _ => format!("{nominal}. Refitted it leaves {refitted}; {floor}."),
    }
}

/// What the model of the verdict leaves of runs that nothing was fitted to, and of those that it was fitted to.
fn held_out(said: &Diagnosis, beside: &Beside) -> Option<String> {
    let gap = &said.gap;
    let (held, fitted) = match said.verdict {
        Verdict::NoGap | Verdict::NoChange => (gap.before, gap.fitted.before),
        Verdict::Parameters | Verdict::OutsideCatalogue => {
            (gap.after_parameters, gap.fitted.after_parameters)
        }
        _ => (gap.after_effect, gap.fitted.after_effect),
    };
    beside.is_held_out.then(|| {
        format!(
            "That is of runs held out, {} counts; of the runs that were fitted the same model leaves {}.",
            counts(held),
            counts(fitted)
        )
    })
}

/// What is closed of the gap, rounded down: what is left must not be hidden.
fn closed(said: &Diagnosis) -> Option<String> {
    let closed = (100.0 * said.gap.closed).floor();
    let is_named = matches!(
        said.verdict,
        Verdict::Effect | Verdict::Partial | Verdict::Ambiguous
    );
    (is_named && closed > 0.0)
        .then(|| format!("That closes {closed:.0} % of the gap above the floor."))
}

/// Where most of it lies.
fn region(said: &Diagnosis) -> Option<String> {
    let (regime, share) = largest_regime(&said.place.regions)?;
    let is_gap = !matches!(
        said.verdict,
        Verdict::NoGap | Verdict::NoChange | Verdict::Parameters
    );
    (is_gap && share >= NAMED_REGIME).then(|| {
        format!(
            "Of what refitting leaves, {:.0} % lie {}.",
            100.0 * share,
            regime.words()
        )
    })
}

/// Base numbers that are far off.
fn bent(beside: &Beside) -> Option<String> {
    let file = match beside.since {
        Some(_) => "reference's",
        None => "file's",
    };
    let named = beside.bent.iter().map(|(key, ratio)| {
        let name = match *key {
            "inertia_kg_m2" => "inertia",
            "back_emf_v_s_per_rad" => "the back EMF constant",
            "coulomb_friction_nm" => "Coulomb friction",
            "viscous_friction_nm_s_per_rad" => "viscous friction",
            other => other,
        };
        format!("{name} is {ratio:.2} times the {file}")
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| format!("Beyond its tolerance, {}.", named.join(", ")))
}

/// A load that wanders.
fn wander(said: &Diagnosis, beside: &Beside) -> Option<String> {
    (said.gap.wander > 0.0).then(|| {
        format!(
            "A load that wanders by {} % of the stall torque leaves {} counts beside the floor.",
            digits(100.0 * beside.wander_share),
            counts(said.gap.wander)
        )
    })
}

/// What is visible below the floor.
fn visible(beside: &Beside) -> Option<String> {
    if !beside.is_by_floor {
        return None;
    }
    Some(match (beside.tied.is_empty(), beside.unknown > 0.5) {
        (true, _) => {
            "Visible below the floor is something that no named effect explains.".to_owned()
        }
        (false, true) => format!(
            "Visible below the floor is {}, and something more.",
            rivals(&beside.tied)
        ),
        (false, false) => format!("Visible below the floor is {}.", rivals(&beside.tied)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::conclusion::samples::diagnosis;

    const ALL: [Verdict; 8] = [
        Verdict::BadRecording,
        Verdict::NoGap,
        Verdict::Parameters,
        Verdict::Effect,
        Verdict::Partial,
        Verdict::Ambiguous,
        Verdict::OutsideCatalogue,
        Verdict::NoChange,
    ];

    fn beside(sets: &[&[&'static str]], is_by_floor: bool) -> Beside {
        Beside {
            tied: sets.iter().map(|set| set.to_vec()).collect(),
            is_by_direction: is_by_floor,
            bent: vec![("inertia_kg_m2", 1.7), ("coulomb_friction_nm", 0.41)],
            wander_share: 0.0123,
            pieces: 6,
            all_pieces: 6,
            is_by_floor,
            is_held_out: is_by_floor,
            is_doubtful: is_by_floor,
            unknown: 0.3,
            since: None,
        }
    }

    /// Every verdict's words have the document's own probability and figures, no others, in short sentences.
    #[test]
    fn sentences_say_the_figures_of_the_document() {
        let sets: [&[&[&'static str]]; 4] = [
            &[],
            &[
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
            ],
            &[&["dead_zone", "asymmetric_voltage_drop"]],
            &[
                &["dead_zone"],
                &["stribeck"],
                &["static_friction"],
                &["backlash", "encoder_eccentricity"],
                &["cogging"],
                &["inertia"],
            ],
        ];
        for verdict in ALL {
            for sets in sets {
                for is_by_floor in [false, true] {
                    let names = matches!(verdict, Verdict::Effect | Verdict::Partial);
                    let said =
                        diagnosis(verdict, sets.first().filter(|_| names && sets.len() == 1));
                    let mut beside = beside(sets, is_by_floor);
                    let text = sentence(&said, &beside);
                    check(&said, &text, verdict, is_by_floor);
                    let note = note(&said, &beside);
                    check_length(&note);
                    for part in ["inertia is 1.70 times", "Coulomb friction is 0.41 times"] {
                        assert!(text.contains(part) && note.contains(part), "{text} {note}");
                    }
                    let load =
                        "A load that wanders by 1.2 % of the stall torque leaves 0.77 counts";
                    assert!(text.contains(load) && note.contains(load), "{text} {note}");
                    assert_eq!(note.contains("Visible below the floor"), is_by_floor);
                    assert_eq!(note.contains("Something fatal"), is_by_floor);
                    beside.since = Some(Since {
                        changed: vec!["Since the reference backlash is new.".to_owned()],
                        alike: vec![vec!["cogging"]],
                    });
                    let text = sentence(&said, &beside);
                    check(&said, &text, verdict, is_by_floor);
                    assert!(text.contains(". Since the reference"), "{text}");
                    assert!(text.contains("times the reference's"), "{text}");
                    assert!(self::note(&said, &beside).contains("These runs show cogging, which"));
                }
            }
        }
    }

    fn check(said: &Diagnosis, text: &str, verdict: Verdict, is_held_out: bool) {
        check_length(text);
        let percents: Vec<&str> = text.split(" sure").collect();
        let spoken = usize::from(verdict != Verdict::BadRecording);
        assert_eq!(percents.len() - 1, spoken, "{text}");
        assert!(spoken == 0 || text.contains("93 % sure"), "{text}");
        assert!(
            text.contains("leaves 12.3 counts, 2.5 % of a piece's travel"),
            "{text}"
        );
        assert!(text.contains("the floor is 0.31"), "{text}");
        let held = text.contains("of runs held out") && text.contains("the same model leaves ");
        assert_eq!(held, is_held_out, "{text}");
        assert!(!said.effects.is_empty() || !text.contains("by direction"));
        for id in &said.effects {
            assert!(text.contains(&id.replace('_', " ")), "{text}");
        }
        let is_of_effects = matches!(
            verdict,
            Verdict::Effect | Verdict::Partial | Verdict::Ambiguous
        );
        assert_eq!(text.contains("closes 98 %"), is_of_effects, "{text}");
        assert_eq!(text.contains(" 0.44; the floor"), is_of_effects, "{text}");
    }

    fn check_length(text: &str) {
        for sentence in text.split(". ") {
            let words = sentence.split_whitespace().count();
            assert!(words <= 25, "{words} words: {sentence}");
        }
    }
}
