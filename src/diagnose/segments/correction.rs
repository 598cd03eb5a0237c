//! Marginalization of the error of a segment's measured initial state from residuals and derivatives.
//!
//! Prediction errors of a segment are `e + A b`: columns of `A` are the responses of the position to an offset of the
//! angle and to an error of the initial speed, `b` has the prior covariance `D` (quantization of the first sample;
//! variance of the measured speed). If `e` has the variance of quantization `s2`, the covariance is `s2 (I + A D
//! A'/s2)`. Its symmetric inverse square root is `W = I - sum_k (1 - 1/sqrt(1 + l_k)) u_k u_k'` with the eigenpairs
//! `(l_k, u_k)` of `A D A'/s2`, so that a correction is two scalar products, linear, and the same for every model
//! (generalized least squares; marginalized nuisance parameters).

use super::{Recording, Segment};
use crate::diagnose::settings::solver::LAST_DIGITS;
use crate::units::ROUNDING_VARIANCE;

/// The operator `W` of one segment.
#[derive(Debug, Clone)]
pub(super) struct Correction {
    /// Orthonormal vectors `u_k` with `1 - 1/sqrt(1 + l_k)`.
    directions: Vec<(f64, Vec<f64>)>,
}

impl Correction {
    pub fn new(run: &Recording, segment: &Segment, time_constant_s: f64) -> Self {
        let n = segment.len() as f64;
        let first = vec![1.0 / n.sqrt(); segment.len()];
        let mut second = speed_response(run, segment, time_constant_s);
        let along: f64 = second.iter().sum::<f64>() / n.sqrt();
        second.iter_mut().for_each(|x| *x -= along / n.sqrt());
        let across = second.iter().map(|x| x * x).sum::<f64>().sqrt();
        // A = Q R, R = [[sqrt n, along], [0, across]]; M = R D R'/s2 with D = diag(s2, sd^2).
        let speed = segment.start_speed_sd.powi(2) / ROUNDING_VARIANCE;
        let m = [
            n + along * along * speed,
            along * across * speed,
            across * across * speed,
        ];
        if across <= LAST_DIGITS || speed <= 0.0 {
            return Self {
                directions: vec![(shrinkage(n), first)],
            };
        }
        second.iter_mut().for_each(|x| *x /= across);
        let middle = 0.5 * (m[0] + m[2]);
        let apart = (0.25 * (m[0] - m[2]).powi(2) + m[1] * m[1]).sqrt();
        let angle = 0.5 * (2.0 * m[1]).atan2(m[0] - m[2]);
        let (sine, cosine) = angle.sin_cos();
        let turned = |a: f64, b: f64| -> Vec<f64> {
            (first.iter().zip(&second))
                .map(|(x, y)| a * x + b * y)
                .collect()
        };
        Self {
            directions: vec![
                (shrinkage(middle + apart), turned(cosine, sine)),
                (shrinkage((middle - apart).max(0.0)), turned(-sine, cosine)),
            ],
        }
    }

    /// Replaces a column by `W` times it.
    pub fn apply(&self, column: &mut [f64]) {
        for (share, direction) in &self.directions {
            let along = share * super::super::model::dot(column, direction);
            for (x, u) in column.iter_mut().zip(direction) {
                *x -= along * u;
            }
        }
    }
}

fn shrinkage(eigenvalue: f64) -> f64 {
    1.0 - 1.0 / (1.0 + eigenvalue).sqrt()
}

/// Response of a segment's position in counts per count/s of additional initial speed.
fn speed_response(run: &Recording, segment: &Segment, time_constant_s: f64) -> Vec<f64> {
    let (mut turned, mut speed) = (0.0, 1.0);
    let mut column = Vec::with_capacity(segment.len());
    for k in segment.from..segment.to {
        if k > segment.from && run.moving[k] {
            let kept = (-(run.t_s[k] - run.t_s[k - 1]) / time_constant_s).exp();
            turned += speed * (1.0 - kept) * time_constant_s;
            speed *= kept;
        }
        column.push(turned);
    }
    column
}

#[cfg(test)]
mod tests {
    use super::super::Segments;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    /// An offset and an error of the initial speed within their standard deviations are reduced to a tenth; a
    /// residual orthogonal to them is unchanged.
    #[test]
    fn the_correction_removes_only_initial_state_errors() {
        let run = recording(&Motor::default(), 2000);
        let segments =
            Segments::new(&[run], &Motor::default(), &Settings::default()).expect("a run");
        let mut offset = vec![0.5; segments.len];
        segments.correct(&mut offset);
        let mut alternating: Vec<f64> = (0..segments.len)
            .map(|k| if k % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        segments.correct(&mut alternating);
        for segment in &segments.segments {
            let rms = |column: &[f64]| {
                let squares: f64 = column[segment.range()].iter().map(|r| r * r).sum();
                (squares / segment.len() as f64).sqrt()
            };
            assert!(rms(&offset) < 0.1, "{segment:?}: {}", rms(&offset));
            assert!(rms(&alternating) > 0.95, "{segment:?}");
        }
    }
}
