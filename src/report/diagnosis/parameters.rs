//! Tables of the parameters of effects and motor, with their intervals.

use super::words;
use crate::diagnose::{Diagnosis, Interval};
use crate::export::PARAMETERS;
use crate::report::Page;
use crate::report::number::{figure, percent};

/// Name of the column of the reference's values.
const IN_THE_REFERENCE: &str = "in the reference";

/// The parameters of each effect, without those of improbable effects.
pub(super) fn of_effects(page: &mut Page, diagnosis: &Diagnosis) {
    let compared = diagnosis.reference.as_ref().map(|_| IN_THE_REFERENCE);
    let mut rows = Vec::new();
    for cause in &diagnosis.causes {
        if !diagnosis.effects.contains(&cause.effect) && cause.inclusion < words::DETAILED_FROM {
            continue;
        }
        for (key, interval) in &cause.parameters {
            let (name, interval) = interval.determined(key);
            let side = words::discrete_words(name, interval.value);
            let side = side.map_or_else(String::new, |side| format!(" ({side})"));
            let name = format!("{}: {name}{side}", cause.effect);
            rows.push(row(compared, name, &interval, interval.reference));
        }
    }
    if rows.is_empty() {
        return;
    }
    page.subsection("Parameters of the effects");
    page.table(&columns(compared, "value"), &rows);
    page.note(
        "An effect that is not identified has the parameters of the most probable set that contains it.",
    );
}

/// Identifiable parameters.
pub(super) fn of_motor(page: &mut Page, diagnosis: &Diagnosis) {
    page.section("Identifiable parameters");
    let compared = (diagnosis.reference.as_ref().map(|_| IN_THE_REFERENCE))
        .or_else(|| words::motor_file_column(diagnosis));
    let identifiable = diagnosis.identifiable_rows().into_iter();
    let mut rows: Vec<Vec<String>> = identifiable
        .map(|(name, interval, given)| row(compared, name.to_owned(), &interval, given))
        .collect();
    let nominal_words = words::nominal_words(diagnosis);
    // Without a known torque the identifiable ones are already above.
    let base = diagnosis.has_torque().then_some(&diagnosis.base);
    for (key, share) in base.into_iter().flatten() {
        let nominal = diagnosis.nominal.parameters.get(key);
        let Some(nominal) = nominal.filter(|value| *value != 0.0) else {
            continue;
        };
        let named = PARAMETERS.iter().find(|named| named.key == *key);
        let value = Interval {
            value: share.value * nominal,
            lo95: share.lo95 * nominal,
            hi95: share.hi95 * nominal,
            unit: named.map_or("", |named| named.unit),
            at_bound: false,
            reference: None,
            in_command: None,
        };
        let name = format!("{key} ({} of the {nominal_words})", percent(share.value));
        rows.push(row(compared, name, &value, Some(nominal)));
    }
    page.table(&columns(compared, &words::value_column(diagnosis)), &rows);
    page.note(&words::parameters_note(diagnosis));
}

/// Column names, with the column of the values to compare with, if there is one.
fn columns<'a>(compared: Option<&'a str>, value: &'a str) -> Vec<&'a str> {
    let mut names = vec!["parameter", value, "95\u{a0}% interval", "unit"];
    if let Some(name) = compared {
        names.insert(1, name);
    }
    names
}

fn row(
    compared: Option<&str>,
    name: String,
    interval: &Interval,
    other: Option<f64>,
) -> Vec<String> {
    let unit = match interval.unit {
        "" => "\u{2013}",
        unit => unit,
    };
    let mut row = vec![
        name,
        figure(interval.value, 4),
        match interval.at_bound {
            true => format!("{}, estimate at its bound", words::interval_words(interval)),
            false => words::interval_words(interval),
        },
        unit.to_owned(),
    ];
    if compared.is_some() {
        let other = other.map_or_else(|| "\u{2013}".to_owned(), |other| figure(other, 4));
        row.insert(1, other);
    }
    row
}
