//! A column of directions for a command without a sign: its number or word for backwards.

use super::super::map::Backwards;
use super::column::Column;
use super::decide::Decision;
use super::given::number_and_rest;
use super::marks::Marks;
use super::unclear::Unclear;
use crate::plain::short;

/// Words of a column of directions.
pub(super) const DIRECTIONS: [&str; 4] = ["dir", "direction", "richtung", "sign"];
/// Most different values of such a column: backwards, standstill, forwards.
const MOST_LEVELS: usize = 3;

impl Decision<'_> {
    /// The column of directions, its level for backwards and the value there, if the command has no sign.
    pub(super) fn direction(
        &mut self,
        command: usize,
        motion: Option<usize>,
    ) -> Result<Option<(usize, Option<usize>, Backwards)>, Unclear> {
        let (at, given) = match &self.given.direction {
            Some(text) if text == "none" => return Ok(None),
            Some(text) => self.stated_direction(text)?,
            None if self.column(command).lowest() < 0.0 => return Ok(None),
            None => match self.direction_by_name() {
                Some(at) => (at, None),
                None => return Ok(None),
            },
        };
        let marks = Marks::of(self.column(at));
        let name = self.name(at);
        if let Some(given) = given {
            let words = format!("{name}: {} is backwards, as given", shown(&given));
            self.understand("direction", Some(at), None, words);
            return Ok(Some((at, marks.find(&given), given)));
        }
        let count = marks.levels.len();
        if !(2..=MOST_LEVELS).contains(&count) {
            return Ok(None);
        }
        // The middle one of three numbers is standstill.
        let by_words = marks.pair();
        let is_numbers = self.column(at).is_numeric();
        let (forwards, backwards) = by_words.unwrap_or((count - 1, 0));
        let turned = motion
            .filter(|_| is_numbers || by_words.is_some() || count == 2)
            .map(|motion| self.turned_at(&marks, backwards, motion));
        let (level, how) = match turned {
            Some((against, along)) if against > along => (backwards, "as the motion shows"),
            Some((against, along)) if against < along => (forwards, "as the motion shows"),
            _ if by_words.is_some() => (
                backwards,
                "by the word; --direction COLUMN:WORD says another",
            ),
            _ if is_numbers => (
                backwards,
                "the smaller one; --direction COLUMN:NUMBER says another",
            ),
            _ => {
                let words: Vec<String> = marks.levels.iter().map(shown).collect();
                let why = format!(
                    "{name} holds {}; the one that is backwards; or none",
                    words.join(", ")
                );
                let flag = self.flag_name(at);
                self.ask("--direction", format!("{flag}:WORD"), why);
                return Ok(None);
            }
        };
        let reverse = marks.levels[level].clone();
        let words = format!("{name}: {} is backwards, {how}", shown(&reverse));
        self.understand("direction", Some(at), None, words);
        Ok(Some((at, Some(level), reverse)))
    }

    /// `dir`, `dir:0` or `dir:CCW`: the value for backwards.
    fn stated_direction(&self, text: &str) -> Result<(usize, Option<Backwards>), Unclear> {
        let (name, reverse) = match text.rsplit_once(':') {
            Some((name, reverse)) if self.find(text).is_none() => (name, Some(backwards(reverse))),
            _ => (text, None),
        };
        let at = self.find(name).ok_or_else(|| Unclear::NoColumn {
            flag: "--direction",
            column: name.to_owned(),
            found: self.all_names(),
        })?;
        let is_there = |backwards: &Backwards| Marks::of(self.column(at)).find(backwards).is_some();
        match &reverse {
            Some(word @ Backwards::Word(_)) if !is_there(word) => Err(Unclear::Form {
                flag: "--direction",
                text: text.to_owned(),
                expected: "a column and the number or word in it that is backwards, such as dir:0 or dir:CCW",
            }),
            Some(Backwards::Number(_)) if !self.column(at).is_numeric() => {
                Err(Unclear::NoNumbers {
                    flag: "--direction",
                    column: name.to_owned(),
                })
            }
            _ => Ok((at, reverse)),
        }
    }

    fn direction_by_name(&self) -> Option<usize> {
        let is_one = |at: &usize| {
            let words = &self.name_facts[*at].words;
            let column = self.column(*at);
            words.iter().any(|word| DIRECTIONS.contains(&word.as_str()))
                && (column.is_numeric() || !column.words.is_empty())
        };
        let mut found = (0..self.survey.columns.len())
            .filter(|at| !self.used.contains(at))
            .filter(is_one);
        found.next().filter(|_| found.next().is_none())
    }

    /// Rows at this level with backward and with forward motion; none if there is no backward motion, since it then
    /// has no sign.
    fn turned_at(&self, marks: &Marks, level: usize, motion: usize) -> (usize, usize) {
        let rates = self.rates(motion);
        if rates.iter().all(|rate| *rate >= 0.0 || rate.is_nan()) {
            return (0, 0);
        }
        let at = || (marks.rows.iter().zip(&rates)).filter(|(at, _)| **at == Some(level));
        let back = at().filter(|(_, rate)| **rate < 0.0).count();
        let on = at().filter(|(_, rate)| **rate > 0.0).count();
        (back, on)
    }

    /// Motion in each row: the speed, or the change of the position.
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

pub(super) fn backwards(text: &str) -> Backwards {
    match number_and_rest(text) {
        Some((number, "")) => Backwards::Number(number),
        _ => Backwards::Word(text.trim().to_owned()),
    }
}

fn shown(level: &Backwards) -> String {
    match level {
        Backwards::Number(number) => short(*number),
        Backwards::Word(word) => word.clone(),
    }
}
