//! Predictions of a motor for all segments, in counts relative to each segment's first sample, and their derivatives.

use std::cell::RefCell;

use nalgebra::DVector;

use super::Model;
use crate::diagnose::segments::{Recording, Segments};
use crate::motor::Motor;
use crate::motor::fit::Workspace;

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

/// The prediction; `None` if the motor cannot be simulated.
pub(crate) fn predict(segments: &Segments, motor: &Motor) -> Option<Vec<f64>> {
    let mut out = vec![0.0; segments.len];
    WORKSPACE.with_borrow_mut(|workspace| {
        for (number, run) in segments.runs.iter().enumerate() {
            let mut angles = vec![0.0; run.t_s.len()];
            let simulated = (run.simulator).angles(&on_run(motor, run), workspace, &mut angles);
            segments.work.add(run.t_s.len(), 0, workspace.take_work());
            simulated.ok()?;
            scatter(segments, number, &angles, 1.0 / run.rad, &mut out);
        }
        Some(out)
    })
}

/// Measured minus predicted in counts, initial states corrected; `None` if the motor cannot be simulated.
pub(crate) fn corrected_residual(segments: &Segments, motor: &Motor) -> Option<Vec<f64>> {
    let mut residual = segments.residual(&predict(segments, motor)?);
    segments.correct(&mut residual);
    Some(residual)
}

/// Counts of each run relative to its first sample for the predicted angle, with the encoder at this fraction of a
/// count, or with the rounded speeds of the log.
pub(crate) fn simulated_counts(
    segments: &Segments,
    motor: &Motor,
    phase: f64,
) -> Option<Vec<Vec<f64>>> {
    WORKSPACE.with_borrow_mut(|workspace| {
        let of_run = |run: &Recording| {
            let mut angles = vec![0.0; run.t_s.len()];
            (run.continuous)
                .angles(&on_run(motor, run), workspace, &mut angles)
                .ok()?;
            angles.iter_mut().for_each(|angle| *angle /= run.rad);
            let off = run.rounding_of_speeds(&angles, phase);
            let count =
                |(position, off): (&f64, f64)| (position + off + phase).floor() - run.first_counts;
            Some(angles.iter().zip(off).map(count).collect())
        };
        segments.runs.iter().map(of_run).collect()
    })
}

/// The prediction and its derivatives by a model's parameters, one column each.
pub(crate) fn sensitivities(
    segments: &Segments,
    model: &Model,
    x: &[f64],
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let motor = model.motor(x);
    let ids = model.free();
    let mut out = vec![0.0; segments.len];
    let mut columns = vec![vec![0.0; segments.len]; ids.len()];
    WORKSPACE.with_borrow_mut(|workspace| {
        for (number, run) in segments.runs.iter().enumerate() {
            let n = run.t_s.len();
            let mut angles = vec![0.0; n];
            let mut block = vec![0.0; n * ids.len()];
            let motor = on_run(&motor, run);
            let simulated =
                (run.simulator).sensitivities(&motor, &ids, workspace, &mut angles, &mut block);
            segments.work.add(n, ids.len(), workspace.take_work());
            simulated.ok()?;
            scatter(segments, number, &angles, 1.0 / run.rad, &mut out);
            for (j, free) in model.parameters.iter().enumerate() {
                let times = free.slope(x[j]) / run.rad;
                scatter(
                    segments,
                    number,
                    &block[j * n..(j + 1) * n],
                    times,
                    &mut columns[j],
                );
            }
        }
        Some(())
    })?;
    for (j, free) in model.parameters.iter().enumerate() {
        if free.smooth {
            continue;
        }
        let step = free.difference();
        let moved = |by: f64| {
            let mut x = x.to_vec();
            x[j] = (x[j] + by).clamp(free.lo, free.hi);
            Some((x[j], predict(segments, &model.motor(&x))?))
        };
        let ((a, low), (b, high)) = (moved(-step)?, moved(step)?);
        if b > a {
            for ((slot, low), high) in columns[j].iter_mut().zip(low).zip(high) {
                *slot = (high - low) / (b - a);
            }
        }
    }
    Some((out, columns))
}

/// The motor with the supply of a run.
fn on_run(motor: &Motor, run: &Recording) -> Motor {
    let mut motor = motor.clone();
    if let Some(supply_v) = run.supply_v {
        motor.parameters.supply_v = supply_v;
    }
    motor
}

/// Writes a run's column to its segments, relative to each segment's first sample.
fn scatter(segments: &Segments, run: usize, column: &[f64], times: f64, out: &mut [f64]) {
    for segment in segments
        .segments
        .iter()
        .filter(|segment| segment.run == run)
    {
        let first = column[segment.from];
        for (slot, value) in
            (out[segment.range()].iter_mut()).zip(&column[segment.from..segment.to])
        {
            *slot = (value - first) * times;
        }
    }
}

/// A column minus some columns times these coefficients.
pub(crate) fn less(column: &[f64], columns: &[Vec<f64>], by: &DVector<f64>) -> Vec<f64> {
    let mut left = column.to_vec();
    for (column, by) in columns.iter().zip(by.iter()) {
        left.iter_mut().zip(column).for_each(|(x, c)| *x -= by * c);
    }
    left
}

pub(crate) fn mean_square(a: &[f64]) -> f64 {
    dot(a, a) / a.len().max(1) as f64
}

/// Scalar product, in eight independent sums.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, a_rest) = a[..n].as_chunks::<8>();
    let (b, b_rest) = b[..n].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}
