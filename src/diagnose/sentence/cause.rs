//! Second part: the cause with its probability and parameters.

use super::{
    ABOVE_FLOOR, capitalized, counts, is_nominal_fitted, is_undescribed, listed, name,
    name_of_cause, percent, probability, repeatability_above_error, three,
};
use crate::diagnose::report::{Cause, Diagnosis, EffectClass, Interval, Verdict};
use crate::diagnose::settings::conventions::{MENTIONED, MENTIONED_BESIDE, MENTIONED_FROM, STATED};
use crate::motor::catalogue::find;

pub(super) fn cause(diagnosis: &Diagnosis) -> String {
    let p = probability(diagnosis.probability);
    let parameters = || percent(share_of(diagnosis, "parameters").max(0.0));
    if is_undescribed(diagnosis) {
        return "No effect that was tried describes these recordings: nearly all of the held-out error remains. The probabilities only compare the sets that were tried.".to_owned();
    }
    match diagnosis.verdict {
        Verdict::BadRecording => String::new(),
        Verdict::NoGap if diagnosis.probability >= diagnosis.settings.confident => {
            format!("No effect is needed: P(no effect is present) {p}.")
        }
        Verdict::NoGap => format!(
            "No effect is identified at this noise floor; P(no effect is present) {p}.{}{}",
            candidates(diagnosis),
            not_visible(diagnosis)
        ),
        Verdict::NoChange => {
            format!("The runs agree with the reference: P(no effect has changed) {p}.")
        }
        Verdict::Parameters if diagnosis.probability < diagnosis.settings.identified => format!(
            "An effect is probably present: P(no effect is present) {p}.{} Re-identified parameters remove {} of {ABOVE_FLOOR}, probably by imitating an effect, and leave {} counts.{}",
            candidates(diagnosis),
            parameters(),
            counts(diagnosis.gap.after_parameters),
            at_floor(diagnosis)
        ),
        Verdict::Parameters => format!(
            "Re-identified parameters explain the error: they remove {} of {ABOVE_FLOOR}; P(no effect is present) {p}.{}",
            parameters(),
            changed(diagnosis)
        ),
        Verdict::OutsideCatalogue => format!(
            "No effect of the catalogue is identified: P(no effect of the catalogue is present) {p}.{}",
            candidates(diagnosis)
        ),
        Verdict::Ambiguous => format!(
            "P(an effect is present) {p}, but none is identified.{}{}",
            candidates(diagnosis),
            at_floor(diagnosis)
        ),
        Verdict::Effect | Verdict::Partial => {
            format!("{}{}", identified(diagnosis, &p), also(diagnosis))
        }
    }
}

/// Effects below the repeatability of the runs.
fn not_visible(diagnosis: &Diagnosis) -> String {
    let repeats = repeatability_above_error(diagnosis);
    repeats.map_or_else(String::new, |repeats| {
        format!(
            " Runs with the same command differ by {} counts over a segment (repeatability). The figure includes the difference of the runs' speeds at the start of a segment, which the model error does not include. So the noise is at most that large, and an effect with a smaller error is not visible.",
            counts(repeats)
        )
    })
}

/// Identifiable parameters that differ from the motor file's: the 95 % interval excludes that value.
fn changed(diagnosis: &Diagnosis) -> String {
    let changed: Vec<String> = (diagnosis.identifiable_rows().into_iter())
        .filter_map(|(name, found, file)| Some((name, found, file?)))
        .filter(|(_, found, file)| !(found.lo95..=found.hi95).contains(file))
        .map(|(name, found, file)| (name, three(found.value), three(file), found.unit))
        .filter(|(_, value, file, _)| value != file)
        .map(|(name, value, file, unit)| format!("{name} {value} {unit} instead of {file}"))
        .collect();
    match changed.is_empty() {
        true => String::new(),
        false => format!(
            " Different from the motor file: {}.",
            listed(&changed, "and")
        ),
    }
}

fn share_of(diagnosis: &Diagnosis, step: &str) -> f64 {
    let found = diagnosis.budget.iter().find(|one| one.step == step);
    found.map_or(0.0, |one| one.share)
}

/// Its name and probability, and why it is not identified although probable.
fn with_probability(diagnosis: &Diagnosis, cause: &Cause) -> String {
    let reason = cause.not_identified(&diagnosis.settings);
    let reason = reason.map_or_else(String::new, |reason| format!(", but {reason}"));
    let p = probability(cause.inclusion);
    format!("{} (P {p}{reason})", name(cause.effect))
}

/// Causes of at least this probability, the most probable first.
fn probable(diagnosis: &Diagnosis, least: f64, is_counted: impl Fn(&Cause) -> bool) -> Vec<&Cause> {
    let causes = diagnosis.causes.iter();
    let mut found: Vec<&Cause> = causes
        .filter(|cause| cause.inclusion >= least && is_counted(cause))
        .collect();
    found.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    found
}

/// The most probable causes if none is identified.
fn candidates(diagnosis: &Diagnosis) -> String {
    let found = probable(diagnosis, MENTIONED_FROM, |_| true);
    let found: Vec<String> = (found.into_iter().take(MENTIONED))
        .map(|cause| with_probability(diagnosis, cause))
        .collect();
    match found.as_slice() {
        [] => String::new(),
        [only] => format!(" Most probable effect: {only}."),
        all => format!(" Most probable effects: {}.", listed(all, "and")),
    }
}

/// Re-identified parameters that leave nothing for a probable effect to remove.
fn at_floor(diagnosis: &Diagnosis) -> &'static str {
    let has_immaterial = diagnosis.causes.iter().any(|cause| cause.immaterial);
    match has_immaterial && diagnosis.gap.after_parameters <= diagnosis.gap.floor {
        true => {
            " Re-identified parameters alone reach the noise floor, although with less probable values."
        }
        false => "",
    }
}

fn identified(diagnosis: &Diagnosis, p: &str) -> String {
    let class_of = |id: &str| {
        diagnosis
            .classes
            .iter()
            .find(|class| class.members.contains(&id))
    };
    let one = |id: &&'static str| match class_of(id) {
        Some(class) => members(diagnosis, class),
        None => name_of_cause(diagnosis, id),
    };
    let probability_of = |id: &str| match class_of(id) {
        Some(class) => class.probability,
        None => (diagnosis.causes.iter().find(|cause| cause.effect == id))
            .map_or(diagnosis.probability, |cause| cause.inclusion),
    };
    let mut text = match diagnosis.effects.as_slice() {
        [only] => format!("Cause: {}, P {p}.", one(only)),
        all => {
            let numbered = (all.iter().enumerate()).map(|(k, id)| {
                let p = probability(probability_of(id));
                format!("({}) {}, P {p}", k + 1, one(id))
            });
            format!(
                "Causes: {}. P(all are present) {p}.",
                numbered.collect::<Vec<_>>().join("; ")
            )
        }
    };
    if !diagnosis.classes.is_empty() {
        text.push_str(" These recordings do not separate the members of a class.");
    }
    let stated: Vec<String> = (diagnosis.effects.iter())
        .filter(|id| class_of(id).is_none())
        .filter_map(|id| diagnosis.causes.iter().find(|cause| cause.effect == *id))
        .filter_map(parameters)
        .collect();
    if !stated.is_empty() {
        text.push_str(&format!(" {}.", capitalized(&stated.join("; "))));
    }
    text.push_str(&reductions(diagnosis));
    text
}

/// Members of a class with their probabilities; more than one of them may be present.
fn members(diagnosis: &Diagnosis, class: &EffectClass) -> String {
    let members = probable(diagnosis, 0.0, |cause| {
        class.members.contains(&cause.effect)
    });
    let sum: f64 = members.iter().map(|cause| cause.inclusion).sum();
    let of = |cause: &&Cause| {
        let p = probability(cause.inclusion);
        format!("{} (P {p})", name_of_cause(diagnosis, cause.effect))
    };
    let names: Vec<String> = members.iter().map(of).collect();
    // More than one of them is present in some set.
    let at_least = if sum > class.probability + MENTIONED_FROM {
        "at least "
    } else {
        ""
    };
    format!(
        "{at_least}one of {} (class {})",
        listed(&names, "or"),
        class.class
    )
}

/// Errors that re-identified parameters leave without the effects and with them.
fn reductions(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    let alone = share_of(diagnosis, "parameters");
    let (effects, them) = match diagnosis.effects.len() {
        1 => ("the effect", "it"),
        _ => ("the effects", "them"),
    };
    let fitted = match is_nominal_fitted(diagnosis) {
        true => ", which was fitted to these runs",
        false => "",
    };
    let [left, remain] = [gap.after_parameters, gap.after_effect].map(counts);
    let mut text = match alone > 0.0 {
        _ if gap.closed <= 0.0 => format!(
            " The held-out error with {effects} is not below that of the nominal model{fitted}."
        ),
        true => format!(
            " Without {effects}, re-identified parameters imitate {them}: they remove {} of {ABOVE_FLOOR} and leave {left} counts; with {effects} {remain} remain.",
            percent(alone)
        ),
        false => format!(
            " Without {effects}, re-identified parameters do not reduce the error and leave {left} counts; with {effects} {remain} remain."
        ),
    };
    if gap.after_parameters <= gap.floor {
        text.push_str(&format!(
            " Without {effects} the parameters reach the noise floor too, but farther from the nominal motor's, which is less probable."
        ));
    }
    text.push_str(&doubtful(diagnosis));
    text
}

/// Identified effects that increase the held-out error, with the error before and after.
fn doubtful(diagnosis: &Diagnosis) -> String {
    let with_before = diagnosis.budget.iter().zip(diagnosis.budget.iter().skip(1));
    let adding = with_before.filter(|(_, step)| is_doubtful(diagnosis, step.step));
    adding
        .map(|(before, step)| {
            format!(
                " {} raises the held-out error from {} to {} counts: doubtful.",
                capitalized(&name(step.step)),
                counts(before.rms_counts),
                counts(step.rms_counts)
            )
        })
        .collect()
}

/// Whether an identified effect increases the held-out error.
pub(super) fn is_doubtful(diagnosis: &Diagnosis, id: &str) -> bool {
    diagnosis.effects.len() > 1 && diagnosis.effects.contains(&id) && share_of(diagnosis, id) < 0.0
}

/// Probable effects that are not identified, in addition to identified ones.
fn also(diagnosis: &Diagnosis) -> String {
    let named = |cause: &Cause| {
        diagnosis.effects.contains(&cause.effect)
            || diagnosis
                .classes
                .iter()
                .any(|class| class.members.contains(&cause.effect))
    };
    let others = probable(diagnosis, MENTIONED_BESIDE, |cause| !named(cause));
    let others: Vec<String> = (others.into_iter())
        .map(|cause| with_probability(diagnosis, cause))
        .collect();
    match others.is_empty() {
        true => String::new(),
        false => format!(" Possible too: {}.", listed(&others, "and")),
    }
}

/// Parameters of an effect with their intervals; fixed ones are in the table of causes.
fn parameters(cause: &Cause) -> Option<String> {
    let of = |key: &'static str, interval: &Interval| {
        let (key, interval) = interval.determined(key);
        let Interval {
            value,
            lo95,
            hi95,
            unit,
            reference,
            ..
        } = interval;
        let before = reference.map_or_else(String::new, |then| {
            format!("; {} in the reference", three(then))
        });
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" {unit}")
        };
        format!(
            "{key} {}{unit} (95 % interval {} to {}{before})",
            three(value),
            three(lo95),
            three(hi95)
        )
    };
    let (_, kind) = find(cause.effect)?;
    let fitted = (kind.parameters.iter())
        .filter_map(|own| cause.parameters.get(own.key).map(|found| (own.key, found)))
        .filter(|(_, found)| found.lo95 < found.hi95);
    let all: Vec<String> = fitted
        .take(STATED)
        .map(|(key, found)| of(key, found))
        .collect();
    (!all.is_empty()).then(|| format!("{}: {}", name(cause.effect), all.join(", ")))
}
