//! Fourth part: the next step, with a command line to copy.

use super::cause::is_doubtful;
use super::{is_at_limit, is_floor_repeatability, is_undescribed, listed, name, other_means};
use crate::diagnose::report::{Diagnosis, NextExperiment, NominalSource, Verdict};
use crate::diagnose::settings::Settings;

use crate::diagnose::settings::conventions::COPIED_CHARACTERS;

/// Steps by hand, then the step with its command.
pub(super) fn next(diagnosis: &Diagnosis, asked: &str, settings: &Settings) -> String {
    let by_hand = match is_undescribed(diagnosis, settings) {
        true => Some(CHECK_BY_HAND.to_owned()),
        false => other_means(diagnosis, settings),
    };
    let is_repeats = is_floor_repeatability(diagnosis) && diagnosis.reference.is_none();
    let repeats = is_repeats.then(|| CHECK_REPEATS.to_owned());
    let step = Some(then(diagnosis, asked, settings));
    let all: Vec<String> = [repeats, by_hand, step].into_iter().flatten().collect();
    all.join(" ")
}

const CHECK_BY_HAND: &str = "First check by hand that the supply and the counts per revolution that were given are right, and the recordings with `motorlab check`.";

const CHECK_REPEATS: &str = "First make sure that the runs with the same command are repeats of one set-up: their difference is the noise floor, and no smaller error can be judged. If they are not, diagnose them separately.";

/// The step.
fn then(diagnosis: &Diagnosis, asked: &str, settings: &Settings) -> String {
    let is_explained =
        diagnosis.verdict == Verdict::Parameters && diagnosis.probability >= settings.identified;
    if let Some(next) = &diagnosis.next_experiment
        && !is_explained
    {
        return record(diagnosis, next, asked);
    }
    let (to, flag) = match diagnosis.verdict {
        Verdict::Effect => (
            match diagnosis.effects.len() {
                1 => "write a motor file with the effect, for simulate and compare",
                _ => "write a motor file with the effects, for simulate and compare",
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
            "use the model as it is; for pictures of it",
            "--html diagnosis.html",
        ),
        _ => (
            "see as pictures where the error lies",
            "--html diagnosis.html",
        ),
    };
    let command = command(&format!("{asked} {flag}"), flag);
    let doubtful = diagnosis
        .effects
        .iter()
        .filter(|id| is_doubtful(diagnosis, id));
    let doubtful: Vec<String> = doubtful.map(|id| format!("[effects.{id}]")).collect();
    let without = match doubtful.is_empty() {
        true => String::new(),
        false => format!(
            " Remove {} from it, or test it on another recording.",
            listed(&doubtful, "and")
        ),
    };
    // After advice to measure and diagnose again.
    let when = match diagnosis.effects.is_empty() && is_at_limit(diagnosis, settings) {
        true => "Next, unless you diagnose again",
        false => "Next",
    };
    format!("{when}, {to}: {command}.{without}")
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
    let names: Vec<String> = (next.tells_apart.iter())
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

/// A command line to copy; for a long one only its new part.
fn command(line: &str, new: &str) -> String {
    match line.chars().count() {
        0..=COPIED_CHARACTERS => format!("`{line}`"),
        _ => format!("the same command with {new}"),
    }
}
