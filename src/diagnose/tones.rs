//! The tones of rounding: what is not white about it.
//!
//! A shaft that turns evenly at `f` counts a sample is rounded by a saw `s - floor(s)` of its position `s`, which
//! repeats `f mod 1` times a sample. Most of the error's power is then in a few lines, and a spring or a ripple
//! that happens to follow one would explain it. The saw is `1/2 - sum_h sin(2 pi h s)/(pi h)`: its first harmonics,
//! of free phase, are nuisances of every hypothesis, with the variance `1/(2 pi^2 h^2)` that they have by rounding.
//! `s` is read off the recording alone: a straight line through each stretch that is straight to within rounding.

use nalgebra::{DMatrix, DVector};

use super::sums::{dot, gram};

/// Harmonics of the saw.
const HARMONICS: usize = 2;
/// Lengths in s of the stretches tried, each within the one before.
const STRETCHES_S: [f64; 3] = [1.2, 0.4, 0.15];
/// Fewest samples of a stretch.
const FEWEST: usize = 6;
/// Fewest counts that a stretch covers.
const LEAST_TRAVEL: f64 = 3.0;
/// RMS in counts up to which a stretch is straight (rounding alone: 0.289).
const STRAIGHT: f64 = 0.36;

/// The columns, a harmonic's sine and cosine after another, in standard deviations of the prior.
pub(super) fn columns(t_s: &[f64], counts: &[f64]) -> Vec<Vec<f64>> {
    let mut position = vec![None; counts.len()];
    straight_lines(t_s, counts, 0..counts.len(), 0, &mut position);
    if position.iter().all(Option::is_none) {
        return Vec::new();
    }
    let mut all = Vec::new();
    for harmonic in 1..=HARMONICS {
        let order = std::f64::consts::TAU * harmonic as f64;
        let deviation = std::f64::consts::SQRT_2 / order;
        for shift in [0.0, std::f64::consts::FRAC_PI_2] {
            let wave = |s: &Option<f64>| s.map_or(0.0, |s| deviation * (order * s + shift).sin());
            all.push(position.iter().map(wave).collect());
        }
    }
    all
}

/// Fills in the positions of stretches of the length with this number, and of shorter ones inside those that
/// are not straight.
fn straight_lines(
    t_s: &[f64],
    counts: &[f64],
    range: std::ops::Range<usize>,
    length: usize,
    position: &mut [Option<f64>],
) {
    let Some(&length_s) = STRETCHES_S.get(length) else {
        return;
    };
    let mut from = range.start;
    while from < range.end {
        let later = t_s[from..range.end].partition_point(|t| *t < t_s[from] + length_s);
        let to = from + later.max(1);
        match line(&t_s[from..to], &counts[from..to]) {
            Some(fitted) => {
                for (place, s) in position[from..to].iter_mut().zip(fitted) {
                    *place = Some(s);
                }
            }
            None => straight_lines(t_s, counts, from..to, length + 1, position),
        }
        from = to;
    }
}

/// The straight line through a stretch, if it is one.
fn line(t_s: &[f64], counts: &[f64]) -> Option<Vec<f64>> {
    let n = t_s.len();
    let (first, last) = (counts.first()?, counts.last()?);
    if n < FEWEST || (last - first).abs() < LEAST_TRAVEL {
        return None;
    }
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n as f64;
    let (t_mean, n_mean) = (mean(t_s), mean(counts));
    let (mut tt, mut tn) = (0.0, 0.0);
    for (t, count) in t_s.iter().zip(counts) {
        tt += (t - t_mean).powi(2);
        tn += (t - t_mean) * (count - n_mean);
    }
    let slope = tn / tt;
    let fitted: Vec<f64> = t_s.iter().map(|t| n_mean + slope * (t - t_mean)).collect();
    let squares: f64 = counts
        .iter()
        .zip(&fitted)
        .map(|(n, s)| (n - s).powi(2))
        .sum();
    ((squares / n as f64).sqrt() < STRAIGHT).then_some(fitted)
}

/// Takes the tones' share out of whitened columns: `(I + C C')^(-1/2) = I - C K C'`, where `C'C` has the eigenvalues `l_i` and the
/// eigenvectors `v_i`, and `K = sum_i (1 - (1 + l_i)^(-1/2))/l_i v_i v_i'`.
#[derive(Debug, Clone)]
pub(super) struct Projection {
    columns: Vec<Vec<f64>>,
    inner: DMatrix<f64>,
    /// `ln |I + C C'|`.
    pub log_determinant: f64,
}

impl Projection {
    /// Of whitened columns `C`.
    pub fn new(columns: Vec<Vec<f64>>) -> Self {
        let d = columns.len();
        let mut inner = DMatrix::zeros(d, d);
        let mut log_determinant = 0.0;
        if d > 0 {
            let eigen = gram(&columns, |_, _| 0.0).symmetric_eigen();
            let vectors = eigen.eigenvectors.column_iter();
            for (lambda, vector) in eigen.eigenvalues.iter().zip(vectors) {
                if *lambda > 1e-9 {
                    inner +=
                        vector * vector.transpose() * ((1.0 - (1.0 + lambda).powf(-0.5)) / lambda);
                    log_determinant += lambda.ln_1p();
                }
            }
        }
        Self {
            columns,
            inner,
            log_determinant,
        }
    }

    /// Takes the tones out of a whitened column.
    pub fn apply(&self, column: &mut [f64]) {
        let along = DVector::from_iterator(
            self.columns.len(),
            self.columns.iter().map(|c| dot(c, column)),
        );
        let shares = &self.inner * along;
        let (pairs, last) = self.columns.as_chunks::<2>();
        let (of_pairs, of_last) = shares.as_slice().as_chunks::<2>();
        for ([a, b], [x, y]) in pairs.iter().zip(of_pairs) {
            for ((value, a), b) in column.iter_mut().zip(a).zip(b) {
                *value -= x * a + y * b;
            }
        }
        for (c, share) in last.iter().zip(of_last) {
            for (value, c) in column.iter_mut().zip(c) {
                *value -= share * c;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaft at 1.95 counts a sample: the tones hold most of what rounding leaves.
    #[test]
    fn an_even_turn_is_rounded_by_tones() {
        let t_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.003).collect();
        let exact: Vec<f64> = (0..1000).map(|k| 0.3 + 1.95 * f64::from(k)).collect();
        let counts: Vec<f64> = exact.iter().map(|x| x.floor() + 0.5).collect();
        let scale = 12f64.sqrt();
        let columns: Vec<Vec<f64>> = columns(&t_s, &counts)
            .into_iter()
            .map(|column| column.into_iter().map(|x| scale * x).collect())
            .collect();
        let projection = Projection::new(columns);
        let mut r: Vec<f64> = counts
            .iter()
            .zip(&exact)
            .map(|(n, x)| scale * (n - x))
            .collect();
        let before: f64 = r.iter().map(|x| x * x).sum();
        projection.apply(&mut r);
        let after: f64 = r.iter().map(|x| x * x).sum();
        // The first two harmonics of the saw hold (1 + 1/4) 6/pi^2 = 76 % of its power.
        assert!((before / 1000.0 - 1.0).abs() < 0.01, "{before}");
        assert!((after / before - 0.24).abs() < 0.02, "{}", after / before);
    }

    /// A shaft that never turns evenly has no tones.
    #[test]
    fn no_tones_change_nothing() {
        let t_s = [0.0, 0.003, 0.006, 0.009];
        assert!(columns(&t_s, &[0.5, 0.5, 1.5, 4.5]).is_empty());
        let mut x = vec![1.0, -2.0];
        let projection = Projection::new(Vec::new());
        projection.apply(&mut x);
        assert_eq!(x, [1.0, -2.0]);
        assert_eq!(projection.log_determinant, 0.0);
    }

    /// The projection is the square root of the marginal likelihood's matrix.
    #[test]
    fn marginalising_is_woodbury() {
        let column: Vec<f64> = (0..50).map(|k| f64::from(k * k % 7) - 3.0).collect();
        let x: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.7).sin()).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let expected = dot(&x, &x) - dot(&x, &column).powi(2) / (1.0 + dot(&column, &column));
        let projection = Projection::new(vec![column.clone()]);
        let mut y = x.clone();
        projection.apply(&mut y);
        assert!((dot(&y, &y) - expected).abs() < 1e-9);
        let determinant = dot(&column, &column).ln_1p();
        assert!((projection.log_determinant - determinant).abs() < 1e-12);
    }
}
