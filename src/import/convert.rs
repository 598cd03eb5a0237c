//! From the cells of a row to a sample in SI.
//!
//! Position in counts is `(number + turns * wrap) * scale + offset`, rounded; `turns` goes up or down
//! by one whenever the number jumps by more than half of `wrap`. A speed-only log is integrated:
//! `n[k] = n[k-1] + (v[k-1] + v[k]) / 2 * (t[k] - t[k-1])` (trapezoid),
//! `n[k] = n[k-1] + v[k] * (t[k] - t[k-1])` (backward) or `n[k] = n[k-1] + v[k-1] * (t[k] - t[k-1])` (forward).

use super::cells::{Cells, number};
use super::error::RowProblem;
use super::layout::{Layout, Place};
use super::map::{CommandSource, Field, Integration, Map, PositionSource, TimeSource};
use super::stamp::{DAY_S, stamp};
use crate::motor::plausible;

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
    held: Held,
}

/// Values that stay until their next one, where the mapping says `empty = "hold"`. Before its first value a command is 0.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// The command, in the column's own numbers.
    command: f64,
    supply_v: Option<f64>,
}

/// What the next row needs of the last good one.
#[derive(Debug, Clone, Copy)]
struct Before {
    t_s: f64,
    /// Where the log has speeds only.
    speed: f64,
    position: f64,
}

/// Time before the first row is taken off: since 1970 in microseconds, in seconds a run's own range.
const ANY_TIME: plausible::Range = plausible::Range {
    lo: -1e15,
    hi: 1e15,
    ..plausible::TIME_S
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
            held: Held::default(),
        }
    }

    /// A row that cannot even be taken apart.
    pub fn skip(&mut self) {
        self.rows += 1;
    }

    /// The sample of a row; a bad row changes nothing but the numbers of those that follow. `None` for a row that has no position
    /// and only sets what is held.
    pub fn convert(&mut self, cells: &Cells) -> Result<Option<Sample>, RowProblem> {
        let seq = self.rows;
        self.rows += 1;
        let sample = self.sample(cells, seq)?;
        if sample.is_none() {
            self.rows = seq;
        }
        Ok(sample)
    }

    fn sample(&mut self, cells: &Cells, seq: u64) -> Result<Option<Sample>, RowProblem> {
        if cells.len() != self.layout.columns {
            return Err(RowProblem::CellCount {
                found: cells.len(),
                expected: self.layout.columns,
            });
        }
        let held = self.held(cells)?;
        if self.map.holds && self.is_empty(cells, &self.layout.motion) {
            self.held = held;
            return Ok(None);
        }
        let (time_s, time) = self.time_s(cells, seq)?;
        let t_s = nanoseconds(time_s - self.first_time_s.unwrap_or(time_s));
        let t_s = within("time", t_s, plausible::TIME_S)?;
        if let Some(before) = self.before
            && t_s <= before.t_s
        {
            return Err(RowProblem::TimeNotRising {
                before: before.t_s,
                after: t_s,
            });
        }
        let supply_v = self
            .measured(cells, &self.map.supply, &self.layout.supply, "supply")?
            .or(held.supply_v);
        let current_a = self.measured(cells, &self.map.current, &self.layout.current, "current")?;
        let command = self.command(cells, t_s, supply_v, held.command)?;
        let command = within("command", command, plausible::COMMAND)?;
        let (counts, position, before) = self.position(cells, t_s)?;
        self.time = time;
        self.position = position;
        self.before = Some(before);
        self.first_time_s.get_or_insert(time_s);
        self.held = held;
        Ok(Some(Sample {
            seq,
            t_s,
            command,
            counts,
            current_a,
            supply_v,
        }))
    }

    fn is_empty(&self, cells: &Cells, place: &Option<Place>) -> bool {
        place
            .as_ref()
            .is_some_and(|place| cells.get(place.at).is_empty())
    }

    /// What is held from this row on.
    fn held(&self, cells: &Cells) -> Result<Held, RowProblem> {
        let mut held = self.held;
        if !self.map.holds {
            return Ok(held);
        }
        if !self.is_empty(cells, &self.layout.command) {
            held.command = self.number(cells, &self.layout.command)?;
        }
        let supply_v = self.measured(cells, &self.map.supply, &self.layout.supply, "supply")?;
        held.supply_v = supply_v.or(held.supply_v);
        Ok(held)
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
        let stamped = self
            .layout
            .time
            .as_ref()
            .and_then(|place| stamp(cells.get(place.at)));
        if let Some(stamp) = stamped {
            let wrap = stamp.is_of_day.then_some(DAY_S);
            let (straight, state) = self.time.next(stamp.s, wrap);
            return Ok((within("time", straight, plausible::TIME_S)?, state));
        }
        let raw = self.number(cells, &self.layout.time)?;
        let (straight, state) = self.time.next(raw, field.wrap);
        let time_s = within("time", field.value(straight), ANY_TIME)?;
        Ok((time_s, state))
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
                let value = field.value(self.number(cells, place)?);
                within(what, value, plausible::COMMAND).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn command(
        &self,
        cells: &Cells,
        t_s: f64,
        supply_v: Option<f64>,
        held: f64,
    ) -> Result<f64, RowProblem> {
        let number = || match self.map.holds {
            true => Ok(held),
            false => self.number(cells, &self.layout.command),
        };
        match &self.map.command {
            CommandSource::Column(field) => Ok(field.value(number()?)),
            CommandSource::OfMeasuredSupply(field) => {
                let share = field.value(number()?);
                let supply_v = supply_v.ok_or_else(|| RowProblem::Empty {
                    column: self
                        .layout
                        .supply
                        .as_ref()
                        .map_or_else(String::new, |p| p.name.clone()),
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
                let whole = text
                    .filter(|_| plain)
                    .and_then(|text| text.parse::<i64>().ok());
                if let Some(whole) = whole {
                    within("position", whole as f64, plausible::COUNTS)?;
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
        let counts = within("position", before.position, plausible::COUNTS)?;
        Ok((counts.round() as i64, state, before))
    }
}

/// Time to whole nanoseconds: what subtraction leaves beyond that is rounding.
fn nanoseconds(t_s: f64) -> f64 {
    (t_s * 1e9).round() / 1e9
}

/// What the readers of run files refuse is not written.
fn within(what: &'static str, value: f64, range: plausible::Range) -> Result<f64, RowProblem> {
    if range.holds(value) {
        Ok(value)
    } else {
        Err(RowProblem::Implausible {
            what,
            value: plausible::Shown(value).to_string(),
            range: range.to_string(),
        })
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
