//! The Kalman filter that whitens the prediction error of a segment.
//!
//! State: error of the angle in counts, of the speed in counts/s, and an acceleration by a random load (Ornstein-Uhlenbeck) in
//! counts/s^2: `v' = -v/tau + d`, `d' = -d/T + noise`. A shaft at rest does not move for it. Measured is the angle with quantization of
//! variance 1/12 (Widrow and Kollar 2008).

use super::Noise;
use super::transition::{Covariance, Transition, Transitions};
use crate::diagnose::model::dot;
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::solver::LOGARITHM_WITHIN;
use crate::units::ROUNDING_VARIANCE;

/// The linearized motor that errors propagate through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearPlant {
    /// Mechanical time constant in s.
    pub time_constant_s: f64,
    /// Acceleration in counts/s^2 at stall torque.
    pub stall_counts_s2: f64,
    /// Spread in s of late samples.
    pub jitter_s: f64,
    /// Probability that an edge is lost.
    pub loss: f64,
}

/// Runs the filter: calls `each` with the transition to every sample, its gain, and the reciprocal variance of its innovation as scale (0 at
/// the first sample of a segment). Returns the log determinant of the innovations' covariance.
fn filter(
    segments: &Segments,
    plant: &LinearPlant,
    noise: Noise,
    mut each: impl FnMut(&Transition),
) -> f64 {
    let mut log_det = 0.0;
    // One logarithm for many variances.
    let mut product = 1.0_f64;
    let sigma = noise.strength * plant.stall_counts_s2;
    let mut transitions = Transitions::new(plant.time_constant_s, noise.time_s);
    for segment in &segments.segments {
        let run = &segments.runs[segment.run];
        let mut p = Covariance {
            xx: ROUNDING_VARIANCE,
            vv: segment.start_speed_sd.powi(2),
            dd: sigma * sigma,
            ..Covariance::default()
        };
        each(&Transition {
            f22: 1.0,
            f11: 1.0,
            ..Transition::default()
        });
        for k in segment.from + 1..segment.to {
            let mut step = transitions.step(run.t_s[k] - run.t_s[k - 1], run.moving[k]);
            p = p.after(&step);
            p.dd += sigma * sigma * (1.0 - step.f22 * step.f22);
            p.xx += run.scatter(noise, k).powi(2);
            if run.moving[k] != run.moving[k - 1] {
                // Where within a count a shaft stops, or from where it starts, is not measured.
                p.xx += ROUNDING_VARIANCE;
            }
            if plant.loss > 0.0 {
                p.xx += plant.loss * (run.counts[k] - run.counts[k - 1]).abs();
            }
            let late = run.speed[k] * plant.jitter_s;
            let weight = segments.weight[segment.at + k - segment.from];
            let s = p.xx + ROUNDING_VARIANCE / weight + late * late * ROUNDING_VARIANCE;
            step.scale = 1.0 / s;
            step.gain = p.update(step.scale);
            product *= s;
            if !LOGARITHM_WITHIN.contains(&product) {
                log_det += product.ln();
                product = 1.0;
            }
            each(&step);
        }
    }
    log_det + product.ln()
}

/// Gains for every sample.
#[derive(Debug, Clone)]
pub(crate) struct Whitener {
    steps: Vec<Transition>,
    /// First sample of each segment.
    starts: Vec<usize>,
    /// Log determinant of the covariance.
    pub log_det: f64,
}

impl Whitener {
    pub fn new(segments: &Segments, plant: &LinearPlant, noise: Noise) -> Self {
        let mut steps = Vec::with_capacity(segments.len);
        let log_det = filter(segments, plant, noise, |step| {
            let mut step = *step;
            step.scale = step.scale.sqrt();
            steps.push(step);
        });
        Self {
            steps,
            starts: segments.segments.iter().map(|segment| segment.at).collect(),
            log_det,
        }
    }

    /// Negative log likelihood of a column under a noise, without the constant: as [`Self::cost`] of the whitened column.
    pub fn cost_of(segments: &Segments, plant: &LinearPlant, noise: Noise, column: &[f64]) -> f64 {
        let mut squares = 0.0;
        let mut values = column.iter();
        let mut state = [0.0; 3];
        let log_det = filter(segments, plant, noise, |step| {
            let value = values.next().copied().unwrap_or(0.0);
            if step.scale == 0.0 {
                state = [0.0; 3];
                return;
            }
            let [x, v, d] = step.ahead(state);
            let e = value - x;
            squares += e * e * step.scale;
            state = [
                x + step.gain[0] * e,
                v + step.gain[1] * e,
                d + step.gain[2] * e,
            ];
        });
        0.5 * (squares + log_det)
    }

    /// Negative log likelihood of whitened innovations, without the constant.
    pub fn cost(&self, white: &[f64]) -> f64 {
        0.5 * (dot(white, white) + self.log_det)
    }

    /// Variance of each innovation in counts^2; 0 for the first sample of a segment.
    pub fn variances(&self) -> impl Iterator<Item = f64> {
        let scales = self.steps.iter().map(|step| step.scale);
        scales.map(|scale| if scale > 0.0 { scale.powi(-2) } else { 0.0 })
    }

    /// The innovations of a column, each over its standard deviation.
    pub fn whiten(&self, column: &[f64]) -> Vec<f64> {
        let [out] = self.whiten_together([column]);
        out
    }

    /// The same of several columns.
    pub fn whiten_all<'a>(&self, columns: impl IntoIterator<Item = &'a Vec<f64>>) -> Vec<Vec<f64>> {
        let columns: Vec<&Vec<f64>> = columns.into_iter().collect();
        let mut out = Vec::with_capacity(columns.len());
        let fours = columns.chunks_exact(4);
        let rest = fours.remainder();
        for four in fours {
            out.extend(self.whiten_together([four[0], four[1], four[2], four[3]]));
        }
        out.extend(rest.iter().map(|column| self.whiten(column)));
        out
    }

    /// The same of some columns in step, so that one does not wait for the other.
    fn whiten_together<const C: usize>(&self, columns: [&[f64]; C]) -> [Vec<f64>; C] {
        let len = self.steps.len();
        let columns = columns.map(|column| &column[..len]);
        let mut out = [(); C].map(|()| vec![0.0; len]);
        let mut starts = self.starts.iter().copied().peekable();
        let mut s = [[0.0; C]; 3];
        for (k, step) in self.steps.iter().enumerate() {
            if starts.next_if_eq(&k).is_some() {
                s = [[0.0; C]; 3];
                continue;
            }
            for c in 0..C {
                let [x, v, d] = step.ahead([s[0][c], s[1][c], s[2][c]]);
                let e = columns[c][k] - x;
                s[0][c] = x + step.gain[0] * e;
                s[1][c] = v + step.gain[1] * e;
                s[2][c] = d + step.gain[2] * e;
                out[c][k] = e * step.scale;
            }
        }
        out
    }
}
