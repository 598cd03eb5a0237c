//! Design of experiments: effects that a profile separates, before it is recorded.
//!
//! The profile is simulated with a motor and its counts are cut into segments like those of a recording. Two models
//! are compared by the separation in standard deviations
//!
//! `D_ij^2 = min over dp of |W (x_i - x_j - J_j dp)|^2 + dp' P_j dp + sum (rho - 1 - ln rho)`,
//!
//! with the predictions `x`, the units `W` of the error, the derivatives `J_j` of the rival and the precision `P_j`
//! of its parameters; `rho` are the ratios of the innovation variances, if one of the two is a stochastic effect.
//! [`isolability`] compares the effects of the catalogue before any recording, [`beyond_parameters`] simulates them
//! with the commands of a recording, [`next_experiment`] the remaining sets of a diagnosis (T-optimality: Atkinson
//! and Fedorov 1975).

mod beyond;
mod change;
mod isolability;
mod next;
mod planned;

pub use beyond::{Beyond, beyond_parameters};
pub use isolability::{Isolability, Pair, Plan, isolability};
pub(crate) use next::next_experiment;
