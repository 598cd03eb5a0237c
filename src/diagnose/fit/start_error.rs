//! A piece begins at a measured angle and a measured speed. What their errors make of the position is no gap.
//!
//! The residual of a piece is, besides the gap, `o + v tau (1 - exp(-t/tau))`: the offset `o` is known to a count's rounding, the
//! speed `v` to what was measured of it. Both are estimated with these as priors (ridge regression: Hoerl and Kennard, 1970), and
//! taken off.

use nalgebra::{Matrix2, Vector2};

use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::ROUNDING;

/// The residual of all pieces less what the errors of their starts make, in counts.
pub(crate) fn less_start(pieces: &Pieces, time_constant_s: f64, residual: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(residual.len());
    for piece in &pieces.pieces {
        let seen = &residual[pieces.range(piece)];
        let run = &pieces.runs[piece.run];
        let (mut turned, mut speed) = (0.0, 1.0);
        let mut column = Vec::with_capacity(seen.len());
        for k in piece.from..piece.to {
            if k > piece.from && run.moving[k] {
                let kept = (-(run.t_s[k] - run.t_s[k - 1]) / time_constant_s).exp();
                turned += speed * (1.0 - kept) * time_constant_s;
                speed *= kept;
            }
            // In standard deviations of the speed, so that one that is known is none.
            column.push(turned * piece.start_speed_sd);
        }
        let squares = seen.iter().map(|r| r * r).sum::<f64>();
        let variance = (squares / seen.len().max(1) as f64).max(ROUNDING);
        let sums = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
            seen.iter().zip(&column).map(|(r, x)| f(*r, *x)).sum()
        };
        let normal = Matrix2::new(
            seen.len() as f64 / variance + 1.0 / ROUNDING,
            sums(&|_, x| x) / variance,
            sums(&|_, x| x) / variance,
            sums(&|_, x| x * x) / variance + 1.0,
        );
        let right = Vector2::new(sums(&|r, _| r), sums(&|r, x| r * x)) / variance;
        let found = normal
            .try_inverse()
            .map_or_else(Vector2::zeros, |inverse| inverse * right);
        out.extend((seen.iter().zip(&column)).map(|(r, x)| r - found[0] - found[1] * x));
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
