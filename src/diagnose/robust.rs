//! Robust weights of regressions.

use super::settings::conventions::MEDIAN_SIZE;
use super::settings::solver::WEIGHTS_FREEDOM;

/// Weights of residuals under Student's t distribution with few degrees of freedom, scaled by their median size (Lange,
/// Little, Taylor 1989).
pub(crate) fn student_weights(residuals: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let sigma = sizes[sizes.len() / 2] / MEDIAN_SIZE + f64::MIN_POSITIVE;
    let weight = |r: &f64| (1.0 + WEIGHTS_FREEDOM) / (WEIGHTS_FREEDOM + (r / sigma).powi(2));
    residuals.iter().map(weight).collect()
}
