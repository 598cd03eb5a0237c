//! The unit of a clock without one in its name: the units that its step allows; of several, the one that other columns of the log agree with.

use super::clock::as_time;
use super::clock_units::{in_seconds, units_of_clock};
use super::decide::Decision;
use super::given::number_and_rest;
use super::readings::Readings;
use super::units::{Role, unit_of};
use crate::plain::short;

/// Words of time counters in addition to those of encoder counters.
const TICKS: [&str; 7] = [
    "ticks",
    "tick",
    "qpc",
    "stopwatch",
    "systick",
    "elapsedticks",
    "timerticks",
];
/// Words of hundredths of a second.
const HUNDREDTHS: [&str; 4] = ["cs", "centiseconds", "hundredths", "csec"];
/// Words of a processor's cycles, which are no unit of time.
const CYCLES: [&str; 4] = ["cycles", "cyccnt", "ccount", "tsc"];
/// Steps of a counter of time are within this factor of their median...
const STEADY: f64 = 1.5;
/// ...in this share of the rows, whatever the motor does.
const STEADY_ROWS: f64 = 0.9;
/// Least counts a row of a counter of time: an encoder has made fewer.
const LEAST_TICKS: f64 = 1000.0;
/// Two clocks agree on a unit within this factor: units are 10 and more apart.
const AGREES: f64 = 1.5;

/// The proposed unit is the one with the sample time nearest to this, in s.
const USUAL_S: f64 = 0.02;

/// A unit and its source in the log, if not the name.
pub(super) struct ClockUnit {
    pub unit: &'static str,
    pub by: Option<String>,
}

impl Decision<'_> {
    /// Whether a column named like an encoder's counts is a time counter: it advances evenly, and another column is the motion.
    pub(super) fn is_tick_clock(&self, at: usize) -> bool {
        let column = self.column(at);
        let step = column.median_step();
        let steps = column.steps();
        let is_steady = |next: &&f64| (step / STEADY..=step * STEADY).contains(*next);
        let steady = steps.iter().filter(is_steady).count();
        let is_motion = |other: &usize| {
            let role = self.name_facts[*other].role;
            let roles = [Role::Position, Role::Increments, Role::Speed].map(Some);
            *other != at && roles.contains(&role) && self.column(*other).is_numeric()
        };
        self.has_word(at, &TICKS)
            && column.is_whole()
            && step >= LEAST_TICKS
            && steady as f64 >= STEADY_ROWS * steps.len() as f64
            && (0..self.survey.columns.len()).any(|other| is_motion(&other))
    }

    fn has_word(&self, at: usize, list: &[&str]) -> bool {
        let words = &self.name_facts[at].words;
        words.iter().any(|word| list.contains(&word.as_str()))
    }

    /// The unit of a clock with this step from row to row: the only one with a usual sample time; of several, the one in which it agrees with
    /// another clock of the log or with a stated sample time. Otherwise the missing fact.
    pub(super) fn unit_by_step(&self, at: usize, step: f64) -> Result<ClockUnit, (String, String)> {
        let (name, flag) = (self.name(at), self.flag_name(at));
        if self.has_word(at, &CYCLES) {
            let why = format!(
                "{name} goes on by {} from row to row, in cycles of a processor, which are no unit of time; \
                 the time from row to row, such as 10ms; of a clock: COLUMN:UNIT",
                short(step)
            );
            return Err(("SAMPLETIME".to_owned(), why));
        }
        if let Some((unit, unit_s)) = self.times_a_unit(at) {
            let why = format!(
                "{name} counts in {unit} by its name, which is no unit of a clock here: a row every {} s; of another clock: COLUMN:UNIT",
                short(step * unit_s)
            );
            return Err((as_time(step * unit_s), why));
        }
        let units = units_of_clock(step, self.has_word(at, &TICKS));
        let told = self.step_told(at, step);
        let is_other = |unit: &str| {
            let times = |step_s: f64| step * in_seconds(unit) / step_s;
            told.as_ref()
                .is_some_and(|(step_s, _)| times(*step_s).log10().round() != 0.0)
        };
        if let [unit] = units.as_slice()
            && !is_other(unit)
        {
            return Ok(ClockUnit { unit, by: None });
        }
        if let Some((step_s, by)) = &told {
            let agrees = |unit: &&&str| {
                let times = step * in_seconds(unit) / step_s;
                (AGREES.recip()..=AGREES).contains(&times)
            };
            if let Some(unit) = units.iter().find(agrees) {
                let by = Some(by.clone());
                return Ok(ClockUnit { unit, by });
            }
        }
        let gives =
            |unit: &&str| format!("in {unit} a row every {} s", short(step * in_seconds(unit)));
        let what = match units.as_slice() {
            [] => "s, ms, us, 100ns or ns".to_owned(),
            units => units.iter().map(gives).collect::<Vec<_>>().join(", "),
        };
        let told = told.map_or_else(String::new, |(step_s, by)| {
            format!(", and by {by} every {} s", short(step_s))
        });
        let why = format!(
            "{name} goes on by {} from row to row and names no unit: {what}{told}; for rows 10 ms apart: --time 10ms",
            short(step)
        );
        let off = |unit: &&&str| (step * in_seconds(unit) / USUAL_S).ln().abs();
        let nearest = units.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let proposed = nearest.copied().unwrap_or("UNIT");
        Err((format!("{flag}:{proposed}"), why))
    }

    /// A multiple of a unit in a name: `time_cs`, `t_100us`, `Time [0.1 ms]`; its words, and its seconds.
    fn times_a_unit(&self, at: usize) -> Option<(String, f64)> {
        let column = self.column(at);
        let texts = [column.name.as_deref(), column.unit_line.as_deref()];
        texts.into_iter().flatten().find_map(|text| {
            let text = text.replace(['µ', 'μ'], "u").to_lowercase();
            let is_between = |c: char| !c.is_alphanumeric() && c != '.';
            let words: Vec<&str> = text
                .split(is_between)
                .filter(|word| !word.is_empty())
                .collect();
            if let Some(word) = words.iter().find(|word| HUNDREDTHS.contains(word)) {
                return Some(((*word).to_owned(), 0.01));
            }
            let spaced = words.windows(2).map(|two| two.concat());
            let all: Vec<String> = words
                .iter()
                .map(|word| (*word).to_owned())
                .chain(spaced)
                .collect();
            all.iter().find_map(|word| {
                let (times, unit) = number_and_rest(word)?;
                let unit = unit_of(Role::Time, unit)?;
                Some((format!("{} {unit}", short(times)), times * in_seconds(unit)))
            })
        })
    }

    /// Time from row to row in s by another clock, whose unit is known, or by a line that states it; and which.
    fn step_told(&self, at: usize, step: f64) -> Option<(f64, String)> {
        let clock = &self.column(at).readings();
        let by_column = |other: usize| {
            let column = self.column(other);
            let unit = match column.is_stamps() {
                true => "s",
                false => self.name_facts[other].unit?,
            };
            let kind = Readings::of(&self.readings(other));
            let is_time = column.is_stamps() || self.name_facts[other].role == Some(Role::Time);
            let both = clock.iter().zip(column.readings());
            let both: Vec<(f64, f64)> = (both.map(|(a, b)| (*a, *b)))
                .filter(|(a, b)| a.is_finite() && b.is_finite())
                .collect();
            let ((from, from_other), (to, to_other)) = (*both.first()?, *both.last()?);
            let step_s = (to_other - from_other) * in_seconds(unit) * step / (to - from);
            let is_source = other != at && is_time && kind.go_on() && step_s > 0.0;
            is_source.then(|| (step_s, self.name(other)))
        };
        let by_interval = |other: usize| {
            let unit = self.name_facts[other].unit?;
            let readings = self.readings(other);
            let is_source = self.name_facts[other].role == Some(Role::Interval)
                && Readings::of(&readings) == Readings::NearOne;
            is_source.then(|| {
                let step_s = super::clock::median(readings) * in_seconds(unit);
                (step_s, self.name(other))
            })
        };
        let columns = || 0..self.survey.columns.len();
        (columns().find_map(by_column))
            .or_else(|| columns().find_map(by_interval))
            .or_else(|| {
                let stated = self.stated_sample_time()?;
                let line = super::super::cells::shortened(&stated.line);
                Some((stated.sample_time_s, format!("`{line}`")))
            })
    }
}
