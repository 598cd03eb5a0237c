//! Statistics that are robust against outlying units.
//!
//! Median and median absolute deviation (Hampel 1974), slope as the median over pairs (Theil 1950, Sen 1968) and the
//! rank test for a trend (Mann 1945, Kendall).

/// Ratio of standard deviation to median absolute deviation for a normal distribution.
const SIGMA_OF_MAD: f64 = 1.4826;
/// Ratio of standard deviation to mean absolute deviation: the root of pi / 2.
const SIGMA_OF_MEAN: f64 = 1.2533;

pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.len().checked_sub(1)? / 2, values.len() / 2);
    Some(0.5 * (values[low] + values[high]))
}

/// Median and robust standard deviation. If more than half of the values are equal, the median deviation is 0 and the
/// mean deviation replaces it (Iglewicz and Hoaglin 1993).
pub(super) fn centre_and_sigma(values: &[f64]) -> Option<(f64, f64)> {
    let centre = median(values.iter().copied())?;
    let deviations = || values.iter().map(|value| (value - centre).abs());
    let mad = median(deviations())?;
    let mean = deviations().sum::<f64>() / values.len() as f64;
    let sigma = if mad > 0.0 {
        SIGMA_OF_MAD * mad
    } else {
        SIGMA_OF_MEAN * mean
    };
    Some((centre, sigma))
}

/// Slope of `y` over `x` (Theil-Sen), and the p-value of the trend.
pub(super) fn trend(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let pairs = || {
        let later = |k: usize| points[k + 1..].iter();
        (0..points.len()).flat_map(move |k| later(k).map(move |b| (points[k], *b)))
    };
    let slopes = pairs().filter(|(a, b)| b.0 != a.0);
    let slope = median(slopes.map(|(a, b)| (b.1 - a.1) / (b.0 - a.0)))?;
    let rising = |(a, b): ((f64, f64), (f64, f64))| {
        let product = (b.0 - a.0) * (b.1 - a.1);
        if product == 0.0 {
            0.0
        } else {
            product.signum()
        }
    };
    let score: f64 = pairs().map(rising).sum();
    let n = points.len() as f64;
    let sigma = (n * (n - 1.0) * (2.0 * n + 5.0) / 18.0).sqrt();
    // Continuity correction.
    let z = (score.abs() - 1.0).max(0.0) / sigma;
    // Two-sided p-value.
    Some((slope, libm::erfc(z / std::f64::consts::SQRT_2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bad_unit_moves_neither_centre_nor_sigma() {
        // By hand: median 3, deviations 2 1 0 1 1000.
        assert_eq!(
            centre_and_sigma(&[1.0, 2.0, 3.0, 4.0, 1003.0]),
            Some((3.0, SIGMA_OF_MAD))
        );
        // More than half are equal: the mean deviation is 6 / 4.
        assert_eq!(
            centre_and_sigma(&[1.0, 1.0, 1.0, 7.0]),
            Some((1.0, SIGMA_OF_MEAN * 1.5))
        );
        assert_eq!(median([1.0, 4.0]), Some(2.5));
        assert_eq!(median([]), None);
    }

    #[test]
    fn a_trend_is_that_of_scipy() {
        // scipy.stats.theilslopes(y, x)[0]; pymannkendall.original_test(y): p by the normal approximation.
        let y = [1.0, 1.4, 1.1, 1.9, 2.2, 2.0, 2.9, 3.3];
        let points: Vec<(f64, f64)> = y.iter().enumerate().map(|(k, y)| (k as f64, *y)).collect();
        let (slope, p) = trend(&points).expect("a trend");
        assert!((slope - SCIPY_SLOPE).abs() < 1e-12, "{slope}");
        assert!((p - MANN_KENDALL_P).abs() < 1e-9, "{p}");
    }

    const SCIPY_SLOPE: f64 = 0.316_666_666_666_666_65;
    const MANN_KENDALL_P: f64 = 0.004_434_008_303_100_66;
}
