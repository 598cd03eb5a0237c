//! A column of directions beside a command without a sign: which of its numbers is backwards.

use super::column::Column;
use super::decide::{Decision, short};
use super::said::number_and_rest;
use super::unclear::Unclear;

/// Words for a column of directions.
pub(super) const DIRECTIONS: [&str; 4] = ["dir", "direction", "richtung", "sign"];
/// Numbers that such a column has at most: backwards, standstill, forwards.
const MOST_LEVELS: usize = 3;

impl Decision<'_> {
    /// The column of directions and the number in it that is backwards, where the command has no sign of its own.
    pub(super) fn direction(
        &mut self,
        command: usize,
        motion: Option<usize>,
    ) -> Result<Option<(usize, f64)>, Unclear> {
        let (at, said) = match &self.said.direction {
            Some(text) if text == "none" => return Ok(None),
            Some(text) => self.said_direction(text)?,
            None if self.column(command).lowest() < 0.0 => return Ok(None),
            None => match self.direction_by_name() {
                Some(at) => (at, None),
                None => return Ok(None),
            },
        };
        let levels = self.column(at).levels();
        let (Some(&least), Some(&most)) = (levels.first(), levels.last()) else {
            return Ok(None);
        };
        if said.is_none() && (levels.len() < 2 || levels.len() > MOST_LEVELS) {
            return Ok(None);
        }
        let turned = motion.map(|motion| self.turned_at(at, least, motion));
        let (reverse, how) = match (said, turned) {
            (Some(said), _) => (said, "as said"),
            (None, Some((against, along))) if against != along => match against > along {
                true => (least, "as the motion shows"),
                false => (most, "as the motion shows"),
            },
            _ => (
                least,
                "the smaller one; --direction COLUMN:NUMBER says another",
            ),
        };
        let words = format!("{}: {} is backwards, {how}", self.name(at), short(reverse));
        self.understand("direction", Some(at), None, words);
        Ok(Some((at, reverse)))
    }

    /// `dir`, or `dir:0`: the number that is backwards.
    fn said_direction(&self, text: &str) -> Result<(usize, Option<f64>), Unclear> {
        let (name, reverse) = match text.rsplit_once(':') {
            Some((name, number)) if self.find(text).is_none() => match number_and_rest(number) {
                Some((number, "")) => (name, Some(number)),
                _ => {
                    return Err(Unclear::Form {
                        flag: "--direction",
                        text: text.to_owned(),
                        expected: "a column and the number in it that is backwards, such as dir:0",
                    });
                }
            },
            _ => (text, None),
        };
        let at = self.find(name).ok_or_else(|| Unclear::NoColumn {
            flag: "--direction",
            column: name.to_owned(),
            found: self.all_names(),
        })?;
        if !self.column(at).is_numeric() {
            return Err(Unclear::NoNumbers {
                flag: "--direction",
                column: name.to_owned(),
            });
        }
        Ok((at, reverse))
    }

    fn direction_by_name(&self) -> Option<usize> {
        let is_one = |at: &usize| {
            let words = &self.says[*at].words;
            words.iter().any(|word| DIRECTIONS.contains(&word.as_str()))
                && self.column(*at).is_numeric()
        };
        let mut found = (0..self.survey.columns.len())
            .filter(|at| !self.used.contains(at))
            .filter(is_one);
        found.next().filter(|_| found.next().is_none())
    }

    /// Rows at this level in which the motion goes back, and on; none where it never goes back, since it has no sign then.
    fn turned_at(&self, direction: usize, level: f64, motion: usize) -> (usize, usize) {
        let rates = self.rates(motion);
        if rates.iter().all(|rate| *rate >= 0.0 || rate.is_nan()) {
            return (0, 0);
        }
        let levels = &self.column(direction).numbers;
        let at = || levels.iter().zip(&rates).filter(|(at, _)| **at == level);
        let back = at().filter(|(_, rate)| **rate < 0.0).count();
        let on = at().filter(|(_, rate)| **rate > 0.0).count();
        (back, on)
    }

    /// What moves in each row: the speed, or what the position has gone on by.
    pub(super) fn rates(&self, motion: usize) -> Vec<f64> {
        let column = self.column(motion);
        let is_position = self.map.speed.is_none()
            && self
                .map
                .position
                .as_ref()
                .is_some_and(|p| p.increments.is_none());
        match is_position {
            true => std::iter::once(0.0).chain(differences(column)).collect(),
            false => column.numbers.clone(),
        }
    }
}

fn differences(column: &Column) -> impl Iterator<Item = f64> + '_ {
    column.numbers.windows(2).map(|pair| pair[1] - pair[0])
}
