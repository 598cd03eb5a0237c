//! Part 2: the first-order step response as encoder, sampling and differences give it.
//!
//! The shaft's angle is quantized to `n = round(N theta / 2 pi)` and read every TS; the speed is the difference of
//! two readings. One count is `2 pi / (N TS)`; the difference is the mean speed between the readings, with a delay of
//! half a sample. A speed of `c` counts a sample alternates between `floor(c)` and `ceil(c)`, with a standard
//! deviation of `sqrt(f (1 - f))` counts for the fraction `f` of `c` (1/sqrt(6) on average).

use serde::Serialize;

use super::step_response::{CURVES, END_S};
use crate::compare::{rms, speed_of_one_count};
use crate::motor::{Drive, Model, Parameters, SimulationError, SimulationOptions, simulate};
use crate::recording::{CommandKind, difference_velocities, velocity_rad_s};
use crate::units::rad_per_count;

/// Sample times of the handout in s.
pub const SAMPLE_TIMES_S: [f64; 2] = [0.03, 0.003];
/// Candidates for the best sample time, in s.
const TRIED_S: [f64; 9] = [0.001, 0.002, 0.003, 0.005, 0.01, 0.015, 0.02, 0.03, 0.05];
/// Spans of a difference in samples.
const SPANS: [usize; 4] = [1, 2, 5, 10];
/// Resolution of the board's microsecond clock in s (an Uno's `micros()` counts in steps of 4 us).
pub const CLOCK_TICK_S: f64 = 4e-6;
/// Counts from 0 to the wrap of an int16.
pub const INT16_COUNTS: f64 = 32_768.0;

/// The discretized step response at one sample time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sampled {
    /// Sample time TS in s.
    pub sample_time_s: f64,
    /// Times in s.
    pub t_s: Vec<f64>,
    /// Encoder counts.
    pub counts: Vec<i64>,
    /// Speed by differences of the counts in rad/s; `None` at the first sample.
    pub speed_rad_s: Vec<Option<f64>>,
    /// True speed at the same times in rad/s.
    pub true_speed_rad_s: Vec<f64>,
    /// Figures of the sampling.
    pub figures: SampledFigures,
}

/// Figures of the speed at one TS.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SampledFigures {
    /// One count per sample in rad/s.
    pub one_count_rad_s: f64,
    /// The same relative to the steady speed.
    pub one_count_of_steady: Option<f64>,
    /// Counts a sample at the steady speed.
    pub counts_per_sample: Option<f64>,
    /// Standard deviation of the difference at the steady speed in rad/s.
    pub scatter_rad_s: Option<f64>,
    /// Half a sample in s: the delay of the difference for a speed that rises linearly.
    pub half_sample_s: f64,
    /// Delay of the difference on this motor's exponential in s.
    pub delay_s: Option<f64>,
    /// Largest error of the speed due to the delay (without quantization) in rad/s.
    pub largest_delay_error_rad_s: f64,
    /// RMS error of the discretized speed against the true one over the step, in rad/s.
    pub error_rad_s: f64,
    /// Its part due to the delay.
    pub delay_error_rad_s: f64,
    /// Largest speed in rad/s whose difference within one sample fits an int16.
    pub largest_int16_speed_rad_s: f64,
    /// False speed of one difference across a wrap, in rad/s.
    pub wrap_spike_rad_s: f64,
}

/// A difference over several samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Span {
    /// Samples between the two readings.
    pub samples: usize,
    /// One count in rad/s.
    pub one_count_rad_s: f64,
    /// Half the span in s: the delay.
    pub delay_s: f64,
    /// RMS error against the true speed over the step, in rad/s.
    pub error_rad_s: f64,
}

/// Part 2.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sampling {
    /// The two responses of the handout.
    pub responses: Vec<Sampled>,
    /// Steady speed of the first-order model in rad/s.
    pub steady_rad_s: Option<f64>,
    /// Turns of the shaft until an int16 count wraps.
    pub int16_turns: f64,
    /// Time at the steady speed until it does, in s.
    pub int16_wraps_after_s: Option<f64>,
    /// Sample time and RMS error over the step in rad/s.
    pub errors_by_sample_time: Vec<(f64, f64)>,
    /// The sample time with the smallest error, in s.
    pub best_sample_time_s: f64,
    /// Differences over several samples at the shorter TS.
    pub spans: Vec<Span>,
    /// Time between two edges at the steady speed in s.
    pub edge_period_s: Option<f64>,
    /// Speed error in rad/s due to one tick of the board's clock.
    pub edge_timing_rad_s: Option<f64>,
}

struct Readings {
    t_s: Vec<f64>,
    counts: Vec<i64>,
    angle_rad: Vec<f64>,
    speed_rad_s: Vec<f64>,
}

impl Readings {
    fn simulated(parameters: &Parameters, sample_time_s: f64) -> Result<Self, SimulationError> {
        let samples = (END_S / sample_time_s + 1e-9).floor() as u32;
        let t_s: Vec<f64> = (0..=samples)
            .map(|k| f64::from(k) * sample_time_s)
            .collect();
        let command = vec![parameters.supply_v; t_s.len()];
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let options = SimulationOptions {
            model: Model::FirstOrder,
            ..SimulationOptions::default()
        };
        let trajectory = simulate(&CURVES[0].motor(parameters), &drive, &options)?;
        Ok(Self {
            t_s,
            counts: trajectory.counts,
            angle_rad: trajectory.angle_rad,
            speed_rad_s: trajectory.speed_rad_s,
        })
    }

    /// Error of a difference over `span` samples against the true speed at each sample; at rest before the step.
    fn errors(
        &self,
        span: usize,
        position_counts: impl Fn(usize) -> f64,
        per_count: f64,
    ) -> Vec<f64> {
        let before = |k: usize| k.checked_sub(span).map_or(0.0, &position_counts);
        (1..self.t_s.len())
            .map(|k| (position_counts(k) - before(k)) * per_count - self.speed_rad_s[k])
            .collect()
    }
}

/// Delay of a difference on the rise `1 - exp(-t / tau)`: the lag that gives the mean over one sample.
fn delay_s(sample_time_s: f64, tau_s: f64) -> f64 {
    let x = sample_time_s / tau_s;
    // ln((e^x - 1) / x), without overflow for a long sample.
    tau_s * (x + (-(-x).exp_m1() / x).ln())
}

impl Sampled {
    fn of(
        p: &Parameters,
        sample_time_s: f64,
        steady: Option<f64>,
        tau_s: Option<f64>,
    ) -> Result<Self, SimulationError> {
        let readings = Readings::simulated(p, sample_time_s)?;
        let one_count = speed_of_one_count(p.counts_per_rev, sample_time_s);
        let counts_per_sample = steady.map(|w| w / one_count);
        let scatter = |counts: f64| {
            let fraction = counts.fract();
            (fraction * (1.0 - fraction)).sqrt() * one_count
        };
        let per_rad = 1.0 / rad_per_count(p.counts_per_rev);
        let delayed = readings.errors(1, |k| readings.angle_rad[k] * per_rad, one_count);
        let read = readings.errors(1, |k| readings.counts[k] as f64, one_count);
        let figures = SampledFigures {
            one_count_rad_s: one_count,
            one_count_of_steady: steady.filter(|&w| w > 0.0).map(|w| one_count / w),
            counts_per_sample,
            scatter_rad_s: counts_per_sample.map(scatter),
            half_sample_s: 0.5 * sample_time_s,
            delay_s: tau_s.map(|tau_s| delay_s(sample_time_s, tau_s)),
            largest_delay_error_rad_s: delayed.iter().fold(0.0, |m, e| f64::max(m, e.abs())),
            error_rad_s: rms(read),
            delay_error_rad_s: rms(delayed),
            largest_int16_speed_rad_s: velocity_rad_s(
                INT16_COUNTS - 1.0,
                1,
                p.counts_per_rev,
                sample_time_s,
            ),
            wrap_spike_rad_s: velocity_rad_s(
                2.0 * INT16_COUNTS,
                1,
                p.counts_per_rev,
                sample_time_s,
            ),
        };
        Ok(Self {
            sample_time_s,
            speed_rad_s: difference_velocities(
                &readings.counts,
                None,
                p.counts_per_rev,
                sample_time_s,
            ),
            t_s: readings.t_s,
            counts: readings.counts,
            true_speed_rad_s: readings.speed_rad_s,
            figures,
        })
    }
}

impl Sampling {
    /// Part 2 for the first-order model with viscous friction.
    ///
    /// # Errors
    /// The motor's states exceed the range of floating point.
    pub fn of(p: &Parameters) -> Result<Self, SimulationError> {
        let steady_rad_s = CURVES[0].steady_speed_rad_s(p, p.supply_v);
        let tau_s = super::transfer::TransferFunction::first_order(p)
            .time_constants_s()
            .first()
            .copied();
        let responses = SAMPLE_TIMES_S
            .iter()
            .map(|&sample_time_s| Sampled::of(p, sample_time_s, steady_rad_s, tau_s))
            .collect::<Result<Vec<_>, _>>()?;
        let errors_by_sample_time = TRIED_S
            .iter()
            .map(|&ts| {
                Ok((
                    ts,
                    Sampled::of(p, ts, steady_rad_s, tau_s)?.figures.error_rad_s,
                ))
            })
            .collect::<Result<Vec<_>, SimulationError>>()?;
        let best = errors_by_sample_time
            .iter()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let best_sample_time_s = best.map_or(SAMPLE_TIMES_S[0], |best| best.0);
        let short_s = SAMPLE_TIMES_S[1];
        let readings = Readings::simulated(p, short_s)?;
        let spans = SPANS
            .iter()
            .map(|&samples| {
                let one_count = speed_of_one_count(p.counts_per_rev, short_s * samples as f64);
                let errors = readings.errors(samples, |k| readings.counts[k] as f64, one_count);
                Span {
                    samples,
                    one_count_rad_s: one_count,
                    delay_s: 0.5 * short_s * samples as f64,
                    error_rad_s: rms(errors),
                }
            })
            .collect();
        let turning = steady_rad_s.filter(|&w| w > 0.0);
        let edge_period_s = turning.map(|w| rad_per_count(p.counts_per_rev) / w);
        let turns = INT16_COUNTS / p.counts_per_rev;
        Ok(Self {
            responses,
            steady_rad_s,
            int16_turns: turns,
            int16_wraps_after_s: turning.map(|w| turns * std::f64::consts::TAU / w),
            errors_by_sample_time,
            best_sample_time_s,
            spans,
            edge_period_s,
            edge_timing_rad_s: edge_period_s
                .zip(turning)
                .map(|(period_s, w)| w * CLOCK_TICK_S / period_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_handouts_encoder_has_its_documented_figures() {
        let sampling = Sampling::of(&Parameters::default()).unwrap();
        let [slow, fast] = &sampling.responses[..] else {
            panic!("two responses");
        };
        // Lab handout: 0.29 and 2.9 rad/s a count.
        assert!((slow.figures.one_count_rad_s - 0.290_888_208_665_721_6).abs() < 1e-12);
        assert!((fast.figures.one_count_rad_s - 2.908_882_086_657_216).abs() < 1e-12);
        // 32768 / 720 turns, at 0.315 / 0.059 rad/s.
        assert!((sampling.int16_turns - 45.511_111_111_111_11).abs() < 1e-9);
        let seconds = 45.511_111_111_111_11 * std::f64::consts::TAU * 0.059 / 0.315;
        assert!((sampling.int16_wraps_after_s.unwrap() - seconds).abs() < 1e-9);
        assert_eq!((slow.t_s.len(), fast.t_s.len()), (11, 101));
    }

    #[test]
    fn the_scatter_is_that_of_a_constant_speed() {
        let one_count = speed_of_one_count(720.0, 0.003);
        let w = 0.315 / 0.059;
        let counts: Vec<i64> = (0..200_000)
            .map(|k| {
                (w * 0.003 * f64::from(k) * 720.0 / std::f64::consts::TAU + 0.5).floor() as i64
            })
            .collect();
        let speeds = difference_velocities(&counts, None, 720.0, 0.003);
        let scatter = rms(speeds.into_iter().flatten().map(|speed| speed - w));
        let sampling = Sampling::of(&Parameters::default()).unwrap();
        let said = sampling.responses[1].figures.scatter_rad_s.unwrap();
        assert!(
            (scatter - said).abs() < 1e-3 * one_count,
            "{scatter}, {said}"
        );
    }

    #[test]
    fn the_delay_of_a_difference_tends_to_half_a_sample() {
        let tau_s = 0.02 / 0.59;
        for ts in [0.03, 0.003] {
            let lag = delay_s(ts, tau_s);
            // The mean of 1 - exp(-t / tau) over a sample, against the same curve `lag` earlier.
            let t = 0.1;
            let integral = |t: f64| t + tau_s * (-t / tau_s).exp();
            let mean = (integral(t) - integral(t - ts)) / ts;
            let earlier = -(-(t - lag) / tau_s).exp_m1();
            assert!((mean - earlier).abs() < 1e-12);
            assert!((lag - 0.5 * ts - ts * ts / (24.0 * tau_s)).abs() < 0.002 * ts);
        }
    }

    #[test]
    fn an_int16_difference_is_right_across_a_wrap_and_a_wider_one_is_not() {
        let sampling = Sampling::of(&Parameters::default()).unwrap();
        let figures = &sampling.responses[0].figures;
        let (before, after) = (32_760_i16, 32_760_i16.wrapping_add(18));
        assert_eq!(after.wrapping_sub(before), 18);
        let unminded = (f64::from(after) - f64::from(before)) * figures.one_count_rad_s;
        let spike = 18.0 * figures.one_count_rad_s - unminded;
        assert!((spike / figures.wrap_spike_rad_s - 1.0).abs() < 1e-12);
    }
}
