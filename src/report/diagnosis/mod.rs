//! The page of a diagnosis: sentence, error budget, causes, sets, identifiable parameters, recorded and simulated
//! runs, the location of the error, the next experiment.

mod bad_recording;
mod budget;
mod ordered;
mod overlaid_run;
mod overlay;
mod parameters;
mod place;
mod residual;
mod spread;
mod words;

use super::number::{figure, percent, probability};
use super::{Figure, Page, Size};
use crate::check::Finding;
use crate::diagnose::{Cause, Diagnosis, EffectSet};
use crate::motor::SimulationError;
use crate::recording::Run;
use overlaid_run::{lay, names};
use overlay::RunWithModels;

pub use bad_recording::{bad_recording_page, recorded};
pub use budget::{BUDGET_COLUMNS, budget_bars, budget_note, budget_rows};
pub use overlay::recorded_speed;
pub use words::{
    DETAILED_FROM, cause_words, causes_note, causes_title, class_of_cause, class_words,
    discrete_words, effects_words, few_words, fitted_words, hypotheses, interval_words,
    is_optional, measured, motor_file_column, named_parts, no_recording, of_reference,
    parameters_note, sets_note, value_column,
};

/// One run, recorded and simulated.
pub struct RunOverlay {
    /// Name of the run.
    pub name: String,
    /// Speed, position, error and command.
    pub figure: Figure,
    /// The error of each model.
    pub caption: String,
    /// Whether its speed is a mean over several samples.
    pub is_smoothed: bool,
    /// Spectrum and autocorrelation of the last model's residual.
    pub residual: Vec<Figure>,
    /// RMS error of the nominal model in counts.
    pub nominal_rms: f64,
}

/// The runs of the error budget, recorded and simulated.
pub fn overlays(diagnosis: &Diagnosis, measured: &[Run]) -> Vec<RunOverlay> {
    let names = names(measured);
    let all = RunWithModels::all(diagnosis, measured);
    let spreads = overlay::ErrorSpreads::of(&all);
    all.iter()
        .map(|beside| RunOverlay {
            name: names[beside.predicted.run].clone(),
            figure: overlay::figure(beside, &spreads),
            caption: overlay::caption(beside),
            is_smoothed: overlay::is_coarse(beside.run),
            residual: residual::figures(beside),
            nominal_rms: beside.predicted.rms(0),
        })
        .collect()
}

/// The smoothing of the speeds, once for all runs; `None` without any.
pub fn smoothing_words(overlays: &[RunOverlay]) -> Option<String> {
    let smoothed = overlays.iter().filter(|overlay| overlay.is_smoothed);
    let names: Vec<&str> = smoothed.map(|overlay| overlay.name.as_str()).collect();
    let of = match names.len() {
        0 => return None,
        n if n == overlays.len() => String::new(),
        _ => format!(" of {}", names.join(", ")),
    };
    Some(format!(
        "Speed{of} is averaged over 60 ms, because one count more in a sample is a large step of speed."
    ))
}

/// Most sets of effects listed.
const LISTED_SETS: usize = 10;

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

/// As [`page`], with the error measured on held-out runs.
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

/// The content of a diagnosis below a page's heading.
///
/// # Errors
/// A run that cannot be simulated with one of the motors.
pub(super) fn lay_out(
    page: &mut Page,
    diagnosis: &Diagnosis,
    runs: &[Run],
    held_out: &[Run],
) -> Result<(), SimulationError> {
    let measured = if held_out.is_empty() { runs } else { held_out };
    let laid = lay(diagnosis, measured)?;
    page.parts(&named_parts(diagnosis));
    if !diagnosis.note.is_empty() {
        page.note(&diagnosis.note);
    }
    if let Some(reference) = &diagnosis.reference {
        page.note(&of_reference(diagnosis, reference));
    }
    checks(page, &diagnosis.data);
    page.section("Error budget");
    page.bars(&budget_bars(diagnosis), &budget_note(diagnosis));
    recorded_over_simulated(page, diagnosis, measured);
    budget_in_numbers(page, diagnosis);
    causes(page, diagnosis);
    sets(page, diagnosis);
    parameters::of_motor(page, diagnosis);
    place::section(page, diagnosis, &laid);
    next_experiment(page, diagnosis);
    page.section("Motor file of the verdict");
    if diagnosis.has_torque() {
        page.note("For the commands simulate and compare; diagnose writes it with --model-out.");
        page.verbatim(&diagnosis.model.to_toml());
    } else {
        page.note(
            "diagnose writes it with --model-out, for the commands simulate and compare. It has to assume a resistance, and says so in its first lines; it is not printed here, since no recording determines those numbers.",
        );
    }
    page.note(&format!(
        "The diagnosis took {}\u{a0}s.",
        figure(diagnosis.elapsed_s, 2)
    ));
    Ok(())
}

fn budget_in_numbers(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Error budget in numbers");
    let rows = budget_rows(diagnosis);
    let columns = rows.first().map_or(0, Vec::len);
    page.table(&BUDGET_COLUMNS[..columns], &rows);
    page.note(&measured(diagnosis));
    page.note(&fitted_words(diagnosis));
    let unexplained = &diagnosis.unexplained;
    page.note(&format!(
        "Unexplained: {} counts RMS above the noise floor, as a random load torque of {} of stall would leave.",
        figure(unexplained.rms_counts, 3),
        percent(unexplained.equivalent_torque_share)
    ));
}

fn causes(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Causes by inclusion probability");
    if diagnosis.causes.is_empty() {
        page.paragraph("No effect has an inclusion probability of 0.01 or more.");
        return;
    }
    for class in &diagnosis.classes {
        let members = class_words(class);
        page.paragraph(&format!("These recordings do not separate {members}."));
    }
    let row = |cause: &Cause| {
        let class =
            class_of_cause(cause, &diagnosis.settings).unwrap_or_else(|| "\u{2013}".to_owned());
        let reason = cause
            .not_identified(&diagnosis.settings)
            .unwrap_or("\u{2013}");
        vec![
            cause_words(cause.effect),
            probability(cause.inclusion),
            cause.stage.to_owned(),
            class,
            reason.to_owned(),
        ]
    };
    let rows: Vec<Vec<String>> = diagnosis.causes.iter().map(row).collect();
    page.sortable(
        &[
            "effect",
            "inclusion probability",
            "stage",
            "class",
            "not identified, since",
        ],
        &rows,
    );
    let note = format!(
        "Inclusion probability: {}, the sum over all sets that contain the effect. A click on a column's name sorts. {}",
        causes_title(diagnosis),
        causes_note(diagnosis)
    );
    page.note(note.trim_end());
    for id in words::explained(diagnosis) {
        if let Some(kind) = words::kind(id) {
            page.note(&format!("{id}: {}.", words::equation(diagnosis, kind)));
        }
    }
    parameters::of_effects(page, diagnosis);
}

fn sets(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Sets of effects");
    let row = |set: &EffectSet| {
        vec![
            effects_words(&set.effects),
            probability(set.probability),
            figure(set.score, 4),
            figure(set.rms_counts, 3),
        ]
    };
    let listed = diagnosis.sets.iter().take(LISTED_SETS);
    let rows: Vec<Vec<String>> = listed.map(row).collect();
    page.table(
        &[
            "set",
            "posterior probability",
            "log score (nats)",
            "RMS on the fitted segments (counts)",
        ],
        &rows,
    );
    page.note(&sets_note(diagnosis));
    let further = diagnosis.sets.iter().skip(LISTED_SETS);
    let (count, rest) = further.fold((0, 0.0), |(n, p), set| (n + 1, p + set.probability));
    if count > 0 {
        page.note(&format!(
            "{count} further sets have a probability of {} together.",
            probability(rest)
        ));
    }
}

fn recorded_over_simulated(page: &mut Page, diagnosis: &Diagnosis, measured: &[Run]) {
    page.section("Recorded and simulated");
    page.note(
        "Each segment is predicted from its measured initial state, as in the error budget; it begins at a dashed vertical line, where the curves of the models are broken. Error: recorded minus predicted position. Band: 95 % of the errors at this time since the start of a segment, over all segments.",
    );
    let mut overlays = overlays(diagnosis, measured);
    overlays.sort_by(|a, b| b.nominal_rms.total_cmp(&a.nominal_rms));
    if let Some(words) = smoothing_words(&overlays) {
        page.note(&words);
    }
    let further = overlays.split_off(overlays.len().min(1));
    for overlay in &overlays {
        one_run(page, overlay);
    }
    let summary = match further.len() {
        0 => return,
        1 => "One further run, with a smaller error".to_owned(),
        n => format!("{n} further runs, with smaller errors"),
    };
    page.folded(&summary, |page| {
        for overlay in &further {
            one_run(page, overlay);
        }
    });
}

fn one_run(page: &mut Page, overlay: &RunOverlay) {
    page.subsection(&overlay.name);
    page.figure(&overlay.figure, OVERLAY, &overlay.caption);
    if overlay.residual.is_empty() {
        return;
    }
    page.folded("Spectrum and autocorrelation of the residual", |page| {
        page.figures(overlay.residual.iter().map(|figure| (figure, "")));
        page.note("Of the last model's held-out residual, over the segments of this run. Of a white residual 95 % of the correlations lie between the dashed lines.");
    });
}

/// Findings of `check` about the recordings.
pub fn checks(page: &mut Page, findings: &[Finding]) {
    if findings.is_empty() {
        page.note("motorlab check finds nothing wrong with the recordings.");
        return;
    }
    page.subsection("Findings about the recordings");
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
        &["run", "severity", "finding", "description", "remedy"],
        &rows,
    );
}

fn next_experiment(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Next experiment");
    let Some(next) = &diagnosis.next_experiment else {
        page.paragraph(&no_recording(diagnosis));
        return;
    };
    let change = next.change.as_ref();
    let optional = if is_optional(diagnosis) {
        "Optional, since the parameters explain the error. "
    } else {
        ""
    };
    page.paragraph(&format!(
        "{optional}This recording{} would separate these hypotheses: {} (each pair by at least {} standard deviations of the noise).",
        change.map_or(String::new(), |change| format!(
            " with {}",
            change.words()
        )),
        hypotheses(&next.named(diagnosis.verdict)),
        figure(next.expected_separation, 2)
    ));
    page.verbatim(&next.command);
    let flag = change.and_then(|change| change.flag("next.csv"));
    page.note(&format!(
        "PORT is the board's port. Diagnose the new run together with the old ones{}.",
        flag.map_or(String::new(), |flag| format!(", with {flag}"))
    ));
}
