//! Conventions: quantiles, what counts as the same, and what is printed. No effect is judged by them.

/// Half width of a 95 % interval of a normal distribution in standard deviations, and its one-sided quantile.
pub(crate) const WITHIN_95: f64 = 1.96;
pub(crate) const ONE_SIDED_95: f64 = 1.645;
/// Ends of a 95 % interval of draws.
pub(crate) const ENDS_95: [f64; 2] = [0.025, 0.975];
/// Median size of a normal number in standard deviations.
pub(crate) const MEDIAN_SIZE: f64 = 0.6745;

// Recordings.
/// Counts by which a shaft moves for certain: an edge at rest dithers by one.
pub(crate) const MOVED_COUNTS: f64 = 1.5;
/// A sample interval of so many medians is a pause.
pub(crate) const PAUSE: f64 = 10.0;
/// Longest mean sample interval in s: tables of steady speeds have a row a second.
pub(crate) const MOST_APART_S: f64 = 3.0;
/// Commands within this share of the largest are the same, and sample times within this share of each other: what a file's decimals leave.
pub(crate) const SAME_COMMAND: f64 = 1e-3;
/// Runs repeat each other where the shorter has this share of the longer's samples.
pub(crate) const REPEATED_SHARE: f64 = 0.9;
/// A change of speed, or a speed, below this share of the top speed is none, or slow: words for the regimes.
pub(crate) const SLOW: f64 = 0.1;
/// A cut is moved by at most this part of a segment: all segments have at least half of the mean length.
pub(crate) const CUT_REACH: usize = 4;
/// Multiples of the motor file's counts per revolution: edges are counted once, twice or four times a line.
pub(crate) const EDGES_COUNTED: [f64; 4] = [0.25, 0.5, 2.0, 4.0];

// Printed precision.
/// Least inclusion probability of an effect in the document, of a set in the table of `--explain`, of a set that an experiment is to separate.
pub(crate) const LISTED_FROM: f64 = 0.01;
/// Least inclusion probability of an effect in a sentence where none is identified, and how many there are at most.
pub(crate) const MENTIONED_FROM: f64 = 0.05;
pub(crate) const MENTIONED: usize = 3;
/// Least inclusion probability of an effect that is mentioned beside identified ones.
pub(crate) const MENTIONED_BESIDE: f64 = 0.25;
/// Fitted parameters of an effect in a sentence, in the catalogue's order, which begins with what characterizes it.
pub(crate) const STATED: usize = 2;
/// Least share of a time interval with a large residual, and how many there are at most.
pub(crate) const LEAST_REGION: f64 = 0.02;
pub(crate) const MOST_REGIONS: usize = 16;
/// Screened sets in the table of `--explain`.
pub(crate) const SCREENED_SHOWN: usize = 8;
/// A command of so many characters is printed whole: three lines of a terminal.
pub(crate) const COPIED_CHARACTERS: usize = 240;

// Progress, in shares of the time that diagnoses take.
/// Share up to the fitted sets, up to the held-out error, up to the choice of the next experiment.
pub(crate) const SEARCH_SHARE: f64 = 0.8;
pub(crate) const HELD_OUT_FROM: f64 = 0.85;
pub(crate) const NEXT_FROM: f64 = 0.9;
/// Share of the re-identification in the first of these.
pub(crate) const REFITTED_SHARE: f64 = 0.1;
/// Share of the search that is left after a round: later rounds fit a third as many sets.
pub(crate) const LEFT_AFTER_ROUND: f64 = 0.4;
