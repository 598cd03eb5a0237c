//! From the cells of a row to a sample in SI.
//!
//! Position in counts is `(number + turns * wrap) * scale + offset`, rounded; `turns` goes up or down
//! by one whenever the number jumps by more than half of `wrap`. Increments are summed up. A speed-only log is integrated:
//! `n[k] = n[k-1] + (v[k-1] + v[k]) / 2 * (t[k] - t[k-1])` (trapezoid; weighted where the motor's time constant is known),
//! `n[k] = n[k-1] + v[k] * (t[k] - t[k-1])` (backward) or `n[k] = n[k-1] + v[k-1] * (t[k] - t[k-1])` (forward).
//!
//! An encoder of one channel has no sign. With `unsigned` what came since the row before has the sign of the command that was in
//! force meanwhile, of the last one that was not 0 while the motor coasts.

use super::cells::Cells;
use super::clock::{Counts, RowClock};
use super::error::RowProblem;
use super::layout::{Layout, Place};
use super::map::{
    Backwards, CommandNumber, CommandSource, Field, Integration, Map, NumberFrom, PositionSource,
    TimeSource,
};
use super::range::{ANY_TIME, nanoseconds, within};
use super::stamp::{DAY_S, stamp};
use super::straight::{Unwrapped, profile};
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
    /// Of a log of speeds the speed in counts/s.
    pub speed_counts_s: Option<f64>,
    pub current_a: Option<f64>,
    pub supply_v: Option<f64>,
    /// The command was this many times full drive, more than there is, and is held to it.
    pub beyond_full: Option<f64>,
}

/// Converts row after row of one run.
#[derive(Debug)]
pub(super) struct Converter<'a> {
    map: &'a Map,
    layout: &'a Layout,
    rows: u64,
    time: RowClock,
    position: Unwrapped,
    first_time_s: Option<f64>,
    before: Option<Before>,
    /// Of the last command that was not 0; 1 before the first.
    sign: f64,
    held: Held,
}

/// Values that stay until their next one, where the mapping says `empty = "hold"`. Before its first value a command is 0.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// The command, in the column's own numbers.
    command: f64,
    supply_v: Option<f64>,
}

/// State of the last good row for the next one.
#[derive(Debug, Clone, Copy)]
struct Before {
    t_s: f64,
    /// Where the log has speeds only.
    speed: f64,
    position: f64,
    /// The position before its sign was the command's.
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

    /// A row that cannot even be taken apart.
    pub fn skip(&mut self) {
        self.rows += 1;
    }

    /// The sample of a row; a bad row changes nothing but the numbers of those that follow. `None` for a row that has no position
    /// and only sets what is held.
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
            // A time since the row before goes on in a row that is no sample.
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

    /// Value held from this row on.
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
            let (straight, state) = self.time.straight(stamp.s, wrap);
            let reading_s = straight + self.fraction_s(cells, fraction)?;
            let reading_s = within("time", reading_s, plausible::TIME_S)?;
            return Ok(state.time_s(reading_s, seq, *counts));
        }
        let (straight, state) = self.time.straight(self.number(cells, place)?, field.wrap);
        let reading_s = field.value(straight) + self.fraction_s(cells, fraction)?;
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
                let value = field.value(self.number(cells, at)?);
                within(what, value, plausible::COMMAND).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The command in SI, and how many times full drive it would have been.
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

    /// `sign` is the direction since the row before, for an encoder that has none.
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
                // Whole numbers are kept as they are, beyond what a float can hold.
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
                let (straight, after) = self.position.next(raw, field.wrap);
                before.unsigned = field.value(straight);
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
                    let mean = match rule {
                        Integration::Trapezoid => {
                            let end = weight_of_end(t_s - last.t_s, *curve);
                            last.speed + end * (before.speed - last.speed)
                        }
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

/// Weight of the speed at the end in the mean between two rows: half of a straight line. A first-order response of time constant `T`
/// that ends a step of `h` at `v1` from `v0` has the mean `v0 + (v1 - v0) (1 / (1 - exp(-h/T)) - T/h)`.
fn weight_of_end(step_s: f64, time_constant_s: Option<f64>) -> f64 {
    let Some(time_constant_s) = time_constant_s else {
        return 0.5;
    };
    let h = step_s / time_constant_s;
    // The two terms cancel below: there it is the beginning of the series.
    match h < 1e-3 {
        true => 0.5 + h / 12.0,
        false => -(-h).exp_m1().recip() - h.recip(),
    }
}

/// A command that is full drive but for the rounding of its digits is full drive.
const ROUNDING: f64 = 1e-6;

fn is_empty(cells: &Cells, place: &Place) -> bool {
    cells.get(place.at).is_empty()
}
