//! Conversion of the cells of a row to a sample in SI units.
//!
//! Position in counts is `(number + turns * wrap) * scale + offset`, rounded; `turns` changes by one when the number
//! jumps by more than half of `wrap`. Increments are summed. A speed-only log is integrated: `n[k] = n[k-1] + (v[k-1]
//! + v[k]) / 2 * (t[k] - t[k-1])` (trapezoid; weighted if the motor's time constant is known), `n[k] = n[k-1] + v[k]
//! * (t[k] - t[k-1])` (backward) or `n[k] = n[k-1] + v[k-1] * (t[k] - t[k-1])` (forward).
//!
//! An encoder with one channel has no sign. With `unsigned` the increment since the previous row has the sign of the
//! command in that interval, or of the last non-zero one while the motor coasts.

use super::cells::Cells;
use super::clock::{Counts, RowClock};
use super::error::RowProblem;
use super::layout::{Layout, Place};
use super::map::{
    Backwards, CommandNumber, CommandSource, Field, Map, NumberFrom, PositionSource, TimeSource,
};
use super::range::{ANY_TIME, nanoseconds, within};
use super::stamp::{DAY_S, stamp};
use super::unwrap::{Unwrapped, profile};
use crate::motor::plausible;

/// One row in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Number of the row in its run, rejected ones included.
    pub seq: u64,
    /// Relative to the run's first row.
    pub t_s: f64,
    /// V, A or N m.
    pub command: f64,
    pub counts: i64,
    /// The speed in counts/s, in a log of speeds.
    pub speed_counts_s: Option<f64>,
    pub current_a: Option<f64>,
    pub supply_v: Option<f64>,
    /// Ratio of the command to full drive before it was clamped.
    pub beyond_full: Option<f64>,
}

/// Converter of the rows of one run.
#[derive(Debug)]
pub(super) struct Converter<'a> {
    map: &'a Map,
    layout: &'a Layout,
    rows: u64,
    time: RowClock,
    position: Unwrapped,
    first_time_s: Option<f64>,
    before: Option<Before>,
    /// Sign of the last non-zero command; 1 before the first.
    sign: f64,
    held: Held,
}

/// Values that are held until the next one, with `empty = "hold"`. Before its first value a command is 0.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// The command in the column's units.
    command: f64,
    supply_v: Option<f64>,
}

/// State of the last accepted row.
#[derive(Debug, Clone, Copy)]
struct Before {
    t_s: f64,
    /// In a log of speeds.
    speed: f64,
    position: f64,
    /// The position before the sign of the command is applied.
    unsigned: f64,
}

impl<'a> Converter<'a> {
    pub fn new(map: &'a Map, layout: &'a Layout) -> Self {
        Self {
            map,
            layout,
            rows: 0,
            time: RowClock::default(),
            position: Unwrapped::default(),
            first_time_s: None,
            before: None,
            sign: 1.0,
            held: Held::default(),
        }
    }

    /// Counts a row that cannot be split into cells.
    pub fn skip(&mut self) {
        self.rows += 1;
    }

    /// The sample of a row; a rejected row changes only the numbers of the following ones. `None` for a row without a
    /// position, which only sets held values.
    pub fn convert(
        &mut self,
        cells: &Cells,
        commented: Option<f64>,
    ) -> Result<Option<Sample>, RowProblem> {
        let seq = self.rows;
        self.rows += 1;
        let sample = self.sample(cells, seq, commented)?;
        if sample.is_none() {
            self.rows = seq;
        }
        Ok(sample)
    }

    fn sample(
        &mut self,
        cells: &Cells,
        seq: u64,
        commented: Option<f64>,
    ) -> Result<Option<Sample>, RowProblem> {
        if cells.len() != self.layout.columns {
            return Err(RowProblem::CellCount {
                found: cells.len(),
                expected: self.layout.columns,
            });
        }
        let held = self.held(cells, commented)?;
        let motion = self.layout.motion.as_ref();
        if self.map.holds && motion.is_some_and(|place| is_empty(cells, place)) {
            self.held = held;
            // The time since the previous row counts in a row that is no sample.
            if self.map.counts_time_since_row_before() {
                self.time = self.time_s(cells, seq)?.1;
            }
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
        let number = match self.map.holds {
            true => held.command,
            false => self.command_number(cells, commented)?,
        };
        let (command, beyond_full) = self.command(number, t_s, supply_v)?;
        let command = within("command", command, plausible::COMMAND)?;
        let sign = match command {
            0.0 => self.sign,
            command => command.signum(),
        };
        let meanwhile = match self.before {
            Some(_) => self.sign,
            None => sign,
        };
        let (counts, position, before) = self.position(cells, t_s, meanwhile)?;
        self.time = time;
        self.position = position;
        self.before = Some(before);
        self.sign = sign;
        self.first_time_s.get_or_insert(time_s);
        self.held = held;
        Ok(Some(Sample {
            seq,
            t_s,
            command,
            counts,
            speed_counts_s: matches!(self.map.position, PositionSource::Speed { .. })
                .then_some(before.speed),
            current_a,
            supply_v,
            beyond_full,
        }))
    }

    /// Values held from this row on.
    fn held(&self, cells: &Cells, commented: Option<f64>) -> Result<Held, RowProblem> {
        let mut held = self.held;
        if !self.map.holds {
            return Ok(held);
        }
        let mut places = self.layout.command.iter().chain(&self.layout.direction);
        if !places.any(|place| is_empty(cells, place)) {
            held.command = self.command_number(cells, commented)?;
        }
        let supply_v = self.measured(cells, &self.map.supply, &self.layout.supply, "supply")?;
        held.supply_v = supply_v.or(held.supply_v);
        Ok(held)
    }

    fn number(&self, cells: &Cells, place: &Place) -> Result<f64, RowProblem> {
        let cell = cells.get(place.at);
        self.map.shape.number(cell, &place.name)
    }

    /// Command of the row, or of the comment before it.
    fn command_number(&self, cells: &Cells, commented: Option<f64>) -> Result<f64, RowProblem> {
        let CommandSource::Number(CommandNumber { from, .. }) = &self.map.command else {
            return Ok(0.0);
        };
        let places = &self.layout.command;
        let is_backwards = match (&self.layout.direction, self.map.direction()) {
            (Some(place), Some((_, Backwards::Number(reverse)))) => {
                self.number(cells, place)? == *reverse
            }
            (Some(place), Some((_, Backwards::Word(reverse)))) => cells.text(place.at) == *reverse,
            _ => false,
        };
        let sign = if is_backwards { -1.0 } else { 1.0 };
        let number = match from {
            NumberFrom::Column(_) => match places.first() {
                Some(place) => self.number(cells, place),
                None => Ok(0.0),
            },
            NumberFrom::Sum { terms, limit } => {
                let mut sum = 0.0;
                for (term, place) in terms.iter().zip(places) {
                    sum += term.factor * self.number(cells, place)?;
                }
                Ok(limit.map_or(sum, |limit| sum.clamp(-limit, limit)))
            }
            NumberFrom::Comment(word) => {
                commented.ok_or_else(|| RowProblem::NoComment(word.clone()))
            }
        };
        number.map(|number| sign * number)
    }

    fn time_s(&self, cells: &Cells, seq: u64) -> Result<(f64, RowClock), RowProblem> {
        let TimeSource::Column {
            field,
            fraction,
            counts,
        } = &self.map.time
        else {
            let sample_time_s = self.map.sample_time_s.unwrap_or(f64::NAN);
            return Ok((seq as f64 * sample_time_s, self.time));
        };
        let Some(place) = &self.layout.time else {
            return Ok((0.0, self.time));
        };
        if let Some(stamp) = stamp(cells.get(place.at)) {
            let wrap = stamp.is_of_day.then_some(DAY_S);
            let (unwrapped, state) = self.time.unwrapped(stamp.s, wrap);
            let reading_s = unwrapped + self.fraction_s(cells, fraction)?;
            let reading_s = within("time", reading_s, plausible::TIME_S)?;
            return Ok(state.time_s(reading_s, seq, *counts));
        }
        let number = self.number(cells, place)?;
        let (number, state) = match counts {
            Counts::SinceRowBefore => (number, self.time),
            _ => self.time.since_first(cells.get(place.at), number),
        };
        let (unwrapped, state) = state.unwrapped(number, field.wrap);
        let reading_s = field.value(unwrapped) + self.fraction_s(cells, fraction)?;
        let reading_s = within("time", reading_s, ANY_TIME)?;
        if *counts == Counts::SinceRowBefore {
            within("time since the row before", reading_s, plausible::GAP_S)?;
        }
        Ok(state.time_s(reading_s, seq, *counts))
    }

    /// Seconds from the second column of a clock in two columns.
    fn fraction_s(&self, cells: &Cells, fraction: &Option<Field>) -> Result<f64, RowProblem> {
        match (fraction, &self.layout.time_fraction) {
            (Some(fraction), Some(place)) => Ok(fraction.value(self.number(cells, place)?)),
            _ => Ok(0.0),
        }
    }

    /// An empty cell is a missing value.
    fn measured(
        &self,
        cells: &Cells,
        field: &Option<Field>,
        place: &Option<Place>,
        what: &'static str,
    ) -> Result<Option<f64>, RowProblem> {
        match (field, place) {
            (Some(field), Some(at)) if !cells.get(at.at).is_empty() => {
                let value = field.value(self.number(cells, at)?);
                within(what, value, plausible::COMMAND).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The command in SI units, and its ratio to full drive before clamping.
    fn command(
        &self,
        number: f64,
        t_s: f64,
        supply_v: Option<f64>,
    ) -> Result<(f64, Option<f64>), RowProblem> {
        match &self.map.command {
            CommandSource::Number(by) => {
                let supply_v = match (by.of_measured_supply, supply_v) {
                    (false, _) => 1.0,
                    (true, Some(supply_v)) => supply_v,
                    (true, None) => {
                        let column = self.layout.supply.as_ref().map(|place| place.name.clone());
                        return Err(RowProblem::Empty {
                            column: column.unwrap_or_default(),
                        });
                    }
                };
                let value = number * by.scale + by.offset;
                Ok(match by.most {
                    Some(most) if value.abs() > most * (1.0 + ROUNDING) => (
                        value.clamp(-most, most) * supply_v,
                        Some(value.abs() / most),
                    ),
                    _ => (value * supply_v, None),
                })
            }
            CommandSource::Profile { points, line } => Ok((profile(points, *line, t_s), None)),
            CommandSource::NotRecorded => Ok((0.0, None)),
        }
    }

    /// `sign` is the direction since the previous row, for an encoder without one.
    fn position(
        &self,
        cells: &Cells,
        t_s: f64,
        sign: f64,
    ) -> Result<(i64, Unwrapped, Before), RowProblem> {
        let raw = match &self.layout.motion {
            Some(place) => self.number(cells, place)?,
            None => 0.0,
        };
        let directed = |value: f64| {
            if self.map.unsigned {
                value.abs() * sign
            } else {
                value
            }
        };
        let mut before = Before {
            t_s,
            speed: 0.0,
            position: 0.0,
            unsigned: 0.0,
        };
        let mut state = self.position;
        match &self.map.position {
            PositionSource::NotRecorded => {}
            PositionSource::Column(field) => {
                // Integers are exact beyond the precision of a float.
                let plain = field.wrap.is_none()
                    && !self.map.unsigned
                    && field.scale == 1.0
                    && field.offset == 0.0;
                let cell = self.layout.motion.as_ref().map(|place| cells.get(place.at));
                let text = cell.and_then(|cell| std::str::from_utf8(cell).ok());
                let whole = text
                    .filter(|_| plain)
                    .and_then(|text| text.parse::<i64>().ok());
                if let Some(whole) = whole {
                    within("position", whole as f64, plausible::COUNTS)?;
                    return Ok((whole, state, before));
                }
                let (unwrapped, after) = self.position.next(raw, field.wrap);
                before.unsigned = field.value(unwrapped);
                before.position = match self.before {
                    Some(last) if self.map.unsigned => {
                        last.position + directed(before.unsigned - last.unsigned)
                    }
                    _ => before.unsigned,
                };
                state = after;
            }
            PositionSource::Increments(field) => {
                // The increments of the first row precede the run.
                if let Some(last) = self.before {
                    before.position = last.position + directed(field.value(raw));
                }
            }
            PositionSource::Speed {
                field, rule, curve, ..
            } => {
                before.speed = directed(field.value(raw));
                if let Some(last) = self.before {
                    let step_s = t_s - last.t_s;
                    let mean = rule.mean_between((last.speed, before.speed), step_s, *curve);
                    before.position = last.position + mean * step_s;
                }
            }
        }
        let counts = within("position", before.position, plausible::COUNTS)?;
        Ok((counts.round() as i64, state, before))
    }
}

/// Rounding tolerance of a command at full drive.
const ROUNDING: f64 = 1e-6;

fn is_empty(cells: &Cells, place: &Place) -> bool {
    cells.get(place.at).is_empty()
}
