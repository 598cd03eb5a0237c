//! Which effects a profile separates before it is recorded.
//!
//! The profile is simulated with a motor and its counts are cut into segments as a recording's are. Two models are compared on it by
//! the separation in standard deviations
//!
//! `D_ij^2 = min over dp of |W (x_i - x_j - J_j dp)|^2 + dp' P_j dp + sum (rho - 1 - ln rho)`,
//!
//! with `x` the predictions, `W` the units of the error, `J_j` the derivatives of the rival and `P_j` the precision to which its
//! parameters are known; `rho` are the ratios of the innovation variances, where one of the two is a stochastic effect. [`isolability`]
//! compares the effects of the catalogue before any recording, [`beyond_parameters`] simulates them on the commands of one, [`next_experiment`] the sets that a diagnosis leaves (T-optimality:
//! Atkinson and Fedorov 1975).

mod beyond;
mod change;
mod isolability;
mod next;
mod planned;

pub use beyond::{Beyond, beyond_parameters};
pub use isolability::{Isolability, Pair, Plan, isolability};
pub(crate) use next::next_experiment;
