//! Units compared with their population: each identified parameter, outliers, drift.

use std::collections::BTreeMap;

use super::document::{Document, Interval};
use super::recurring::{Recurring, recurring};
use super::robust::{centre_and_sigma, median, trend};

/// Fewest units of a population: with fewer the spread is hardly determined.
pub const FEWEST_UNITS: usize = 5;
/// Least robust z-score of an outlier (Iglewicz and Hoaglin 1993).
pub const LEAST_OUTLIER_SCORE: f64 = 3.5;
/// Fewest dates of a unit for a trend test: with fewer no order is significant.
pub const FEWEST_DATES: usize = 5;
/// Significance level of all trend tests together (Bonferroni).
pub const SIGNIFICANT: f64 = 0.05;

/// One unit and its diagnoses.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Name.
    pub name: String,
    /// Indices of its diagnoses, the earliest first; bad recordings included.
    pub documents: Vec<usize>,
}

/// One identified parameter over all units that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// A base parameter relative to the motor file's, or `EFFECT.KEY`.
    pub name: String,
    /// Whether it is a base parameter.
    pub is_base: bool,
    /// Unit and value of its median diagnosis, in ascending order.
    pub values: Vec<(usize, Interval)>,
    /// Median and robust standard deviation over units; `None` with fewer than [`FEWEST_UNITS`].
    pub centre: Option<(f64, f64)>,
    /// Values with a date: unit, days since 1970, value; the earliest first.
    pub dated: Vec<(usize, f64, f64)>,
}

/// A unit with an outlying parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// Index of the unit.
    pub unit: usize,
    /// Index of the parameter.
    pub number: usize,
    /// Robust z-score.
    pub z: f64,
}

/// A significant trend of a parameter of a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Index of the unit.
    pub unit: usize,
    /// Index of the parameter.
    pub number: usize,
    /// Slope per day.
    pub per_day: f64,
    /// p-value of the trend.
    pub p: f64,
    /// Number of dates.
    pub dates: usize,
}

/// Many diagnoses as one population.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// Units by name.
    pub units: Vec<Unit>,
    /// Parameters, the base parameters first.
    pub numbers: Vec<Number>,
    /// Effects that recur in the recordings of one unit, the most significant first.
    pub recurring: Vec<Recurring>,
    /// Outliers, the largest z-score first.
    pub standing: Vec<Outlier>,
    /// Trends, the most significant first.
    pub drifts: Vec<Drift>,
    /// Number of trends tested.
    pub trends: usize,
    /// Largest number of dates of a unit.
    pub most_dates: usize,
    /// Diagnoses by verdict, the most frequent first.
    pub verdicts: Vec<(String, usize)>,
    /// Identified effects with the number of diagnoses and of units; the most frequent first.
    pub effects: Vec<(String, usize, usize)>,
}

impl Population {
    /// The population of these diagnoses.
    pub fn of(documents: &[Document]) -> Self {
        let units = units(documents);
        let numbers = numbers(documents, &units);
        let (trends, drifts) = drifts(&numbers);
        Self {
            recurring: recurring(documents, &units),
            standing: standing(&numbers),
            verdicts: counted(documents.iter().map(|document| document.verdict.clone())),
            effects: effects(documents, &units),
            units,
            drifts,
            trends,
            most_dates: most_dates(&numbers),
            numbers,
        }
    }

    /// Outlying units: first those with a recurring effect, then those with an outlying parameter, by z-score.
    pub fn apart(&self) -> Vec<usize> {
        let recurring = self.recurring.iter().map(|one| one.unit);
        let mut units: Vec<usize> = Vec::new();
        for unit in recurring.chain(self.standing.iter().map(|one| one.unit)) {
            if !units.contains(&unit) {
                units.push(unit);
            }
        }
        units
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

/// Values of one parameter by unit, with the date of each diagnosis.
type Found = BTreeMap<usize, Vec<(Option<f64>, Interval)>>;

fn numbers(documents: &[Document], units: &[Unit]) -> Vec<Number> {
    // Base parameters sort before those of effects.
    let mut found: BTreeMap<(bool, String), Found> = BTreeMap::new();
    for (k, unit) in units.iter().enumerate() {
        for document in unit.documents.iter().map(|place| &documents[*place]) {
            for (name, interval) in document
                .numbers()
                .filter(|(_, number)| number.value.is_finite())
            {
                let key = (!document.is_relative(&name), name);
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

fn standing(numbers: &[Number]) -> Vec<Outlier> {
    let of_number = |(k, number): (usize, &Number)| {
        let Some((centre, sigma)) = number.centre.filter(|(_, sigma)| *sigma > 0.0) else {
            return Vec::new();
        };
        // A unit whose interval contains the median is no outlier.
        let is_apart = |number: &Interval| !(number.lo95 <= centre && centre <= number.hi95);
        let of_unit = |(unit, number): &(usize, Interval)| Outlier {
            unit: *unit,
            number: k,
            z: (number.value - centre) / sigma,
        };
        (number.values.iter().filter(|(_, number)| is_apart(number)))
            .map(of_unit)
            .filter(|standing| standing.z.abs() > LEAST_OUTLIER_SCORE)
            .collect()
    };
    let mut all: Vec<Outlier> = numbers.iter().enumerate().flat_map(of_number).collect();
    all.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    all
}

/// Number of trends tested, and the significant ones (Bonferroni).
fn drifts(numbers: &[Number]) -> (usize, Vec<Drift>) {
    let mut asked = Vec::new();
    for (k, number) in numbers.iter().enumerate() {
        for (unit, points) in series(number) {
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

/// Values of each unit over time; recordings of one date are merged.
fn series(number: &Number) -> impl Iterator<Item = (usize, Vec<(f64, f64)>)> {
    let mut of: BTreeMap<usize, Vec<(f64, f64)>> = BTreeMap::new();
    for (unit, days, value) in &number.dated {
        of.entry(*unit).or_default().push((*days, *value));
    }
    of.into_iter()
        .map(|(unit, points)| (unit, at_each_date(&points)))
}

fn most_dates(numbers: &[Number]) -> usize {
    let lengths = numbers.iter().flat_map(series);
    lengths.map(|(_, points)| points.len()).max().unwrap_or(0)
}

/// Points in ascending order of x; points of one x are replaced by their median.
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
