//! Detection of closed loops: whether the command of a run depends on its motion.
//!
//! In open loop a command depends on its own past at most. A controller's depends on the position that it has just
//! read, with the opposite sign: on the innovation of the position given the past of command and position. The share
//! of the command's innovation that it explains (partial R^2 of a regression; Granger 1969) is above 0.97 for
//! controllers that are logged with the position that they read, and below 0.15 for other real recordings. Steps of
//! the set point are outliers of this regression, so that it is a robust one.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fit::gram;
use crate::diagnose::model::{dot, less};
use crate::diagnose::robust::student_weights;
use crate::diagnose::settings::Settings;
use crate::diagnose::settings::solver::{LAST_DIGITS, REWEIGHTED};

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
    let (command, motion) = (column(&|k| command[k]), column(&moved));
    innovations(&past, &command, &motion).is_some_and(|(of_command, of_motion)| {
        let both = dot(&of_command, &of_motion);
        let squares = dot(&of_command, &of_command) * dot(&of_motion, &of_motion);
        both < 0.0 && both * both > settings.feedback_share * squares
    })
}

/// Innovations of command and motion given their past, times the square roots of robust weights from the regression
/// of the command on both; `None` if one of them is zero.
fn innovations(past: &[Vec<f64>], command: &[f64], motion: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let all = [past, &[motion.to_vec()]].concat();
    let mut root = vec![1.0; command.len()];
    for _ in 0..REWEIGHTED {
        let coefficients = regression(&all, command, &root)?;
        let weights = student_weights(&less(command, &all, &coefficients));
        root = weights.iter().map(|weight| weight.sqrt()).collect();
    }
    let innovation = |of: &[f64]| {
        let left = less(of, past, &regression(past, of, &root)?);
        let (left, of) = (times(&left, &root), times(of, &root));
        (dot(&left, &left) > LAST_DIGITS * dot(&of, &of)).then_some(left)
    };
    Some((innovation(command)?, innovation(motion)?))
}

/// Coefficients of a regression of rows with these square roots of weights.
fn regression(columns: &[Vec<f64>], of: &[f64], root: &[f64]) -> Option<DVector<f64>> {
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| times(column, root)).collect();
    let mut normal: DMatrix<f64> = gram(&columns);
    for k in 0..normal.nrows() {
        normal[(k, k)] += LAST_DIGITS * normal[(k, k)].max(f64::MIN_POSITIVE);
    }
    let of = times(of, root);
    let right = DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, &of)));
    Some(normal.cholesky()?.solve(&right))
}

fn times(column: &[f64], by: &[f64]) -> Vec<f64> {
    column.iter().zip(by).map(|(x, by)| x * by).collect()
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

    /// Command of a controller that sees the counts and the sample's number.
    fn controlled(samples: u32, mut controller: impl FnMut(u32, f64) -> f64) -> Vec<f64> {
        let mut command: Vec<f64> = Vec::new();
        for k in 0..samples {
            command.push(0.0);
            let now = *counts_of(&command).last().expect("a sample");
            *command.last_mut().expect("a sample") = controller(k, now).clamp(-4.5, 4.5);
        }
        command
    }

    /// A position loop computes each command from the counts that it has just read; the same command played from a
    /// table is open loop for another motor.
    #[test]
    fn a_position_loop_is_closed_loop_and_a_profile_is_not() {
        let settings = Settings::default();
        let command = controlled(600, |k, now| {
            0.05 * (300.0 * (0.002 * f64::from(k)).sin() - now)
        });
        assert!(depends_on_motion(&command, &counts_of(&command), &settings));
        let run = recording(&Motor::default(), 1500);
        let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
        assert!(!depends_on_motion(&run.command, &counts, &settings));
        let chirp: Vec<f64> = (0..1500)
            .map(|k| 4.0 * (1e-5 * f64::from(k).powi(2)).sin())
            .collect();
        assert!(!depends_on_motion(&chirp, &counts_of(&chirp), &settings));
    }

    /// Steps of the set point move the command by more than all that the motion does to it.
    #[test]
    fn a_speed_loop_whose_set_point_steps_is_closed_loop() {
        let (mut before, mut integral) = (0.0, 0.0);
        let command = controlled(600, |k, now| {
            let goal = if (k / 100) % 2 == 0 { 1.2 } else { -0.6 };
            let error = goal - (now - before);
            before = now;
            integral += 0.02 * error;
            0.2 * error + integral
        });
        let counts = counts_of(&command);
        assert!(depends_on_motion(&command, &counts, &Settings::default()));
    }
}
