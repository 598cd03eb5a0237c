//! Top speed and time constant of a run, without a motor file.
//!
//! The run is cut into equal time bins in which the fastest passes some twenty counts, so that quantization is not
//! taken for motion. The mean speeds follow the mean commands as a sampled first-order system, `v[k] = a v[k-1] + b
//! u[k] + c u[k-1] + d` with `a = exp(-h / tau)` (ARX: Ljung, System Identification, 1999, chapter 4).

use nalgebra::{Matrix4, Vector4};

use crate::recording::Run;

/// Counts in the fastest bin: one count of quantization is then 5 % of it.
const BIN_COUNTS: f64 = 20.0;
/// Fewest bins, ten for each of the four coefficients.
const LEAST_BINS: usize = 40;
/// Most bins; a longer recording is examined from its beginning.
const MOST_BINS: usize = 20_000;
/// Least share of the speeds' variance that the fit explains, and least share of the AR residual that the commands
/// explain.
const EXPLAINED: f64 = 0.9;
const BY_COMMAND: f64 = 0.3;
/// Below this value of `a` the response is faster than the bins.
const LEAST_KEPT: f64 = 0.1;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    /// Speed of the fastest bin in counts/s, absolute.
    pub top_counts_s: f64,
    /// Time constant.
    pub time_constant: TimeConstant,
}

/// Time constant of the response to the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TimeConstant {
    /// Its value in s.
    Estimated(f64),
    /// An upper bound in s.
    AtMost(f64),
    /// Not determined by the recording.
    Unknown,
}

#[derive(Debug)]
pub(super) struct Bins {
    /// How long each lasts in s.
    pub bin_s: f64,
    /// Speed of the fastest bin in counts/s, absolute.
    pub top_counts_s: f64,
    /// Mean speed of each in counts/s.
    pub speed: Vec<f64>,
    /// Mean command of each.
    pub command: Vec<f64>,
    /// Position at the end of each bin in counts, relative to the run's first.
    pub position: Vec<f64>,
}

/// A run in bins; `None` for a shaft that hardly moves.
pub(super) fn bins(run: &Run) -> Option<Bins> {
    let (first_s, last_s) = (*run.t_s.first()?, *run.t_s.last()?);
    let steps = run.t_s.len() - 1;
    if steps == 0 {
        return None;
    }
    // Twenty counts at the top speed of the bins that result: fixed-point iteration.
    let mut bin = 1_usize;
    let top_counts_s = loop {
        let top = (0..run.len().saturating_sub(bin))
            .step_by(bin)
            .map(|k| {
                let counts = run.counts[k + bin].abs_diff(run.counts[k]) as f64;
                (counts, run.t_s[k + bin] - run.t_s[k])
            })
            .fold((0.0_f64, 0.0_f64), |most, (counts, lasts_s)| {
                (most.0.max(counts), most.1.max(counts / lasts_s))
            });
        if top.0 >= BIN_COUNTS {
            break top.1;
        }
        bin *= 2;
        if bin > steps {
            return None;
        }
    };
    let bin_s = bin as f64 * (last_s - first_s) / steps as f64;
    let bins = (((last_s - first_s) / bin_s) as usize).min(MOST_BINS);
    let mut found = Bins {
        bin_s,
        top_counts_s,
        speed: Vec::with_capacity(bins),
        command: Vec::with_capacity(bins),
        position: Vec::with_capacity(bins),
    };
    found.fill(run, first_s, bins);
    Some(found)
}

/// Top speed and time constant of a run; `None` for a shaft that hardly moves.
pub(super) fn response(run: &Run) -> Option<Response> {
    let bins = bins(run)?;
    Some(Response {
        top_counts_s: bins.top_counts_s,
        time_constant: time_constant(&bins),
    })
}

fn time_constant(cut: &Bins) -> TimeConstant {
    let (bins, bin_s) = (cut.speed.len(), cut.bin_s);
    if bins < LEAST_BINS {
        return TimeConstant::Unknown;
    }
    let (speed, command) = (&cut.speed, &cut.command);
    // Scaled, so that the normal equations are well conditioned in any units.
    let (by_speed, by_command) = (scale(speed), scale(command));
    let rows = || {
        (1..bins).map(|k| {
            let row = Vector4::new(
                by_speed * speed[k - 1],
                by_command * command[k],
                by_command * command[k - 1],
                1.0,
            );
            (row, by_speed * speed[k])
        })
    };
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (row, speed) in rows() {
        normal += row * row.transpose();
        right += row * speed;
    }
    let Some(fit) = solved(normal, right) else {
        return TimeConstant::Unknown;
    };
    let mean = by_speed * speed[1..].iter().sum::<f64>() / (bins - 1) as f64;
    let (mut residual, mut variance) = (0.0, 0.0);
    for (row, speed) in rows() {
        residual += (speed - row.dot(&fit)).powi(2);
        variance += (speed - mean).powi(2);
    }
    // Residual without the commands, with the previous speed alone.
    let mut alone = (0.0, 0.0, 0.0, 0.0);
    for (row, speed) in rows() {
        alone.0 += row[0] * row[0];
        alone.1 += row[0];
        alone.2 += row[0] * speed;
        alone.3 += speed;
    }
    let n = (bins - 1) as f64;
    let spread = alone.0 - alone.1 * alone.1 / n;
    let shared = alone.2 - alone.1 * alone.3 / n;
    let left_alone = variance
        - if spread > 0.0 {
            shared * shared / spread
        } else {
            0.0
        };
    if residual > (1.0 - EXPLAINED) * variance || residual > (1.0 - BY_COMMAND) * left_alone {
        return TimeConstant::Unknown;
    }
    match fit[0] {
        kept if kept >= 1.0 => TimeConstant::Unknown,
        kept if kept > LEAST_KEPT => TimeConstant::Estimated(-bin_s / kept.ln()),
        _ => TimeConstant::AtMost(-bin_s / LEAST_KEPT.ln()),
    }
}

/// The solution, if the columns are linearly independent.
fn solved(normal: Matrix4<f64>, right: Vector4<f64>) -> Option<Vector4<f64>> {
    let eigen = normal.symmetric_eigenvalues();
    let (least, most) = (eigen.min(), eigen.max());
    if least > 1e-10 * most {
        return normal.cholesky().map(|factor| factor.solve(&right));
    }
    None
}

/// Inverse of the largest absolute value.
pub(super) fn scale(values: &[f64]) -> f64 {
    let most = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if most > 0.0 { 1.0 / most } else { 1.0 }
}

impl Bins {
    /// Fills speeds, commands and positions; the position is interpolated linearly.
    fn fill(&mut self, run: &Run, first_s: f64, bins: usize) {
        let (origin, bin_s) = (run.counts[0], self.bin_s);
        let (mut k, mut before) = (0, 0.0);
        for bin in 1..=bins {
            let end_s = first_s + bin as f64 * bin_s;
            let (mut from_s, mut sum) = (end_s - bin_s, 0.0);
            while k + 2 < run.len() && run.t_s[k + 1] < end_s {
                sum += run.command[k] * (run.t_s[k + 1] - from_s);
                from_s = run.t_s[k + 1];
                k += 1;
            }
            sum += run.command[k] * (end_s - from_s);
            let share = (end_s - run.t_s[k]) / (run.t_s[k + 1] - run.t_s[k]);
            let at = |sample: usize| run.counts[sample].saturating_sub(origin) as f64;
            let position = at(k) + share * (at(k + 1) - at(k));
            self.speed.push((position - before) / bin_s);
            self.command.push(sum / bin_s);
            self.position.push(position);
            before = position;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First-order motor in closed form, held between changes: `w = w_end + (w_0 - w_end) exp(-t / tau)`.
    fn run(step_s: f64, time_constant_s: f64, top_counts_s: f64) -> Run {
        let mut run = Run::default();
        let (mut speed, mut position) = (0.0, 0.0_f64);
        let kept = (-step_s / time_constant_s).exp();
        for k in 0..2000 {
            let command = [0.0, 1.0, -0.5, 0.7][(k / 100) % 4];
            run.t_s.push(f64::from(k as u32) * step_s);
            run.command.push(command);
            run.counts.push(position.round() as i64);
            let end = top_counts_s * command;
            position += end * step_s + (speed - end) * time_constant_s * (1.0 - kept);
            speed = end + (speed - end) * kept;
        }
        run
    }

    #[test]
    fn the_time_constant_of_a_first_order_motor_is_estimated() {
        for step_s in [0.001, 0.003, 0.03, 3.0] {
            for steps in [3.0, 10.0, 40.0] {
                let run = run(step_s, steps * step_s, 6.0 / step_s);
                let found = response(&run).expect("it moves");
                let TimeConstant::Estimated(time_constant_s) = found.time_constant else {
                    panic!("{found:?}");
                };
                let ratio = time_constant_s / (steps * step_s);
                assert!((0.6..1.7).contains(&ratio), "{step_s} {steps}: {ratio}");
                let top = found.top_counts_s * step_s;
                assert!((5.0..8.0).contains(&top), "{top}");
            }
        }
    }

    #[test]
    fn a_response_within_one_sample_is_faster_than_the_sample_time() {
        let run = run(1.0, 0.03, 300.0);
        let found = response(&run).expect("it moves").time_constant;
        assert!(
            matches!(found, TimeConstant::AtMost(s) if s < 1.0),
            "{found:?}"
        );
    }

    #[test]
    fn a_constant_command_gives_no_time_constant() {
        let mut run = run(0.01, 0.1, 500.0);
        run.command.fill(1.0);
        let found = response(&run).expect("it moves").time_constant;
        assert_eq!(found, TimeConstant::Unknown);
        run.counts.fill(3);
        assert_eq!(response(&run), None);
    }
}
