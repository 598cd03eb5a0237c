//! Least-squares fit of a first-order motor to recordings: position error in counts, open loop from the start of each
//! run.
//!
//! [`fit_runs`] takes runs, [`plain_fit`] columns. It has no noise model, no priors and no effects; the diagnosis
//! starts from its result. `tests/diagnosis/plain_fit.rs` compares it with SciPy's `least_squares` on 200 drawn
//! motors and on real steps.

mod first_order;
mod motor;
mod plain_fit;
mod record;
mod start;

pub use first_order::FirstOrder;
pub use motor::FirstOrderMotor;
pub use plain_fit::{PlainFit, plain_fit};
pub use record::{Record, counts_from_first};
pub(crate) use record::{columns, records};
pub use start::{Start, start_of};

use crate::recording::Run;

/// The least-squares first-order motor of these runs of one axis. `starts` are further initial values; the result is
/// at least as good as each of them. Each run begins at rest or in motion, as its first samples show. Known
/// differences between the runs are neglected.
///
/// `None` if nothing turns, or only against the command.
///
/// ```
/// use motorlab::least_squares::fit_runs;
/// use motorlab::recording::Run;
///
/// // theta = K u (t - T (1 - exp(-t/T))) with K = 2 rad/s/V, T = 0.1 s, at 5 V and 1000 counts per revolution.
/// let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.005).collect();
/// let turned = |t: &f64| 2.0 * 5.0 * (t + 0.1 * (-t / 0.1_f64).exp_m1());
/// let run = Run {
///     sample_time_s: 0.005,
///     counts_per_rev: 1000.0,
///     counts: t_s.iter().map(|t| (turned(t) * 1000.0 / std::f64::consts::TAU) as i64).collect(),
///     command: vec![5.0; t_s.len()],
///     t_s,
///     ..Run::default()
/// };
/// let found = fit_runs(&[run], &[]).expect("it turns");
/// assert!((found.motor.shape.time_constant_s - 0.1).abs() < 1e-3);
/// assert!(found.left_counts < 0.31);
/// ```
pub fn fit_runs(runs: &[Run], starts: &[FirstOrderMotor]) -> Option<PlainFit> {
    let columns = columns(runs);
    plain_fit(&records(runs, &columns), starts)
}
