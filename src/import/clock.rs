//! The time of each row, from what the clock column of the log shows.
//!
//! A clock that counts from an origin is the time as it stands. Two kinds of column are not:
//! - the time since the row before (`dt`): the rows' times are its running sum;
//! - a coarse clock, whose steps are longer than the sample time, so that several rows share a reading `r`: a row lies one sample
//!   time after the row before, but not outside `[r, r + resolution]`, the interval that the reading allows. The first row's is the
//!   origin, and a log begins somewhere within its first reading: where the second one comes early, all intervals are that much earlier.

use super::cells::whole;
use super::unwrap::Unwrapped;

/// Every whole number up to here is a float, 2^53. The 100 ns since the year 1 are beyond: floats of them are 13 us apart.
const MOST_EXACT: u64 = 1 << 53;

/// Least step of a row of a coarse clock, as a share of the sample time: time rises from row to row.
const LEAST_STEP: f64 = 0.01;
/// Readings of a coarse clock that are farther apart than so many of its steps have a pause between them.
const PAUSE_STEPS: f64 = 1.5;

/// Quantity of a clock's column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Counts {
    /// Time since an origin.
    SinceOrigin,
    /// Time since the row before.
    SinceRowBefore,
    /// Time since an origin, in steps longer than the sample time.
    Coarsely {
        /// The step of the clock in s.
        resolution_s: f64,
        /// Time from row to row in s.
        sample_time_s: f64,
    },
}

/// First reading of a clock, if it is an integer beyond 2^53: later readings are computed relative to it, exactly.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FirstReading(Option<i64>);

impl FirstReading {
    /// The reference of a clock, from its first cell.
    pub fn of(cell: &[u8]) -> Self {
        Self(whole(cell).filter(|first| first.unsigned_abs() > MOST_EXACT))
    }

    /// A cell relative to the reference; `number` is the cell as a float.
    pub fn since(self, cell: &[u8], number: f64) -> f64 {
        match (self.0, whole(cell)) {
            (None, _) => number,
            (Some(first), Some(whole)) => whole.saturating_sub(first) as f64,
            (Some(first), None) => number - first as f64,
        }
    }

    /// The reference as a float; 0 without one.
    pub fn rounded(self) -> f64 {
        self.0.map_or(0.0, |first| first as f64)
    }
}

/// The state of the clock; a rejected row does not change it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RowClock {
    first: FirstReading,
    unwrapped: Unwrapped,
    before: Option<Before>,
    /// Delay of the first row of a coarse clock after its reading in s; known from the second reading on.
    late_s: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Before {
    seq: u64,
    reading_s: f64,
    time_s: f64,
}

impl RowClock {
    /// The number in a cell of the clock relative to the first row, and the state after it.
    pub fn since_first(self, cell: &[u8], number: f64) -> (f64, Self) {
        let first = match self.before {
            None => FirstReading::of(cell),
            Some(_) => self.first,
        };
        (first.since(cell, number), Self { first, ..self })
    }

    /// The counter of the clock, unwrapped at `wrap`, and the state after it.
    pub fn unwrapped(self, number: f64, wrap: Option<f64>) -> (f64, Self) {
        let (number, unwrapped) = self.unwrapped.next(number, wrap);
        (number, Self { unwrapped, ..self })
    }

    /// Time in s of the row `seq`, whose clock reads `reading_s`, and the state after it.
    pub fn time_s(self, reading_s: f64, seq: u64, counts: Counts) -> (f64, Self) {
        let mut late_s = self.late_s;
        let time_s = match (counts, self.before) {
            (Counts::SinceOrigin, _) | (_, None) => reading_s,
            (Counts::SinceRowBefore, Some(before)) => before.time_s + reading_s,
            (Counts::Coarsely { .. }, Some(before)) if reading_s < before.reading_s => reading_s,
            (
                Counts::Coarsely {
                    resolution_s,
                    sample_time_s,
                },
                Some(before),
            ) => {
                let rows = seq.saturating_sub(before.seq) as f64;
                let next_s = before.time_s + rows * sample_time_s;
                if late_s.is_none() && reading_s > before.reading_s {
                    let goes_on = reading_s - before.reading_s <= PAUSE_STEPS * resolution_s;
                    late_s = Some(if goes_on {
                        (reading_s - next_s).max(0.0)
                    } else {
                        0.0
                    });
                }
                let from_s = reading_s - late_s.unwrap_or(0.0);
                next_s
                    .clamp(from_s, from_s + resolution_s)
                    .max(before.time_s + LEAST_STEP * sample_time_s)
            }
        };
        let before = Some(Before {
            seq,
            reading_s,
            time_s,
        });
        let after = Self {
            before,
            late_s,
            ..self
        };
        (time_s, after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(readings_s: &[f64], counts: Counts) -> Vec<f64> {
        let mut clock = RowClock::default();
        let time = |(seq, reading_s): (usize, &f64)| {
            let (time_s, after) = clock.time_s(*reading_s, seq as u64, counts);
            clock = after;
            time_s
        };
        readings_s.iter().enumerate().map(time).collect()
    }

    #[test]
    fn rows_of_one_reading_are_spread_and_a_pause_is_kept() {
        let counts = Counts::Coarsely {
            resolution_s: 1.0,
            sample_time_s: 0.5,
        };
        let found = times(&[0.0, 0.0, 1.0, 1.0, 7.0, 7.0, 8.0], counts);
        assert_eq!(found, [0.0, 0.5, 1.0, 1.5, 7.0, 7.5, 8.0]);
        // A log that begins with the last row of a reading.
        let found = times(&[0.0, 1.0, 1.0, 2.0, 2.0, 9.0], counts);
        assert_eq!(found, [0.0, 0.5, 1.0, 1.5, 2.0, 8.5]);
        // Readings that share three rows at a sample time of half a step: time rises all the same.
        let found = times(&[0.0, 0.0, 0.0, 0.0, 1.0], counts);
        assert!(found.windows(2).all(|pair| pair[1] > pair[0]), "{found:?}");
    }

    #[test]
    fn times_since_the_row_before_are_summed() {
        let found = times(&[0.25, 0.5, 0.5, 0.25], Counts::SinceRowBefore);
        assert_eq!(found, [0.25, 0.75, 1.25, 1.5]);
    }
}
