//! The numbers of the effects and of the motor, with their intervals.

use super::words;
use crate::diagnose::{Cause, Diagnosis, Interval};
use crate::export::PARAMETERS;
use crate::report::Page;
use crate::report::number::{figure, percent};
use crate::units::rpm_from_rad_s;

/// A cause from this probability on has its numbers shown.
const NUMBERS_FROM: f64 = 0.05;

/// The section of the page.
pub(super) fn section(page: &mut Page, diagnosis: &Diagnosis) {
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
    if let Some(seen) = &diagnosis.fitted_nominal {
        let exact = |name: &str, value: f64, unit: String| {
            vec![
                name.to_owned(),
                figure(value, 4),
                "\u{2013}".to_owned(),
                unit,
            ]
        };
        let unit = seen.command_unit;
        let speed = rpm_from_rad_s(seen.steady_rad_s_per_unit);
        rows.push(exact(
            "plain motor: steady speed",
            speed,
            format!("RPM/{unit}"),
        ));
        rows.push(exact(
            "plain motor: time constant",
            seen.time_constant_s,
            "s".to_owned(),
        ));
        rows.push(exact(
            "plain motor: friction",
            seen.friction,
            unit.to_owned(),
        ));
    }
    for cause in diagnosis.causes.iter().filter(shown) {
        for (name, interval) in &cause.parameters {
            let (scale, seen_unit) = words::seen_scale(diagnosis, interval.unit);
            let row = vec![
                format!(
                    "{}: {}",
                    cause.effect,
                    words::seen_name(name, interval.unit, seen_unit)
                ),
                figure(interval.value * scale, 4),
                ends(interval, scale),
                unit(seen_unit),
            ];
            rows.push(beside(row, interval.reference.map(|then| then * scale)));
        }
    }
    for (key, ratio) in &diagnosis.base {
        let of_nominal = diagnosis.nominal.parameters.get(key);
        let Some(value) = of_nominal.filter(|value| *value != 0.0) else {
            continue;
        };
        let named = PARAMETERS.iter().find(|named| named.key == *key);
        let of_file = named.map_or("", |named| named.unit);
        let (scale, seen_unit) = words::seen_scale(diagnosis, of_file);
        let name = words::seen_name(key, of_file, seen_unit);
        let row = vec![
            format!("{name} ({} of the {whose})", percent(ratio.value)),
            figure(ratio.value * value * scale, 4),
            ends(ratio, value * scale),
            unit(seen_unit),
        ];
        rows.push(beside(row, Some(value * scale)));
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
    if unit.is_empty() { "\u{2013}" } else { unit }.to_owned()
}
