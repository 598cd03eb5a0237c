//! Units held against the population that they are of: each identified number, who stands out, what drifts.

use std::collections::BTreeMap;

use super::document::{Document, Interval};
use super::robust::{centre_and_sigma, median, trend};

/// Fewest units that make a population: of fewer the spread is hardly known.
pub const FEWEST_UNITS: usize = 5;
/// From this robust z-score on a unit stands out (Iglewicz and Hoaglin 1993).
pub const OUTSTANDING: f64 = 3.5;
/// Fewest dates of a unit at which a trend is asked for: with fewer no order is clear beside chance.
pub const FEWEST_DATES: usize = 5;
/// Probability by chance of one trend or more among all that are told (Bonferroni).
pub const SIGNIFICANT: f64 = 0.05;

/// One unit and its diagnoses.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: String,
    /// Places of its diagnoses among all, the earliest first; bad recordings too.
    pub documents: Vec<usize>,
}

/// One identified number over all units that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Its name: the base model's, relative to the motor file's, or `EFFECT.KEY`.
    pub name: String,
    /// Whether it is one of the base model's.
    pub is_base: bool,
    /// Unit with its value: that of the diagnosis in the middle. The least first.
    pub values: Vec<(usize, Interval)>,
    /// Median and robust standard deviation over units; none of fewer than [`FEWEST_UNITS`].
    pub centre: Option<(f64, f64)>,
    /// Every value with a date: unit, days since 1970, value; the earliest first.
    pub dated: Vec<(usize, f64, f64)>,
}

/// A unit that stands out by a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Its place among the units.
    pub unit: usize,
    /// The number's place.
    pub number: usize,
    /// Robust z-score.
    pub z: f64,
}

/// A number of a unit that goes one way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Its place among the units.
    pub unit: usize,
    /// The number's place.
    pub number: usize,
    /// How much it changes a day.
    pub per_day: f64,
    /// Probability of so clear a trend by chance.
    pub p: f64,
    /// Dates.
    pub dates: usize,
}

/// Many diagnoses as one population.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// Units by name.
    pub units: Vec<Unit>,
    /// Numbers, the base model's first.
    pub numbers: Vec<Number>,
    /// Who stands out, farthest first.
    pub standing: Vec<Standing>,
    /// What drifts, clearest first.
    pub drifts: Vec<Drift>,
    /// Trends that were asked for.
    pub trends: usize,
    /// Diagnoses by verdict, most often first.
    pub verdicts: Vec<(String, usize)>,
    /// Effects that are named: in how many diagnoses, of how many units; most often first.
    pub effects: Vec<(String, usize, usize)>,
}

impl Population {
    /// Of these diagnoses.
    pub fn of(documents: &[Document]) -> Self {
        let units = units(documents);
        let numbers = numbers(documents, &units);
        let (trends, drifts) = drifts(&numbers);
        Self {
            standing: standing(&numbers),
            verdicts: counted(documents.iter().map(|document| document.verdict.clone())),
            effects: effects(documents, &units),
            units,
            numbers,
            drifts,
            trends,
        }
    }
}

fn units(documents: &[Document]) -> Vec<Unit> {
    let mut of: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (k, document) in documents.iter().enumerate() {
        of.entry(document.unit()).or_default().push(k);
    }
    let dates: Vec<f64> = (documents.iter())
        .map(|document| document.started_days().unwrap_or(f64::NEG_INFINITY))
        .collect();
    let in_order = |(name, mut documents): (String, Vec<usize>)| {
        documents.sort_by(|a, b| dates[*a].total_cmp(&dates[*b]));
        Unit { name, documents }
    };
    of.into_iter().map(in_order).collect()
}

/// A number as it was found: by unit, with the date of each diagnosis.
type Found = BTreeMap<usize, Vec<(Option<f64>, Interval)>>;

fn numbers(documents: &[Document], units: &[Unit]) -> Vec<Number> {
    // By whether it is an effect's, and by name: the base model's come first.
    let mut found: BTreeMap<(bool, String), Found> = BTreeMap::new();
    for (k, unit) in units.iter().enumerate() {
        for document in unit.documents.iter().map(|place| &documents[*place]) {
            for (name, interval) in document
                .numbers()
                .filter(|(_, number)| number.value.is_finite())
            {
                let key = (!document.base.contains_key(&name), name);
                let of_unit = found.entry(key).or_default().entry(k).or_default();
                of_unit.push((document.started_days(), interval.clone()));
            }
        }
    }
    let all = found.into_iter();
    all.map(|((is_effects, name), of)| number(!is_effects, name, of))
        .collect()
}

fn number(is_base: bool, name: String, of: Found) -> Number {
    let mut dated: Vec<(usize, f64, f64)> = (of.iter())
        .flat_map(|(unit, found)| {
            let dated = found
                .iter()
                .filter_map(|(days, number)| Some(((*days)?, number.value)));
            dated.map(|(days, value)| (*unit, days, value))
        })
        .collect();
    dated.sort_by(|a, b| a.1.total_cmp(&b.1));
    let middle = |(unit, mut found): (usize, Vec<(Option<f64>, Interval)>)| {
        found.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
        let middle = (found.len() - 1) / 2;
        (unit, found.swap_remove(middle).1)
    };
    let mut values: Vec<(usize, Interval)> = of.into_iter().map(middle).collect();
    values.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let all: Vec<f64> = values.iter().map(|(_, number)| number.value).collect();
    Number {
        name,
        is_base,
        centre: (all.len() >= FEWEST_UNITS)
            .then(|| centre_and_sigma(&all))
            .flatten(),
        values,
        dated,
    }
}

fn standing(numbers: &[Number]) -> Vec<Standing> {
    let of_number = |(k, number): (usize, &Number)| {
        let Some((centre, sigma)) = number.centre.filter(|(_, sigma)| *sigma > 0.0) else {
            return Vec::new();
        };
        // Who is not sure of its own value is not known to stand out.
        let is_apart = |number: &Interval| !(number.lo95 <= centre && centre <= number.hi95);
        let of_unit = |(unit, number): &(usize, Interval)| Standing {
            unit: *unit,
            number: k,
            z: (number.value - centre) / sigma,
        };
        (number.values.iter().filter(|(_, number)| is_apart(number)))
            .map(of_unit)
            .filter(|standing| standing.z.abs() > OUTSTANDING)
            .collect()
    };
    let mut all: Vec<Standing> = numbers.iter().enumerate().flat_map(of_number).collect();
    all.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    all
}

/// How many trends were asked for, and those that are clear beside so many.
fn drifts(numbers: &[Number]) -> (usize, Vec<Drift>) {
    let mut asked = Vec::new();
    for (k, number) in numbers.iter().enumerate() {
        let mut of: BTreeMap<usize, Vec<(f64, f64)>> = BTreeMap::new();
        for (unit, days, value) in &number.dated {
            of.entry(*unit).or_default().push((*days, *value));
        }
        for (unit, points) in of {
            // Recordings of one moment are one point.
            let points = at_each_date(&points);
            if points.len() >= FEWEST_DATES
                && let Some((per_day, p)) = trend(&points)
            {
                asked.push(Drift {
                    unit,
                    number: k,
                    per_day,
                    p,
                    dates: points.len(),
                });
            }
        }
    }
    let trends = asked.len();
    asked.retain(|drift| drift.p * (trends as f64) < SIGNIFICANT);
    asked.sort_by(|a, b| a.p.total_cmp(&b.p));
    (trends, asked)
}

/// Points in the order of x; of several with one x their median.
fn at_each_date(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let same = points.chunk_by(|a, b| a.0 == b.0);
    same.filter_map(|same| Some((same.first()?.0, median(same.iter().map(|point| point.1))?)))
        .collect()
}

fn effects(documents: &[Document], units: &[Unit]) -> Vec<(String, usize, usize)> {
    let mut of: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for unit in units {
        let mut seen: Vec<&str> = Vec::new();
        for effect in unit
            .documents
            .iter()
            .flat_map(|place| &documents[*place].effects)
        {
            let counts = of.entry(effect).or_default();
            counts.0 += 1;
            if !seen.contains(&effect.as_str()) {
                seen.push(effect);
                counts.1 += 1;
            }
        }
    }
    let mut all: Vec<_> = (of.into_iter())
        .map(|(effect, (diagnoses, units))| (effect.to_owned(), diagnoses, units))
        .collect();
    all.sort_by_key(|(_, diagnoses, _)| std::cmp::Reverse(*diagnoses));
    all
}

fn counted(items: impl Iterator<Item = String>) -> Vec<(String, usize)> {
    let mut of: BTreeMap<String, usize> = BTreeMap::new();
    for item in items {
        *of.entry(item).or_default() += 1;
    }
    let mut all: Vec<(String, usize)> = of.into_iter().collect();
    all.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    all
}
