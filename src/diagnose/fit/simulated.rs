//! What a motor does in all pieces, in counts from each piece's first sample.

use std::borrow::Cow;
use std::cell::RefCell;

use super::{Model, Starts};
use crate::diagnose::pieces::{Pieces, Recording};
use crate::motor::Motor;
use crate::motor::fit::{Simulator, Workspace};

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

/// Share of a number's range by which one without derivatives is moved.
const DIFFERENCE: f64 = 0.01;

/// Response in counts from the measured starts, expanded about others.
pub(crate) fn response(pieces: &Pieces, motor: &Motor, starts: &Starts) -> Option<Vec<f64>> {
    let mut out = vec![0.0; pieces.len];
    WORKSPACE.with_borrow_mut(|workspace| {
        for (number, run) in pieces.runs.iter().enumerate() {
            pieces.work.add(run.t_s.len(), 0);
            let mut angles = vec![0.0; run.t_s.len()];
            (simulator(pieces, number, starts).angles(&on_run(motor, run), workspace, &mut angles))
                .ok()?;
            spread(pieces, number, &angles, 1.0 / run.rad, &mut out);
        }
        starts.put_back(pieces, &mut out);
        Some(out)
    })
}

/// The simulator of a run from these starts.
fn simulator<'a>(pieces: &'a Pieces, run: usize, starts: &Starts) -> Cow<'a, Simulator> {
    let recording = &pieces.runs[run];
    match &starts.of_run(pieces, run)[..] {
        [] => Cow::Borrowed(&recording.simulator),
        others => {
            let by_rad_s = others.iter().map(|(from, by)| (*from, by * recording.rad));
            Cow::Owned(recording.simulator.clone().starting_faster(by_rad_s))
        }
    }
}

/// Response and its derivatives by a model's numbers, a column each.
pub(crate) fn sensitivities(
    pieces: &Pieces,
    model: &Model,
    x: &[f64],
    starts: &Starts,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let motor = model.motor(x);
    let ids = model.free();
    let mut out = vec![0.0; pieces.len];
    let mut columns = vec![vec![0.0; pieces.len]; ids.len()];
    WORKSPACE.with_borrow_mut(|workspace| {
        for (number, run) in pieces.runs.iter().enumerate() {
            let n = run.t_s.len();
            pieces.work.add(n, ids.len());
            let mut angles = vec![0.0; n];
            let mut block = vec![0.0; n * ids.len()];
            simulator(pieces, number, starts)
                .sensitivities(
                    &on_run(&motor, run),
                    &ids,
                    workspace,
                    &mut angles,
                    &mut block,
                )
                .ok()?;
            spread(pieces, number, &angles, 1.0 / run.rad, &mut out);
            for (j, free) in model.numbers.iter().enumerate() {
                spread(
                    pieces,
                    number,
                    &block[j * n..(j + 1) * n],
                    free.slope(x[j]) / run.rad,
                    &mut columns[j],
                );
            }
        }
        starts.put_back(pieces, &mut out);
        Some(())
    })?;
    for (j, free) in model.numbers.iter().enumerate() {
        if free.smooth {
            continue;
        }
        let step = DIFFERENCE * (free.hi - free.lo).min(10.0);
        let moved = |by: f64| {
            let mut x = x.to_vec();
            x[j] = (x[j] + by).clamp(free.lo, free.hi);
            Some((x[j], response(pieces, &model.motor(&x), starts)?))
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

/// The motor under the supply of a run.
fn on_run(motor: &Motor, run: &Recording) -> Motor {
    let mut motor = motor.clone();
    if let Some(supply_v) = run.supply_v {
        motor.parameters.supply_v = supply_v;
    }
    motor
}

/// Puts a run's column into its pieces' places, from each piece's first sample on.
fn spread(pieces: &Pieces, run: usize, column: &[f64], times: f64, out: &mut [f64]) {
    for piece in pieces.pieces.iter().filter(|piece| piece.run == run) {
        let first = column[piece.from];
        for (slot, value) in out[pieces.range(piece)]
            .iter_mut()
            .zip(&column[piece.from..piece.to])
        {
            *slot = (value - first) * times;
        }
    }
}
