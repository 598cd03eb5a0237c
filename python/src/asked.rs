//! The command line that asks the program the same: what to do next repeats it. A motor and runs that are no files stand as words in
//! capitals.

use motorlab::diagnose::GoodEnough;
use motorlab::plain::quoted;
use motorlab::recording::Run;

use crate::diagnosis::Question;

/// Name in place of the motor's file.
const MOTOR: &str = "MOTOR.toml";

/// The command line of a question.
pub(crate) fn asked(question: &Question) -> String {
    let mut line = format!("motorlab diagnose {}", words(&question.runs));
    let mut add = |words: String| {
        line.push(' ');
        line.push_str(&words);
    };
    if question.motor.is_some() {
        add(format!("--motor {MOTOR}"));
    }
    if !question.held_out.is_empty() {
        add(format!("--hold-out {}", words(&question.held_out)));
    }
    if !question.reference.is_empty() {
        add(format!("--reference {}", words(&question.reference)));
    }
    for group in &question.repeats {
        let names = group.iter().map(|run| word(&question.runs[*run]));
        add(format!("--repeats {}", names.collect::<Vec<_>>().join(",")));
    }
    match question.is_fitted {
        Some(true) => add("--nominal fit".to_owned()),
        Some(false) => add("--nominal file".to_owned()),
        None => {}
    }
    match question.good_enough {
        Some(GoodEnough::Counts(counts)) => add(format!("--good-enough {counts}")),
        // Percent without the rounding of the product.
        Some(GoodEnough::Share(share)) => {
            add(format!("--good-enough {}%", (share * 1e12).round() / 1e10));
        }
        None => {}
    }
    if question.despite_findings {
        add("--despite-findings".to_owned());
    }
    line
}

fn words(runs: &[Run]) -> String {
    match runs.iter().all(|run| run.path.is_some()) {
        true => runs.iter().map(word).collect::<Vec<_>>().join(" "),
        false => "RUN...".to_owned(),
    }
}

fn word(run: &Run) -> String {
    let path = run.path.as_ref();
    path.map_or_else(|| "RUN".to_owned(), |path| quoted(&path.to_string_lossy()))
}
