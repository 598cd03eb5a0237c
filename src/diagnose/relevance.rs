//! The relevance test: whether a model's error exceeds that for simulated recordings of itself.
//!
//! In: segments and a fit. Out: the noise floor, the mean square residual of the model for its own prediction with
//! quantization by the encoder, or by the rounded speeds of a log without position, initial states measured again
//! (parametric bootstrap over the fraction of a count, or over the last digit of the speeds); or repeatability and
//! the accepted error, if larger.

use super::fit::Fit;
use super::model::{corrected_residual, mean_square, simulated_counts};
use super::score::fitted_time_constant_s;
use super::segments::Segments;
use super::settings::Settings;
use super::settings::conventions::ONE_SIDED_95;
use super::settings::solver::PHASES;

/// The largest mean square residual in counts^2 of a fit's motor for simulated recordings of itself.
pub(crate) fn noise_floor(segments: &Segments, fit: &Fit) -> Option<f64> {
    let motor = fit.model.motor(&fit.x);
    let tau_s = fitted_time_constant_s(fit);
    let mut most: f64 = 0.0;
    for phase in PHASES {
        let counts = simulated_counts(segments, &motor, phase)?;
        let own = segments.with_counts(counts, tau_s);
        most = most.max(mean_square(&corrected_residual(&own, &motor)?));
    }
    Some(most)
}

/// Whether a mean square exceeds a noise floor by more than an immaterial share and by more than its sampling error
/// (one-sided 95 %): that of a mean of `n_eff` squares of normal variates.
pub(crate) fn exceeds(mean_square: f64, floor: f64, n_eff: f64, settings: &Settings) -> bool {
    let sampling = ONE_SIDED_95 * (2.0 / n_eff).sqrt();
    mean_square > floor * (1.0 + sampling.max(settings.unexplained_share))
}
