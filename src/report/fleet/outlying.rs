//! Outlying units: a recurring effect, or an outlying parameter.

use std::path::Path;

use super::{cause_of, name_of};
use crate::fleet::{
    Document, FEWEST_UNITS, LEAST_OUTLIER_SCORE, Outlier, Population, Recurring, SIGNIFICANT,
};
use crate::report::Page;
use crate::report::cell::Cell;
use crate::report::number::figure;

/// Most units listed; `tabulate` writes all.
const LISTED: usize = 100;

pub(super) fn section(page: &mut Page, documents: &[Document], population: &Population) {
    page.section("Units that stand out");
    let apart = population.apart();
    if apart.is_empty() {
        page.answer("None.");
    } else {
        let rows: Vec<Vec<Cell>> = (apart.iter().take(LISTED))
            .map(|unit| row(documents, population, *unit))
            .collect();
        page.linked_table(
            &[
                "unit",
                "cause",
                "outlying parameter",
                "value",
                "95 % interval",
                "median of all",
                "robust z",
                "recordings",
            ],
            &rows,
        );
        if apart.len() > LISTED {
            page.note(&format!("{} more are in the tables.", apart.len() - LISTED));
        }
    }
    page.note(&format!(
        "First stand units in whose recordings an effect is identified more often than in those of the others (binomial test, p times the number of \
         tests below {SIGNIFICANT}), then those with an outlying parameter: it lies more than {LEAST_OUTLIER_SCORE} robust standard deviations from the median of all \
         units, and its own interval does not contain that median. A robust standard deviation is 1.4826 times the median absolute deviation; where that is 0, \
         1.2533 times the mean absolute deviation. At least {FEWEST_UNITS} units are needed. Of a unit with several outlying parameters the farthest is shown."
    ));
}

/// The effects that recur in a unit's recordings.
pub(super) fn recurring_words<'a>(of_unit: impl Iterator<Item = &'a Recurring>) -> String {
    let words = |one: &Recurring| {
        format!(
            "{} in {} of {} recordings",
            one.effect.replace('_', " "),
            one.found,
            one.of
        )
    };
    of_unit.map(words).collect::<Vec<_>>().join("; ")
}

fn row(documents: &[Document], population: &Population, unit: usize) -> Vec<Cell> {
    let own = &population.units[unit];
    let recurring = population.recurring.iter().filter(|one| one.unit == unit);
    let cause = match recurring_words(recurring) {
        none if none.is_empty() => cause_of(documents, population, unit),
        recurring => recurring,
    };
    let farthest = population.standing.iter().find(|one| one.unit == unit);
    let number = |of: &dyn Fn(&Outlier) -> String| farthest.map_or("\u{2013}".to_owned(), of);
    let value = |of: &dyn Fn(&crate::fleet::Interval) -> String| {
        number(&|standing| {
            let values = &population.numbers[standing.number].values;
            let own = values.iter().find(|(at, _)| *at == unit);
            own.map_or(String::new(), |(_, value)| of(value))
        })
    };
    let date = |place: &usize| -> Option<String> {
        let started = documents[*place].started()?;
        Some(started.chars().take(DATE).collect())
    };
    let dates: Vec<Option<String>> = own.documents.iter().map(date).collect();
    let recordings = own.documents.iter().zip(&dates).map(|(place, date)| {
        let document = &documents[*place];
        // Recordings of one day, and those without a date, are named by file.
        let is_only = dates.iter().filter(|other| *other == date).count() == 1;
        let own = date.clone().filter(|_| is_only);
        let file = Path::new(&document.document).file_stem();
        let name = own.or(file.map(|name| name.to_string_lossy().into_owned()));
        (name.unwrap_or_default(), document.page.clone())
    });
    vec![
        Cell::Text(own.name.clone()),
        Cell::Text(cause),
        Cell::Text(number(&|one| name_of(&population.numbers[one.number]))),
        Cell::Text(value(&|value| figure(value.value, 4))),
        Cell::Text(value(&|value| {
            format!("{} to {}", figure(value.lo95, 3), figure(value.hi95, 3))
        })),
        Cell::Text(number(&|one| {
            let centre = population.numbers[one.number].centre;
            centre.map_or(String::new(), |(centre, _)| figure(centre, 4))
        })),
        Cell::Text(number(&|one| figure(one.z, 3))),
        Cell::Links(recordings.collect()),
    ]
}

const DATE: usize = 10;
