//! Every number of the method: its unit and why it has this value.

/// Length of a piece in s: long against a gear motor's time constant, short against what drifts. Convention.
pub(crate) const PIECE_S: f64 = 1.0;
/// The same in time constants of the motor: after so many 95 % of a start is forgotten. Over longer pieces what a law leaves adds up,
/// and hides the inertia.
pub(crate) const PIECE_TIME_CONSTANTS: f64 = 3.0;
/// Fewest samples of a piece. Convention.
pub(crate) const PIECE_SAMPLES: usize = 40;
/// Samples that are searched at most; of longer recordings some pieces are drawn. At 3 ms they are fifty pieces, so that each of some
/// forty regimes and levels has one at least.
pub(crate) const SEARCHED_SAMPLES: usize = 16_000;
/// Seconds that are simulated before a piece whose past is left out: the longest delay in play.
pub(crate) const LEAD_S: f64 = 0.3;
/// Parts of the command's range, either way, that pieces are drawn from alike. Convention.
pub(crate) const COMMAND_LEVELS: f64 = 4.0;
/// Folds of the cross-validation. Convention (Hastie, Tibshirani, Friedman, 7.10).
pub(crate) const FOLDS: usize = 5;
/// Samples that are held out together where pieces are few. Convention: few beside a start of a hundred samples, and enough that one that is
/// off does not decide a score. A start that is over within them is in one fold.
pub(crate) const STRETCH_SAMPLES: usize = 5;
/// Half width in s of the window in which the speed at a sample is measured.
pub(crate) const SPEED_WINDOW_S: f64 = 0.045;
/// Half width in s of the line that gives the speed at a piece's start, two samples at least: half a time constant of a small motor.
/// With the window above a right model of cogging leaves three times what rounding does.
pub(crate) const START_WINDOW_S: f64 = 0.015;
/// Uncertainty of the speed at a piece's start beside what rounding makes, as a share of the top speed.
pub(crate) const START_SPEED_SHARE: f64 = 0.02;
/// Samples that count in a stretch of one count, whatever its length: a shaft at rest says the same again.
pub(crate) const REST_SAMPLES: f64 = 1.0;
/// Variance of rounding in counts^2.
pub(crate) use crate::units::ROUNDING_VARIANCE as ROUNDING;
/// Correlation times in s among which that of a wandering load is chosen.
pub(crate) const WANDER_TIMES_S: [f64; 4] = [0.05, 0.2, 0.6, 2.0];
/// Strength of a wandering load that is plausible (one sigma), as a share of the stall torque: benches shake by 0.3 to 1 %.
pub(crate) const USUAL_WANDER: f64 = 0.01;
/// Strengths among which that of a wandering load is chosen, one sigma as a share of the stall torque: from nothing in steps of 2.
pub(crate) const WANDER_LEAST: f64 = 1e-4;
pub(crate) const WANDER_LEVELS: usize = 12;
/// Scatter of logged speeds among which theirs is chosen, one sigma as a share of the top speed, in steps of 2: from what ten bits resolve
/// to a sixteenth. Convention.
pub(crate) const SPEED_SCATTER_LEAST: f64 = 1e-3;
pub(crate) const SPEED_SCATTER_LEVELS: usize = 7;
/// Relative tolerance of a number that the motor file states none for: the scale of its Student's t (`fit/tolerances.rs`). Convention.
pub(crate) const DEFAULT_TOLERANCE: f64 = 0.05;
/// Recordings simulated to see what chance makes of the best of all rivals: what is there promises more than each, which chance does
/// once in a hundred times. Convention.
pub(crate) const NULLS: usize = 99;
/// Nats that a rival has to gain to be there that closes nothing of the gap: one that scatters, or takes a bent base back. As much is
/// asked of a refit, of something unknown beyond chance, and of what a set loses without some of its members.
pub(crate) const LEAST_GAIN: f64 = 4.0;
/// Effects fitted for each look at what promises most, and all that promise as much.
pub(crate) const FITTED: usize = 6;
/// Most effects of a set: with three the search has seen all pairs and what hides behind them.
pub(crate) const MOST_EFFECTS: usize = 3;
/// Least share of the mean square above rounding that an effect closes: what closes less is not what the gap is.
pub(crate) const CLOSES: f64 = 0.1;
/// Fewer pieces than these, or recordings in which something fatal is found, and nothing is said with more than `SURE`. Convention.
pub(crate) const FEW_PIECES: usize = 8;
/// From this probability on a thing is said surely. Convention.
pub(crate) const SURE: f64 = 0.9;
/// How well the host reads the board's clock at either end, in s: earliest arrivals of a tenth of the samples.
pub(crate) const CLOCK_READING_S: f64 = 0.5e-3;
/// Base numbers within so many tolerances of the motor file's are its own.
pub(crate) const WITHIN_TOLERANCES: f64 = 3.0;
/// Fewest samples of a run. Convention: five for a gain, a time constant, a start and an end.
pub(crate) const LEAST_SAMPLES: usize = crate::check::FEWEST_SAMPLES;
/// Longest time constant in s that pieces are made longer for: what coasts is not followed to its end.
pub(crate) const LONGEST_TIME_CONSTANT_S: f64 = 1.0;
/// Least nats that a candidate promises to be fitted at all: what one number gains by chance.
pub(crate) const LEAST_PROMISE: f64 = 0.5;
/// Most that a start's column is stretched by: beyond, another start is nearer.
pub(crate) const MOST_STRETCH: f64 = 2.0;
/// Shares of the wander that is found under which candidates are looked at beside the whole: what is missing makes a load seem to wander.
pub(crate) const WANDER_SHARES: [f64; 1] = [0.1];
/// How many times the file's counts a turn may be, beside the usual ones: the edges of an encoder are counted once, twice or four times a line.
pub(crate) const EDGES_COUNTED: [f64; 4] = [0.25, 0.5, 2.0, 4.0];
/// Shares of a range from which an effect's first number starts, those that nothing depends on smoothly, those of either sign, and
/// further numbers.
pub(crate) const STARTS: [f64; 3] = [0.15, 0.5, 0.85];
pub(crate) const STEPPED_STARTS: [f64; 5] = [0.08, 0.25, 0.45, 0.65, 0.85];
pub(crate) const SIGNED_STARTS: [f64; 4] = [-0.5, -0.12, 0.12, 0.5];
pub(crate) const FURTHER_STARTS: [f64; 2] = [0.2, 0.7];
/// Lowest rate above which edges are lost, as a share of the top rate: lower is a decoder that nobody would use.
pub(crate) const LEAST_RATE: f64 = 0.2;
/// A rival within so many standard errors, or so many nats, is not told from the best.
pub(crate) const TIED_ERRORS: f64 = 2.0;
pub(crate) const TIED_NATS: f64 = 4.0;
/// Orders of the angle among the shapes of a flexible torque.
pub(crate) const SHAPE_ORDERS: usize = 20;
/// Ridge of its regression, for columns of length 1: small beside what a whitened unit says.
pub(crate) const RIDGE: f64 = 0.1;
/// Relative tolerance (one sigma) of the numbers of a nominal motor that was fitted to the runs: they are as the runs say.
pub(crate) const FITTED_TOLERANCE: f64 = 0.5;
/// Strength of a load that wanders, one sigma as a share of the stall torque, from which on it is something unknown: benches shake by
/// 0.3 to 1 %.
pub(crate) const MOST_WANDER: f64 = 0.05;
/// Effects that are named beside something unknown are said with no more than this: what is unknown may be what they stand for. Of 49 such
/// verdicts of breadth sets with tuning seeds in 39 a named effect was there.
pub(crate) const PARTIAL_SURE: f64 = 0.8;
/// Longest mean time between samples in s. Tables of steady speeds have a row a second; three are no motor's log.
pub(crate) const MOST_APART_S: f64 = 3.0;
/// A step of time that is so many times the median is a pause. Convention.
pub(crate) const PAUSE: f64 = 10.0;
/// Most that a number of the motor file is changed by, as a factor either way: beyond lies another motor.
pub(crate) const MOST_CHANGED: f64 = 100.0;
/// Most that an effect's number is beyond the end of a plausible range that is a multiple of the motor's own numbers, as a factor: the
/// prior speaks against it, no wall does. Convention.
pub(crate) const BEYOND_RANGE: f64 = 1.5;
/// Commands within this share of the largest are the same: what a file's decimals leave.
pub(crate) const SAME_COMMAND: f64 = 1e-3;
/// Runs repeat each other where the shorter has this share of the longer's samples. Convention.
pub(crate) const REPEATED_SHARE: f64 = 0.9;
/// Where in a count a shaft starts, of the recordings that tell what rounding leaves: the middles of quarters.
pub(crate) const START_PHASES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
/// From so many runs on whole runs are drawn again, not pieces: repeats are not independent.
pub(crate) const CLUSTERED_RUNS: usize = 5;
/// Numbers of a cause are said from this probability on that it is there: below, they are of no use. Convention.
pub(crate) const NUMBERS_FROM: f64 = 0.01;
/// Seconds to either side over which a change of speed is looked for: two time constants of a small motor.
pub(crate) const CHANGE_SPAN_S: f64 = 0.06;
/// Breakaway lasts this long in s from the last sample at rest: until a small motor turns as the command says.
pub(crate) const BREAKAWAY_S: f64 = 0.12;
/// A change of speed by this share of the top speed within the span is acceleration, or braking. Convention.
pub(crate) const CHANGE_SHARE: f64 = 0.06;
/// Turning below this share of the run's top speed is slow. Convention.
pub(crate) const SLOW_SHARE: f64 = 0.15;
/// Stretches with a smaller share of the gap than this, or beyond so many, are not listed. Convention.
pub(crate) const LEAST_REGION: f64 = 0.02;
pub(crate) const MOST_REGIONS: usize = 16;
/// A regime is named in the sentence from this share of the gap on. Convention.
pub(crate) const NAMED_REGIME: f64 = 0.25;
/// Rivals are named in a sentence up to so many words; the others are counted. Convention: a sentence has 25 at most.
pub(crate) const RIVAL_WORDS: usize = 14;
/// So many named effects are explained in the sentence. Convention: more is no sentence.
pub(crate) const EXPLAINED_EFFECTS: usize = 2;
/// A command to copy has so many characters at most in the sentence. Convention: three lines of a terminal.
pub(crate) const COPIED_CHARACTERS: usize = 240;
/// Separation in standard deviations below which two models are one class: beyond it one draw in 700 mistakes them.
pub(crate) const TIE: f64 = 3.0;
/// Where no experiment separates any pair so far, one is still asked for that separates some by this much.
pub(crate) const FAINT: f64 = 1.0;
/// Sets this many nats behind the best are in play where the runs do not separate them from it.
pub(crate) const IN_PLAY_NATS: f64 = 12.0;
/// Sets are in play that are no less likely than the likeliest by this factor.
pub(crate) const IN_PLAY_SHARE: f64 = 0.02;
/// Most sets in play: beyond, the pairs are too many for one experiment.
pub(crate) const MOST_IN_PLAY: usize = 6;
/// Shortest and longest recording that is asked for, in s, and most samples of it. Convention.
pub(crate) const ASKED_S: (f64, f64) = (4.0, 20.0);
pub(crate) const MOST_ASKED_SAMPLES: f64 = 20_000.0;
/// Torque of the load that is proposed, as a share of the stall torque: the motor lifts it, and feels it.
pub(crate) const KNOWN_LOAD: f64 = 0.3;
/// The other supply that is proposed, as a share.
pub(crate) const OTHER_SUPPLY: f64 = 0.5;
/// Wander of a plan without a recording, one sigma as a share of the stall torque: that of a clean bench.
pub(crate) const ORDINARY_WANDER: f64 = 1e-3;
/// Relative step of the difference along what no recording tells.
pub(crate) const UNSEEN_STEP: f64 = 0.01;
/// Most that the resistance is off along it, as a share: far beyond any tolerance.
pub(crate) const MOST_UNSEEN: f64 = 0.5;
/// Experiments that are looked at again with the rivals refitted, and most steps of each refit.
pub(crate) const SHORT_LIST: usize = 4;
pub(crate) const REFIT_STEPS: usize = 6;
/// Shares of a step of Gauss and Newton that are tried until one lowers what is left. Convention.
pub(crate) const REFIT_SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// Where in its range a rival's first number is tried.
pub(crate) const RIVAL_PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Where in its range an effect's first number stands that the runs might hide: a small and a large one.
pub(crate) const HIDDEN_PLACES: [f64; 2] = [0.25, 0.75];
/// Where in its range a number stands as the truth whose middle is not this many least distances from what changes nothing.
pub(crate) const AWAY: f64 = 0.8;
pub(crate) const WELL_AWAY: f64 = 2.0;
/// The inverse form: what rounding may make of an acceleration, as a share of its own size; half the narrowest window in samples; and the
/// fewest windows that tell anything, as many as a run's samples.
pub(crate) const INVERSE_NOISE: f64 = 0.1;
pub(crate) const INVERSE_SAMPLES: f64 = 4.0;
pub(crate) const INVERSE_ROWS: usize = LEAST_SAMPLES;
/// Speeds below which a shaft starts hard, as shares of the top speed: through the range of `stribeck`.
pub(crate) const STRIBECK_SHARES: [f64; 4] = [0.04, 0.1, 0.2, 0.4];
/// Gain of a term of the inverse form from which on it decides where no simulation explains the runs: of tie-free picks on nine recordings
/// of real motors with documented causes those of 0.45 and more were right, those of 0.25 and less were not.
pub(crate) const INVERSE_DECIDES: f64 = 0.35;
/// Relative standard deviation by which the base numbers of one axis differ from one recording to the next without a change: what some
/// 3 K of its winding make of a resistance.
pub(crate) const SAME_AXIS: f64 = 0.01;
