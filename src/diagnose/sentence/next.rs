//! Fourth part: the next step, with a command line to copy.

use std::collections::BTreeSet;

use super::cause::is_doubtful;
use super::{
    is_at_limit, is_floor_repeatability, is_undescribed, listed, name, other_means,
    repeatability_above_error,
};
use crate::check::{Finding, Severity};
use crate::diagnose::report::{Diagnosis, NextExperiment, NominalSource, Verdict};

use crate::diagnose::settings::conventions::COPIED_CHARACTERS;

/// Steps by hand, then the step with its command.
pub(super) fn next(diagnosis: &Diagnosis, asked: &str) -> String {
    let is_undescribed = is_undescribed(diagnosis);
    let by_hand = match is_undescribed {
        true => Some(CHECK_BY_HAND.to_owned()),
        false => other_means(diagnosis),
    };
    let is_repeats = repeatability_above_error(diagnosis).is_some()
        || is_floor_repeatability(diagnosis) && diagnosis.reference.is_none();
    let repeats = is_repeats.then(|| CHECK_REPEATS.to_owned());
    // A motor that imitates a probable effect is no result.
    let is_measured_first = by_hand.is_some()
        && !is_undescribed
        && diagnosis.effects.is_empty()
        && is_at_limit(diagnosis);
    let step = (!is_measured_first).then(|| then(diagnosis, asked));
    let all: Vec<String> = [repeats, by_hand, step].into_iter().flatten().collect();
    all.join(" ")
}

const CHECK_BY_HAND: &str = "First check that the supply and the counts per revolution are right (header of the run file, or flags of the import), and check the recordings with `motorlab check`.";

const CHECK_REPEATS: &str = "First make sure that the runs with the same command are repeats of one set-up, because an error below their repeatability cannot be judged. If they are not repeats, diagnose them separately.";

/// The step.
fn then(diagnosis: &Diagnosis, asked: &str) -> String {
    let is_explained = diagnosis.verdict == Verdict::Parameters
        && diagnosis.probability >= diagnosis.settings.identified;
    let is_open = matches!(
        diagnosis.verdict,
        Verdict::Partial | Verdict::Ambiguous | Verdict::OutsideCatalogue
    );
    let is_quick = diagnosis.quick.is_some() && is_open;
    let all_samples = asked.replacen(" --quick", "", 1);
    let asked = if is_quick { &all_samples } else { asked };
    if let Some(next) = &diagnosis.next_experiment
        && !is_explained
    {
        return record(diagnosis, next, asked);
    }
    let (to, flag) = match diagnosis.verdict {
        Verdict::Effect => (
            match diagnosis.effects.len() {
                1 => "write a motor file with the effect, for the commands simulate and compare",
                _ => "write a motor file with the effects, for the commands simulate and compare",
            },
            "--model-out diagnosed.toml",
        ),
        Verdict::Parameters => (
            "write a motor file with the re-identified parameters",
            "--model-out fitted.toml",
        ),
        Verdict::NoGap if diagnosis.nominal_source == NominalSource::Fit => (
            "write a motor file of the fitted motor",
            "--model-out fitted.toml",
        ),
        Verdict::NoGap | Verdict::NoChange => (
            "use the model for commands like the recorded ones; for a page with the recorded and simulated curves",
            "--html diagnosis.html",
        ),
        _ if is_quick => (
            "diagnose all samples, without --quick",
            "--html diagnosis.html",
        ),
        _ => (
            "make a page that shows where the error lies",
            "--html diagnosis.html",
        ),
    };
    let command = command(&format!("{asked} {flag}"), flag);
    let doubtful = diagnosis
        .effects
        .iter()
        .filter(|id| is_doubtful(diagnosis, id));
    let doubtful: Vec<String> = doubtful.map(|id| format!("[effects.{id}]")).collect();
    let then = match diagnosis.verdict {
        _ if !doubtful.is_empty() => format!(
            " Remove {} from it, or test it on another recording.",
            listed(&doubtful, "and")
        ),
        Verdict::Parameters if !is_explained => {
            " This motor imitates these runs; its parameters are no measurement.".to_owned()
        }
        Verdict::NoGap | Verdict::NoChange => {
            " No recording shows every effect: `motorlab design --profile NAME` lists those that the profile NAME (such as reversing) excites too little.".to_owned()
        }
        _ => String::new(),
    };
    format!("Next, {to}: {command}.{then}")
}

/// The recording that separates the remaining sets, and the command that diagnoses it with the others.
fn record(diagnosis: &Diagnosis, next: &NextExperiment, asked: &str) -> String {
    let change = next.change.as_ref();
    let with = change.map_or_else(String::new, |change| {
        format!(" Record it with {}.", change.words())
    });
    let flag = change.and_then(|change| change.flag("next.csv"));
    let flag = flag.map_or_else(String::new, |flag| format!(" {flag}"));
    let again = match asked.strip_prefix("motorlab diagnose ") {
        Some(rest) => format!("motorlab diagnose next.csv {rest}{flag}"),
        None => format!("motorlab diagnose next.csv RUN...{flag}"),
    };
    let names: Vec<String> = (next.named(diagnosis.verdict).iter())
        .map(|id| match id.as_str() {
            "none" => "no effect at all".to_owned(),
            ids => ids.split('+').map(name).collect::<Vec<_>>().join(" with "),
        })
        .collect();
    let what = match (diagnosis.verdict, names.len()) {
        (_, 1) => format!("shows whether {} is present", names[0]),
        _ => format!("distinguishes {}", listed(&names, "and")),
    };
    let written = match diagnosis.verdict {
        Verdict::Effect | Verdict::Partial => {
            " To use the motor with the identified effects now, add --model-out diagnosed.toml to this diagnosis."
        }
        Verdict::Parameters => {
            " To use the re-identified motor now, add --model-out fitted.toml to this diagnosis."
        }
        _ => "",
    };
    format!(
        "Next, make a recording that {what}: `{}`.{with} Then diagnose all runs together: {}.{written}",
        next.command,
        command(&again, "next.csv among the runs")
    )
}

/// The next step after warnings about the recordings; `None` without any.
pub(crate) fn after_warnings(next: &str, findings: &[Finding]) -> Option<String> {
    let warnings = findings.iter();
    let warnings = warnings.filter(|finding| finding.severity == Severity::Warning);
    let names: BTreeSet<String> = warnings.map(|one| format!("`{}`", one.id())).collect();
    let names: Vec<String> = names.into_iter().collect();
    let (word, then) = match (names.len(), next.strip_prefix("First ")) {
        (0, _) => return None,
        (1, then) => ("finding", then),
        (_, then) => ("findings", then),
    };
    let then = then.map_or_else(|| next.to_owned(), |then| format!("Then {then}"));
    Some(format!(
        "First settle the {word} {} of `motorlab check`. {then}",
        listed(&names, "and")
    ))
}

/// A command line to copy; for a long one only its new part.
fn command(line: &str, new: &str) -> String {
    match line.chars().count() {
        0..=COPIED_CHARACTERS => format!("`{line}`"),
        _ => format!("the same command with {new}"),
    }
}
