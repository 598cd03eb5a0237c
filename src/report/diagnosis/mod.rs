//! A diagnosis as one offline page: the sentence, before and after, how far, where, which, what next.

mod bad_recording;
mod laid;
mod ordered;
mod overlay;
mod parameters;
mod place;
mod words;

use super::number::{figure, probability};
use super::{Page, Size};
use crate::check::Finding;
use crate::diagnose::{Cause, Diagnosis, other_means};
use crate::motor::SimulationError;
use crate::recording::Run;
use laid::{lay, names};
use overlay::Beside;

pub use bad_recording::bad_recording_page;
pub use words::{
    PARTS, cause_words, closed_words, effects_words, few_words, note_beside, of_reference, rungs,
    seen_name, seen_scale, seen_words, strongest,
};

/// Causes below this probability are summed up instead of listed, where others are above.
const LISTED_FROM: f64 = 0.001;
/// So many causes are listed in any case.
const LISTED: usize = 5;

/// Size of the overlay of one run.
const OVERLAY: Size = Size {
    width: 860,
    height: 780,
};

/// The page of a diagnosis of these runs against this motor.
///
/// # Errors
/// A run that cannot be simulated with one of the motors.
pub fn page(diagnosis: &Diagnosis, runs: &[Run], title: &str) -> Result<String, SimulationError> {
    page_held_out(diagnosis, runs, &[], title)
}

/// The same where the gap was measured on runs that nothing was fitted to.
///
/// # Errors
/// A run that cannot be simulated with one of the motors.
pub fn page_held_out(
    diagnosis: &Diagnosis,
    runs: &[Run],
    held_out: &[Run],
    title: &str,
) -> Result<String, SimulationError> {
    let mut page = Page::new(title);
    lay_out(&mut page, diagnosis, runs, held_out)?;
    Ok(page.finish())
}

/// All of a diagnosis, below the heading of a page.
///
/// # Errors
/// A run that cannot be simulated with one of the motors.
pub(super) fn lay_out(
    page: &mut Page,
    diagnosis: &Diagnosis,
    runs: &[Run],
    held_out: &[Run],
) -> Result<(), SimulationError> {
    let laid = lay(diagnosis, runs)?;
    checks(page, &diagnosis.data);
    let said = diagnosis.parts.iter().map(String::as_str);
    page.parts(&PARTS.into_iter().zip(said).collect::<Vec<_>>());
    if let Some(note) = words::note_beside(diagnosis) {
        page.note(&note);
    }
    if let Some(reference) = &diagnosis.reference {
        page.note(&words::of_reference(reference));
    }
    for id in strongest(diagnosis) {
        if let Some(kind) = words::kind(id) {
            page.note(&format!("{id}: {} ({}).", kind.summary, kind.equation));
        }
    }
    let measured = if held_out.is_empty() { runs } else { held_out };
    before_and_after(page, diagnosis, measured);
    how_far(page, diagnosis);
    place::section(page, diagnosis, &laid);
    which(page, diagnosis);
    parameters::section(page, diagnosis);
    next_experiment(page, diagnosis);
    page.section("Motor with what was found");
    page.note("A motor file for simulate and compare; diagnose writes it with --model-out.");
    if diagnosis.fitted_nominal.is_some() {
        page.note(
            "Its resistance and torque constant are assumed: nobody measured them, and these runs do not tell them. Torques and inertia are in proportion.",
        );
    }
    page.verbatim(&diagnosis.model.to_toml());
    page.note(&format!(
        "The diagnosis took {}\u{a0}s.",
        figure(diagnosis.elapsed_s, 2)
    ));
    Ok(())
}

fn before_and_after(page: &mut Page, diagnosis: &Diagnosis, measured: &[Run]) {
    page.section("Before and after");
    page.note(&format!(
        "Every piece, about {} s long, from its own measured start: the position error below is that of the bars. Gap: recorded less predicted position. {}.",
        figure(diagnosis.gap.horizon_s, 2),
        capital(&diagnosis.gap.held_out)
    ));
    let names = names(measured);
    for beside in Beside::all(diagnosis, measured) {
        page.subsection(&names[beside.predicted.run]);
        page.figure(
            &overlay::figure(&beside),
            OVERLAY,
            &overlay::caption(&beside),
        );
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

fn how_far(page: &mut Page, diagnosis: &Diagnosis) {
    let gap = &diagnosis.gap;
    page.section("How far the gap shrinks");
    page.bars(
        &rungs(diagnosis),
        "Position error on data kept from the fit, counts RMS over pieces, with 95 % intervals; the scale is logarithmic.",
    );
    if words::best_set(diagnosis).is_empty() {
        page.paragraph("No effect is added: what shrinks is what other numbers shrink.");
    }
    page.paragraph(&closed_words(gap));
    let fitted = [
        gap.fitted.before,
        gap.fitted.after_parameters,
        gap.fitted.after_effect,
    ];
    let fitted = words::models(diagnosis).into_iter().zip(fitted);
    let fitted: Vec<String> = fitted
        .map(|(name, left)| format!("{name} {}", figure(left, 3)))
        .collect();
    page.note(&format!(
        "On the very data that was fitted the models leave: {}.",
        fitted.join(", ")
    ));
}

fn which(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Which effect");
    let (listed, others) = split(&diagnosis.causes);
    let rows: Vec<Vec<String>> = listed
        .iter()
        .map(|cause| {
            vec![
                cause_words(&cause.effect),
                cause.stage.clone().unwrap_or_else(|| "\u{2013}".to_owned()),
                probability(cause.probability),
                probability(cause.inclusion),
                tie_words(cause),
                cause.evidence.map_or_else(
                    || "\u{2013}".to_owned(),
                    |found| {
                        format!(
                            "{} \u{b1} {}, in {} of {} pieces",
                            figure(found.gain_nats, 3),
                            figure(found.error_nats, 2),
                            found.gaining_pieces,
                            found.pieces
                        )
                    },
                ),
            ]
        })
        .collect();
    page.sortable(
        &[
            "cause",
            "stage",
            "probability",
            "is there at all",
            "fits as well",
            "evidence (nats)",
        ],
        &rows,
    );
    page.note(
        "The probabilities of all causes add to 1; several effects at once are one cause. An effect that is there at all is there alone, with others or beside something unknown. Evidence: what a cause gains on pieces that it was not fitted to; three nats are a factor of twenty. A click on a column's name sorts.",
    );
    if !others.is_empty() {
        let total: f64 = others.iter().map(|cause| cause.probability).sum();
        page.note(&format!(
            "{} further causes together: {}.",
            others.len(),
            probability(total)
        ));
    }
    if diagnosis.sets.len() > 1 {
        page.subsection("Sets of effects that were weighed");
        let rows: Vec<Vec<String>> = diagnosis
            .sets
            .iter()
            .take(LISTED)
            .map(|set| {
                vec![
                    effects_words(&set.effects),
                    probability(set.probability),
                    figure(set.behind_nats, 3),
                ]
            })
            .collect();
        page.table(&["set", "probability", "behind the best (nats)"], &rows);
    }
}

/// Causes that are listed, those that are there beside something unknown among them, and the others.
fn split(causes: &[Cause]) -> (Vec<&Cause>, Vec<&Cause>) {
    let mut listed = Vec::new();
    let mut others = Vec::new();
    for (place, cause) in causes.iter().enumerate() {
        if place < LISTED || cause.probability.max(cause.inclusion) >= LISTED_FROM {
            listed.push(cause);
        } else {
            others.push(cause);
        }
    }
    (listed, others)
}

fn tie_words(cause: &Cause) -> String {
    if cause.indistinguishable_from.is_empty() {
        return "\u{2013}".to_owned();
    }
    cause.indistinguishable_from.join(", ")
}

/// What is wrong with the recordings comes first: nothing else means much before it is mended.
pub fn checks(page: &mut Page, findings: &[Finding]) {
    if findings.is_empty() {
        page.note("motorlab check finds nothing wrong with the recordings.");
        return;
    }
    page.subsection("What is found in the recordings");
    let rows: Vec<Vec<String>> = findings
        .iter()
        .map(|found| {
            vec![
                found.run.clone(),
                found.severity.word().to_owned(),
                found.id().replace('_', " "),
                found.message.clone(),
                found.remedy.clone(),
            ]
        })
        .collect();
    page.table(
        &["run", "weight", "finding", "what was found", "what to do"],
        &rows,
    );
}

fn next_experiment(page: &mut Page, diagnosis: &Diagnosis) {
    if let Some(means) = other_means(diagnosis) {
        page.section("What to measure next");
        page.paragraph(&means);
    }
    let Some(next) = &diagnosis.next_experiment else {
        return;
    };
    page.section("What to record next");
    page.paragraph(&format!(
        "This profile{} tells {} apart by at least {} standard deviations:",
        next.change.as_ref().map_or(String::new(), |change| format!(
            ", with {},",
            change.words()
        )),
        words::few_words(&next.tells_apart),
        figure(next.expected_separation, 2)
    ));
    page.verbatim(&next.command);
    let flag = next
        .change
        .as_ref()
        .and_then(|change| change.flag("next.csv"));
    page.note(&format!(
        "PORT is the board's; then diagnose the new run together with the old ones{}.",
        flag.map_or(String::new(), |flag| format!(", with {flag}"))
    ));
}
