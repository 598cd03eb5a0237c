//! The fleet page: units compared with the population, drift, verdicts, unusable recordings.

mod outlying;
mod queries;

pub use queries::Names;

use super::cell::Cell;
use super::number::{figure, percent, probability};
use super::strip::{Dot, Strip};
use super::{Bar, Bars, Page, Scale};
use crate::fleet::{
    Damaged, Document, Drift, FEWEST_DATES, FEWEST_UNITS, LEAST_OUTLIER_SCORE, Number, Outlier,
    Population, SIGNIFICANT,
};

/// Most parameters drawn, by number of units.
const DRAWN: usize = 12;
/// Most rows of a table on the page; `tabulate` writes all.
const LISTED: usize = 100;
/// Most characters of a reason.
const REASON: usize = 600;
/// Days per month in printed slopes.
const MONTH_D: f64 = 30.0;
/// Julian day number of 1970-01-01.
const JULIAN_1970: i32 = 2_440_588;

/// The page.
pub fn page(
    documents: &[Document],
    damaged: &[Damaged],
    population: &Population,
    names: &Names,
) -> String {
    let mut page = Page::new("Many diagnoses side by side");
    page.lead(&lead(documents, damaged, population));
    outlying::section(&mut page, documents, population);
    named(&mut page, documents, population);
    numbers(&mut page, population);
    drift(&mut page, population);
    unusable(&mut page, documents, damaged);
    recordings(&mut page, documents, population);
    units(&mut page, documents, population);
    queries::put(&mut page, names);
    page.finish()
}

fn lead(documents: &[Document], damaged: &[Damaged], population: &Population) -> String {
    let apart = population.apart();
    let bad = documents
        .iter()
        .filter(|document| document.is_bad())
        .count();
    let first = apart.first().map_or(String::new(), |first| {
        let recurring = population.recurring.iter().filter(|one| one.unit == *first);
        let why = match outlying::recurring_words(recurring) {
            none if none.is_empty() => population
                .standing
                .iter()
                .find(|one| one.unit == *first)
                .map_or(String::new(), |one| {
                    name_of(&population.numbers[one.number])
                }),
            recurring => recurring,
        };
        format!(" First: {}, {why}.", population.units[*first].name)
    });
    format!(
        "{} of {}. {}.{first} {}.",
        several(documents.len(), "diagnosis", "diagnoses"),
        several(population.units.len(), "unit", "units"),
        match apart.len() {
            0 => "No unit stands out".to_owned(),
            1 => "1 unit stands out".to_owned(),
            n => format!("{n} units stand out"),
        },
        match bad + damaged.len() {
            0 => "Every recording is usable".to_owned(),
            1 => "1 recording is not usable".to_owned(),
            n => format!("{n} recordings are not usable"),
        }
    )
}

fn several(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

fn name_of(number: &Number) -> String {
    if number.is_base {
        format!("{}, relative to the motor file", number.name)
    } else {
        match number.values.first() {
            Some((_, first)) if !first.unit.is_empty() => {
                format!("{} ({})", number.name, first.unit)
            }
            _ => number.name.clone(),
        }
    }
}

/// A short name for drawings on a phone; the caption states the reference.
fn drawn_name(number: &Number) -> String {
    if number.is_base {
        number.name.clone()
    } else {
        name_of(number)
    }
}

fn relative(number: &Number) -> &'static str {
    if number.is_base {
        "Relative to the motor file. "
    } else {
        ""
    }
}

/// Effects of the unit's last diagnosis, else its verdict.
fn cause_of(documents: &[Document], population: &Population, unit: usize) -> String {
    let last = population.units[unit]
        .documents
        .last()
        .map(|place| &documents[*place]);
    match last {
        Some(last) if !last.effects.is_empty() => {
            format!("{} ({})", last.effects.join("+"), percent(last.probability))
        }
        Some(last) => last.verdict.clone(),
        None => String::new(),
    }
}

fn left_out(page: &mut Page, all: usize) {
    if all > LISTED {
        page.note(&format!("{} more are in the tables.", all - LISTED));
    }
}

fn named(page: &mut Page, documents: &[Document], population: &Population) {
    page.section("Verdicts and identified effects");
    let most = documents.len().max(1) as f64;
    let bars = |title: &str, counts: Vec<(String, usize, String)>, colour: usize| Bars {
        title: title.to_owned(),
        scale: Scale(most),
        bars: (counts.into_iter())
            .map(|(name, count, text)| Bar {
                name,
                value: count as f64,
                text,
                interval: None,
                colour,
            })
            .collect(),
    };
    let verdicts = population.verdicts.iter();
    let verdicts = verdicts
        .map(|(name, count)| (name.clone(), *count, count.to_string()))
        .collect();
    page.bars(&bars("verdicts", verdicts, 0), "Diagnoses by verdict.");
    if population.effects.is_empty() {
        return;
    }
    let effects = population.effects.iter().map(|(name, count, units)| {
        let text = format!("{count}, of {}", several(*units, "unit", "units"));
        (name.clone(), *count, text)
    });
    page.bars(
        &bars("identified effects", effects.collect(), 1),
        "Diagnoses in which the effect is identified, alone or with others.",
    );
}

/// The parameters that most units have, in their order.
fn drawn(population: &Population) -> Vec<(usize, &Number)> {
    let mut all: Vec<(usize, &Number)> = population.numbers.iter().enumerate().collect();
    all.retain(|(_, number)| number.values.len() >= FEWEST_UNITS);
    all.sort_by_key(|(place, number)| (std::cmp::Reverse(number.values.len()), *place));
    all.truncate(DRAWN);
    all.sort_by_key(|(place, _)| *place);
    all
}

fn numbers(page: &mut Page, population: &Population) {
    page.section("Each parameter over all units");
    let drawn = drawn(population);
    if drawn.is_empty() {
        page.paragraph(&format!("No parameter is known of {FEWEST_UNITS} units."));
        return;
    }
    for (place, number) in drawn {
        let is_marked = |unit: usize| {
            let mut standing = population.standing.iter();
            standing.any(|standing| standing.unit == unit && standing.number == place)
        };
        let dot = |(k, (unit, value)): (usize, &(usize, crate::fleet::Interval))| Dot {
            x: k as f64,
            y: value.value,
            interval: Some((value.lo95, value.hi95)),
            is_marked: is_marked(*unit),
        };
        let name = |(k, (unit, _)): (usize, &(usize, crate::fleet::Interval))| {
            (k as f64, population.units[*unit].name.clone())
        };
        let strip = Strip {
            title: drawn_name(number),
            x_label: "unit, in ascending order of the value".to_owned(),
            ticks: number.values.iter().enumerate().map(name).collect(),
            dots: number.values.iter().enumerate().map(dot).collect(),
            ordinary: number
                .centre
                .map(|(centre, sigma)| (centre, LEAST_OUTLIER_SCORE * sigma)),
        };
        let caption = match number.centre {
            Some((centre, sigma)) => format!(
                "{}{}: median {}, robust standard deviation {}. Grey: no outlier. Bars: 95 % intervals. Values far outside are drawn \
                 at the edge.",
                relative(number),
                several(number.values.len(), "unit", "units"),
                figure(centre, 4),
                figure(sigma, 2)
            ),
            None => String::new(),
        };
        page.strip(&strip, &caption);
    }
}

fn date(days: f64) -> String {
    let date = time::Date::from_julian_day(days.floor() as i32 + JULIAN_1970);
    date.map_or(String::new(), |date| date.to_string())
}

fn drift(page: &mut Page, population: &Population) {
    page.section("Drift");
    if population.trends == 0 {
        page.paragraph(&format!(
            "Drift needs at least {FEWEST_DATES} dated recordings of a unit; the longest series here has {}.",
            population.most_dates
        ));
        return;
    }
    if population.drifts.is_empty() {
        page.answer("No trend is significant.");
    } else {
        let row = |drift: &Drift| {
            let number = &population.numbers[drift.number];
            vec![
                population.units[drift.unit].name.clone(),
                name_of(number),
                figure(MONTH_D * drift.per_day, 3),
                number
                    .centre
                    .map_or(String::new(), |(centre, _)| figure(centre, 4)),
                drift.dates.to_string(),
                figure(drift.p, 2),
            ]
        };
        let rows: Vec<Vec<String>> = population.drifts.iter().take(LISTED).map(row).collect();
        page.table(
            &[
                "unit",
                "parameter",
                "change in 30 days",
                "median of all",
                "dates",
                "p",
            ],
            &rows,
        );
        left_out(page, population.drifts.len());
    }
    page.note(&format!(
        "Slopes are the median over pairs of dates (Theil and Sen). {} trends were tested by ranks (Mann and Kendall); shown are those that are \
         significant among so many: p times their number is below {SIGNIFICANT}.",
        population.trends
    ));
    for (place, number) in drawn(population) {
        let days = number.dated.iter().map(|(_, days, _)| *days);
        let (first, last) = days.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), day| {
            (a.min(day), b.max(day))
        });
        if first >= last {
            continue;
        }
        let is_marked = |unit: usize| {
            let mut drifts = population.drifts.iter();
            drifts.any(|drift| drift.unit == unit && drift.number == place)
        };
        let dot = |(unit, days, value): &(usize, f64, f64)| Dot {
            x: *days,
            y: *value,
            interval: None,
            is_marked: is_marked(*unit),
        };
        let strip = Strip {
            title: drawn_name(number),
            x_label: "date".to_owned(),
            ticks: [first, 0.5 * (first + last), last]
                .map(|day| (day, date(day)))
                .to_vec(),
            dots: number.dated.iter().map(dot).collect(),
            ordinary: number
                .centre
                .map(|(centre, sigma)| (centre, LEAST_OUTLIER_SCORE * sigma)),
        };
        let caption = format!(
            "{}Every diagnosis with a date. Large: units with a significant trend.",
            relative(number)
        );
        page.strip(&strip, &caption);
    }
}

fn unusable(page: &mut Page, documents: &[Document], damaged: &[Damaged]) {
    page.section("Recordings that are not usable");
    let short = |text: &str| crate::plain::clipped(text, REASON).into_owned();
    let bad = documents.iter().filter(|document| document.is_bad());
    let bad = bad.map(|document| vec![document.document.clone(), short(&document.sentence)]);
    let rows: Vec<Vec<String>> = (damaged.iter())
        .map(|damaged| vec![damaged.document.clone(), short(&damaged.why)])
        .chain(bad)
        .collect();
    if rows.is_empty() {
        page.answer("None.");
        return;
    }
    page.table(&["document", "why"], &rows[..rows.len().min(LISTED)]);
    left_out(page, rows.len());
}

/// Every recording with its verdict and page.
fn recordings(page: &mut Page, documents: &[Document], population: &Population) {
    page.section("Every recording");
    let of_units = population.units.iter();
    let rows: Vec<Vec<Cell>> = of_units
        .flat_map(|unit| {
            unit.documents.iter().map(|place| {
                let document = &documents[*place];
                let effects = match document.effects.is_empty() {
                    true => "\u{2013}".to_owned(),
                    false => document.effects.join("+"),
                };
                vec![
                    Cell::Links(vec![(document.name(), document.page.clone())]),
                    Cell::Text(unit.name.clone()),
                    Cell::Text(document.verdict.replace('_', " ")),
                    Cell::Text(effects),
                    Cell::Text(probability(document.probability)),
                ]
            })
        })
        .collect();
    if documents.iter().all(|document| document.page.is_none()) {
        page.note("A recording is linked where its page lies beside its document: motorlab diagnose RUN --html NAME.html --json > NAME.json.");
    }
    let names = [
        "recording",
        "unit",
        "verdict",
        "identified effects",
        "probability",
    ];
    page.folded(&several(rows.len(), "recording", "recordings"), |page| {
        page.linked_table(&names, &rows);
    });
}

fn units(page: &mut Page, documents: &[Document], population: &Population) {
    page.section("Every unit");
    let mut farthest = vec![None; population.units.len()];
    for standing in population.standing.iter().rev() {
        farthest[standing.unit] = Some(standing);
    }
    let row = |(k, unit): (usize, &crate::fleet::Unit)| {
        vec![
            unit.name.clone(),
            unit.documents.len().to_string(),
            cause_of(documents, population, k),
            farthest[k].map_or(String::new(), |standing: &Outlier| {
                format!(
                    "{} in {}",
                    figure(standing.z, 3),
                    population.numbers[standing.number].name
                )
            }),
        ]
    };
    let rows: Vec<Vec<String>> = population.units.iter().enumerate().map(row).collect();
    let names = ["unit", "diagnoses", "last diagnosis", "largest robust z"];
    page.folded(&several(rows.len(), "unit", "units"), |page| {
        page.table(&names, &rows);
    });
}
