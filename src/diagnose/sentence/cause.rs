//! Second part: the cause with its probability and parameters.

use super::{listed, name, percent, probability, three};
use crate::diagnose::classes::members_of;
use crate::diagnose::report::{Cause, Diagnosis, Interval, Verdict};
use crate::diagnose::settings::conventions::{MENTIONED, MENTIONED_FROM};

pub(super) fn cause(said: &Diagnosis, probable: f64) -> String {
    let p = probability(said.probability);
    match said.verdict {
        Verdict::BadRecording => String::new(),
        Verdict::NoGap => format!("No effect is needed: P(no effect is present) {p}."),
        Verdict::NoChange => {
            format!("The runs agree with the reference: P(no effect has changed) {p}.")
        }
        Verdict::Parameters if said.probability < probable => format!(
            "Re-identified parameters remove {} of the reducible squared error. P(no effect is present) {p}, but none is identified.{}{}",
            percent(share_of(said, "parameters")),
            candidates(said),
            unconfirmed(said, probable)
        ),
        Verdict::Parameters => format!(
            "Re-identified parameters explain it: they remove {} of the reducible squared error; P(no effect is present) {p}.",
            percent(share_of(said, "parameters"))
        ),
        Verdict::OutsideCatalogue => format!(
            "No effect of the catalogue is identified: P(no effect of the catalogue is present) {p}.{}",
            candidates(said)
        ),
        Verdict::Ambiguous => format!(
            "An effect is present, P {p}, but none is identified.{}{}",
            candidates(said),
            unconfirmed(said, probable)
        ),
        Verdict::Effect | Verdict::Partial => identified(said, &p),
    }
}

fn share_of(said: &Diagnosis, step: &str) -> f64 {
    let found = said.budget.iter().find(|one| one.step == step);
    found.map_or(0.0, |one| one.share)
}

/// The most probable causes where none is identified.
fn candidates(said: &Diagnosis) -> String {
    let listed_causes: Vec<String> = (said.causes.iter())
        .filter(|cause| cause.inclusion >= MENTIONED_FROM)
        .take(MENTIONED)
        .map(|cause| format!("{} ({:.2})", name(cause.effect), cause.inclusion))
        .collect();
    match listed_causes.is_empty() {
        true => String::new(),
        false => format!(" Most probable: {}.", listed(&listed_causes, "and")),
    }
}

/// That the most probable effects do not reduce the held-out error by a tenth, if that is why they are not identified.
fn unconfirmed(said: &Diagnosis, probable: f64) -> &'static str {
    // A class has what its members have, and is not identified with one of them at a bound.
    let is_bounded = |cause: &Cause| {
        (said.causes.iter()).any(|other| {
            other.at_bound
                && (other.effect == cause.effect
                    || other.class.is_some() && other.class == cause.class)
        })
    };
    let is_probable = |cause: &Cause| {
        cause.class_probability.unwrap_or(cause.inclusion) >= probable && !is_bounded(cause)
    };
    match said.causes.iter().any(is_probable) {
        true => {
            " Adding the most probable reduces the held-out squared error by less than a tenth."
        }
        false => "",
    }
}

fn identified(said: &Diagnosis, p: &str) -> String {
    let one = |id: &&'static str| -> String {
        let class = said.classes.iter().find(|class| class.members.contains(id));
        match class {
            Some(class) => {
                let members: Vec<String> = class.members.iter().map(|id| name(id)).collect();
                format!("one of {}", listed(&members, "or"))
            }
            None => name(id),
        }
    };
    let names: Vec<String> = said.effects.iter().map(one).collect();
    let mut text = format!("Cause: {}, P {p}.", listed(&names, "and"));
    for class in &said.classes {
        text.push_str(&format!(
            " These recordings do not separate the {} of class {}.",
            class.members.len().max(2),
            class.class
        ));
    }
    let stated: Vec<String> = (said.effects.iter())
        .filter(|id| {
            !said
                .classes
                .iter()
                .any(|class| members_of(class.class).contains(id))
        })
        .filter_map(|id| said.causes.iter().find(|cause| cause.effect == *id))
        .filter_map(parameters)
        .collect();
    if !stated.is_empty() {
        text.push_str(&format!(" {}.", stated.join("; ")));
    }
    let removed: f64 = (said.budget.iter())
        .filter(|one| said.effects.contains(&one.step))
        .map(|one| one.share)
        .sum();
    text.push_str(&format!(
        " It removes {} of the reducible squared error, re-identified parameters {}.",
        percent(removed.max(0.0)),
        percent(share_of(said, "parameters").max(0.0))
    ));
    text
}

/// Parameters of an effect with their intervals.
fn parameters(cause: &Cause) -> Option<String> {
    let of = |(key, interval): (&&'static str, &Interval)| {
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
            format!(", {} in the reference", three(then))
        });
        format!(
            "{key} {} {unit} (95 % {} to {}{before})",
            three(value),
            three(lo95),
            three(hi95)
        )
    };
    let all: Vec<String> = cause.parameters.iter().take(2).map(of).collect();
    (!all.is_empty()).then(|| format!("{}: {}", name(cause.effect), all.join(", ")))
}
