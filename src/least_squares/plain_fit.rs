//! Least-squares fit of a first-order motor (`first_order.rs`) to recorded counts.
//!
//! Minimizes `sum over samples (n - x(K, T, F) - o)^2` in counts^2: open loop from the first sample, with one offset
//! `o` per run for the initial fraction of a count. No weights, no priors. The gain is linear and eliminated
//! (variable projection: Golub and Pereyra 1973). Time constant and friction start from a grid over the plausible
//! range, from the given starts, and from each of these without friction; the best are refined by
//! Levenberg-Marquardt. The derivative by the friction vanishes for a resting shaft, so that a line search along it
//! alternates with the steps. `tests/diagnosis/plain_fit.rs` compares with SciPy's `least_squares` on drawn and real
//! steps.

use nalgebra::{Matrix3, Vector3};

use super::record::{Record, Records};
use super::{FirstOrder, FirstOrderMotor};

/// Time constants of the grid, logarithmically spaced: a factor of 1.6 over at most 5 decades, so that each basin of
/// the error contains one.
const TIME_CONSTANTS: usize = 14;
/// The shortest one as a share of the sample time: shorter ones have settled before the next sample.
const SHORTEST: f64 = 0.1;
/// Frictions of the grid as shares of the largest command; with more a motor hardly turns.
const FRICTIONS: [f64; 8] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7];
/// Starts that are refined.
const POLISHED: usize = 4;
/// Most steps of a refinement, and the relative gain that ends it.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-9;
/// Relative step of a finite difference: half of the digits.
const DIFFERENCE: f64 = 1e-6;
/// Resolution of the line search along the friction, as a share of the largest command.
const FRICTION_STEP: f64 = 0.01;
/// Fits whose errors differ by less than this share are equal, and the one with less friction is taken.
const SAME: f64 = 1e-3;
/// Least friction that is not absent, as a share of the largest command: a tenth of that of the best small gear
/// motors.
const LEAST_FRICTION: f64 = 1e-3;
/// Largest relative increase of the error that the runs do not resolve.
const NOT_RESOLVED: f64 = 0.01;

/// A fitted first-order motor and its error.
#[derive(Debug, Clone, Copy)]
pub struct PlainFit {
    /// The motor.
    pub motor: FirstOrderMotor,
    /// Position error in counts RMS over all samples.
    pub left_counts: f64,
}

/// The least-squares fit to these runs; `starts` are further initial values. `None` if nothing turns, or only against
/// the command.
pub fn plain_fit(records: &[Record<'_>], starts: &[FirstOrderMotor]) -> Option<PlainFit> {
    let all = Records(records);
    let largest_command = all.largest_command();
    let given = starts.iter().filter_map(|start| all.with_error(*start));
    let mut found: Vec<PlainFit> = given.collect();
    let given_leave = least(&found);
    for FirstOrderMotor { gain, shape } in starts {
        found.extend(all.with_gain(*gain, *shape));
        found.extend(all.with_gain(*gain, without_friction(*shape)));
    }
    let guess = starts.first().map_or(1.0, |start| start.gain);
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
    // The simplest one is always a start.
    let simplest = found.first().and_then(|best| {
        let FirstOrderMotor { gain, shape } = best.motor;
        all.with_gain(gain, without_friction(shape))
    });
    found.extend(simplest);
    let polished: Vec<PlainFit> = (found.into_iter())
        .map(|fit| all.polished(fit, largest_command))
        .collect();
    let least = least(&polished);
    let as_good = polished
        .into_iter()
        .filter(|fit| fit.left_counts <= ((1.0 + SAME) * least).min(given_leave.max(least)));
    let best = as_good.min_by(|a, b| {
        let friction = |fit: &PlainFit| fit.motor.shape.friction;
        friction(a).total_cmp(&friction(b))
    })?;
    // Where the runs do not determine friction, an estimate of 0 becomes a small value, because other parameters are
    // relative to it.
    let FirstOrderMotor { gain, shape } = best.motor;
    let friction = shape.friction.max(LEAST_FRICTION * largest_command);
    let rubs = all.with_gain(gain, FirstOrder { friction, ..shape });
    rubs.filter(|fit| fit.left_counts <= ((1.0 + NOT_RESOLVED) * least).min(given_leave))
        .or(Some(best))
}

fn least(fits: &[PlainFit]) -> f64 {
    let left = fits.iter().map(|fit| fit.left_counts);
    left.fold(f64::INFINITY, f64::min)
}

fn without_friction(shape: FirstOrder) -> FirstOrder {
    FirstOrder {
        friction: 0.0,
        ..shape
    }
}

impl Records<'_> {
    /// Range of time constants in s: from settled before the next sample to the length of the longest run.
    fn span_of_time_constants(&self) -> [f64; 2] {
        let (step_s, longest_s) = self.step_and_length_s().unwrap_or((1.0, 1.0));
        let shortest_s = SHORTEST * step_s;
        [shortest_s, longest_s.max(shortest_s)]
    }

    fn time_constants(&self) -> impl Iterator<Item = f64> {
        let [shortest, longest] = self.span_of_time_constants();
        let ratio = (longest / shortest).ln() / (TIME_CONSTANTS - 1) as f64;
        (0..TIME_CONSTANTS).map(move |k| shortest * (ratio * k as f64).exp())
    }

    /// The fit with the best gain for this shape; `None` if it turns against the command. The initial speed is
    /// proportional to the gain `guess`, then to the result.
    fn with_gain(&self, guess: f64, shape: FirstOrder) -> Option<PlainFit> {
        let once = self.best_gain(guess, shape)?;
        let in_motion = self.0.iter().any(|run| run.start_rad_s != 0.0);
        let gain = if in_motion {
            self.best_gain(once, shape)?
        } else {
            once
        };
        self.with_error(FirstOrderMotor { gain, shape })
    }

    /// The error of a motor; `None` if it is not finite.
    fn with_error(&self, motor: FirstOrderMotor) -> Option<PlainFit> {
        let residuals = self.residuals(motor.gain, motor.shape);
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let left_counts = (squares / residuals.len() as f64).sqrt();
        left_counts
            .is_finite()
            .then_some(PlainFit { motor, left_counts })
    }

    /// Alternates Levenberg-Marquardt steps and the line search along the friction until neither improves the fit.
    fn polished(&self, start: PlainFit, largest_command: f64) -> PlainFit {
        let mut best = self.descended(start, largest_command);
        loop {
            let near = [-1.0, 1.0].into_iter().filter_map(|sign| {
                let FirstOrderMotor { gain, shape } = best.motor;
                let friction = shape.friction + sign * FRICTION_STEP * largest_command;
                let shape = FirstOrder {
                    friction: friction.max(0.0),
                    ..shape
                };
                self.with_gain(gain, shape)
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

    /// Damped least squares over the logarithms of gain and time constant, and the friction relative to the largest
    /// command.
    fn descended(&self, start: PlainFit, largest_command: f64) -> PlainFit {
        let unit = largest_command.max(f64::MIN_POSITIVE);
        let [shortest, longest] = self.span_of_time_constants();
        let of = |p: Vector3<f64>| {
            let shape = FirstOrder {
                time_constant_s: p[1].exp(),
                friction: unit * p[2].max(0.0),
            };
            FirstOrderMotor {
                gain: p[0].exp(),
                shape,
            }
        };
        let FirstOrderMotor { gain, shape } = start.motor;
        let mut p = Vector3::new(gain.ln(), shape.time_constant_s.ln(), shape.friction / unit);
        let (mut best, mut damping) = (start, 1e-3);
        for _ in 0..STEPS {
            let residuals = self.residuals(best.motor.gain, best.motor.shape);
            let moved = |k: usize| {
                let mut q = p;
                q[k] += DIFFERENCE;
                let moved = of(q);
                self.residuals(moved.gain, moved.shape)
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
                match self.with_error(of(tried)) {
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
