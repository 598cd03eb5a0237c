//! A diagnosis on the terminal, in short.

use super::design::next_line;
use super::{Failure, Output};
use crate::diagnose::{Cause, Diagnosis, other_means};
use crate::report::Bars;
use crate::report::diagnosis::{cause_words, of_reference, rungs};
use crate::report::number::{figure, percent, probability};

/// How many causes and stretches are listed.
const LISTED: usize = 5;
/// Width of a bar in characters.
const BAR: usize = 24;
/// Effects that are there at all with this probability are listed in any case, with it.
const BESIDE_FROM: f64 = 0.5;
/// Causes that are there with less than this probability have their numbers left out.
const NUMBERS_FROM: f64 = 0.02;

/// Writes the short form.
pub(super) fn show(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    output.line(&diagnosis.sentence)?;
    if !diagnosis.note.is_empty() {
        output.line(&diagnosis.note)?;
    }
    if let Some(reference) = &diagnosis.reference {
        output.line(&of_reference(reference))?;
    }
    let gap = &diagnosis.gap;
    output.line("\nposition error on data kept from the fit, with 95 % intervals (logarithmic)")?;
    for line in bars(&rungs(diagnosis)) {
        output.line(&line)?;
    }
    output.line(&format!(
        "  closed {:.1} % (95 %: {:.1} to {:.1}); {}",
        100.0 * gap.closed,
        100.0 * gap.closed_lo95,
        100.0 * gap.closed_hi95,
        gap.held_out
    ))?;
    output.line(&format!(
        "  the gap is {} of the travel of a piece, {} counts in {} s",
        percent(gap.before / gap.travel.max(f64::MIN_POSITIVE)),
        figure(gap.travel, 4),
        figure(gap.horizon_s, 3)
    ))?;
    output.line("\ncauses")?;
    let listed = diagnosis.causes.iter().enumerate();
    for (_, cause) in
        listed.filter(|(place, cause)| *place < LISTED || cause.inclusion >= BESIDE_FROM)
    {
        causes(cause, output)?;
    }
    if !diagnosis.place.regions.is_empty() {
        output.line("\nwhere")?;
    }
    for region in diagnosis.place.regions.iter().take(LISTED) {
        output.line(&format!(
            "  {:>4.0} %  {} from {:.2} s to {:.2} s, {}",
            100.0 * region.share,
            region.regime.words(),
            region.from_s,
            region.to_s,
            region.run
        ))?;
    }
    if let Some(next) = &diagnosis.next_experiment {
        output.line(&format!("\n{}", next_line(next)))?;
    }
    if let Some(means) = other_means(diagnosis) {
        output.line(&format!("\n{means}"))?;
    }
    Ok(())
}

fn causes(cause: &Cause, output: &Output) -> Result<(), Failure> {
    let mut line = format!(
        "  {:>8}  {}",
        probability(cause.probability),
        cause_words(&cause.effect)
    );
    if cause.inclusion >= BESIDE_FROM && cause.inclusion > cause.probability + 0.01 {
        line.push_str(&format!(
            "; is there at all: {}",
            probability(cause.inclusion)
        ));
    }
    if !cause.indistinguishable_from.is_empty() {
        line.push_str(&format!(
            "; not told from {}",
            cause.indistinguishable_from.join(", ")
        ));
    }
    output.line(&line)?;
    if cause.inclusion < NUMBERS_FROM {
        return Ok(());
    }
    for (name, number) in &cause.parameters {
        let ends = if number.lo95 == number.hi95 {
            "held".to_owned()
        } else {
            format!(
                "95 %: {} to {}",
                figure(number.lo95, 4),
                figure(number.hi95, 4)
            )
        };
        let then = number.reference.map_or_else(String::new, |then| {
            format!("; {} in the reference", figure(then, 4))
        });
        output.line(&format!(
            "            {name} = {} {} ({ends}{then})",
            figure(number.value, 4),
            number.unit
        ))?;
    }
    Ok(())
}

/// Bars as lines of blocks.
fn bars(bars: &Bars) -> Vec<String> {
    let widest = bars.bars.iter().map(|bar| bar.name.chars().count()).max();
    let widest = widest.unwrap_or(0);
    bars.bars
        .iter()
        .map(|bar| {
            let eighths = (bars.scale.share(bar.value) * (8 * BAR) as f64).round() as usize;
            let mut blocks = "\u{2588}".repeat(eighths / 8);
            if let Some(part) = (eighths % 8).checked_sub(1) {
                blocks.extend(
                    [
                        '\u{258f}', '\u{258e}', '\u{258d}', '\u{258c}', '\u{258b}', '\u{258a}',
                        '\u{2589}',
                    ]
                    .get(part),
                );
            }
            let name = &bar.name;
            format!("  {name:<widest$}  {blocks:<BAR$}  {}", bar.text)
        })
        .collect()
}
