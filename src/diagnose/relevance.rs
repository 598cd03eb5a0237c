//! The relevance test: whether a model leaves more than simulated recordings of itself do.
//!
//! In: segments and a fit. Out: the noise floor, the mean square that the model leaves of its own prediction with the encoder's
//! quantization, initial states measured anew (parametric bootstrap over where in a count the encoder stands), or what repeats and the user
//! say of it if that is more.

use super::fit::Fit;
use super::model::{dot, predict, simulated_counts};
use super::score::fitted_time_constant_s;
use super::segments::Segments;
use super::settings::Settings;

/// Where in a count the encoder stands: the middles of quarters.
const PHASES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];

/// The largest mean square in counts^2 that a fit's motor leaves of simulated recordings of itself.
pub(crate) fn noise_floor(segments: &Segments, fit: &Fit, settings: &Settings) -> Option<f64> {
    let motor = fit.model.motor(&fit.x);
    let tau_s = fitted_time_constant_s(fit);
    let mut most: f64 = 0.0;
    for phase in PHASES {
        let counts = simulated_counts(segments, &motor, phase)?;
        let own = segments.with_counts(counts, tau_s, settings);
        let mut residual = own.residual(&predict(&own, &motor)?);
        own.correct(&mut residual);
        most = most.max(dot(&residual, &residual) / residual.len().max(1) as f64);
    }
    Some(most)
}

/// Whether a mean square exceeds a noise floor by more than an immaterial share and by more than its sampling error (one-sided 95 %): that
/// of a mean of `n_eff` squares of normal numbers.
pub(crate) fn exceeds(mean_square: f64, floor: f64, n_eff: f64, settings: &Settings) -> bool {
    const ONE_SIDED_95: f64 = 1.645;
    let sampling = ONE_SIDED_95 * (2.0 / n_eff).sqrt();
    mean_square > floor * (1.0 + sampling.max(settings.unexplained_share))
}
