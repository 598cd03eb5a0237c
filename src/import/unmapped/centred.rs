//! Commands without a sign for a shaft that turns in both directions: PWM around half of full drive (locked
//! antiphase), or a magnitude without its direction.

use super::decide::Decision;
use crate::plain::short;

/// Least rate of a turning row as a share of the largest.
const TURNS: f64 = 0.25;
/// Least share of the turning rows in either direction.
const EITHER_WAY: f64 = 0.1;
/// Least share of the rows of one direction with the command on that side of half drive; after a step the shaft
/// coasts.
const ON_ITS_SIDE: f64 = 0.8;
/// Tolerance of the standstill level around half of full drive.
const NEAR_HALF: f64 = 0.02;
/// Fewest rows at rest that determine that level.
const LEAST_AT_REST: usize = 5;

impl Decision<'_> {
    /// The level of the command at standstill, if commands on either side of half drive turn the shaft in the
    /// corresponding direction. Adds a note for a magnitude without direction.
    pub(super) fn centre(&mut self, command: usize, motion: usize, full: f64) -> Option<f64> {
        let commands = self.column(command);
        if commands.lowest() < 0.0 {
            return None;
        }
        let rates = self.rates(motion);
        let rows: Vec<(f64, f64)> = (commands.numbers.iter().copied().zip(rates))
            .filter(|(command, rate)| command.is_finite() && rate.is_finite())
            .collect();
        let top = rows
            .iter()
            .fold(0.0_f64, |most, (_, rate)| most.max(rate.abs()));
        let turning = |sign: f64| {
            let is_turning = move |row: &&(f64, f64)| sign * row.1 >= TURNS * top && top > 0.0;
            rows.iter().filter(is_turning)
        };
        let (on, back) = (turning(1.0).count(), turning(-1.0).count());
        if on.min(back) as f64 <= EITHER_WAY * (on + back) as f64 {
            return None;
        }
        let half = 0.5 * full;
        let above = |sign: f64, count: usize| {
            turning(sign).filter(|row| row.0 > half).count() as f64 / count as f64
        };
        let (on_above, back_above) = (above(1.0, on), above(-1.0, back));
        let is_centred = (on_above >= ON_ITS_SIDE && back_above <= 1.0 - ON_ITS_SIDE)
            || (on_above <= 1.0 - ON_ITS_SIDE && back_above >= ON_ITS_SIDE);
        if !is_centred {
            self.notes.push(format!(
                "{} is never negative, and {} goes backward in {} % of the rows in which it moves: the command's direction is not in it; \
                 hint: --direction COLUMN says where it is; without it the motor seems to turn against its command, as a load can make it",
                self.name(command),
                self.name(motion),
                (100 * back) / (on + back),
            ));
            return None;
        }
        let mut at_rest: Vec<f64> = (rows.iter())
            .filter(|(command, rate)| *rate == 0.0 && (command - half).abs() <= NEAR_HALF * full)
            .map(|(command, _)| *command)
            .collect();
        at_rest.sort_by(f64::total_cmp);
        Some(match at_rest.len() >= LEAST_AT_REST {
            true => at_rest[at_rest.len() / 2],
            false => half,
        })
    }

    /// Whether a column has one value while the shaft turns in both directions.
    pub(super) fn is_constant_both_ways(&self, command: usize, motion: usize) -> bool {
        let column = self.column(command);
        let rates = self.rates(motion);
        let top = (rates.iter().filter(|rate| rate.is_finite()))
            .fold(0.0_f64, |most, rate| most.max(rate.abs()));
        let turning = |sign: f64| {
            let is_turning = |rate: &&f64| sign * **rate >= TURNS * top;
            rates.iter().filter(is_turning).count() as f64
        };
        let (on, back) = (turning(1.0), turning(-1.0));
        column.lowest() == column.highest()
            && column.most() > 0.0
            && top > 0.0
            && on.min(back) > EITHER_WAY * (on + back)
    }

    /// As text, and as scale and offset of a mapping: full drive is as far from the centre as half of it.
    pub(super) fn about_centre(centre: f64) -> (f64, f64, String) {
        let words = format!("; {} is standstill, as the motion shows", short(centre));
        (2.0, -2.0 * centre, words)
    }
}
