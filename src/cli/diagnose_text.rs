//! A diagnosis on the terminal, in the order of its page.

use super::picture::on_terminal;
use super::{Failure, Output};
use crate::diagnose::{Cause, Diagnosis, EffectSet, LEAST_PRINTED, NominalFit};
use crate::plain::one_line;
use crate::recording::Run;
use crate::report::diagnosis::{
    BUDGET_COLUMNS, DETAILED_FROM, budget_bars, budget_note, budget_rows, cause_words, causes_note,
    causes_title, class_of_cause, class_words, discrete_words, effects_words, fitted_words,
    hypotheses, interval_words, is_optional, measured, motor_file_column, named_parts,
    no_recording, of_reference, overlays, parameters_note, sets_note, smoothing_words,
    value_column,
};
use crate::report::number::{figure, percent, probability};
use crate::report::table::Table;

/// Most causes, sets and time intervals listed.
const LISTED: usize = 5;
/// Least inclusion probability of effects that are always listed.
const LISTED_FROM: f64 = 0.05;
/// Width of a bar in characters.
const BAR: usize = 24;

/// Prints sentence, error budget, causes, sets, identifiable parameters, recorded and simulated runs, the location of
/// the error and the next experiment; `recorded` are the runs of the budget.
pub(super) fn show(
    diagnosis: &Diagnosis,
    recorded: &[Run],
    output: &Output,
) -> Result<(), Failure> {
    for (k, (name, part)) in named_parts(diagnosis).into_iter().enumerate() {
        if k > 0 {
            output.line("")?;
        }
        output.line(&name.to_uppercase())?;
        output.line(&part)?;
    }
    if !diagnosis.note.is_empty() {
        output.line(&format!("\n{}", diagnosis.note))?;
    }
    if let Some(reference) = &diagnosis.reference {
        output.line(&format!("\n{}", of_reference(diagnosis, reference)))?;
    }
    output.line("\nERROR BUDGET")?;
    budget(diagnosis, output)?;
    output.line(&format!("\nCAUSES ({})", causes_title(diagnosis)))?;
    for class in &diagnosis.classes {
        output.line(&format!("  not separated: {}", class_words(class)))?;
    }
    let is_listed =
        |(place, cause): &(usize, &Cause)| *place < LISTED || cause.inclusion >= LISTED_FROM;
    let listed = diagnosis.causes.iter().enumerate().filter(is_listed);
    for (_, cause) in listed {
        one_cause(diagnosis, cause, output)?;
    }
    let note = causes_note(diagnosis);
    if !note.is_empty() {
        output.line(&format!("  {note}"))?;
    }
    output.line("\nSETS OF EFFECTS")?;
    let listed = &diagnosis.sets[..diagnosis.sets.len().min(LISTED)];
    output.line(&sets(listed, diagnosis))?;
    output.line("IDENTIFIABLE PARAMETERS")?;
    identifiable(diagnosis, output)?;
    output.line("\nRECORDED AND SIMULATED")?;
    over_simulated(diagnosis, recorded, output)?;
    output.line("\nWHERE THE ERROR LIES")?;
    place(diagnosis, output)?;
    output.line("\nNEXT EXPERIMENT")?;
    next(diagnosis, output)
}

/// Prints the search, all sets with their scores, and the terms of the scores.
pub(super) fn explain(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    output.line("\nSEARCH (log score in nats; screened: predicted change if an effect is added, from one initial value, before it is fitted; an effect may be listed for several initial values)")?;
    for step in &diagnosis.steps {
        output.line(step.to_string().trim_end())?;
    }
    output.line("\nALL SETS")?;
    output.line(&sets(&diagnosis.sets, diagnosis))?;
    let scoring = &diagnosis.scoring;
    output.line(&format!(
        "  score: {}; effective number of observations {}; random load torque {} of stall; whitened residual variance {} times its expectation (near 1: the noise model is adequate)",
        scoring.score.replace('_', " "),
        figure(scoring.effective_observations, 4),
        percent(scoring.random_load_share),
        figure(scoring.whitened_squares, 3)
    ))?;
    output.line(&format!("  {}", fitted_words(diagnosis)))
}

/// Residuals of the nominal fit, of its initial motor, and of a shaft at rest.
pub(super) fn nominal_fit_words(fit: &NominalFit) -> String {
    let given = match fit.given_left_counts {
        Some(left) => format!("{left:.2} with the initial parameter values"),
        None => "the initial parameter values cannot be simulated".to_owned(),
    };
    let motor = match fit.is_given {
        true => "the given motor, since no fit leaves less",
        false => "fitted to these runs without effects",
    };
    format!(
        "nominal motor: {motor}; RMS error of whole runs without restarts {:.2} counts ({given}; {:.1} for a motor that stays at rest)",
        fit.left_counts, fit.at_rest_counts
    )
}

fn budget(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    let bars = budget_bars(diagnosis);
    let rows = budget_rows(diagnosis);
    let mut names = BUDGET_COLUMNS[..rows.first().map_or(0, Vec::len)].to_vec();
    names.insert(names.len().min(4), "");
    let mut table = Table::new(names);
    for (mut row, bar) in rows.into_iter().zip(&bars.bars) {
        row.insert(4, blocks(bars.scale.share(bar.value)));
        table.row(row);
    }
    output.line(table.to_string().trim_end())?;
    output.line(&format!("  {}", budget_note(diagnosis)))?;
    output.line(&format!("  {}", measured(diagnosis)))
}

/// A bar of a share.
fn blocks(share: f64) -> String {
    const PARTS: [char; 7] = [
        '\u{258f}', '\u{258e}', '\u{258d}', '\u{258c}', '\u{258b}', '\u{258a}', '\u{2589}',
    ];
    let eighths = (share * (8 * BAR) as f64).round() as usize;
    let mut blocks = "\u{2588}".repeat(eighths / 8);
    if let Some(part) = (eighths % 8).checked_sub(1) {
        blocks.extend(PARTS.get(part));
    }
    blocks
}

fn one_cause(diagnosis: &Diagnosis, cause: &Cause, output: &Output) -> Result<(), Failure> {
    let mut line = format!(
        "  {:>8}  {} ({})",
        probability(cause.inclusion),
        cause_words(cause.effect),
        cause.stage
    );
    if let Some(class) = class_of_cause(cause, &diagnosis.settings) {
        line.push_str(&format!("; {class}"));
    }
    if let Some(reason) = cause.not_identified(&diagnosis.settings) {
        line.push_str(&format!("; not identified: {reason}"));
    }
    output.line(&line)?;
    if !diagnosis.effects.contains(&cause.effect) && cause.inclusion < DETAILED_FROM {
        return Ok(());
    }
    for (key, number) in &cause.parameters {
        let (name, number) = number.determined(key);
        let reference = number.reference.map_or_else(String::new, |then| {
            format!("; {} in the reference", figure(then, 4))
        });
        let limit = match number.at_bound {
            true => "; at its bound",
            false => "",
        };
        if let Some(words) = discrete_words(name, number.value) {
            output.line(&format!(
                "            {name} = {}: {words}",
                figure(number.value, 4)
            ))?;
            continue;
        }
        let interval = match number.lo95 == number.hi95 {
            true => interval_words(&number),
            false => format!("95 %: {}", interval_words(&number)),
        };
        output.line(&format!(
            "            {name} = {} {} ({interval}{reference}{limit})",
            figure(number.value, 4),
            number.unit,
        ))?;
    }
    Ok(())
}

fn sets(sets: &[EffectSet], diagnosis: &Diagnosis) -> String {
    let mut table = Table::new([
        "probability",
        "log score (nats)",
        "RMS on the fitted segments (counts)",
        "set",
    ]);
    for set in sets {
        table.row([
            probability(set.probability),
            figure(set.score, 4),
            figure(set.rms_counts, 3),
            effects_words(&set.effects),
        ]);
    }
    format!("{table}  {}\n", sets_note(diagnosis))
}

fn identifiable(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    let file = motor_file_column(diagnosis);
    let value = value_column(diagnosis);
    let mut names = vec!["parameter", &value, "95\u{a0}% interval", "unit"];
    if let Some(file) = file {
        names.insert(1, file);
    }
    let mut table = Table::new(names);
    for (name, number, given) in diagnosis.identifiable_rows() {
        let mut row = vec![
            name.to_owned(),
            figure(number.value, 4),
            match number.at_bound {
                true => format!("{}, estimate at its bound", interval_words(&number)),
                false => interval_words(&number),
            },
            number.unit.to_owned(),
        ];
        if file.is_some() {
            row.insert(1, given.map_or_else(String::new, |given| figure(given, 4)));
        }
        table.row(row);
    }
    output.line(table.to_string().trim_end())?;
    output.line(&format!("  {}", parameters_note(diagnosis)))
}

/// The error of each run, and the speed of the run with the largest error.
fn over_simulated(diagnosis: &Diagnosis, recorded: &[Run], output: &Output) -> Result<(), Failure> {
    let overlays = overlays(diagnosis, recorded);
    let largest = (overlays.iter()).max_by(|a, b| a.nominal_rms.total_cmp(&b.nominal_rms));
    if let Some(largest) = largest
        && let Some(speed) = largest.figure.panels.first()
    {
        output.line(&format!("  {}:", one_line(&largest.name)))?;
        output.picture(&on_terminal(speed, &largest.figure.x_label))?;
        output.line(&format!(
            "  Vertical lines of a simulated curve are restarts from the measured state, every {} s (median).",
            figure(diagnosis.gap.horizon_s, 3)
        ))?;
    }
    for overlay in &overlays {
        let name = one_line(&overlay.name);
        output.line(&format!("  {name}: {}", overlay.caption))?;
    }
    match smoothing_words(&overlays) {
        Some(words) => output.line(&format!("  {}", one_line(&words))),
        None => Ok(()),
    }
}

/// The stage of the identified effects; several if the members of their classes differ.
fn stage_words(diagnosis: &Diagnosis, stage: &str) -> String {
    if diagnosis.classes.is_empty() {
        return format!("stage of the signal chain: {stage}");
    }
    let probable = diagnosis.place.stage_probabilities.iter();
    let probable = probable.filter(|(_, p)| **p >= DETAILED_FROM);
    let stages: Vec<String> = probable
        .map(|(stage, p)| format!("{stage} {}", probability(*p)))
        .collect();
    format!(
        "probability that an effect is in a stage: {}",
        stages.join(", ")
    )
}

fn place(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    if let Some(stage) = &diagnosis.place.stage {
        output.line(&format!("  {}", stage_words(diagnosis, stage)))?;
    }
    if diagnosis.place.regions.is_empty() || diagnosis.unexplained.share < LEAST_PRINTED {
        return output.line("  no significant error above the noise floor remains");
    }
    for region in diagnosis.place.regions.iter().take(LISTED) {
        output.line(&format!(
            "  {:>8}  {} from {:.2} s to {:.2} s, {}",
            percent(region.share),
            region.regime.words(),
            region.from_s,
            region.to_s,
            one_line(&region.run)
        ))?;
    }
    output.line("  shares of the unexplained squared error, the largest first")
}

fn next(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    let Some(next) = &diagnosis.next_experiment else {
        return output.line(&format!("  {}", no_recording(diagnosis)));
    };
    let change = next.change.as_ref();
    let change = change.map_or_else(String::new, |change| format!(" with {}", change.words()));
    let optional = match is_optional(diagnosis) {
        true => "Optional, since the parameters explain the error. ",
        false => "",
    };
    output.line(&format!(
        "  {optional}`{}`{change} would separate these hypotheses: {} (each pair by at least {} standard deviations of the noise). PORT is the board's port.",
        next.command,
        hypotheses(&next.named(diagnosis.verdict)),
        figure(next.expected_separation, 2)
    ))
}
