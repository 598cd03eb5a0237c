//! What the page and the terminal say of a diagnosis in the same words.

use crate::diagnose::{Diagnosis, ReferenceRuns, SeenMotor};
use crate::motor::catalogue::{EffectKind, catalogue};
use crate::report::number::figure;
use crate::report::{Bar, Bars, Scale};
use crate::units::rpm_from_rad_s;

/// An effect of the catalogue by its id.
pub(super) fn kind(id: &str) -> Option<&'static EffectKind> {
    catalogue().iter().find(|kind| kind.id == id)
}

/// A cause and what it is.
pub fn cause_words(id: &str) -> String {
    match id {
        "none" => "none: the same model with other numbers".to_owned(),
        "unknown" => "unknown: nothing of the catalogue".to_owned(),
        ids => {
            let words = ids.split('+').map(|id| {
                kind(id).map_or_else(|| id.to_owned(), |kind| format!("{id}: {}", kind.summary))
            });
            words.collect::<Vec<String>>().join("; ")
        }
    }
}

/// A set of effects.
pub fn effects_words(ids: &[&str]) -> String {
    if ids.is_empty() {
        "none".to_owned()
    } else {
        ids.join(" + ")
    }
}

/// The likeliest set of named effects, whatever the verdict.
pub(super) fn best_set(diagnosis: &Diagnosis) -> &[&'static str] {
    diagnosis.sets.first().map_or(&[], |set| &set.effects)
}

/// The effects that the verdict names, or those that are in play where it cannot.
pub fn strongest(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let mut ids = diagnosis.effects.clone();
    let in_play = diagnosis.sets.iter().filter(|set| set.probability > 0.02);
    ids.extend(in_play.flat_map(|set| set.effects.iter().copied()));
    let mut seen = Vec::new();
    ids.retain(|id| {
        kind(id).is_some() && !seen.contains(id) && {
            seen.push(id);
            true
        }
    });
    ids.truncate(4);
    ids
}

/// What the runs are held against.
pub(super) fn nominal(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.reference {
        Some(_) => "as the reference",
        None => "nominal",
    }
}

/// Whose numbers those are.
pub(super) fn whose(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.reference {
        Some(_) => "reference's",
        None => "file's",
    }
}

/// A motor in what voltage in and position out tell of it.
pub fn seen_words(seen: &SeenMotor) -> String {
    let unit = seen.command_unit;
    format!(
        "{} RPM per {unit}, time constant {} s, friction {} {unit}",
        figure(rpm_from_rad_s(seen.steady_rad_s_per_unit), 3),
        figure(seen.time_constant_s, 3),
        figure(seen.friction, 3)
    )
}

/// What the reference is, in a sentence.
pub fn of_reference(reference: &ReferenceRuns) -> String {
    let effects = match reference.effects.as_slice() {
        [] => "no effect beside the motor file's own".to_owned(),
        effects => effects.join(" + "),
    };
    format!(
        "Reference: {}. Its motor has {effects} and leaves {} counts.",
        reference.runs.join(", "),
        figure(reference.left_counts, 3)
    )
}

/// The four rungs as bars on a logarithmic scale.
pub fn rungs(diagnosis: &Diagnosis) -> Bars {
    let gap = &diagnosis.gap;
    let effects = best_set(diagnosis);
    let [before, after_parameters, after_effect] = gap.rungs95;
    let mut rungs = vec![
        (nominal(diagnosis).to_owned(), gap.before, Some(before), 6),
        (
            "refitted".to_owned(),
            gap.after_parameters,
            Some(after_parameters),
            4,
        ),
    ];
    if !effects.is_empty() {
        let name = format!("with {}", effects.join(" + "));
        rungs.push((name, gap.after_effect, Some(after_effect), 1));
    }
    rungs.push(("floor".to_owned(), gap.floor, None, 2));
    let most = rungs.iter().fold(gap.floor, |most, rung| {
        most.max(rung.2.map_or(rung.1, |ends| ends.1.max(rung.1)))
    });
    Bars {
        title: "Position error".to_owned(),
        scale: Scale::Logarithmic(0.5 * gap.floor, 1.1 * most),
        bars: rungs
            .into_iter()
            .map(|(name, value, interval, colour)| Bar {
                name,
                value,
                text: match interval {
                    Some((low, high)) => format!(
                        "{} counts ({} to {})",
                        figure(value, 3),
                        figure(low, 3),
                        figure(high, 3)
                    ),
                    None => format!("{} counts", figure(value, 3)),
                },
                interval,
                colour,
            })
            .collect(),
    }
}
