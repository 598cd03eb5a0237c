//! Sentences of a diagnosis: from the document, and from nothing else.
//!
//! Four parts: the size of the error, its cause, what the model with it leaves, what to do next.

mod cause;
mod next;
mod words;

pub(crate) use words::{counts, listed, name, percent, probability, three};

use super::report::{Diagnosis, Regime, Verdict};

/// The four parts; an effect from `probable` on is identified if it reduces the held-out error.
pub(crate) fn parts(said: &Diagnosis, asked: &str, probable: f64) -> [String; 4] {
    [
        size(said),
        cause::cause(said, probable),
        remaining(said),
        next::next(said, asked),
    ]
}

/// First part: the held-out error of the nested models and the noise floor.
fn size(said: &Diagnosis) -> String {
    let error = error(said);
    match &said.quick {
        Some(quick) => format!("{error} {}", quick.sentence()),
        None => error,
    }
}

fn error(said: &Diagnosis) -> String {
    let gap = &said.gap;
    let floor = counts(gap.floor);
    if said.verdict == Verdict::NoGap {
        return format!(
            "Held-out RMS error: {} counts with the nominal model, within the noise floor of {floor}.",
            counts(gap.before)
        );
    }
    let refitted = counts(gap.after_parameters);
    let effects = match said.effects.is_empty() {
        true => String::new(),
        false => {
            let names: Vec<String> = said.effects.iter().map(|id| name(id)).collect();
            format!(
                ", {} with {}",
                counts(gap.after_effect),
                listed(&names, "and")
            )
        }
    };
    format!(
        "Held-out RMS error: {} counts nominal, {refitted} with re-identified parameters{effects} (noise floor {floor}).",
        counts(gap.before)
    )
}

/// Third part: what is unexplained, where and how large.
fn remaining(said: &Diagnosis) -> String {
    let unexplained = &said.unexplained;
    if matches!(said.verdict, Verdict::NoGap | Verdict::NoChange) {
        return String::new();
    }
    let share = format!(
        "Unexplained: {} of the reducible squared error (95 % {} to {})",
        percent(unexplained.share),
        percent(unexplained.lo95.max(0.0)),
        percent(unexplained.hi95)
    );
    let place = largest_regime(said)
        .filter(|_| unexplained.share > 0.0)
        .map(|(regime, share)| format!("; {} of it {}", percent(share), regime.words()));
    format!("{share}{}.", place.unwrap_or_default())
}

fn largest_regime(said: &Diagnosis) -> Option<(Regime, f64)> {
    super::budget::largest_regime(&said.unexplained.regions)
}

/// Reservations: a closed loop, base parameters outside their tolerance, parameters at a bound, the score that was used, the source of the nominal motor.
pub(crate) fn note(
    said: &Diagnosis,
    outside: &[(&'static str, f64)],
    is_doubtful: bool,
    is_closed_loop: bool,
    probable: f64,
) -> String {
    let mut notes: Vec<String> = Vec::new();
    if is_closed_loop {
        notes.push(format!(
            "Closed loop: the command answers to the measured position. Segments are {} s long, so that the prediction error is close to an equation error.",
            three(said.gap.horizon_s)
        ));
    }
    for (key, share) in outside {
        notes.push(format!(
            "{} is {} times the motor file's value, outside its tolerance: it has changed, or the file is wrong.",
            words_of_key(key),
            three(*share)
        ));
    }
    for cause in said
        .causes
        .iter()
        .filter(|cause| cause.at_bound && cause.inclusion >= probable)
    {
        notes.push(format!(
            "The parameter of {} is at the bound of its range, so that it is not identified (inclusion probability {:.2}).",
            name(cause.effect),
            cause.inclusion
        ));
    }
    if said.scoring.score == "likelihood" && said.scoring.random_load_share > 0.0 {
        notes.push(format!(
            "A random load torque of {} of stall (estimated) is part of the error; no deterministic model removes it.",
            percent(said.scoring.random_load_share)
        ));
    }
    if is_doubtful {
        notes.push(
            "A finding about the recordings is fatal: correct it before using this result."
                .to_owned(),
        );
    }
    notes.join(" ")
}

/// A key of a motor file as words.
pub(crate) fn words_of_key(key: &str) -> String {
    let words = match key {
        "inertia_kg_m2" => "Inertia",
        "back_emf_v_s_per_rad" => "The back-EMF constant",
        "coulomb_friction_nm" => "Coulomb friction",
        "viscous_friction_nm_s_per_rad" => "Viscous friction",
        "inductance_h" => "Inductance",
        "torque_constant_nm_per_a" => "The torque constant",
        other => other,
    };
    words.to_owned()
}
