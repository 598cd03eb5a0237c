//! Where pieces begin: at a measured angle and a measured speed. What their errors make of the position is no gap.
//!
//! The residual of a piece is, besides the gap, `o + v tau (1 - exp(-t/tau))`: the offset `o` is known to a count's rounding, the
//! speed `v` to what was measured of it. Both are estimated with these as priors (ridge regression: Hoerl and Kennard, 1970), and
//! taken off. That is linear, and no motor is: so a piece is simulated from the speed that is estimated, and what the difference to
//! the measured one makes is put back (Gauss and Newton's expansion about the estimate).

use nalgebra::{Matrix2, Vector2};

use super::fitted::{dot, residual};
use super::response;
use crate::diagnose::pieces::{Piece, Pieces};
use crate::diagnose::settings::ROUNDING;
use crate::motor::Motor;

/// How many times the variance of a piece is found anew: what the start makes of it is gone after two.
const ROUNDS: usize = 3;

/// By how many counts/s each piece is simulated faster than what is measured.
#[derive(Debug, Clone)]
pub(crate) struct Starts {
    faster: Vec<f64>,
    /// Time constant in s by which that passes.
    time_constant_s: f64,
}

impl Starts {
    /// As they are measured.
    pub fn measured(pieces: &Pieces) -> Self {
        Self {
            faster: vec![0.0; pieces.pieces.len()],
            time_constant_s: 1.0,
        }
    }

    /// As a motor's residual has them, whatever that is expanded about.
    pub fn seen(pieces: &Pieces, time_constant_s: f64, residual: &[f64]) -> Self {
        let faster = |piece: &Piece| {
            let passing = passing(pieces, piece, time_constant_s);
            let [_, speed] = estimated(&residual[pieces.range(piece)], &passing, piece);
            speed * piece.start_speed_sd
        };
        Self {
            faster: pieces.pieces.iter().map(faster).collect(),
            time_constant_s,
        }
    }

    /// As a motor has them, and what it leaves about them, in counts; those that are measured where it leaves no less about others.
    pub fn of(pieces: &Pieces, motor: &Motor, time_constant_s: f64) -> Option<(Self, Vec<f64>)> {
        let left = |starts: Self| {
            let residual = residual(pieces, &response(pieces, motor, &starts)?);
            Some((starts, residual))
        };
        let shown = |residual: &[f64]| {
            let shown = less_start(pieces, time_constant_s, residual);
            dot(&shown, &shown)
        };
        let measured = left(Self::measured(pieces))?;
        let seen = left(Self::seen(pieces, time_constant_s, &measured.1));
        Some(match seen {
            Some(seen) if shown(&seen.1) < shown(&measured.1) => seen,
            _ => measured,
        })
    }

    /// The pieces of a run that are not simulated from what is measured: first sample and by how many counts/s faster.
    pub fn of_run(&self, pieces: &Pieces, run: usize) -> Vec<(usize, f64)> {
        let pairs = pieces.pieces.iter().zip(&self.faster);
        pairs
            .filter(|(piece, by)| piece.run == run && **by != 0.0)
            .map(|(piece, by)| (piece.from, *by))
            .collect()
    }

    /// Takes from a response what the starts make of it, so that it is that from what is measured.
    pub fn put_back(&self, pieces: &Pieces, response: &mut [f64]) {
        for (piece, by) in pieces.pieces.iter().zip(&self.faster) {
            if *by != 0.0 {
                let passing = passing(pieces, piece, self.time_constant_s);
                let slots = response[pieces.range(piece)].iter_mut();
                slots.zip(passing).for_each(|(slot, x)| *slot -= by * x);
            }
        }
    }
}

/// Counts that a piece comes to beyond others for each count/s that it begins faster.
fn passing(pieces: &Pieces, piece: &Piece, time_constant_s: f64) -> Vec<f64> {
    let run = &pieces.runs[piece.run];
    let (mut turned, mut speed) = (0.0, 1.0);
    let mut column = Vec::with_capacity(piece.to - piece.from);
    for k in piece.from..piece.to {
        if k > piece.from && run.moving[k] {
            let kept = (-(run.t_s[k] - run.t_s[k - 1]) / time_constant_s).exp();
            turned += speed * (1.0 - kept) * time_constant_s;
            speed *= kept;
        }
        column.push(turned);
    }
    column
}

/// Offset in counts and error of the start speed in its standard deviations (so that one that is known is none) that a piece's residual
/// shows.
fn estimated(seen: &[f64], passing: &[f64], piece: &Piece) -> [f64; 2] {
    let sd = piece.start_speed_sd;
    let n = seen.len().max(1) as f64;
    let sums = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        seen.iter().zip(passing).map(|(r, x)| f(*r, sd * x)).sum()
    };
    let (rr, r1, x1) = (sums(&|r, _| r * r), sums(&|r, _| r), sums(&|_, x| x));
    let (rx, xx) = (sums(&|r, x| r * x), sums(&|_, x| x * x));
    let mut found = Vector2::<f64>::zeros();
    for _ in 0..ROUNDS {
        let squares = rr - 2.0 * (found[0] * r1 + found[1] * rx)
            + found[0] * (found[0] * n + 2.0 * found[1] * x1)
            + found[1] * found[1] * xx;
        let variance = (squares / n).max(ROUNDING);
        let normal = Matrix2::new(
            n / variance + 1.0 / ROUNDING,
            x1 / variance,
            x1 / variance,
            xx / variance + 1.0,
        );
        let right = Vector2::new(r1, rx) / variance;
        let Some(inverse) = normal.try_inverse() else {
            return [0.0; 2];
        };
        found = inverse * right;
    }
    found.into()
}

/// The residual of all pieces less what the errors of their starts make, in counts.
pub(crate) fn less_start(pieces: &Pieces, time_constant_s: f64, residual: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(residual.len());
    for piece in &pieces.pieces {
        let seen = &residual[pieces.range(piece)];
        let passing = passing(pieces, piece, time_constant_s);
        let [offset, speed] = estimated(seen, &passing, piece);
        let faster = speed * piece.start_speed_sd;
        out.extend((seen.iter().zip(&passing)).map(|(r, x)| r - offset - faster * x));
    }
    out
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::motor::Motor;

    /// Of a start at rest the offset is taken off as of any other: rounding is all that is left of a shift by half a count.
    #[test]
    fn an_offset_is_no_gap_whether_the_start_is_at_rest_or_not() {
        let run = recording(&Motor::default(), 2000);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let at_rest = |piece: &&crate::diagnose::pieces::Piece| piece.start_speed_sd == 0.0;
        assert!(pieces.pieces.iter().any(|piece| at_rest(&piece)));
        assert!(pieces.pieces.iter().any(|piece| !at_rest(&piece)));
        let left = less_start(&pieces, 0.03, &vec![0.5; pieces.len]);
        for piece in &pieces.pieces {
            let squares = left[pieces.range(piece)].iter().map(|r| r * r).sum::<f64>();
            let rms = (squares / (piece.to - piece.from) as f64).sqrt();
            assert!(rms < 0.1, "{piece:?}: {rms}");
        }
    }
}
