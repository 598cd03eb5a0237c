//! Fourth part: what to do next, with a command to copy.

use super::Beside;
use crate::diagnose::conclusion::words::rivals_of;
use crate::diagnose::report::{Diagnosis, NextExperiment, NominalSource, Verdict, other_means};
use crate::diagnose::settings::{COPIED_CHARACTERS, SURE};

/// The next step of a verdict.
pub(super) fn what_next(said: &Diagnosis, beside: &Beside) -> String {
    let is_open = match said.verdict {
        Verdict::NoGap | Verdict::Partial | Verdict::Ambiguous | Verdict::OutsideCatalogue => true,
        Verdict::Effect => said.probability < SURE,
        _ => false,
    };
    if let (true, Some(next)) = (is_open, &said.next_experiment) {
        return record(said, next, beside);
    }
    let (to, flag) = match said.verdict {
        Verdict::Effect if said.gap.after_effect >= said.gap.before => {
            ("see where it arises", "--html diagnosis.html")
        }
        Verdict::Effect => (
            match said.effects.len() {
                1 => "write the motor with it, to simulate with",
                _ => "write the motor with them, to simulate with",
            },
            "--model-out diagnosed.toml",
        ),
        Verdict::Parameters => (
            "write the motor with its new numbers",
            "--model-out fitted.toml",
        ),
        Verdict::NoGap if said.nominal_source == NominalSource::Fit => {
            ("write the motor that was fitted", "--model-out fitted.toml")
        }
        Verdict::NoGap | Verdict::NoChange => (
            "use the model as it is; to see both motions",
            "--html diagnosis.html",
        ),
        Verdict::Partial => ("see where the rest arises", "--html diagnosis.html"),
        _ => ("see where it arises", "--html diagnosis.html"),
    };
    let command = command(&format!("{} {flag}", beside.asked), flag);
    match other_means(said) {
        Some(means) => format!("{means} Next, {to}: {command}."),
        None => format!("Next, {to}: {command}."),
    }
}

/// The recording that would tell more, and the command that asks again with it.
fn record(said: &Diagnosis, next: &NextExperiment, beside: &Beside) -> String {
    let bench = next.change.as_ref();
    // A sentence of its own: it may be long.
    let with = bench.map_or_else(String::new, |change| {
        format!(" Record it with {}.", change.words())
    });
    let flag = bench.and_then(|change| change.flag("next.csv"));
    let flag = flag.map_or_else(String::new, |flag| format!(" {flag}"));
    let again = match beside.asked.strip_prefix("motorlab diagnose ") {
        Some(rest) => format!("motorlab diagnose next.csv {rest}{flag}"),
        None => format!("motorlab diagnose next.csv RUN...{flag}"),
    };
    let names: Vec<&str> = next.tells_apart.iter().map(String::as_str).collect();
    let effects = || {
        names
            .iter()
            .copied()
            .filter(|id| !matches!(*id, "none" | "unknown"))
    };
    let lead = match names.as_slice() {
        // Where nothing is missing, what these runs hide is not in question.
        _ if said.verdict == Verdict::NoGap && effects().next().is_some() => format!(
            "These runs cannot show {}. Next, record what does",
            rivals_of(&effects().collect::<Vec<&str>>())
        ),
        [one] => format!(
            "Next, record what shows whether {} is there",
            rivals_of(&[one])
        ),
        several => format!("Next, record what tells apart {}", rivals_of(several)),
    };
    format!(
        "{lead}: `{}`.{with} Then ask again: {}.",
        next.command,
        command(&again, "next.csv among the runs")
    )
}

/// A command to copy; of one too long to be read, what is new in it.
fn command(line: &str, new: &str) -> String {
    match line.chars().count() {
        0..=COPIED_CHARACTERS => format!("`{line}`"),
        _ => format!("the same command with {new}"),
    }
}
