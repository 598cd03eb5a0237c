//! What the page and the terminal say of a diagnosis in the same words.

use crate::diagnose::{Diagnosis, Gap, ReferenceRuns, SeenMotor};
use crate::motor::CommandKind;
use crate::motor::catalogue::{EffectKind, catalogue};
use crate::report::number::figure;
use crate::report::{Bar, Bars, Scale};
use crate::units::rpm_from_rad_s;

/// Names of a list that are read in a line.
const NAMED: usize = 5;

/// An effect of the catalogue by its id.
pub(super) fn kind(id: &str) -> Option<&'static EffectKind> {
    catalogue().iter().find(|kind| kind.id == id)
}

/// Names of the four parts of what a diagnosis says.
pub const PARTS: [&str; 4] = [
    "The gap",
    "Its cause",
    "How far it shrinks",
    "What to do next",
];

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
    match (&diagnosis.reference, &diagnosis.fitted_nominal) {
        (Some(_), _) => "reference's",
        (None, Some(_)) => "plain motor's",
        (None, None) => "file's",
    }
}

/// A motor in what voltage in and position out tell of it.
pub fn seen_words(seen: &SeenMotor) -> String {
    let unit = seen.command_unit;
    let load = seen
        .load_per_nm
        .map(|load| format!(", {} {unit} per N m of load", figure(load, 3)));
    format!(
        "{} RPM per {unit}, time constant {} s, friction {} {unit}{}",
        figure(rpm_from_rad_s(seen.steady_rad_s_per_unit), 3),
        figure(seen.time_constant_s, 3),
        figure(seen.friction, 3),
        load.unwrap_or_default()
    )
}

/// By what a number of this unit is multiplied, and the unit that it is told in then. Where nobody measured the motor's resistance and
/// torque constant, nor hung a known load on it, a torque is told as the voltage that makes it, an inertia and a friction by the same rule.
pub fn seen_scale(diagnosis: &Diagnosis, unit: &'static str) -> (f64, &'static str) {
    let p = &diagnosis.nominal.parameters;
    let is_driven_by_voltage = diagnosis.command_kind == CommandKind::Voltage;
    let is_torque_seen = (diagnosis.fitted_nominal).is_none_or(|seen| seen.load_per_nm.is_some());
    if is_torque_seen || !is_driven_by_voltage {
        return (1.0, unit);
    }
    let volts = p.resistance_ohm / p.torque_constant_nm_per_a;
    match unit {
        "N m" => (volts, "V"),
        "N m s/rad" => (volts, "V s/rad"),
        "N m s^2/rad^2" => (volts, "V s^2/rad^2"),
        "kg m^2" => (volts, "V s^2/rad"),
        other => (1.0, other),
    }
}

/// A number's name without the unit that it is not in.
pub fn seen_name(key: &str, unit: &str, seen_unit: &str) -> String {
    if unit == seen_unit {
        return key.to_owned();
    }
    let name = ["_nm_s_per_rad", "_nm_per_rad", "_kg_m2", "_nm"];
    let name = name.iter().find_map(|end| key.strip_suffix(end));
    format!("{} as seen from the terminals", name.unwrap_or(key))
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

/// Names of what a recording tells apart: the first few, and how many more.
pub fn few_words(names: &[String]) -> String {
    let named = names[..names.len().min(NAMED)].join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => named,
        others => format!("{named} and {others} more"),
    }
}

/// What the note says beside the sentence: some of it is in both.
pub fn note_beside(diagnosis: &Diagnosis) -> Option<String> {
    let sentence = &diagnosis.parts[0];
    let note = diagnosis.note.trim_end_matches('.').split(". ");
    let rest: Vec<&str> = note.filter(|part| !sentence.contains(part)).collect();
    (!rest.is_empty()).then(|| format!("{}.", rest.join(". ")))
}

/// How much of the gap closes, with its interval; rounded so that nothing that is left is hidden.
pub fn closed_words(gap: &Gap) -> String {
    if gap.before <= gap.floor {
        return "Nothing exceeds the floor.".to_owned();
    }
    if gap.closed <= 0.0 && gap.after_effect < gap.before {
        return "What exceeds the floor is too little to say how much of it closes.".to_owned();
    }
    if gap.closed <= 0.0 {
        return "Nothing of what exceeds the floor closes on data kept from the fit.".to_owned();
    }
    let from = match gap.closed_lo95 {
        lo95 if lo95 <= 0.0 => "nothing".to_owned(),
        lo95 => format!("{:.0} %", (100.0 * lo95).floor()),
    };
    format!(
        "{:.0} % of what exceeds the floor closes (95 % interval {from} to {:.0} %).",
        (100.0 * gap.closed).floor(),
        (100.0 * gap.closed_hi95).ceil()
    )
}

/// The models that the pictures show, from the nominal one on.
pub(super) fn models(diagnosis: &Diagnosis) -> Vec<String> {
    let mut names = vec![nominal(diagnosis).to_owned(), "refitted".to_owned()];
    let effects = best_set(diagnosis);
    if !effects.is_empty() {
        names.push(format!("with {}", effects.join(" + ")));
    }
    names
}

/// The four rungs as bars on a logarithmic scale.
pub fn rungs(diagnosis: &Diagnosis) -> Bars {
    let gap = &diagnosis.gap;
    let values = [gap.before, gap.after_parameters, gap.after_effect];
    let names = models(diagnosis).into_iter().zip(values);
    let names = names.zip(gap.rungs95.into_iter().zip([6, 4, 1]));
    let mut rungs: Vec<_> = names
        .map(|((name, value), (ends, colour))| (name, value, Some(ends), colour))
        .collect();
    rungs.push(("floor".to_owned(), gap.floor, None, 2));
    let most = rungs.iter().fold(gap.floor, |most, rung| {
        most.max(rung.2.map_or(rung.1, |ends| ends.1.max(rung.1)))
    });
    Bars {
        title: "Position error over pieces".to_owned(),
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
