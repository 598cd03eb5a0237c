//! Where the times are, and in which unit.

use super::super::map_file::TimeSection;
use super::decide::{Decision, short};
use super::said::number_and_rest;
use super::unclear::Unclear;
use super::units::{Role, unit_of};

/// Sample times in s of motors' logs: 5 kHz to a row a second, which shows no motor's start. A clock that goes on by 20 counts ms then,
/// since 20 us and 20 s are none; from 200 to 900 it may count us or ms.
const SAMPLE_TIMES_S: (f64, f64) = (2e-4, 0.9);
/// `micros()` and `millis()` begin again at 0 here.
const CLOCK_WRAP: f64 = 4_294_967_296.0;

impl Decision<'_> {
    /// Where the times are; the time from row to row in s where it is known.
    pub(super) fn time(&mut self) -> Result<Option<f64>, Unclear> {
        if let Some(text) = &self.said.time
            && self.find(text).is_none()
            && let Some((number, unit)) = number_and_rest(text)
            && let Some(unit) = unit_of(Role::Time, unit)
        {
            let sample_time_s = number * in_seconds(unit);
            self.map.sample_time_s = Some(sample_time_s);
            self.understand(
                "time",
                None,
                None,
                format!("row number times {number} {unit}"),
            );
            return Ok(Some(sample_time_s));
        }
        let (at, said_unit) = match &self.said.time {
            Some(text) => self.said_column("--time", Role::Time, text)?,
            None => match self.clock() {
                Ok(at) => (at, None),
                Err((value, why)) => {
                    self.ask("--time", value.to_owned(), why);
                    return Ok(None);
                }
            },
        };
        let column = self.column(at);
        let name = self.name(at);
        if column.is_stamps() {
            self.map.time = Some(TimeSection::of(self.column_ref(at), "stamp", None));
            self.understand(
                "time",
                Some(at),
                Some("stamp"),
                format!("{name}, time stamps"),
            );
            return Ok(None);
        }
        let step = column.median_step();
        let unit = said_unit
            .or(self.says[at].unit)
            .or_else(|| unit_of_clock(step));
        let Some(unit) = unit else {
            let flag = self.flag_name(at);
            self.used.push(at);
            let why = format!(
                "{name} goes on by {} from row to row and names no unit; s, ms or us",
                short(step)
            );
            self.ask("--time", format!("{flag}:ms"), why);
            return Ok(None);
        };
        self.clock = Some((at, in_seconds(unit)));
        let is_counter = column.is_whole() && matches!(unit, "ms" | "us");
        let wrap = is_counter.then_some(CLOCK_WRAP);
        self.map.time = Some(TimeSection::of(self.column_ref(at), unit, wrap));
        let step_s = step * in_seconds(unit);
        let words = format!("{name} in {unit}, a row every {} s", short(step_s));
        self.understand("time", Some(at), Some(unit), words);
        Ok(Some(step_s))
    }

    /// The clock: by name the one with the finest unit; else the only column that rises as a clock does, and does not count the
    /// rows. Else what `--time` is to say, and why.
    fn clock(&self) -> Result<usize, (&'static str, String)> {
        let all = || 0..self.survey.columns.len();
        let fineness = |at: usize| match self.says[at].unit {
            Some("ns") => 4,
            Some("us") => 3,
            Some("ms") => 2,
            Some(_) => 1,
            None => 0,
        };
        let named = all()
            .filter(|&at| self.says[at].role == Some(Role::Time) && self.column(at).is_numeric());
        if let Some(at) = named.max_by_key(|&at| (fineness(at), usize::MAX - at)) {
            return Ok(at);
        }
        if let Some(at) = all().find(|&at| self.column(at).is_stamps()) {
            return Ok(at);
        }
        let is_free = |at: &usize| self.says[*at].role.is_none();
        let (numbers, rising): (Vec<usize>, Vec<usize>) = all()
            .filter(|&at| self.column(at).is_clock())
            .filter(is_free)
            .partition(|&at| self.column(at).is_row_number());
        match (rising.as_slice(), numbers.as_slice()) {
            ([one], _) => Ok(*one),
            ([], [number, ..]) => Err((
                "SAMPLETIME",
                format!(
                    "{} counts the rows and is no clock; the time from row to row, such as 20ms; of a clock: COLUMN:UNIT",
                    self.name(*number)
                ),
            )),
            ([], []) => Err((
                "COLUMN:UNIT",
                format!(
                    "no column is a clock; the columns are {}; for rows 10 ms apart: --time 10ms",
                    self.all_names()
                ),
            )),
            _ => Err((
                "COLUMN:UNIT",
                format!(
                    "several columns rise as a clock does; the columns are {}",
                    self.all_names()
                ),
            )),
        }
    }
}

/// Seconds in a unit of time.
pub(super) fn in_seconds(unit: &str) -> f64 {
    match unit {
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "min" => 60.0,
        _ => 1.0,
    }
}

/// The unit in which a clock that goes on by `step` a row gives a sample time that motors are sampled with: no two do.
fn unit_of_clock(step: f64) -> Option<&'static str> {
    let (least_s, most_s) = SAMPLE_TIMES_S;
    let holds = |unit: &&str| (least_s..=most_s).contains(&(step * in_seconds(unit)));
    let mut found = ["s", "ms", "us"].into_iter().filter(holds);
    found.next().filter(|_| found.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_clock_is_decided_only_where_one_fits() {
        for (step, unit) in [
            (0.003, Some("s")),
            (0.1, Some("s")),
            (0.25, None),
            (250.0, None),
            (1.0, Some("ms")),
            (20.0, Some("ms")),
            (5000.0, Some("us")),
            (1e7, None),
            (0.0, None),
            (f64::NAN, None),
        ] {
            assert_eq!(unit_of_clock(step), unit, "{step}");
        }
    }
}
