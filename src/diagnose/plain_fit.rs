//! The plain least-squares fit of a first-order motor (`first_order.rs`) to recorded counts.
//!
//! Minimised is `sum over samples (n - x(K, T, F) - o)^2` in counts^2: open loop from the first sample, `o` one number a run,
//! where inside a count the shaft started. No weights, no priors. The gain is linear, so that it follows from each time
//! constant and friction (variable projection: Golub and Pereyra 1973). These two come from a grid over all that is plausible,
//! from the starts that are handed in, and from each of them without friction; the best are polished by Levenberg's and
//! Marquardt's steps. A resting shaft has no derivative by its friction, so that a scan along it comes in between.
//! `tests/plain_fit.rs` compares with SciPy's `least_squares` on real steps.

use nalgebra::{Matrix3, Vector3};

use super::data::RunData;
use super::first_order::FirstOrder;

/// Time constants of the grid, evenly spaced in logarithm: a factor of 1.6 between them over the 5 decades that a recording spans
/// at most, so that each basin of the error has one.
const TIME_CONSTANTS: usize = 14;
/// The shortest of them as a share of the sample time: what is shorter is over before the next sample.
const SHORTEST: f64 = 0.1;
/// Frictions of the grid as shares of the largest command; a motor with more hardly turns.
const FRICTIONS: [f64; 8] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7];
/// Starts that are polished.
const POLISHED: usize = 4;
/// Most steps of a polish, and the relative gain that ends it.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-9;
/// Relative step of a difference: half of the digits.
const DIFFERENCE: f64 = 1e-6;
/// Frictions that differ by less than this share of the largest command are one: step of the last scan along it.
const FRICTION_STEP: f64 = 0.01;
/// A fit that leaves less by a smaller share than this is not better: then the one with less friction is taken, the simpler one.
const SAME: f64 = 1e-3;
/// Friction that is not absent, as a share of the largest command: a tenth of what the best of small gear motors have.
const LEAST_FRICTION: f64 = 1e-3;
/// By so small a share more the runs do not mind.
const NOT_MINDED: f64 = 0.01;

/// A first-order motor and what it leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainFit {
    /// Gain in rad/s per unit of the command.
    pub gain: f64,
    /// Time constant and friction.
    pub shape: FirstOrder,
    /// Position error in counts RMS over all samples.
    pub left_counts: f64,
}

/// A run as this fit needs it.
struct Record<'a> {
    t_s: &'a [f64],
    command: &'a [f64],
    counts: &'a [f64],
    counts_per_rad: f64,
    /// Speed at the first sample in rad/s.
    start: f64,
}

/// The least-squares fit to these runs; `starts` are gains, time constants and frictions to begin from beside the grid's.
/// `None` where nothing turns, or only against the command.
pub(super) fn plain_fit(runs: &[RunData], starts: &[(f64, FirstOrder)]) -> Option<PlainFit> {
    let all = Records::new(runs);
    let largest_command = runs
        .iter()
        .map(|run| run.largest_command)
        .fold(0.0, f64::max);
    let mut found: Vec<PlainFit> = Vec::new();
    for (gain, shape) in starts {
        let free = FirstOrder {
            friction: 0.0,
            ..*shape
        };
        found.extend(all.left_by(*gain, *shape));
        found.extend(all.with_gain(*gain, *shape));
        found.extend(all.with_gain(*gain, free));
    }
    let guess = starts.first().map_or(1.0, |start| start.0);
    for time_constant_s in all.time_constants() {
        for share in FRICTIONS {
            let friction = share * largest_command;
            let shape = FirstOrder {
                time_constant_s,
                friction,
            };
            found.extend(all.with_gain(guess, shape));
        }
    }
    found.sort_by(|a, b| a.left_counts.total_cmp(&b.left_counts));
    found.truncate(POLISHED);
    // The simplest is a start whatever it leaves.
    let simplest = found.first().and_then(|best| {
        let free = FirstOrder {
            friction: 0.0,
            ..best.shape
        };
        all.with_gain(best.gain, free)
    });
    found.extend(simplest);
    let polished: Vec<PlainFit> = (found.into_iter())
        .map(|fit| all.polished(fit, largest_command))
        .collect();
    let least = polished
        .iter()
        .map(|fit| fit.left_counts)
        .fold(f64::INFINITY, f64::min);
    let as_good = polished
        .into_iter()
        .filter(|fit| fit.left_counts <= (1.0 + SAME) * least);
    let best = as_good.min_by(|a, b| a.shape.friction.total_cmp(&b.shape.friction))?;
    // Friction that came out as nothing is small, not absent, where the runs do not mind: other numbers are shares of it.
    let friction = best.shape.friction.max(LEAST_FRICTION * largest_command);
    let rubs = all.with_gain(
        best.gain,
        FirstOrder {
            friction,
            ..best.shape
        },
    );
    rubs.filter(|fit| fit.left_counts <= (1.0 + NOT_MINDED) * least)
        .or(Some(best))
}

/// What a shaft that never turns leaves of these runs, in counts RMS: what a fit has to beat.
pub(super) fn left_at_rest(runs: &[RunData]) -> f64 {
    let counts = runs
        .iter()
        .flat_map(|run| run.counts.iter().map(|n| n - run.counts[0]));
    let (samples, squares) = counts.fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x * x));
    (squares / f64::max(samples, 1.0)).sqrt()
}

struct Records<'a>(Vec<Record<'a>>);

impl<'a> Records<'a> {
    fn new(runs: &'a [RunData]) -> Self {
        let record = |run: &'a RunData| {
            let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
            Record {
                t_s: &run.t_s,
                command: &run.command,
                counts: &run.counts,
                counts_per_rad,
                start: run.start_speed_counts_s / counts_per_rad,
            }
        };
        Self(runs.iter().map(record).collect())
    }

    /// From what is over before the next sample to what lasts as long as the longest run, in s.
    fn span_of_time_constants(&self) -> [f64; 2] {
        let ends = self.0.iter().filter_map(|run| {
            let last = run.t_s.last()? - run.t_s.first()?;
            (last > 0.0).then_some((last / (run.t_s.len() - 1) as f64, last))
        });
        let (step_s, longest_s) = ends.fold((f64::INFINITY, 0.0_f64), |(a, b), (step, length)| {
            (a.min(step), b.max(length))
        });
        let shortest_s = SHORTEST * step_s;
        [shortest_s, longest_s.max(shortest_s)]
    }

    fn time_constants(&self) -> impl Iterator<Item = f64> {
        let [shortest, longest] = self.span_of_time_constants();
        let ratio = (longest / shortest).ln() / (TIME_CONSTANTS - 1) as f64;
        (0..TIME_CONSTANTS).map(move |k| shortest * (ratio * k as f64).exp())
    }

    /// The fit with the gain that suits this shape best; `None` where it would turn against the command. The speed at the first
    /// sample is in proportion to the gain `guess`, then to what came of it.
    fn with_gain(&self, guess: f64, shape: FirstOrder) -> Option<PlainFit> {
        let once = self.best_gain(guess, shape)?;
        let in_motion = self.0.iter().any(|run| run.start != 0.0);
        let gain = if in_motion {
            self.best_gain(once, shape)?
        } else {
            once
        };
        self.left_by(gain, shape)
    }

    fn best_gain(&self, guess: f64, shape: FirstOrder) -> Option<f64> {
        let (mut with, mut square) = (0.0, 0.0);
        for run in &self.0 {
            let angles = run.counts_for(guess, shape);
            let mean = mean(&angles);
            let counts_mean = self::mean(run.counts);
            for (angle, counts) in angles.iter().zip(run.counts) {
                with += (angle - mean) * (counts - counts_mean);
                square += (angle - mean).powi(2);
            }
        }
        let gain = guess * with / square;
        (gain.is_finite() && gain > 0.0).then_some(gain)
    }

    /// What these numbers leave; `None` where that is no number.
    fn left_by(&self, gain: f64, shape: FirstOrder) -> Option<PlainFit> {
        let residuals = self.residuals(gain, shape);
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let left_counts = (squares / residuals.len() as f64).sqrt();
        left_counts.is_finite().then_some(PlainFit {
            gain,
            shape,
            left_counts,
        })
    }

    /// Recorded less simulated counts of all runs end to end.
    fn residuals(&self, gain: f64, shape: FirstOrder) -> Vec<f64> {
        let of_run = |run: &Record<'_>| {
            let angles = run.counts_for(gain, shape);
            let raw: Vec<f64> = run.counts.iter().zip(&angles).map(|(n, x)| n - x).collect();
            // Where inside a count the shaft started: half a count of rounding is put back.
            let start = mean(&raw).clamp(0.0, 1.0);
            raw.into_iter().map(move |r| r - start)
        };
        self.0.iter().flat_map(of_run).collect()
    }

    /// Levenberg's and Marquardt's steps, then a scan along the friction, until neither gains.
    fn polished(&self, start: PlainFit, largest_command: f64) -> PlainFit {
        let mut best = self.descended(start, largest_command);
        loop {
            let near = [-1.0, 1.0].into_iter().filter_map(|sign| {
                let friction = best.shape.friction + sign * FRICTION_STEP * largest_command;
                let shape = FirstOrder {
                    friction: friction.max(0.0),
                    ..best.shape
                };
                self.with_gain(best.gain, shape)
            });
            let better = (near.map(|fit| self.descended(fit, largest_command)))
                .min_by(|a, b| a.left_counts.total_cmp(&b.left_counts))
                .filter(|fit| fit.left_counts < (1.0 - SAME) * best.left_counts);
            match better {
                Some(better) => best = better,
                None => return best,
            }
        }
    }

    /// Damped least squares over the logarithms of gain and time constant, and the friction as a share of the largest command.
    fn descended(&self, start: PlainFit, largest_command: f64) -> PlainFit {
        let unit = largest_command.max(f64::MIN_POSITIVE);
        let [shortest, longest] = self.span_of_time_constants();
        let of = |p: Vector3<f64>| {
            let shape = FirstOrder {
                time_constant_s: p[1].exp(),
                friction: unit * p[2].max(0.0),
            };
            (p[0].exp(), shape)
        };
        let FirstOrder {
            time_constant_s,
            friction,
        } = start.shape;
        let mut p = Vector3::new(start.gain.ln(), time_constant_s.ln(), friction / unit);
        let (mut best, mut damping) = (start, 1e-3);
        for _ in 0..STEPS {
            let residuals = self.residuals(best.gain, best.shape);
            let moved = |k: usize| {
                let mut q = p;
                q[k] += DIFFERENCE;
                let (gain, shape) = of(q);
                self.residuals(gain, shape)
            };
            let columns = [moved(0), moved(1), moved(2)];
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for (k, r) in residuals.iter().enumerate() {
                let row = Vector3::from_fn(|j, _| (columns[j][k] - r) / DIFFERENCE);
                normal += row * row.transpose();
                right -= row * *r;
            }
            let before = best.left_counts;
            while damping < 1e9 {
                let diagonal =
                    Matrix3::from_diagonal(&normal.diagonal().add_scalar(f64::MIN_POSITIVE));
                let step = (normal + diagonal * damping).lu().solve(&right);
                let Some(step) = step.filter(|step| step.iter().all(|x| x.is_finite())) else {
                    damping *= 4.0;
                    continue;
                };
                let mut tried = p + step;
                tried[1] = tried[1].clamp(shortest.ln(), longest.ln());
                tried[2] = tried[2].max(0.0);
                let (gain, shape) = of(tried);
                match self.left_by(gain, shape) {
                    Some(fit) if fit.left_counts < best.left_counts => {
                        (best, p) = (fit, tried);
                        damping *= 0.25;
                        break;
                    }
                    _ => damping *= 4.0,
                }
            }
            if best.left_counts >= (1.0 - SETTLED) * before {
                break;
            }
        }
        best
    }
}

impl Record<'_> {
    /// Simulated counts from the first sample on, not rounded.
    fn counts_for(&self, gain: f64, shape: FirstOrder) -> Vec<f64> {
        let mut angles = shape.angles(self.t_s, self.command, self.start / gain);
        for angle in &mut angles {
            *angle *= gain * self.counts_per_rad;
        }
        angles
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
