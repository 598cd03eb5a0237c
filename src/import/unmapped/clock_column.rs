//! Which column is the clock.

use super::super::cells::shortened;
use super::clock::{Question, as_time};
use super::clock_units::unit_since_epoch;
use super::decide::Decision;
use super::readings::Readings;
use super::units::Role;

/// A clock with nothing but a unit in its name decreases at most once in so many rows: at a restart of the board.
const MOST_FALLS: usize = 1000;
/// Words of a host's clock: arrivals come late and in bunches, so a device's clock beside it is better.
const HOSTS: [&str; 7] = ["host", "pc", "arrival", "arrived", "received", "recv", "rx"];
/// Names of a time since the row before that say no unit and may as well be counts.
const BARE_DELTA: [&str; 1] = ["delta"];

impl Decision<'_> {
    /// Whether a column is by its name the time since the previous row.
    pub(super) fn is_interval(&self, at: usize) -> bool {
        let words: Vec<&str> = self.name_facts[at]
            .words
            .iter()
            .map(String::as_str)
            .collect();
        self.name_facts[at].role == Some(Role::Interval) || words == BARE_DELTA
    }

    /// Whether a name states a time by more than the unit in its brackets; `ESC signal (µs)` does not.
    fn is_time_by_name(&self, at: usize) -> bool {
        let facts = &self.name_facts[at];
        facts.role == Some(Role::Time) && (facts.is_named || facts.words.len() == 1)
    }

    /// The clock: by name the one with the finest unit; else time stamps; else the only column that rises as a clock does, and does
    /// not count the rows; else the time since the row before.
    pub(super) fn clock(&self) -> Result<usize, Question> {
        let all = || 0..self.survey.columns.len();
        let fineness = |at: usize| match self.name_facts[at].unit {
            Some("ns") => 4,
            Some("us") => 3,
            Some("ms") => 2,
            Some(_) => 1,
            None => 0,
        };
        let is_time = |&at: &usize| {
            let role = self.name_facts[at].role;
            matches!(role, Some(Role::Time | Role::Interval)) && self.column(at).is_numeric()
        };
        let goes_on = |at: usize| {
            let kind = Readings::of(&self.readings(at));
            match self.is_time_by_name(at) {
                true => kind.go_on(),
                // A throttle in µs rises and falls.
                false => kind.go_on() && self.column(at).falls() * MOST_FALLS <= self.survey.rows,
            }
        };
        let named = all().filter(is_time).filter(|&at| goes_on(at));
        let rank = |&at: &usize| {
            let is_rising = Readings::of(&self.readings(at)) == Readings::Rising;
            let is_host =
                (self.name_facts[at].words.iter()).any(|word| HOSTS.contains(&word.as_str()));
            (
                !is_host,
                self.is_time_by_name(at),
                is_rising,
                fineness(at),
                usize::MAX - at,
            )
        };
        // A ratio, 1:50, is written as a time too.
        let is_stamped =
            |at: &usize| self.column(*at).is_stamps() && Readings::of(&self.readings(*at)).go_on();
        let stamped = all().find(is_stamped);
        // A `Time` that counts the rows is none beside time stamps.
        let counts_rows =
            |at: &usize| self.name_facts[*at].unit.is_none() && self.column(*at).is_row_number();
        let named = named.max_by_key(rank);
        if let Some(at) = named
            .filter(|at| stamped.is_none() || !counts_rows(at))
            .or(stamped)
        {
            return Ok(at);
        }
        if let Some(pair) = self.pair(None) {
            return Ok(pair.at);
        }
        // `Ticks` of .NET and of a stopwatch, which may be counts by name.
        let is_ticks = |at: &usize| {
            let column = self.column(*at);
            let is_epoch = || unit_since_epoch(column, column.median_step()).is_some();
            column.is_clock() && (is_epoch() || self.is_tick_clock(*at))
        };
        if let Some(at) = all().find(is_ticks) {
            return Ok(at);
        }
        let is_free = |at: &usize| self.name_facts[*at].role.is_none();
        let (numbers, rising): (Vec<usize>, Vec<usize>) = all()
            .filter(|&at| self.column(at).is_clock())
            .filter(is_free)
            .partition(|&at| self.column(at).is_row_number());
        if let [one] = rising.as_slice() {
            return Ok(*one);
        }
        let is_interval = |&at: &usize| {
            self.is_interval(at) && Readings::of(&self.readings(at)) == Readings::NearOne
        };
        if let Some(at) = all().find(is_interval) {
            return Ok(at);
        }
        if let Some(stated) = self.stated_sample_time().filter(|_| rising.is_empty()) {
            let why = format!(
                "no column is a clock, and a line above the rows says `{}`; of a clock: COLUMN:UNIT",
                shortened(&stated.line)
            );
            return Err((as_time(stated.sample_time_s), why));
        }
        let why = match (rising.as_slice(), numbers.as_slice()) {
            ([], [number, ..]) => {
                let why = format!(
                    "{} counts the rows and is no clock; the time from row to row, such as 20ms; of a clock: COLUMN:UNIT",
                    self.name(*number)
                );
                return Err(("SAMPLETIME".to_owned(), why));
            }
            ([], []) => format!(
                "no column is a clock; the columns are {}; for rows 10 ms apart: --time 10ms",
                self.all_names()
            ),
            _ => format!(
                "several columns rise as a clock does; the columns are {}",
                self.all_names()
            ),
        };
        Err(("COLUMN:UNIT".to_owned(), why))
    }
}
