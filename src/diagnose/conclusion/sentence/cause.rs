//! Second part: what causes the gap, and how sure that is.

use super::Beside;
use crate::diagnose::conclusion::place::largest_regime;
use crate::diagnose::conclusion::words::{rivals, sure, words};
use crate::diagnose::report::{Diagnosis, NominalSource, Verdict};
use crate::diagnose::settings::{EXPLAINED_EFFECTS, NAMED_REGIME};
use crate::motor::catalogue::find;

/// The cause, what it is, where it shows.
pub(super) fn cause(said: &Diagnosis, beside: &Beside) -> Vec<String> {
    let mut sentences = vec![match beside.since {
        Some(_) => changed(said, beside),
        None => lead(said, beside),
    }];
    sentences.extend(explained(said));
    sentences.extend(more(said, beside));
    sentences.extend(beside.since.iter().flat_map(|since| since.changed.clone()));
    sentences.extend(by_direction(said, beside));
    sentences.extend(region(said));
    if said.verdict == Verdict::Parameters
        || said.verdict == Verdict::OutsideCatalogue && mends_it(said)
    {
        sentences.extend(bent(said, beside));
    }
    sentences
}

/// What the verdict says.
fn lead(said: &Diagnosis, beside: &Beside) -> String {
    let sure = sure(said.probability);
    match said.verdict {
        Verdict::NoGap if beside.is_by_floor => {
            format!("So small a gap needs no cause ({sure}).")
        }
        Verdict::NoGap if said.gap.wander > said.gap.floor => {
            match said.gap.before > said.gap.floor.hypot(said.gap.wander) {
                true => {
                    format!("No cause stands out of chance; the model may stay as it is ({sure}).")
                }
                false => format!("The load alone causes the gap; the model is right ({sure})."),
            }
        }
        Verdict::NoGap | Verdict::NoChange => format!("Nothing is missing in the model ({sure})."),
        Verdict::Parameters => {
            format!("The cause is numbers of the motor that are a little off ({sure}).")
        }
        Verdict::Effect => format!("The cause is {} ({sure}).", words(&said.effects)),
        Verdict::Partial => format!("One cause is {} ({sure}).", one_of(said, beside)),
        Verdict::Ambiguous => may_be("The cause", said, beside),
        Verdict::OutsideCatalogue if mends_it(said) && !beside.bent.is_empty() => format!(
            "Other numbers explain it, some far beyond their tolerances ({sure}). None of the effects that motorlab knows takes them back."
        ),
        Verdict::OutsideCatalogue => {
            // What is as sure as that something unknown is there leaves no part to a known effect.
            let part = match self::sure(beside.unknown) == sure {
                true => "None is borne out, even as a part of it.",
                false => "Something unknown is there; a known effect may play a part in it.",
            };
            format!("The cause is none of the effects that motorlab knows ({sure}). {part}")
        }
        Verdict::BadRecording => "The cause is in the recording itself.".to_owned(),
    }
}

/// Whether other numbers leave no more than floor and wander.
fn mends_it(said: &Diagnosis) -> bool {
    said.gap.fitted.after_parameters <= said.gap.floor.hypot(said.gap.wander)
}

/// What the verdict says of runs that are held against a reference.
fn changed(said: &Diagnosis, beside: &Beside) -> String {
    let sure = sure(said.probability);
    match said.verdict {
        Verdict::NoChange if beside.is_by_floor => {
            format!("So small a difference is no change since the reference ({sure}).")
        }
        Verdict::NoGap | Verdict::Parameters | Verdict::NoChange => {
            format!("Nothing has changed since the reference ({sure}).")
        }
        Verdict::Effect => format!("What has changed is {} ({sure}).", words(&said.effects)),
        Verdict::Partial => format!("One change is {} ({sure}).", one_of(said, beside)),
        Verdict::Ambiguous => may_be("The change", said, beside),
        Verdict::OutsideCatalogue => {
            format!("The change is none of the effects that motorlab knows ({sure}).")
        }
        Verdict::BadRecording => lead(said, beside),
    }
}

/// The effects of `partial`, or those that are not told apart.
fn one_of(said: &Diagnosis, beside: &Beside) -> String {
    match beside.tied.len() {
        0 | 1 => words(&said.effects),
        _ => rivals(&beside.tied),
    }
}

/// What is likeliest, and why it is not asserted.
fn may_be(subject: &str, said: &Diagnosis, beside: &Beside) -> String {
    let (sure, rivals) = (sure(said.probability), rivals(&beside.tied));
    match (beside.tied.len(), said.probability > 0.5) {
        (0 | 1, _) => {
            format!("{subject} may be {rivals} ({sure}). These runs fit other causes too.")
        }
        (_, true) => {
            format!(
                "{subject} is {rivals} ({sure} that it is one of them). These runs fit each of them well."
            )
        }
        (_, false) => {
            format!(
                "{subject} may be {rivals} ({sure} that it is one of them). These runs fit each, and others."
            )
        }
    }
}

/// What the named effects are, of few.
fn explained(said: &Diagnosis) -> Vec<String> {
    if said.effects.len() > EXPLAINED_EFFECTS {
        return Vec::new();
    }
    let found = said.effects.iter().filter_map(|id| find(id));
    let kinds = found.map(|(_, kind)| {
        let name = words(&[kind.id]);
        format!("{}: {}.", capital(&name), kind.summary)
    });
    kinds.collect()
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    let first = letters.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

/// That it is not all.
fn more(said: &Diagnosis, beside: &Beside) -> Option<String> {
    let is = match beside.since {
        Some(_) => "has changed",
        None => "is there",
    };
    (said.verdict == Verdict::Partial)
        .then(|| format!("Something more {is} that is none of the known effects."))
}

/// What takes from the probability of an effect that may differ by direction.
fn by_direction(said: &Diagnosis, beside: &Beside) -> Option<String> {
    (beside.is_by_direction && !said.effects.is_empty())
        .then(|| "It may differ by direction: these runs do not show it.".to_owned())
}

/// Where most of the gap lies.
fn region(said: &Diagnosis) -> Option<String> {
    let (regime, share) = largest_regime(&said.place.regions)?;
    let is_gap = !matches!(
        said.verdict,
        Verdict::NoGap | Verdict::NoChange | Verdict::Parameters
    ) && !mends_it(said);
    (is_gap && share >= NAMED_REGIME).then(|| {
        format!(
            "Of what other numbers cannot mend, {:.0} % arises {}.",
            100.0 * share,
            regime.words()
        )
    })
}

/// Base numbers that are far off.
pub(super) fn bent(said: &Diagnosis, beside: &Beside) -> Option<String> {
    let whose = match (&beside.since, said.nominal_source) {
        (Some(_), _) => "reference's",
        (None, NominalSource::Given) => "file's",
        (None, NominalSource::Handout) => "handout's",
        (None, NominalSource::Fit) => "plain fit's",
    };
    let named = beside.bent.iter().map(|(key, ratio)| {
        let name = match *key {
            "inertia_kg_m2" => "inertia",
            "back_emf_v_s_per_rad" => "the back EMF constant",
            "coulomb_friction_nm" => "Coulomb friction",
            "viscous_friction_nm_s_per_rad" => "viscous friction",
            "inductance_h" => "the inductance",
            other => other,
        };
        format!("{name} is {ratio:.2} times the {whose}")
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| format!("Beyond its tolerance, {}.", named.join(", ")))
}
