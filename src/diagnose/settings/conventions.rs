//! Conventions: quantiles, tolerances of comparisons, and printed precision. They do not affect the judgement of
//! effects.

/// Half width of a 95 % interval of a normal distribution in standard deviations, and its one-sided quantile.
pub(crate) const WITHIN_95: f64 = 1.96;
pub(crate) const ONE_SIDED_95: f64 = 1.645;
/// Ends of a 95 % interval of draws.
pub(crate) const ENDS_95: [f64; 2] = [0.025, 0.975];
/// Median absolute value of a normal variate in standard deviations.
pub(crate) const MEDIAN_SIZE: f64 = 0.6745;

// Recordings.
/// Least certain motion of a shaft in counts: dither at rest is one.
pub(crate) const MOVED_COUNTS: f64 = 1.5;
/// Least sample interval of a pause in medians.
pub(crate) const PAUSE: f64 = 10.0;
/// Longest mean sample interval in s: tables of steady speeds have a row a second.
pub(crate) const MOST_APART_S: f64 = 3.0;
/// Tolerance of equal commands relative to the largest, and of equal sample times: the decimals of a file.
pub(crate) const SAME_COMMAND: f64 = 1e-3;
/// Least ratio of the lengths of repeated runs.
pub(crate) const REPEATED_SHARE: f64 = 0.9;
/// Share of the top speed below which a change of speed is none, and a speed is low: for the regimes.
pub(crate) const SLOW: f64 = 0.1;
/// A cut is moved by at most this part of a segment: all segments have at least half of the mean length.
pub(crate) const CUT_REACH: usize = 4;
/// Multiples of the motor file's counts per revolution: one, two or four edges counted per line.
pub(crate) const EDGES_COUNTED: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

// Printed precision.
/// Least inclusion probability of an effect in the document, of a set in the table of `--explain`, of a set that an
/// experiment is to separate.
pub(crate) const LISTED_FROM: f64 = 0.01;
/// Least inclusion probability of an effect in a sentence without identified ones, and the most effects in it.
pub(crate) const MENTIONED_FROM: f64 = 0.05;
pub(crate) const MENTIONED: usize = 3;
/// Least inclusion probability of a further effect in a sentence with identified ones.
pub(crate) const MENTIONED_BESIDE: f64 = 0.25;
/// Fitted parameters of an effect in a sentence, in the catalogue's order, most characteristic first.
pub(crate) const STATED: usize = 2;
/// Least share that is printed as a figure.
pub(crate) const LEAST_PRINTED: f64 = 1e-3;
/// Least share of a listed time interval, and the most intervals.
pub(crate) const LEAST_REGION: f64 = 0.02;
pub(crate) const MOST_REGIONS: usize = 16;
/// Intervals of omitted samples in a sentence.
pub(crate) const LEFT_OUT_SHOWN: usize = 3;
/// Screened sets in the table of `--explain`.
pub(crate) const SCREENED_SHOWN: usize = 8;
/// Longest command line printed in full, in characters: three lines of a terminal.
pub(crate) const COPIED_CHARACTERS: usize = 240;

// Progress, in shares of the computing time.
/// Share up to the fitted sets, up to the held-out error, up to the choice of the next experiment.
pub(crate) const SEARCH_SHARE: f64 = 0.8;
pub(crate) const HELD_OUT_FROM: f64 = 0.85;
pub(crate) const NEXT_FROM: f64 = 0.9;
/// Share of the re-identification in the first of these.
pub(crate) const REFITTED_SHARE: f64 = 0.1;
/// Share of the search that remains after a round: later rounds fit a third as many sets.
pub(crate) const LEFT_AFTER_ROUND: f64 = 0.4;
