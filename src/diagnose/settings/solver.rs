//! Limits of the solvers: starts, step sizes, termination. They affect computing time and, through termination, the
//! result.

/// Relative floating-point error: of a pivot, of a linearly dependent column, of uniform times.
pub(crate) const LAST_DIGITS: f64 = 1e-9;
/// Relative difference, or one in nats, below which two values are equal, so that platforms agree.
pub(crate) const SAME: f64 = 1e-6;

// Levenberg-Marquardt (`fit`).
/// Most steps of a fit; a converging one takes six.
pub(crate) const FIT_STEPS: usize = 15;
/// Most attempts at one step.
pub(crate) const ATTEMPTS: usize = 8;
/// Steps after which a fit that costs more than the model it extends is abandoned.
pub(crate) const PATIENCE: usize = 5;
/// Least decrease of the cost in nats; a smaller one ends the fit.
pub(crate) const CONVERGED: f64 = 0.1;
/// The same where another fit starts from the result.
pub(crate) const CONVERGED_START: f64 = 1.0;
/// Distance from the optimum in nats of two fits that have ended: at most 0.3.
pub(crate) const WITHIN_OPTIMUM: f64 = 0.5;
/// Initial damping relative to the diagonal; its factors after a step that decreases the cost, and after one that
/// does not (Marquardt 1963).
pub(crate) const DAMPING: f64 = 1e-3;
pub(crate) const DAMPING_LESS: f64 = 0.2;
pub(crate) const DAMPING_MORE: f64 = 6.0;
/// Longest step of one parameter: relative to the motor file's value, or in a logarithm.
pub(crate) const LONGEST_STEP: f64 = 1.5;
/// Least mean square relative to the variance of quantization, which keeps its logarithm finite.
pub(crate) const LEAST_SQUARE: f64 = 0.01;
/// Values in its range at which a parameter is tried if the prediction is not a smooth function of it.
pub(crate) const PLACES: usize = 16;
/// Relative step of a difference quotient: of the parameter's range, or of a known torque; and the largest range for
/// it.
pub(crate) const DIFFERENCE: f64 = 0.01;
pub(crate) const DIFFERENCE_RANGE: f64 = 10.0;
/// Step of the difference quotients of a formula: small relative to the parameter's changes, large relative to
/// floating-point errors.
pub(crate) const FORMULA_STEP: f64 = 1e-5;
/// Most times that runs are cut again for the nominal fit: the fitted time constant determines the length of
/// segments.
pub(crate) const CUTS: usize = 3;
/// Starts of the electrical time constant relative to the mechanical one: of a small gear motor, and of a large
/// motor.
pub(crate) const WINDINGS: [f64; 2] = [0.03, 0.3];

// Priors (`model`), scores, intervals.
/// Most steps to the most probable combination of deviations of base parameters, and the least decrease in nats.
pub(crate) const PRIOR_STEPS: usize = 200;
pub(crate) const PRIOR_CONVERGED: f64 = 1e-9;
/// Precision of a parameter that no sample of a planned recording depends on, so that its normal equations are
/// positive definite.
pub(crate) const LEAST_PRECISION: f64 = 1e-12;
/// Refinements of a score's optimum by one linear step each, most fits with the noise estimated from the previous one,
/// and estimates of the number of observations from the best set's residual.
pub(crate) const REFINEMENTS: usize = 2;
/// Coefficients of a segment's cosine transform that are grouped by octaves; all others are one band.
pub(crate) const COEFFICIENTS: usize = 512;
/// Range of the linearized plant's time constant in s.
pub(crate) const TIME_CONSTANTS_S: (f64, f64) = (1e-4, 100.0);
/// Fractions of a count of the encoder in simulated recordings: the middles of quarters.
pub(crate) const PHASES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
/// First share of a range, and bisections, of the end of a profile interval.
pub(crate) const PROFILE_FIRST: f64 = 1e-3;
pub(crate) const BISECTIONS: usize = 8;
/// Draws of the bootstrap.
pub(crate) const DRAWS: usize = 1000;

// Noise (`noise`): grid of its maximum likelihood.
/// Correlation times in s: a tooth, a revolution, a breath of the supply, drift.
pub(crate) const LOAD_TIMES_S: [f64; 4] = [0.05, 0.2, 0.6, 2.0];
/// Strengths: levels above a hundredth of the usual load, and their ratio.
pub(crate) const LOAD_LEVELS: i32 = 12;
pub(crate) const LEAST_LOAD: f64 = 0.01;
pub(crate) const LOAD_FACTORS: [f64; 4] = [0.5, 0.7, 1.4, 2.0];
/// Simulated recordings for the error due to random effects.
pub(crate) const RECORDINGS: usize = 32;
/// Octaves of its range at which a random effect's parameter is tried, and halvings of the step from the best of them.
pub(crate) const OCTAVES: i32 = 10;
pub(crate) const REFINED: usize = 4;
/// Noise of logged speeds, in halvings of the top speed: from a sixteenth to a resolution of ten bits.
pub(crate) const SCATTER_LEVELS: std::ops::RangeInclusive<i32> = 4..=10;

/// Products of variances in counts^2 whose logarithm is not taken yet: far from the ends of a floating-point number.
pub(crate) const LOGARITHM_WITHIN: std::ops::Range<f64> = 1e-100..1e100;

// Search (`search`).
/// Rounds of adding, dropping and exchanging; the best set stays after two or three.
pub(crate) const ROUNDS: usize = 5;
/// Most simulation time of a search in ns of recordings of up to this many samples, and for each further sample, by the
/// simulator's own estimate, which does not depend on the machine. Beyond it the best single effects of the first
/// round, random effects, and for as long again the best set without each of its effects and with those of their
/// classes are fitted: 3,000 rows take some 3 s of one core.
pub(crate) const SEARCH_NS: u64 = 800_000_000;
pub(crate) const SEARCH_SAMPLES: usize = 3_000;
pub(crate) const SEARCH_NS_PER_FURTHER_SAMPLE: u64 = 10_000_000;
/// Largest screened set of the first round; the later ones add one effect to a set. Part of the first round's sets that
/// a later round fits.
pub(crate) const LARGEST_SCREENED: usize = 3;
pub(crate) const LATER_PART: usize = 3;
/// Best screened effects that are fitted regardless of the time.
pub(crate) const FITTED_ANYWAY: usize = 4;
/// Sets near the best that are fitted without each of their members; fitted starts of one set, also of a nested fit.
pub(crate) const SIMPLIFIED: usize = 2;
pub(crate) const STARTS_PER_SET: usize = 2;
/// Pairs extended to triples.
pub(crate) const EXTENDED: usize = 8;
/// Largest coefficient of a start's column; beyond, another start is nearer.
pub(crate) const LARGEST_COEFFICIENT: f64 = 2.0;
/// Starts of an effect's first parameter as shares of its range; denser if the prediction is not a smooth function of
/// it; of either sign; and of further parameters.
pub(crate) const STARTS: [f64; 3] = [0.15, 0.5, 0.85];
pub(crate) const CLOSE_STARTS: [f64; 5] = [0.08, 0.25, 0.45, 0.65, 0.85];
pub(crate) const SIGNED_STARTS: [f64; 4] = [-0.5, -0.12, 0.12, 0.5];
pub(crate) const FURTHER_STARTS: [f64; 2] = [0.2, 0.7];
/// Mean square relative to quantization above which no simulated recording of a model is at the noise floor, unless
/// starts matter.
pub(crate) const FLOOR_WITHIN: f64 = 2.0;
/// Most samples of a window on either side, which bounds the computing time for short sample times.
pub(crate) const WINDOW_SAMPLES: f64 = 1000.0;

// Equation-error regression (`inverse`), which gives starts.
/// Largest quantization error of an acceleration, as a share of its size.
pub(crate) const ACCELERATION_NOISE: f64 = 0.1;
/// Half width of the narrowest window in samples, and of the widest in s.
pub(crate) const NARROWEST_SAMPLES: f64 = 4.0;
pub(crate) const WIDEST_S: f64 = 0.5;
/// Fewest windows: five per coefficient.
pub(crate) const LEAST_ROWS: usize = 20;
/// Degrees of freedom of Student's weights, and number of reweightings.
pub(crate) const WEIGHTS_FREEDOM: f64 = 3.0;
pub(crate) const REWEIGHTED: usize = 5;

// Experiments (`design`).
/// Most samples of a simulated planned recording, most sets that it is to separate, profiles tried with changes on
/// the bench.
pub(crate) const PLANNED_SAMPLES: usize = 1_500;
pub(crate) const SETS_TO_SEPARATE: usize = 6;
pub(crate) const CHANGED_PROFILES: usize = 3;
