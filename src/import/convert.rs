//! From the cells of a row to a sample in SI.
//!
//! Position in counts is `(number + turns * wrap) * scale + offset`, rounded; `turns` goes up or down
//! by one whenever the number jumps by more than half of `wrap`. A speed-only log is integrated:
//! `n[k] = n[k-1] + (v[k-1] + v[k]) / 2 * (t[k] - t[k-1])` (trapezoid),
//! `n[k] = n[k-1] + v[k] * (t[k] - t[k-1])` (backward) or `n[k] = n[k-1] + v[k-1] * (t[k] - t[k-1])` (forward).

use super::cells::{Cells, number, shortened};
use super::error::RowProblem;
use super::layout::{Layout, Place};
use super::map::{CommandSource, Field, Integration, Map, PositionSource, TimeSource};
use crate::motor::plausible::{COMMAND, Range, TIME_S};

/// One row in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Number of the row in its run, bad ones included.
    pub seq: u64,
    /// From the run's first row.
    pub t_s: f64,
    /// V, A or N m.
    pub command: f64,
    pub counts: i64,
    pub current_a: Option<f64>,
    pub supply_v: Option<f64>,
}

/// A counter that goes round, made straight.
#[derive(Debug, Clone, Copy, Default)]
struct Unwrapped {
    before: Option<f64>,
    turns: f64,
}

impl Unwrapped {
    /// This and the state after it, which is kept only if the row is good.
    fn next(self, number: f64, wrap: Option<f64>) -> (f64, Self) {
        let Some(wrap) = wrap else {
            return (number, self);
        };
        let jump = self.before.map_or(0.0, |before| number - before);
        let after = Self {
            before: Some(number),
            turns: self.turns - (jump / wrap).round(),
        };
        (number + after.turns * wrap, after)
    }
}

/// Converts row after row of one run.
#[derive(Debug)]
pub(super) struct Converter<'a> {
    map: &'a Map,
    layout: &'a Layout,
    rows: u64,
    time: Unwrapped,
    position: Unwrapped,
    first_time_s: Option<f64>,
    before: Option<Before>,
}

/// What the next row needs of the last good one.
#[derive(Debug, Clone, Copy)]
struct Before {
    t_s: f64,
    /// Where the log has speeds only.
    speed: f64,
    position: f64,
}

/// Largest number that fits a count.
const MOST_COUNTS: f64 = 9.2e18;
/// Time before the first row is taken off: since 1970 in microseconds, in seconds a run's own range.
const ANY_TIME: Range = Range {
    lo: -1e15,
    hi: 1e15,
    ..TIME_S
};

impl<'a> Converter<'a> {
    pub fn new(map: &'a Map, layout: &'a Layout) -> Self {
        Self {
            map,
            layout,
            rows: 0,
            time: Unwrapped::default(),
            position: Unwrapped::default(),
            first_time_s: None,
            before: None,
        }
    }

    /// A row that cannot even be taken apart.
    pub fn skip(&mut self) {
        self.rows += 1;
    }

    /// The sample of a row; a bad row changes nothing but the numbers of those that follow.
    pub fn convert(&mut self, cells: &Cells) -> Result<Sample, RowProblem> {
        let seq = self.rows;
        self.rows += 1;
        if cells.len() != self.layout.columns {
            return Err(RowProblem::CellCount {
                found: cells.len(),
                expected: self.layout.columns,
            });
        }
        let (time_s, time) = self.time_s(cells, seq)?;
        let t_s = nanoseconds(time_s - self.first_time_s.unwrap_or(time_s));
        if let Some(before) = self.before
            && t_s <= before.t_s
        {
            return Err(RowProblem::TimeNotRising {
                before: before.t_s,
                after: t_s,
            });
        }
        let supply_v = self.measured(cells, &self.map.supply, &self.layout.supply, "supply")?;
        let current_a = self.measured(cells, &self.map.current, &self.layout.current, "current")?;
        let command = within("command", COMMAND, self.command(cells, t_s, supply_v)?)?;
        let (counts, position, before) = self.position(cells, t_s)?;
        self.time = time;
        self.position = position;
        self.before = Some(before);
        self.first_time_s.get_or_insert(time_s);
        Ok(Sample {
            seq,
            t_s,
            command,
            counts,
            current_a,
            supply_v,
        })
    }

    fn number(&self, cells: &Cells, place: &Option<Place>) -> Result<f64, RowProblem> {
        match place {
            Some(place) => {
                let cell = cells.get(place.at);
                number(cell, self.map.shape.decimal_comma, &place.name)
            }
            None => Ok(0.0),
        }
    }

    fn time_s(&self, cells: &Cells, seq: u64) -> Result<(f64, Unwrapped), RowProblem> {
        let TimeSource::Column(field) = &self.map.time else {
            let sample_time_s = self.map.sample_time_s.unwrap_or(f64::NAN);
            return Ok((seq as f64 * sample_time_s, self.time));
        };
        let raw = self.number(cells, &self.layout.time)?;
        let (straight, state) = self.time.next(raw, field.wrap);
        Ok((within("time", ANY_TIME, field.value(straight))?, state))
    }

    /// An empty cell is a value that this sample lacks.
    fn measured(
        &self,
        cells: &Cells,
        field: &Option<Field>,
        place: &Option<Place>,
        what: &'static str,
    ) -> Result<Option<f64>, RowProblem> {
        match (field, place) {
            (Some(field), Some(at)) if !cells.get(at.at).is_empty() => {
                within(what, COMMAND, field.value(self.number(cells, place)?)).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn command(&self, cells: &Cells, t_s: f64, supply_v: Option<f64>) -> Result<f64, RowProblem> {
        match &self.map.command {
            CommandSource::Column(field) => {
                Ok(field.value(self.number(cells, &self.layout.command)?))
            }
            CommandSource::OfMeasuredSupply(field) => {
                let share = field.value(self.number(cells, &self.layout.command)?);
                let supply_v = supply_v.ok_or_else(|| RowProblem::NotANumber {
                    column: self
                        .layout
                        .supply
                        .as_ref()
                        .map_or_else(String::new, |p| p.name.clone()),
                    found: shortened(""),
                })?;
                Ok(share * supply_v)
            }
            CommandSource::Profile { points, line } => Ok(profile(points, *line, t_s)),
            CommandSource::NotRecorded => Ok(0.0),
        }
    }

    fn position(&self, cells: &Cells, t_s: f64) -> Result<(i64, Unwrapped, Before), RowProblem> {
        let raw = self.number(cells, &self.layout.motion)?;
        let mut before = Before {
            t_s,
            speed: 0.0,
            position: 0.0,
        };
        let mut state = self.position;
        match &self.map.position {
            PositionSource::NotRecorded => {}
            PositionSource::Column(field) => {
                // Whole numbers are kept as they are, beyond what a float can hold.
                let plain = field.wrap.is_none() && field.scale == 1.0 && field.offset == 0.0;
                let cell = self.layout.motion.as_ref().map(|place| cells.get(place.at));
                let text = cell.and_then(|cell| std::str::from_utf8(cell).ok());
                if let Some(whole) = text.filter(|_| plain).and_then(|text| text.parse().ok()) {
                    return Ok((whole, state, before));
                }
                let (straight, after) = self.position.next(raw, field.wrap);
                before.position = field.value(straight);
                state = after;
            }
            PositionSource::Speed { field, rule } => {
                before.speed = field.value(raw);
                if let Some(last) = self.before {
                    let mean = match rule {
                        Integration::Trapezoid => (last.speed + before.speed) / 2.0,
                        Integration::Backward => before.speed,
                        Integration::Forward => last.speed,
                    };
                    before.position = last.position + mean * (t_s - last.t_s);
                }
            }
        }
        if before.position.abs() >= MOST_COUNTS || before.position.is_nan() {
            return Err(RowProblem::CountsTooLarge {
                counts: before.position,
            });
        }
        Ok((before.position.round() as i64, state, before))
    }
}

/// Time to whole nanoseconds: what subtraction leaves beyond that is rounding.
fn nanoseconds(t_s: f64) -> f64 {
    (t_s * 1e9).round() / 1e9
}

/// A value that readers of run files take.
fn within(what: &'static str, range: Range, value: f64) -> Result<f64, RowProblem> {
    if range.holds(value) {
        Ok(value)
    } else {
        Err(RowProblem::TooLarge { what, value })
    }
}

/// The value of a profile at a time: the first point's before it, the last one's after it.
fn profile(points: &[(f64, f64)], line: bool, t_s: f64) -> f64 {
    // A point at the very time of a row holds from that row on, whatever the rounding.
    let after = points.partition_point(|&(at, _)| at <= t_s + 1e-9);
    let Some(&(from_s, from)) = after.checked_sub(1).and_then(|k| points.get(k)) else {
        return points.first().map_or(0.0, |&(_, value)| value);
    };
    match points.get(after) {
        Some(&(to_s, to)) if line => {
            from + (to - from) * ((t_s - from_s) / (to_s - from_s)).max(0.0)
        }
        _ => from,
    }
}
