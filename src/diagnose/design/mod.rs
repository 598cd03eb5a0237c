//! What a profile would tell before it is recorded.
//!
//! The profile is simulated with a motor, its counts made ready as if they were a recording (so that rounding, rest, pieces and
//! wander have their weights), and two models are compared on it by the separation
//!
//! `D_ij^2 = min over dp of |W (x_i - x_j - J_j dp)|^2 + dp' P_j dp + sum (rho - 1 - ln rho)`,
//!
//! where `P_j` is how well `j`'s numbers are known and `rho` the ratio of the noise variances that the two stand for (late
//! samples, lost edges). `isolability` asks it of the whole catalogue before a recording; `next` chooses what to record after one
//! (T-optimality: Atkinson and Fedorov, 1975; Hunter and Reiner, 1965); [`separation_of`] asks it of the runs themselves.

mod bench;
mod change;
mod hidden;
mod in_play;
mod isolability;
mod next;
mod planned;
mod refit;
mod supposed;

pub use isolability::{Isolability, Pair, Plan, isolability};
pub(crate) use next::next_experiment;
pub(crate) use planned::separation_of;
