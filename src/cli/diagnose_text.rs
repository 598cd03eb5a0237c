//! A diagnosis on the terminal, in short.

use super::{Failure, Output};
use crate::diagnose::{Cause, Diagnosis};
use crate::plain::one_line;
use crate::report::Bars;
use crate::report::diagnosis::{
    PARTS, cause_words, closed_words, few_words, note_beside, of_reference, rungs, seen_name,
    seen_scale,
};
use crate::report::number::{figure, probability};

/// How many causes and stretches are listed.
const LISTED: usize = 5;
/// Width of a bar in characters.
const BAR: usize = 24;
/// Effects that are there at all with this probability are listed in any case, with it.
const BESIDE_FROM: f64 = 0.5;
/// Causes that are there with less than this probability have their numbers left out.
const NUMBERS_FROM: f64 = 0.02;

/// Writes the short form: the four parts of the sentence, each with its figures.
pub(super) fn show(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    let gap = &diagnosis.gap;
    let part = |k: usize| {
        if k > 0 {
            output.line("")?;
        }
        output.line(&PARTS[k].to_uppercase())?;
        output.line(&diagnosis.parts[k])
    };
    part(0)?;
    output.line(&format!(
        "  a piece is {} s long and travels {} counts",
        figure(gap.horizon_s, 3),
        figure(gap.travel, 4)
    ))?;
    if let Some(note) = note_beside(diagnosis) {
        output.line(&note)?;
    }
    if let Some(reference) = &diagnosis.reference {
        output.line(&of_reference(reference))?;
    }
    part(1)?;
    let listed = diagnosis.causes.iter().enumerate();
    for (_, cause) in
        listed.filter(|(place, cause)| *place < LISTED || cause.inclusion >= BESIDE_FROM)
    {
        causes(diagnosis, cause, output)?;
    }
    if !diagnosis.place.regions.is_empty() {
        output.line("  where it arises")?;
    }
    for region in diagnosis.place.regions.iter().take(LISTED) {
        output.line(&format!(
            "  {:>6.0} %  {} from {:.2} s to {:.2} s, {}",
            100.0 * region.share,
            region.regime.words(),
            region.from_s,
            region.to_s,
            one_line(&region.run)
        ))?;
    }
    part(2)?;
    output.line(
        "  position error over pieces kept from the fit, with 95 % intervals (logarithmic)",
    )?;
    for line in bars(&rungs(diagnosis)) {
        output.line(&line)?;
    }
    output.line(&format!("  {}", closed_words(gap)))?;
    output.line(&format!("  held out: {}", gap.held_out))?;
    part(3)?;
    if let Some(next) = &diagnosis.next_experiment {
        output.line(&format!(
            "  {}profile {} for {} s is expected to part {} by {} standard deviations at least",
            if diagnosis.parts[3].contains(&next.command) {
                ""
            } else {
                "to be surer: "
            },
            next.profile,
            figure(next.duration_s, 3),
            few_words(&next.tells_apart),
            figure(next.expected_separation, 2)
        ))?;
    }
    Ok(())
}

fn causes(diagnosis: &Diagnosis, cause: &Cause, output: &Output) -> Result<(), Failure> {
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
            "; fits as well: {}",
            cause.indistinguishable_from.join(", ")
        ));
    }
    output.line(&line)?;
    if cause.inclusion < NUMBERS_FROM {
        return Ok(());
    }
    for (name, number) in &cause.parameters {
        let (scale, unit) = seen_scale(diagnosis, number.unit);
        let value = |value: f64| figure(value * scale, 4);
        let ends = if number.lo95 == number.hi95 {
            "held".to_owned()
        } else {
            format!("95 %: {} to {}", value(number.lo95), value(number.hi95))
        };
        let then = number.reference.map_or_else(String::new, |then| {
            format!("; {} in the reference", value(then))
        });
        let name = seen_name(name, number.unit, unit);
        output.line(&format!(
            "            {name} = {} {unit} ({ends}{then})",
            value(number.value)
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
