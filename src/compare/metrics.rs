//! Error figures of a comparison.
//!
//! With recorded counts `n_k` (relative to the first) and the simulated position `x_k` in counts, not quantized, the
//! residual is `r_k = n_k + 1/2 - x_k - phi`: the encoder reads `floor(x + phi)`, where the initial fraction of a
//! count `phi` in [0, 1) cannot be observed. `phi` minimizes the residual; its influence is at most half a count. A
//! perfect model leaves the quantization error, uniform over one count: 1/sqrt(12) = 0.289 counts RMS.

use crate::recording::velocity_rad_s;

/// Quantization error of a perfect model, RMS: the standard deviation of a uniform distribution over one count,
/// 1/sqrt(12).
pub const FLOOR_COUNTS: f64 = 0.288_675_134_594_812_9;

/// Recorded and simulated position of a run, both relative to the first sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Initial fraction of a count, in [0, 1).
    pub start_fraction: f64,
    /// Recorded minus simulated position in counts, plus half a count of quantization.
    pub residual_counts: Vec<f64>,
    /// The simulated encoder: `floor(x + phi)`, from 0.
    pub simulated_counts: Vec<i64>,
}

/// Aligns the recorded counts with the simulated position (in counts, not quantized, from 0).
pub fn align(recorded: &[i64], simulated: &[f64]) -> Alignment {
    let first = recorded.first().copied().unwrap_or(0);
    let raw: Vec<f64> = recorded
        .iter()
        .zip(simulated)
        .map(|(&n, x)| (i128::from(n) - i128::from(first)) as f64 + 0.5 - x)
        .collect();
    let mean = raw.iter().sum::<f64>() / raw.len().max(1) as f64;
    let start_fraction = mean.clamp(0.0, 1.0 - f64::EPSILON);
    Alignment {
        start_fraction,
        residual_counts: raw.iter().map(|r| r - start_fraction).collect(),
        simulated_counts: simulated
            .iter()
            .map(|x| (x + start_fraction).floor() as i64)
            .collect(),
    }
}

/// Root mean square; 0 for an empty sequence.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0u64), |(sum, count), v| (sum + v * v, count + 1));
    if count == 0 {
        0.0
    } else {
        (sum / count as f64).sqrt()
    }
}

/// Relative spread of a column that is no more than floating-point error: sums of millions of numbers of 53 bits.
const ROUNDING: f64 = 1e-9;

/// RMS of the difference of two columns, and the same relative to the variation of the first, `||a - b|| / ||a -
/// mean(a)||` (MATLAB's NRMSE cost); rows without both values are left out. The second figure is NaN if the first
/// column is constant.
pub fn root_mean_square_errors(a: &[Option<f64>], b: &[Option<f64>]) -> (f64, f64) {
    let pairs: Vec<(f64, f64)> = a.iter().zip(b).filter_map(|(a, b)| a.zip(*b)).collect();
    let mean = pairs.iter().map(|pair| pair.0).sum::<f64>() / pairs.len().max(1) as f64;
    let error = rms(pairs.iter().map(|(a, b)| a - b));
    let spread = rms(pairs.iter().map(|(a, _)| a - mean));
    (
        error,
        if spread > ROUNDING * rms(pairs.iter().map(|(a, _)| *a)) {
            error / spread
        } else {
            f64::NAN
        },
    )
}

/// Speed in rad/s of one count per sample.
pub fn speed_of_one_count(counts_per_rev: f64, sample_time_s: f64) -> f64 {
    velocity_rad_s(1.0, 1, counts_per_rev, sample_time_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_model_has_only_rounding_residuals() {
        // Steady motion by an irrational number of counts a sample, from any initial fraction.
        for start in [0.0, 0.123, 0.5, 0.987] {
            let x: Vec<f64> = (0..100_000)
                .map(|k| f64::from(k) * 0.618_033_988_75)
                .collect();
            let recorded: Vec<i64> = x.iter().map(|x| (x + start).floor() as i64 + 77).collect();
            let alignment = align(&recorded, &x);
            let error = rms(alignment.residual_counts.iter().copied());
            assert!((error - FLOOR_COUNTS).abs() < 1e-3, "{start}: {error}");
            assert!((alignment.start_fraction - start).abs() < 1e-2);
        }
    }

    #[test]
    fn the_initial_state_does_not_absorb_a_gap() {
        let x = vec![0.0; 100];
        let recorded: Vec<i64> = (0..100).map(|k| if k == 0 { 0 } else { 10 }).collect();
        let error = rms(align(&recorded, &x).residual_counts);
        assert!(error > 9.0, "{error}");
    }

    #[test]
    fn no_error_is_relative_to_a_constant_speed() {
        let a = vec![Some(0.1 + 0.2); 1001];
        let b = vec![Some(1.0); 1001];
        assert!(root_mean_square_errors(&a, &b).1.is_nan());
        assert!(
            root_mean_square_errors(&[Some(0.0); 9], &[Some(1.0); 9])
                .1
                .is_nan()
        );
    }

    #[test]
    fn errors_are_relative_to_the_spread_of_the_recording() {
        let a: Vec<_> = [0.0, 2.0, 4.0, 6.0].map(Some).to_vec();
        let b: Vec<_> = [1.0, 3.0, 5.0, 7.0].map(Some).to_vec();
        let (error, relative) = root_mean_square_errors(&a, &b);
        assert!((error - 1.0).abs() < 1e-12);
        assert!((relative - 1.0 / 5f64.sqrt()).abs() < 1e-12);
    }
}
