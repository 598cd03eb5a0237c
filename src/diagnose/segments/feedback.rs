//! Detection of closed loops: whether the command of a run depends on its motion.
//!
//! In open loop a command depends on its own past at most. A controller's depends on the position that it has just
//! read, with the opposite sign: on the innovation of the position given the past of command and position. The share
//! of the command's innovation that it explains (partial R^2 of a regression; Granger 1969) is above 0.69 for
//! position loops of servos, and below 0.12 for other real recordings.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fit::gram;
use crate::diagnose::model::{dot, less};
use crate::diagnose::settings::Settings;
use crate::diagnose::settings::solver::LAST_DIGITS;

/// Whether a command depends on the counts read at the same sample.
pub(super) fn depends_on_motion(command: &[f64], counts: &[f64], settings: &Settings) -> bool {
    let past_samples = settings.feedback_samples;
    let n = command.len().min(counts.len());
    if n <= 4 * past_samples {
        return false;
    }
    let rows = past_samples..n;
    let moved = |k: usize| counts[k] - counts[k - 1];
    let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { rows.clone().map(of).collect() };
    let mut past = vec![column(&|_| 1.0)];
    for lag in 1..=past_samples {
        past.push(column(&|k| command[k - lag]));
    }
    for lag in 1..past_samples {
        past.push(column(&|k| moved(k - lag)));
    }
    let (Some(command), Some(motion)) = (
        innovation(&past, &column(&|k| command[k])),
        innovation(&past, &column(&moved)),
    ) else {
        return false;
    };
    let both = dot(&command, &motion);
    let (of_command, of_motion) = (dot(&command, &command), dot(&motion, &motion));
    both < 0.0 && both * both > settings.feedback_share * of_command * of_motion
}

/// Innovation of a column: the residual of its regression; `None` if it is zero.
fn innovation(columns: &[Vec<f64>], of: &[f64]) -> Option<Vec<f64>> {
    let mut normal: DMatrix<f64> = gram(columns);
    for k in 0..normal.nrows() {
        normal[(k, k)] += LAST_DIGITS * normal[(k, k)].max(f64::MIN_POSITIVE);
    }
    let right = DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, of)));
    let solved = normal.cholesky()?.solve(&right);
    let left = less(of, columns, &solved);
    (dot(&left, &left) > LAST_DIGITS * dot(of, of)).then_some(left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};

    fn counts_of(command: &[f64]) -> Vec<f64> {
        let t_s: Vec<f64> = (0..command.len()).map(|k| 0.003 * k as f64).collect();
        let drive = Drive {
            t_s: &t_s,
            command,
            kind: CommandKind::Voltage,
        };
        let made = simulate(&Motor::default(), &drive, &SimulationOptions::default());
        let counts = made.expect("it can be simulated").counts;
        counts.into_iter().map(|n| n as f64).collect()
    }

    /// A position loop computes each command from the counts that it has just read; the same command played from a
    /// table is open loop for another motor.
    #[test]
    fn a_position_loop_is_closed_loop_and_a_profile_is_not() {
        let settings = Settings::default();
        let mut command: Vec<f64> = Vec::new();
        for k in 0..600 {
            let goal = 300.0 * (0.002 * f64::from(k)).sin();
            command.push(0.0);
            let now = *counts_of(&command).last().expect("a sample");
            *command.last_mut().expect("a sample") = (0.05 * (goal - now)).clamp(-4.5, 4.5);
        }
        assert!(depends_on_motion(&command, &counts_of(&command), &settings));
        let run = recording(&Motor::default(), 1500);
        let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
        assert!(!depends_on_motion(&run.command, &counts, &settings));
        let chirp: Vec<f64> = (0..1500)
            .map(|k| 4.0 * (1e-5 * f64::from(k).powi(2)).sin())
            .collect();
        assert!(!depends_on_motion(&chirp, &counts_of(&chirp), &settings));
    }
}
