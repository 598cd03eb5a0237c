//! Content of one column of a log, by its values.

use super::super::cells::{decode, number};
use super::super::clock::FirstReading;
use super::super::stamp::stamp;
use super::grid::step_of;

/// Share of the cells that are not empty which must be numbers: words in between are messages.
const NUMBERS: f64 = 0.9;
/// More digits after the point than a print has by choice: a float's own.
const MOST_DIGITS: usize = 9;

/// A stamp below this many seconds is of the first minute, or of the first hour after midnight.
const MINUTE_S: f64 = 60.0;

/// Different words of a column that are few.
const FEW_WORDS: usize = 8;

/// A column under the survey.
#[derive(Debug, Clone, Default)]
pub(super) struct Column {
    pub name: Option<String>,
    /// The import can ask for it by its name.
    pub is_by_name: bool,
    pub unit_line: Option<String>,
    /// NaN for a cell that is no number. Integers beyond 2^53 are relative to the first one.
    pub numbers: Vec<f64>,
    first: Option<FirstReading>,
    /// Of a time stamp the seconds; NaN where a cell is none.
    pub stamp_s: Vec<f64>,
    pub empty: usize,
    pub stamps: usize,
    /// Of these, minutes and seconds that may be hours and minutes.
    either: usize,
    pub has_comma: bool,
    word_cells: usize,
    /// The different words in it, as far as they are few, and which of them each row has.
    pub words: Vec<String>,
    pub words_at: Vec<Option<usize>>,
    digits: usize,
}

impl Column {
    /// A column whose name, and perhaps its unit, are known.
    pub fn named(name: &str, unit: Option<String>) -> Self {
        Self {
            name: Some(name.to_owned()),
            is_by_name: true,
            unit_line: unit,
            ..Self::default()
        }
    }

    /// One more cell.
    pub fn take(&mut self, cell: &[u8], is_decimal_comma: bool) {
        let parsed = number(cell, is_decimal_comma, "");
        let stamped = match &parsed {
            Err(_) if !cell.is_empty() => stamp(cell),
            _ => None,
        };
        self.stamp_s.push(stamped.map_or(f64::NAN, |stamp| stamp.s));
        match &parsed {
            Ok(_) => {
                self.has_comma |= cell.contains(&b',');
                let point = cell.iter().position(|byte| matches!(byte, b'.' | b','));
                let digits = point.map_or(0, |at| cell.len() - at - 1);
                let has_power = cell.iter().any(|byte| matches!(byte, b'e' | b'E'));
                self.digits = self.digits.max(if has_power { usize::MAX } else { digits });
            }
            Err(_) if cell.is_empty() => self.empty += 1,
            Err(_) if stamped.is_some() => {
                self.stamps += 1;
                self.either += usize::from(stamped.is_some_and(|stamp| stamp.is_either));
            }
            Err(_) => self.word_cells += 1,
        }
        let word = match parsed {
            Err(_) if !cell.is_empty() => self.word(cell),
            _ => None,
        };
        self.words_at.push(word);
        let number = parsed.map_or(f64::NAN, |number| {
            let first = self.first.get_or_insert_with(|| FirstReading::of(cell));
            first.since(cell, number)
        });
        self.numbers.push(number);
    }

    /// The number of a word; none beyond a few.
    fn word(&mut self, cell: &[u8]) -> Option<usize> {
        let word = decode(cell);
        let found = self.words.iter().position(|known| *known == word);
        if found.is_none() && self.words.len() <= FEW_WORDS {
            self.words.push(word.into_owned());
            return Some(self.words.len() - 1);
        }
        found
    }

    fn finite(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        self.numbers.iter().copied().filter(|x| x.is_finite())
    }

    pub fn is_numeric(&self) -> bool {
        let count = self.finite().count();
        count > 0 && count as f64 >= NUMBERS * (count + self.word_cells + self.stamps) as f64
    }

    pub fn is_stamps(&self) -> bool {
        self.stamps > 0 && self.stamps as f64 >= NUMBERS * (self.numbers.len() - self.empty) as f64
    }

    /// Whether its time stamps may be hours and minutes as well as minutes and seconds: they do not begin at 0, and stay below 24.
    pub fn is_minutes_or_hours(&self) -> bool {
        let first = self.stamp_s.iter().find(|s| s.is_finite());
        self.is_stamps() && self.either == self.stamps && first.is_some_and(|s| *s >= MINUTE_S)
    }

    pub fn is_whole(&self) -> bool {
        self.digits == 0 || self.finite().all(|x| x.fract() == 0.0)
    }

    pub fn lowest(&self) -> f64 {
        self.first_rounded() + self.finite().fold(f64::INFINITY, f64::min)
    }

    pub fn highest(&self) -> f64 {
        self.first_rounded() + self.finite().fold(f64::NEG_INFINITY, f64::max)
    }

    fn first_rounded(&self) -> f64 {
        self.first.map_or(0.0, FirstReading::rounded)
    }

    /// Largest magnitude.
    pub fn most(&self) -> f64 {
        self.highest().max(-self.lowest())
    }

    /// Differences of neighbours.
    pub fn steps(&self) -> Vec<f64> {
        let numbers: Vec<f64> = self.finite().collect();
        numbers.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Rows in which it falls.
    pub fn falls(&self) -> usize {
        self.steps().iter().filter(|step| **step < 0.0).count()
    }

    /// Median of the steps; NaN where there are none.
    pub fn median_step(&self) -> f64 {
        let mut steps = self.steps();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// The readings of a clock, row by row: numbers, or the seconds of time stamps.
    pub fn readings(&self) -> &[f64] {
        match self.is_stamps() {
            true => &self.stamp_s,
            false => &self.numbers,
        }
    }

    /// Whether it rises as a clock does: from every row to the next, but for a new start in a thousand.
    pub fn is_clock(&self) -> bool {
        let steps = self.steps();
        let falls = steps.iter().filter(|step| **step <= 0.0).count();
        !steps.is_empty() && self.is_numeric() && falls * 1000 <= steps.len()
    }

    /// Whether it counts the rows: whole numbers that rise by 1.
    pub fn is_row_number(&self) -> bool {
        self.is_clock() && self.is_whole() && self.median_step() == 1.0
    }

    /// Half of the last digit; 0 where the digits are a float's own.
    pub fn rounding(&self) -> f64 {
        if self.digits > MOST_DIGITS {
            return 0.0;
        }
        0.5 * 0.1_f64.powi(self.digits as i32)
    }

    /// The step that its numbers come in.
    pub fn step(&self) -> Option<f64> {
        let numbers: Vec<f64> = self.finite().collect();
        step_of(&numbers, self.rounding())
    }

    /// The different numbers in it, least first.
    pub fn levels(&self) -> Vec<f64> {
        let finite = self.numbers.iter().copied().filter(|x| x.is_finite());
        let mut levels: Vec<f64> = finite.collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        levels
    }

    /// Whether its digits are fine enough that steps would show: a hundred of them in the range.
    pub fn is_fine(&self) -> bool {
        self.rounding() * 2.0 * 1000.0 < self.most()
    }
}
