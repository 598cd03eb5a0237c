//! Whether what is said to scatter does: innovations of what scatters do not add up (the CUSUM test: Brown, Durbin and Evans, J. R.
//! Statist. Soc. B 37, 1975), held against recordings simulated with it.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::residual_by_chance;
use crate::diagnose::fit::{Fit, dot};
use crate::diagnose::noise::Whitener;
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{CHANCE, NULLS};

/// Whether a fit's innovations add up to no more than chance makes: an error that goes on is no scatter.
pub(crate) fn is_white(pieces: &Pieces, fit: &Fit) -> bool {
    let whitener = Whitener::new(pieces, &fit.around, fit.noise);
    let predicted = fit.predicted(pieces);
    let own = farthest(pieces, &fit.white);
    let as_much = |seed: &u64| {
        let mut random = Pcg64Mcg::seed_from_u64(0x7768_6974 ^ seed);
        let residual = residual_by_chance(pieces, &predicted, &fit.around, fit.noise, &mut random);
        farthest(pieces, &whitener.whiten(&residual)) >= own
    };
    let count = (0..NULLS as u64).into_par_iter().filter(as_much).count();
    (count + 1) as f64 / (NULLS + 1) as f64 > CHANCE
}

/// Largest square of a sum of innovations from a piece's beginning on, over the sum of their squares, mean of the pieces (CUSUM).
fn farthest(pieces: &Pieces, white: &[f64]) -> f64 {
    let of_piece = |piece| {
        let own = &white[pieces.range(piece)];
        let mut sum = 0.0;
        let most = own.iter().fold(0.0_f64, |most, e| {
            sum += e;
            most.max(sum * sum)
        });
        most / dot(own, own).max(f64::MIN_POSITIVE)
    };
    pieces.pieces.iter().map(of_piece).sum::<f64>() / pieces.pieces.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::{Base, Model, fit};
    use crate::diagnose::samples::{motor_with, recording};
    use crate::motor::{CommandKind, Motor};

    fn is_white_of(truth: &Motor) -> bool {
        let run = recording(truth, 1500);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let sample_time_s = pieces.runs[0].sample_time_s;
        let base = Base::new(Motor::default(), CommandKind::Voltage, sample_time_s);
        let model = Model::new(&base, Vec::new());
        let found = fit(&pieces, &model, base.kind, &[model.start()]).expect("a motor");
        is_white(&pieces, &found)
    }

    /// What rounding leaves is white as the recordings simulated with it are; what a dead zone leaves goes on.
    #[test]
    fn an_error_that_goes_on_is_not_white() {
        assert!(is_white_of(&Motor::default()));
        assert!(!is_white_of(&motor_with(&[("dead_zone", &[1.3])])));
    }
}
