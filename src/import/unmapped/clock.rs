//! Where the times are, in which unit, and what kind of clock tells them.

use super::super::clock::{Counts, RowClock};
use super::super::map_file::TimeSection;
use super::clock_unit::ClockUnit;
use super::clock_units::{
    CLOCK_WRAP, CLOCK_WRAP_16, in_seconds, is_days, unit_since_epoch, wraps_at_16_bits,
};
use super::column::Column;
use super::decide::Decision;
use super::given::number_and_rest;
use super::readings::Readings;
use super::unclear::Unclear;
use super::units::{Role, unit_of};
use crate::plain::short;

/// Share by which a given sample time contradicts the log's clock; jitter and rounding are smaller.
const CONTRADICTS: f64 = 0.05;

/// A clock that was found.
pub(super) struct Clock {
    pub at: usize,
    pub unit: &'static str,
    /// Source of the unit in the log, if not the name.
    pub unit_by: Option<String>,
    /// The column of the rest of it, and its unit.
    pub fraction: Option<(usize, &'static str)>,
    pub counts: Counts,
    pub wrap: Option<f64>,
    /// Rows that share a reading.
    pub shared: f64,
    /// Time from row to row in s.
    pub step_s: f64,
}

/// Proposed `--time`, and the reason.
pub(super) type Question = (String, String);

impl Decision<'_> {
    /// Where the times are; the time from row to row in s where it is known.
    pub(super) fn time(&mut self) -> Result<Option<f64>, Unclear> {
        self.map.rows.runs = self.given.runs;
        if let Some(text) = &self.given.time
            && self.find(text).is_none()
            && let Some((number, unit)) = number_and_rest(text)
            && let Some(unit) = unit_of(Role::Time, unit)
        {
            let sample_time_s = number * in_seconds(unit);
            self.map.sample_time_s = Some(sample_time_s);
            self.contradicted(sample_time_s);
            let times = (0..self.survey.rows).map(|row| row as f64 * sample_time_s);
            self.times_s = Some(times.collect());
            let words = format!("row number times {number} {unit}");
            self.understand("time", None, None, words);
            return Ok(Some(sample_time_s));
        }
        let found = match &self.given.time {
            Some(text) => {
                let (at, unit) = self.given_column("--time", Role::Time, text)?;
                self.clock_at(at, unit, true)
            }
            None => self.clock().and_then(|at| {
                let found = self.clock_at(at, None, false);
                // It is no position, whatever its unit.
                if found.is_err() && self.column(at).is_clock() {
                    self.used.push(at);
                }
                found
            }),
        };
        match found {
            Ok(clock) => {
                let step_s = clock.step_s;
                self.take_clock(&clock);
                Ok(Some(step_s))
            }
            Err((value, why)) => {
                self.ask("--time", value, why);
                Ok(None)
            }
        }
    }

    /// Takes a clock into the mapping.
    fn take_clock(&mut self, clock: &Clock) {
        let &Clock { at, unit, .. } = clock;
        let name = self.name(at);
        let mut section = TimeSection::of(self.column_ref(at), unit);
        section.wrap = clock.wrap;
        let every = format!("a row every {} s", short(clock.step_s));
        let mut words = match (unit, clock.fraction) {
            ("stamp", None) => format!("{name}, time stamps, {every}"),
            (_, Some((rest, rest_unit))) => {
                section.fraction = Some(self.column_ref(rest));
                section.fraction_unit = Some(rest_unit.to_owned());
                let rest = self.name(rest);
                let whole = if unit == "stamp" { "time stamps" } else { unit };
                format!("{name} in {whole} plus {rest} in {rest_unit}, {every}")
            }
            (_, None) => match &clock.unit_by {
                Some(by) => format!("{name} in {unit}, as {by} tells, {every}"),
                None => format!("{name} in {unit}, {every}"),
            },
        };
        match clock.counts {
            Counts::SinceOrigin => {}
            Counts::SinceRowBefore => {
                section.increments = Some(true);
                words.push_str(": the time since the row before, summed up");
            }
            Counts::Coarsely {
                resolution_s,
                sample_time_s,
            } => {
                section.resolution = Some(resolution_s / in_seconds(unit));
                self.map.sample_time_s = Some(sample_time_s);
                words = format!(
                    "{name} in {unit}, a coarse clock: {} rows share each reading, {} s long; they are spread, {every}",
                    short((clock.shared * 100.0).round() / 100.0),
                    short(resolution_s),
                );
            }
        }
        self.map.time = Some(section);
        self.times_s = Some(self.times_of(clock));
        self.used.extend(clock.fraction.map(|(rest, _)| rest));
        self.understand("time", Some(at), Some(unit), words);
    }

    /// The times of all rows by this clock, as the import makes them.
    fn times_of(&self, clock: &Clock) -> Vec<f64> {
        let seconds = in_seconds(clock.unit);
        let rest = clock
            .fraction
            .map(|(at, unit)| (self.column(at), in_seconds(unit)));
        let mut state = RowClock::default();
        let mut time = |(row, reading): (usize, &f64)| {
            let (unwrapped, after) = state.unwrapped(*reading, clock.wrap);
            let rest_s = rest.map_or(0.0, |(column, unit_s)| column.numbers[row] * unit_s);
            let reading_s = unwrapped * seconds + rest_s;
            if !reading_s.is_finite() {
                return f64::NAN;
            }
            let (time_s, after) = after.time_s(reading_s, row as u64, clock.counts);
            state = after;
            time_s
        };
        let readings = self.column(clock.at).readings();
        readings.iter().enumerate().map(&mut time).collect()
    }

    /// The kind of clock that a column is, and its unit.
    fn clock_at(
        &self,
        at: usize,
        given_unit: Option<&'static str>,
        is_said: bool,
    ) -> Result<Clock, Question> {
        if let Some(pair) = self.pair(Some(at)) {
            return Ok(pair);
        }
        let column = self.column(at);
        let name = self.name(at);
        let readings = self.readings(at);
        let kind = Readings::of(&readings);
        let usual = match kind {
            Readings::Coarse {
                resolution, rows, ..
            } => resolution / rows,
            Readings::NearOne => median(readings.clone()),
            _ => median(readings.windows(2).map(|pair| pair[1] - pair[0]).collect()),
        };
        if let Readings::Coarse { rows, .. } = kind
            && column.is_minutes_or_hours()
        {
            let why = format!(
                "{name} may be minutes and seconds or hours and minutes, and {} rows share each reading; the time from row to row, \
                 {}ms if these are seconds",
                short(rows.round()),
                short(1000.0 * usual)
            );
            return Err(("SAMPLETIME".to_owned(), why));
        }
        let is_interval = is_said || self.is_interval(at);
        let unit = match column.is_stamps() {
            true => Some("stamp"),
            false => (given_unit.or(self.name_facts[at].unit.filter(|unit| is_of_time(unit))))
                .or_else(|| is_days(column, usual).then_some("d"))
                .or_else(|| unit_since_epoch(column, usual)),
        };
        let counts = |unit_s: f64| match kind {
            Readings::Rising => Ok((Counts::SinceOrigin, 1.0)),
            Readings::NearOne if is_interval => Ok((Counts::SinceRowBefore, 1.0)),
            Readings::Coarse {
                resolution,
                rows,
                is_even: true,
            } => {
                let resolution_s = resolution * unit_s;
                let sample_time_s = resolution_s / rows;
                let counts = Counts::Coarsely {
                    resolution_s,
                    sample_time_s,
                };
                Ok((counts, rows))
            }
            Readings::Coarse { .. } => {
                let mean_s = mean_step(&readings) * unit_s;
                let why = format!(
                    "rows arrive in bunches: several share a reading of {name}, and its steps are uneven. \
                     They come every {} s on average; for a column: COLUMN:UNIT",
                    short(mean_s)
                );
                Err((as_time(mean_s), why))
            }
            Readings::NearOne | Readings::Other => {
                let why = format!(
                    "{name} does not rise from row to row, so it is no clock; the columns are {}; \
                     for rows 10 ms apart: --time 10ms",
                    self.all_names()
                );
                Err(("COLUMN:UNIT".to_owned(), why))
            }
        };
        let ClockUnit { unit, by } = match unit {
            Some(unit) => ClockUnit { unit, by: None },
            None => {
                // Whether it is a clock at all comes before its unit.
                counts(1.0)?;
                self.unit_by_step(at, usual)?
            }
        };
        let unit_s = in_seconds(unit);
        let (counts, shared) = counts(unit_s)?;
        let is_counter =
            column.is_whole() && counts != Counts::SinceRowBefore && matches!(unit, "ms" | "us");
        let wrap = match wraps_at_16_bits(&readings, usual) {
            true => CLOCK_WRAP_16,
            false => CLOCK_WRAP,
        };
        Ok(Clock {
            at,
            unit,
            unit_by: by,
            fraction: None,
            counts,
            wrap: is_counter.then_some(wrap),
            shared,
            step_s: usual * unit_s,
        })
    }

    /// The readings of a column as a clock, without rows that have none. Where signals of different rates share rows, one reading
    /// may stand in several of them.
    pub(super) fn readings(&self, at: usize) -> Vec<f64> {
        let finite = |reading: &&f64| reading.is_finite();
        let readings = self.column(at).readings().iter().filter(finite);
        let mut readings: Vec<f64> = readings.copied().collect();
        let is_sparse = |column: &Column| 10 * column.empty > self.survey.rows;
        if self.survey.columns.iter().any(is_sparse) {
            readings.dedup();
        }
        readings
    }

    /// A note where the log's clock contradicts the given sample time.
    fn contradicted(&mut self, sample_time_s: f64) {
        let clock = (self.clock()).and_then(|at| self.clock_at(at, None, false));
        let Ok(clock) = clock else { return };
        let times = clock.step_s / sample_time_s;
        if clock.step_s > 0.0 && !(1.0 - CONTRADICTS..=1.0 + CONTRADICTS).contains(&times) {
            self.notes.push(format!(
                "{} says that the rows are {} s apart, not {} s as --time says; with --time every time constant is {} that of the clock; \
                 hint: leave --time out to take the clock of the log",
                self.name(clock.at),
                short(clock.step_s),
                short(sample_time_s),
                match times < 1.0 {
                    true => format!("{} times", short(times.recip())),
                    false => format!("1/{} of", short(times)),
                },
            ));
        }
    }
}

pub(super) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
}

fn mean_step(readings: &[f64]) -> f64 {
    match readings {
        [first, .., last] => (last - first) / (readings.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// A sample time in the form of `--time`.
pub(super) fn as_time(seconds: f64) -> String {
    format!("{}ms", short(1000.0 * seconds))
}

/// Whether a unit is one of time.
fn is_of_time(unit: &str) -> bool {
    unit_of(Role::Time, unit).is_some()
}
