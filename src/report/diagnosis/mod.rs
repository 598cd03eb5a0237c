//! A diagnosis as one offline page: the sentence, before and after, how far, where, which, what next.

mod laid;
mod ordered;
mod overlay;
mod place;
mod words;

use super::number::{figure, percent, probability};
use super::{Page, Size};
use crate::check::Finding;
use crate::diagnose::{Cause, Diagnosis, Interval, other_means};
use crate::export::PARAMETERS;
use crate::motor::SimulationError;
use crate::recording::Run;
use laid::{LaidRun, lay};

pub use words::{cause_words, effects_words, of_reference, rungs, seen_words, strongest};

/// Causes below this probability are summed up instead of listed, where others are above.
const LISTED_FROM: f64 = 0.001;
/// So many causes are listed in any case.
const LISTED: usize = 5;
/// A cause from this probability on has its numbers shown.
const NUMBERS_FROM: f64 = 0.05;

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
    let laid = lay(diagnosis, runs)?;
    let mut page = Page::new(title);
    page.lead(&diagnosis.sentence);
    if !diagnosis.note.is_empty() {
        page.note(&diagnosis.note);
    }
    if let Some(reference) = &diagnosis.reference {
        page.note(&words::of_reference(reference));
    }
    for id in strongest(diagnosis) {
        if let Some(kind) = words::kind(id) {
            page.note(&format!("{id}: {} ({}).", kind.summary, kind.equation));
        }
    }
    before_and_after(&mut page, &laid);
    how_far(&mut page, diagnosis);
    place::section(&mut page, diagnosis, &laid);
    which(&mut page, diagnosis);
    parameters(&mut page, diagnosis);
    checks(&mut page, &diagnosis.data);
    next_experiment(&mut page, diagnosis);
    page.section("Motor with what was found");
    page.note("A motor file for simulate and compare; diagnose writes it with --model-out.");
    page.verbatim(&diagnosis.model.to_toml());
    page.note(&format!(
        "The diagnosis took {}\u{a0}s.",
        figure(diagnosis.elapsed_s, 2)
    ));
    Ok(page.finish())
}

fn before_and_after(page: &mut Page, laid: &[LaidRun<'_>]) {
    page.section("Before and after");
    page.note(
        "Every run in open loop from rest, with the numbers that fit all runs best. Gap: recorded less simulated position.",
    );
    for run in laid {
        page.subsection(&run.name);
        page.figure(&overlay::figure(run), OVERLAY, &overlay::caption(run));
    }
}

fn how_far(page: &mut Page, diagnosis: &Diagnosis) {
    let gap = &diagnosis.gap;
    page.section("How far the gap shrinks");
    page.bars(
        &rungs(diagnosis),
        "Position error on data kept from the fit, counts RMS, with 95 % intervals; the scale is logarithmic.",
    );
    if words::best_set(diagnosis).is_empty() {
        page.paragraph("No effect is added: what closes is what refitting closes.");
    }
    page.paragraph(&format!(
        "Closed: {} of the gap above the floor (95 % interval {} to {}).",
        percent(gap.closed),
        percent(gap.closed_lo95),
        percent(gap.closed_hi95)
    ));
    page.note(&format!("Held out: {}.", gap.held_out));
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
                            "{} \u{b1} {} nats, in {} of {} pieces",
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
    page.table(
        &[
            "cause",
            "stage",
            "probability",
            "is there at all",
            "not told from",
            "gains on pieces not fitted",
        ],
        &rows,
    );
    page.note(
        "The probabilities of all causes add to 1; several effects at once are one cause. An effect that is there at all is there alone, with others or beside something unknown.",
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

fn parameters(page: &mut Page, diagnosis: &Diagnosis) {
    let whose = words::whose(diagnosis);
    page.section("Parameters");
    let best = words::best_set(diagnosis).join("+");
    let shown = |cause: &&Cause| cause.effect == best || cause.inclusion >= NUMBERS_FROM;
    let beside = |mut row: Vec<String>, then: Option<f64>| {
        if diagnosis.reference.is_some() {
            let then = then.map_or_else(|| "\u{2013}".to_owned(), |then| figure(then, 4));
            row.insert(1, then);
        }
        row
    };
    let mut rows = Vec::new();
    for cause in diagnosis.causes.iter().filter(shown) {
        for (name, interval) in &cause.parameters {
            let row = vec![
                format!("{}: {name}", cause.effect),
                figure(interval.value, 4),
                ends(interval, 1.0),
                unit(interval.unit),
            ];
            rows.push(beside(row, interval.reference));
        }
    }
    for (key, ratio) in &diagnosis.base {
        let of_nominal = diagnosis.nominal.parameters.get(key);
        let Some(value) = of_nominal.filter(|value| *value != 0.0) else {
            continue;
        };
        let named = PARAMETERS.iter().find(|named| named.key == *key);
        let row = vec![
            format!("{key} ({} of the {whose})", percent(ratio.value)),
            figure(ratio.value * value, 4),
            ends(ratio, value),
            unit(named.map_or("", |named| named.unit)),
        ];
        rows.push(beside(row, Some(value)));
    }
    let mut names = vec!["parameter", "value", "95\u{a0}% interval", "unit"];
    if diagnosis.reference.is_some() {
        names.insert(1, "in the reference");
    }
    page.table(&names, &rows);
    page.note(
        "An effect's numbers are those of the likeliest set that has it. Voltage in and position out tell inertia, back EMF and friction only as seen from the terminals: resistance and torque constant are held, and the motor's numbers take up what these have.",
    );
}

fn ends(interval: &Interval, scale: f64) -> String {
    if interval.lo95 == interval.hi95 {
        return "held".to_owned();
    }
    format!(
        "{} to {}",
        figure(interval.lo95 * scale, 4),
        figure(interval.hi95 * scale, 4)
    )
}

fn unit(unit: &str) -> String {
    if unit.is_empty() { "1" } else { unit }.to_owned()
}

fn checks(page: &mut Page, findings: &[Finding]) {
    page.section("Checks of the recordings");
    if findings.is_empty() {
        page.paragraph("motorlab check finds nothing.");
        return;
    }
    let rows: Vec<Vec<String>> = findings
        .iter()
        .map(|found| {
            vec![
                found.run.clone(),
                found.id().replace('_', " "),
                found.message.clone(),
                found.remedy.clone(),
            ]
        })
        .collect();
    page.table(&["run", "finding", "what was found", "what to do"], &rows);
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
        next.tells_apart.join(", "),
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
