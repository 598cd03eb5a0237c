//! Every number of the method: its unit and why it has this value.

/// Length of a piece in s: long against a gear motor's time constant, short against what drifts. Convention.
pub(crate) const PIECE_S: f64 = 1.0;
/// The same in time constants of the motor: after so many a start is forgotten.
pub(crate) const PIECE_TIME_CONSTANTS: f64 = 10.0;
/// Fewest samples of a piece. Convention.
pub(crate) const PIECE_SAMPLES: usize = 40;
/// Folds of the cross-validation. Convention (Hastie, Tibshirani, Friedman, 7.10).
pub(crate) const FOLDS: usize = 5;
/// Half width in s of the window in which the speed at a sample is measured.
pub(crate) const SPEED_WINDOW_S: f64 = 0.045;
/// Uncertainty of the speed at a piece's start beside what rounding makes, as a share of the top speed.
pub(crate) const START_SPEED_SHARE: f64 = 0.02;
/// Samples that count in a stretch of one count, whatever its length: a shaft at rest says the same again.
pub(crate) const REST_SAMPLES: f64 = 1.0;
/// Variance of rounding in counts^2 (Widrow).
pub(crate) const ROUNDING: f64 = 1.0 / 12.0;
/// Correlation times in s among which that of a wandering load is chosen.
pub(crate) const WANDER_TIMES_S: [f64; 4] = [0.05, 0.2, 0.6, 2.0];
/// Strengths among which that of a wandering load is chosen, one sigma as a share of the stall torque: from nothing in steps of 2.
pub(crate) const WANDER_LEAST: f64 = 1e-4;
pub(crate) const WANDER_LEVELS: usize = 12;
/// Relative tolerance (one sigma) of a number that the motor file states none for.
pub(crate) const DEFAULT_TOLERANCE: f64 = 0.05;
/// Width (one sigma, of the logarithm) that an effect sets free: the catalogue's range of 0.3 to 4 times.
pub(crate) const FREED_WIDTH: f64 = 0.8;
/// Recordings simulated to see what chance makes of the best of all rivals.
pub(crate) const NULLS: usize = 99;
/// Nats that a rival has to gain to be there at all.
pub(crate) const LEAST_GAIN: f64 = 4.0;
/// Effects fitted for each look at what promises most.
pub(crate) const FITTED: usize = 6;
/// Most effects of a set: with three the search has seen all pairs and what hides behind them.
pub(crate) const MOST_EFFECTS: usize = 3;
/// Share of simulated recordings that may promise as much as what is said to be there. Convention (1 %).
pub(crate) const CHANCE: f64 = 0.01;
/// Least share of the mean square above rounding that an effect closes: what closes less is not what the gap is.
pub(crate) const CLOSES: f64 = 0.1;
/// Fewer pieces than these, and nothing is said with more than so much.
pub(crate) const FEW_PIECES: usize = 8;
pub(crate) const FEW_PIECES_SURE: f64 = 0.9;
/// How well the host reads the board's clock at either end, in s: earliest arrivals of a tenth of the samples.
pub(crate) const CLOCK_READING_S: f64 = 0.5e-3;
