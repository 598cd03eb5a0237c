//! Counts since the previous row under the name of a position: they follow the command as a speed does.

use super::decide::Decision;
use super::units::Role;
use crate::units::ROUNDING_VARIANCE;

/// Parts of a log whose means are compared: long relative to a motor's start, and many.
const PARTS: usize = 20;
/// Least correlation with the command of a quantity that follows it; a position that rises during one step has at
/// most 0.78.
const FOLLOWS: f64 = 0.8;

impl Decision<'_> {
    /// Whether the numbers of a column follow the command, unlike those of a position, whose differences do.
    pub(super) fn follows_command(&self, at: usize) -> bool {
        let given = (self.given.command.as_deref())
            .and_then(|text| self.given_column("--command", Role::Command, text).ok())
            .map(|(command, _)| command);
        let named = self.candidates(Role::Command);
        let Some(command) = given.or(named.first().copied()) else {
            return false;
        };
        let (numbers, commands) = (&self.column(at).numbers, &self.column(command).numbers);
        // A command without a sign has a separate direction, and an encoder with one channel has none.
        let has_sign = self.column(command).lowest() < 0.0 && self.column(at).lowest() < 0.0;
        let sized = |number: f64| if has_sign { number } else { number.abs() };
        let rows: Vec<(f64, f64)> = (numbers.iter().zip(commands))
            .filter(|(number, command)| number.is_finite() && command.is_finite())
            .map(|(number, command)| (*number, *command))
            .collect();
        let length = rows.len() / PARTS;
        if length < 2 {
            return false;
        }
        let (mut means, mut gains, mut driven) = (Vec::new(), Vec::new(), Vec::new());
        for part in rows.chunks_exact(length) {
            let mean =
                |of: &dyn Fn(&(f64, f64)) -> f64| part.iter().map(of).sum::<f64>() / length as f64;
            means.push(mean(&|(number, _)| sized(*number)));
            gains.push(sized(part[length - 1].0 - part[0].0));
            driven.push(mean(&|(_, command)| sized(*command)));
        }
        // Quantization at either end of a part attenuates the correlation of a gain with the command (Spearman,
        // 1904).
        let own = variance(&gains) - 2.0 * ROUNDING_VARIANCE;
        let hidden = if own > 0.0 {
            (variance(&gains) / own).sqrt()
        } else {
            1.0
        };
        // Under position control the command falls where the position rises.
        let follows = correlation(&means, &driven);
        follows > FOLLOWS && follows > hidden * correlation(&gains, &driven).abs()
    }

    /// Adds a note that the column is summed.
    pub(super) fn doubt_position(&mut self, at: usize) {
        let name = self.name(at);
        let what = format!("{name} follows the command as counts since the row before do");
        if self.given.position.is_some() {
            self.notes
                .push(format!("{what}: --increments sums them up"));
            return;
        }
        let flag = self.flag_name(at);
        let why = format!("{what}; of a position all the same: --position {flag}:counts");
        self.ask("--increments", String::new(), why);
    }
}

fn variance(a: &[f64]) -> f64 {
    let mean = a.iter().sum::<f64>() / a.len() as f64;
    a.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / a.len() as f64
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        (a.iter().zip(b))
            .map(|(a, b)| of(a - mean_a, b - mean_b))
            .sum()
    };
    let spread = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    match spread > 0.0 {
        true => sum(&|a, b| a * b) / spread,
        false => 0.0,
    }
}
