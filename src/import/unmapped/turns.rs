//! Revolutions in units of angle, from the steps of a position; and voltages of sensors, which are no position.

use std::f64::consts::TAU;

use super::decide::Decision;
use super::names::NameFacts;

/// Relative accuracy of a step estimated from many positions: at worst, and at best that of a 32-bit float.
const EXACT: f64 = 1e-5;
const MOST_EXACT: f64 = 2e-7;
/// Largest error of a quotient that is taken as integral counts per revolution. Convention.
const WHOLE_ERROR: f64 = 0.2;
/// Counts per revolution of a 16-bit encoder: above, steps that divide a revolution divide degrees as well.
const MOST_COUNTS: f64 = 65_536.0;
/// Fewest observed counts: one in this many.
const MOST_SKIPPED: f64 = 8.0;
/// Decimals of a step that is a round decimal number in any unit.
const DECIMALS: f64 = 1e4;

/// Prefixes of the names of sensors whose voltage is logged.
const ANALOGUE: [&str; 5] = ["photo", "opto", "hall", "lightbarrier", "phototransistor"];

impl Decision<'_> {
    /// The only two columns of levels, as the channels A and B of a quadrature encoder have.
    pub(super) fn channels(&self) -> Option<[usize; 2]> {
        let is_level = |&at: &usize| {
            let column = self.column(at);
            column.is_numeric() && column.levels() == [0.0, 1.0]
        };
        let levels: Vec<usize> = (0..self.survey.columns.len()).filter(is_level).collect();
        levels.try_into().ok()
    }

    /// For two channels of a quadrature encoder from a logic analyzer: how their edges become counts.
    pub(super) fn levels_of_channels(&self) -> String {
        let Some([a, b]) = self.channels() else {
            return String::new();
        };
        let (first, second) = (a + 1, b + 1);
        format!(
            "; {} and {} hold 0 and 1, as the channels A and B of an encoder do. Their edges are counted by \
             awk -F, 'NR==1{{print \"time_s,counts\"}} NR>1{{i=index(\"0132\",2*${first}+${second})-1; if(NR>2){{d=(i-p+4)%4; \
             n+=(d==3)?-1:d}}; p=i; print $1 \",\" n+0}}' LOG > counts.csv",
            self.name(a),
            self.name(b)
        )
    }

    /// The unit of angle in whose revolution the steps of a column divide evenly, if it is unique, and the counts:
    /// the given ones, or, if the steps are no round decimals, any integer.
    pub(super) fn unit_of_counts(&self, at: usize) -> Option<(&'static str, f64)> {
        let column = self.column(at);
        let step = column.step()?;
        // The largest position has the rounding of its last digit.
        let exact = (2.0 * column.rounding() / column.most()).clamp(MOST_EXACT, EXACT);
        let named = self
            .name_facts
            .iter()
            .find_map(|facts| facts.counts_per_rev);
        let given = self.given.counts_per_rev.or(named);
        let is_round = |number: f64| (number - number.round()).abs() < exact * number;
        let mut fits = ["rev", "rad", "deg"].into_iter().filter_map(|unit| {
            let counts = turn_in(unit)? / step;
            let fits = match given {
                // Every count of the encoder, or one in several.
                Some(given) => {
                    (0.5..=MOST_SKIPPED).contains(&(given / counts)) && is_round(given / counts)
                }
                None => {
                    let is_exact = exact * counts <= WHOLE_ERROR && counts <= MOST_COUNTS;
                    is_round(counts) && is_exact && !is_round(step * DECIMALS)
                }
            };
            fits.then_some((unit, counts.round()))
        });
        fits.next().filter(|_| fits.next().is_none())
    }

    /// For a light barrier or a Hall sensor that is logged as a voltage: how its edges become counts.
    pub(super) fn analogue(&self) -> String {
        let is_sensor =
            |at: &usize| self.column(*at).is_numeric() && is_sensor(&self.name_facts[*at]);
        let Some(at) = (0..self.survey.columns.len()).find(is_sensor) else {
            return String::new();
        };
        let name = self.column(at).name.clone().unwrap_or_default();
        format!(
            "; {} is the voltage of a sensor: count its edges first: python3 -c \"import pandas as p; d = p.read_csv('{}'); \
             x = d['{name}']; d['counts'] = ((x > x.median()).astype(int).diff().abs() == 1).cumsum(); \
             d.to_csv('counted.csv', index=False)\"",
            self.name(at),
            self.file_name
        )
    }
}

/// Whether a name is that of a sensor whose voltage is logged.
pub(super) fn is_sensor(facts: &NameFacts) -> bool {
    let has = |word: &String| ANALOGUE.iter().any(|sensor| word.starts_with(sensor));
    facts.words.iter().any(has)
}

/// One revolution in a unit of angle.
pub(super) fn turn_in(unit: &str) -> Option<f64> {
    match unit {
        "deg" => Some(360.0),
        "rad" => Some(TAU),
        "mrad" => Some(1000.0 * TAU),
        "rev" => Some(1.0),
        _ => None,
    }
}
