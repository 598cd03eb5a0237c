//! Error of a perfect model on recordings with random errors: Monte Carlo.
//!
//! In: segments, the linearized plant with its random effects, the noise. Out: the expected mean square of the corrected residual.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

use super::transition::Transitions;
use super::{LinearPlant, Noise};
use crate::diagnose::model::mean_square;
use crate::diagnose::segments::Segments;
use crate::diagnose::settings::solver::RECORDINGS;
use crate::units::ROUNDING_VARIANCE;

/// Mean square in counts^2, initial states corrected: of quantization, the random load, the scatter of logged speeds, lost edges and late
/// samples, as [`super::Whitener`] has them.
pub(crate) fn expected_mean_square(segments: &Segments, plant: &LinearPlant, noise: Noise) -> f64 {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let drawn = (0..RECORDINGS).map(|_| {
        let mut residual = drawn(segments, plant, noise, &mut random);
        segments.correct(&mut residual);
        mean_square(&residual)
    });
    drawn.sum::<f64>() / RECORDINGS as f64
}

/// The error of one recording, from each segment's first sample.
fn drawn(
    segments: &Segments,
    plant: &LinearPlant,
    noise: Noise,
    random: &mut Pcg64Mcg,
) -> Vec<f64> {
    let sigma = noise.strength * plant.stall_counts_s2;
    let mut transitions = Transitions::new(plant.time_constant_s, noise.time_s);
    let mut out = Vec::with_capacity(segments.len);
    for segment in &segments.segments {
        let run = &segments.runs[segment.run];
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let (mut angle, mut load) = (0.0, sigma * normal());
        let mut speed = segment.start_speed_sd * normal();
        out.push(0.0);
        let first = random.random::<f64>() - 0.5;
        for k in segment.from + 1..segment.to {
            let step = transitions.step(run.t_s[k] - run.t_s[k - 1], run.moving[k]);
            let mut normal = || -> f64 { StandardNormal.sample(random) };
            let lost = plant.loss * (run.counts[k] - run.counts[k - 1]).abs();
            let stops = f64::from(u8::from(run.moving[k] != run.moving[k - 1]));
            let walk = run.scatter(noise, k).powi(2) + lost + stops * ROUNDING_VARIANCE;
            angle += step.f01 * speed + step.f02 * load + walk.sqrt() * normal();
            speed = step.f11 * speed + step.f01 * load;
            load = step.f22 * load + sigma * (1.0 - step.f22 * step.f22).sqrt() * normal();
            let late = run.speed[k] * plant.jitter_s * (random.random::<f64>() - 0.5);
            let rounding = random.random::<f64>() - 0.5;
            out.push(angle + late + rounding - first);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::model::dot;
    use crate::diagnose::noise::Whitener;
    use crate::diagnose::samples::SAMPLE_TIME_S;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;
    use crate::recording::Run;

    /// Standard errors within which a mean of so many draws agrees with its expectation.
    const AGREES: f64 = 4.0;

    /// Ten seconds of even turning: at rest a further sample says nothing new.
    fn segments() -> Segments {
        let samples = 0..1000;
        let run = Run {
            sample_time_s: SAMPLE_TIME_S,
            counts_per_rev: 720.0,
            t_s: (samples.clone().map(|k| f64::from(k) * SAMPLE_TIME_S)).collect(),
            command: vec![4.0; samples.len()],
            counts: samples.map(|k| i64::from(k) * 11 / 2).collect(),
            ..Run::default()
        };
        Segments::new(&[run], &Motor::default(), &Settings::default()).expect("a run")
    }

    /// A motor whose errors the tests draw.
    fn plant() -> LinearPlant {
        LinearPlant {
            time_constant_s: 0.04,
            stall_counts_s2: 2e4,
            jitter_s: 0.0,
            loss: 0.0,
        }
    }

    /// Quantization alone leaves its variance, less what the correction of the initial angles takes.
    #[test]
    fn quantization_leaves_its_variance() {
        let segments = segments();
        let found = expected_mean_square(&segments, &plant(), Noise::NONE);
        let corrected = 2.0 * segments.segments.len() as f64 / segments.len as f64;
        let n = (segments.len * RECORDINGS) as f64;
        // The fourth moment of a uniform variate is 9/5 of the variance squared.
        let error = (0.8 / n).sqrt();
        let ratio = found / ROUNDING_VARIANCE;
        assert!(
            (1.0 - corrected - AGREES * error..1.0 + AGREES * error).contains(&ratio),
            "{ratio}"
        );
    }

    /// The innovations of the Kalman filter of the same errors have unit variance (Kalman 1960), whichever of them there are.
    #[test]
    fn the_filter_whitens_what_is_drawn() {
        let segments = segments();
        let load = Noise {
            strength: 0.01,
            ..Noise::NONE
        };
        let lossy = LinearPlant {
            loss: 0.05,
            ..plant()
        };
        let late = LinearPlant {
            jitter_s: 0.004,
            ..plant()
        };
        for (plant, noise) in [
            (plant(), Noise::NONE),
            (plant(), load),
            (lossy, Noise::NONE),
            (late, load),
        ] {
            let whitener = Whitener::new(&segments, &plant, noise);
            let mut random = Pcg64Mcg::seed_from_u64(2);
            let mut squares = 0.0;
            for _ in 0..RECORDINGS {
                let white = whitener.whiten(&drawn(&segments, &plant, noise, &mut random));
                squares += dot(&white, &white);
            }
            let n = ((segments.len - segments.segments.len()) * RECORDINGS) as f64;
            let error = (2.0 / n).sqrt();
            let ratio = squares / n;
            assert!(
                (ratio - 1.0).abs() < AGREES * error,
                "{plant:?} {noise:?}: {ratio}"
            );
        }
    }
}
