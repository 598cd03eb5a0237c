//! Decides the mapping of a log from its columns and the given facts, or the missing facts.
//!
//! A quantity is in the column given by its flag; else in the only column with such a name. A unit is that of the
//! flag; else of the name; else the only one consistent with the numbers. Everything else is requested.

use super::super::map::ColumnRef;
use super::super::map_file::{Empty, FieldSection, MapFile};
use super::column::Column;
use super::direction::DIRECTIONS;
use super::given::{GivenColumn, GivenFlags, expected};
use super::names::{NameFacts, name_facts, name_outputs};
use super::survey::Survey;
use super::turns::is_sensor;
use super::unclear::{Missing, Unclear};
use super::units::Role;
use crate::plain::short;

/// Most columns in a message.
pub(super) const MOST_NAMED: usize = 30;

/// One decision.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Understood {
    /// time, command, position, speed, supply, current, counts_per_rev, rows or unused.
    pub what: &'static str,
    /// The column, by its name or number.
    pub column: Option<String>,
    /// Its unit.
    pub unit: Option<String>,
    /// Text, with the evidence in the numbers.
    pub words: String,
}

/// State of the decisions.
pub(super) struct Decision<'a> {
    pub survey: &'a Survey,
    pub given: &'a GivenFlags,
    /// Name of the log, without its folder.
    pub file_name: &'a str,
    pub name_facts: Vec<NameFacts>,
    pub map: MapFile,
    pub understood: Vec<Understood>,
    pub notes: Vec<String>,
    pub missing: Vec<Missing>,
    /// The flags of the proposed command line.
    pub line: Vec<(&'static str, String)>,
    /// Columns in use.
    pub used: Vec<usize>,
    /// The column of the command's direction, and its level for backwards.
    pub reverse: Option<(usize, usize)>,
    /// The signed command of every row in any unit, if known.
    pub commands: Option<Vec<f64>>,
    /// The speed has steps of counts, or its integration rule is given.
    pub is_difference: bool,
    /// Time of every row in s, if known; NaN in rows without one.
    pub times_s: Option<Vec<f64>>,
}

impl<'a> Decision<'a> {
    pub fn new(survey: &'a Survey, given: &'a GivenFlags, file_name: &'a str) -> Self {
        let mut name_facts: Vec<NameFacts> = (survey.columns.iter())
            .map(|column| {
                let name = column.name.as_deref().unwrap_or_default();
                name_facts(name, column.unit_line.as_deref())
            })
            .collect();
        // The voltage of a sensor is no command.
        for facts in name_facts.iter_mut().filter(|facts| is_sensor(facts)) {
            facts.role = facts.role.filter(|role| *role != Role::Command);
        }
        name_outputs(&mut name_facts, |at| survey.columns[at].is_numeric());
        let mut map = MapFile {
            file: survey.file.clone(),
            ..MapFile::default()
        };
        map.rows.every = given.every;
        map.m_per_rev = given.m_per_rev;
        let times: Vec<String> = (name_facts.iter().zip(&survey.columns)).filter_map(|(facts, column)| {
                let (times, name) = (facts.times?, column.name.as_ref()?);
                Some(format!(
                    "`{name}`: by its name its numbers are {} times the quantity, and a unit takes them as they are; \
                     hint: --save-map map.toml, there `scale = {}`, then --map map.toml",
                    short(times),
                    short(1.0 / times)
                ))
        }).collect();
        Self {
            survey,
            given,
            file_name,
            name_facts,
            map,
            understood: Vec::new(),
            notes: survey.notes.iter().cloned().chain(times).collect(),
            missing: Vec::new(),
            line: given.flags(),
            used: Vec::new(),
            reverse: None,
            commands: None,
            is_difference: false,
            times_s: None,
        }
    }

    /// Decides everything.
    pub fn decide(&mut self) -> Result<(), Unclear> {
        let step_s = self.time()?;
        let motion = self.motion(step_s)?;
        self.command(motion)?;
        if let Some(motion) = motion {
            self.integration(motion);
        }
        self.current()?;
        self.rows();
        if self.given.reverse {
            self.map.reverse();
        }
        Ok(())
    }

    pub fn column(&self, at: usize) -> &'a Column {
        &self.survey.columns[at]
    }

    /// A column for messages: its name, or its number.
    pub fn name(&self, at: usize) -> String {
        match &self.column(at).name {
            Some(name) => format!("`{name}`"),
            None => format!("column {}", at + 1),
        }
    }

    /// Reference of a column in the mapping.
    pub fn column_ref(&self, at: usize) -> ColumnRef {
        match &self.column(at).name {
            Some(name) if self.column(at).is_by_name => ColumnRef::Name(name.clone()),
            _ => ColumnRef::Number(at + 1),
        }
    }

    /// A column in a flag: by its number if its name is not usable.
    pub fn flag_name(&self, at: usize) -> String {
        match self.column_ref(at) {
            ColumnRef::Name(name) => name,
            ColumnRef::Number(number) => number.to_string(),
        }
    }

    /// Every column with the range of its numbers, for messages.
    pub fn all_names(&self) -> String {
        let name = |at: usize| {
            let column = self.column(at);
            let range = match column.is_numeric() {
                true => format!(
                    " ({} to {})",
                    short(column.lowest()),
                    short(column.highest())
                ),
                false => String::new(),
            };
            let name = (column.name.as_ref()).map_or(String::new(), |name| format!(" `{name}`"));
            format!("{}{name}{range}", at + 1)
        };
        let count = self.survey.columns.len();
        let names: Vec<String> = (0..count.min(MOST_NAMED)).map(name).collect();
        let more = match count.saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        names.join(", ") + &more
    }

    /// The column of a flag, and its unit.
    pub fn given_column(
        &self,
        flag: &'static str,
        role: Role,
        text: &str,
    ) -> Result<(usize, Option<&'static str>), Unclear> {
        let found = GivenColumn::parse(flag, role, text, |whole| self.find(whole).is_some())?;
        let at = self.find(&found.column).ok_or_else(|| Unclear::NoColumn {
            flag,
            column: found.column.clone(),
            found: self.all_names(),
        })?;
        let is_stamped_clock = role == Role::Time && self.column(at).is_stamps();
        if !self.column(at).is_numeric() && !is_stamped_clock {
            let column = found.column;
            return Err(Unclear::NoNumbers { flag, column });
        }
        Ok((at, found.unit))
    }

    pub fn find(&self, column: &str) -> Option<usize> {
        let columns = &self.survey.columns;
        let by = |is: &dyn Fn(&str) -> bool| {
            let mut found =
                (0..columns.len()).filter(|&at| columns[at].name.as_deref().is_some_and(is));
            found.next().filter(|_| found.next().is_none())
        };
        let number = || {
            column
                .parse::<usize>()
                .ok()
                .filter(|n| (1..=columns.len()).contains(n))
        };
        by(&|name| name == column)
            .or_else(|| by(&|name| name.eq_ignore_ascii_case(column)))
            .or_else(|| number().map(|n| n - 1))
    }

    /// Numeric columns with names of this quantity.
    pub fn candidates(&self, role: Role) -> Vec<usize> {
        (0..self.survey.columns.len())
            .filter(|&at| self.name_facts[at].role == Some(role) && self.column(at).is_numeric())
            .filter(|at| !self.used.contains(at))
            .collect()
    }

    /// Candidates that share a word with the columns in use, unlike the others: `left_duty` with `left_rpm`.
    pub fn beside_used(&self, candidates: Vec<usize>) -> Vec<usize> {
        if candidates.len() < 2 {
            return candidates;
        }
        let is_common = |word: &String| {
            candidates
                .iter()
                .all(|&at| self.name_facts[at].words.contains(word))
        };
        let belongs = |&at: &usize| {
            self.name_facts[at].words.iter().any(|word| {
                let is_used = self
                    .used
                    .iter()
                    .any(|&used| self.name_facts[used].words.contains(word));
                is_used && !is_common(word)
            })
        };
        let beside: Vec<usize> = candidates.iter().copied().filter(belongs).collect();
        match beside.is_empty() {
            true => candidates,
            false => beside,
        }
    }

    pub fn understand(
        &mut self,
        what: &'static str,
        at: Option<usize>,
        unit: Option<&str>,
        words: String,
    ) {
        let column = at.map(|at| self.flag_name(at));
        self.understood.push(Understood {
            what,
            column,
            unit: unit.map(str::to_owned),
            words,
        });
        self.used.extend(at);
    }

    /// Adds a missing fact: the flag, an example of its value for the command line, and the reason.
    pub fn ask(&mut self, flag: &'static str, value: String, why: String) {
        self.missing.push(Missing {
            flag: format!("{flag} {value}").trim().to_owned(),
            why,
        });
        match self.line.iter_mut().find(|(name, _)| *name == flag) {
            Some(asked) => asked.1 = value,
            None => self.line.push((flag, value)),
        }
    }

    /// Continues with the proposal of a question, so that all questions are asked at once, without recording it as
    /// decided.
    pub fn tentatively<T>(&mut self, go_on: impl FnOnce(&mut Self) -> T) -> T {
        let (understood, notes) = (self.understood.len(), self.notes.len());
        let found = go_on(self);
        self.understood.truncate(understood);
        self.notes.truncate(notes);
        found
    }

    fn current(&mut self) -> Result<(), Unclear> {
        let found = match &self.given.current {
            Some(text) => Some(self.given_column("--current", Role::Current, text)?),
            None => match self.beside_used(self.candidates(Role::Current)).as_slice() {
                [one] => Some((*one, None)),
                _ => None,
            },
        };
        let Some((at, given_unit)) = found else {
            return Ok(());
        };
        let name = self.name(at);
        let Some(unit) = given_unit.or(self.name_facts[at].unit) else {
            let flag = self.flag_name(at);
            if self.given.current.is_some() {
                let why = format!("{name} names no unit; {}", expected(Role::Current));
                self.ask("--current", format!("{flag}:A"), why);
            } else {
                self.notes.push(format!(
                    "{name} names no unit, so no current is read; --current {flag}:A says it"
                ));
            }
            return Ok(());
        };
        self.map.current = Some(FieldSection::of(self.column_ref(at), unit));
        self.understand(
            "current",
            Some(at),
            Some(unit),
            format!("{name} in {unit}, measured"),
        );
        Ok(())
    }

    /// Rows without values, decimation, and unused columns.
    fn rows(&mut self) {
        let holes: Vec<usize> = (self.used.iter().copied())
            .filter(|&at| self.column(at).empty > 0)
            .collect();
        if !holes.is_empty() {
            self.map.rows.empty = Some(Empty::Hold);
            let names: Vec<String> = holes.iter().map(|&at| self.name(at)).collect();
            let words = format!(
                "{} with empty cells: the command holds its last value",
                names.join(", ")
            );
            self.understand("rows", None, None, words);
        }
        if let Some(split_by) = &self.survey.split_by {
            self.map.rows.split_by = Some(ColumnRef::Name(split_by.clone()));
            let words = format!("a run for every `{split_by}`");
            self.understand("rows", None, None, words);
        }
        if let Some(every) = self.given.every.filter(|every| *every > 1) {
            let words = format!("one of {every}, with the mean of the command until the next");
            self.understand("rows", None, None, words);
        }
        let rest: Vec<String> = (0..self.survey.columns.len())
            .filter(|at| !self.used.contains(at))
            .map(|at| self.name(at))
            .collect();
        let is_direction = |at: &usize| {
            let words = &self.name_facts[*at].words;
            words.iter().any(|word| DIRECTIONS.contains(&word.as_str()))
        };
        let has_sign =
            |at: &usize| self.column(*at).is_numeric() && self.column(*at).lowest() < 0.0;
        if let Some(at) = (0..self.survey.columns.len()).find(is_direction)
            && !self.used.contains(&at)
            && !self.used.iter().any(has_sign)
        {
            let name = self.name(at);
            self.notes.push(format!(
                "{name} is not used, so command and motion have no sign"
            ));
        }
        if !rest.is_empty() {
            let mut words = rest[..rest.len().min(MOST_NAMED)].join(", ");
            if rest.len() > MOST_NAMED {
                words.push_str(&format!(" and {} more", rest.len() - MOST_NAMED));
            }
            self.understand("unused", None, None, words);
        }
    }
}
