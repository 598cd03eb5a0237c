//! Limits of the solvers: where they start, how finely they step, when they end. They cost time; what they end at is a number of the method.

/// Relative difference that floating point leaves: of a pivot, of a column that others make up, of even times.
pub(crate) const LAST_DIGITS: f64 = 1e-9;
/// Relative difference, or one in nats, below which two values are the same: platforms round alike.
pub(crate) const SAME: f64 = 1e-6;

// Levenberg-Marquardt (`fit`).
/// Most steps of a fit; one that converges takes six.
pub(crate) const FIT_STEPS: usize = 15;
/// Most attempts at one step.
pub(crate) const ATTEMPTS: usize = 8;
/// Steps after which a fit is given up that costs more than the model that it extends.
pub(crate) const PATIENCE: usize = 5;
/// A step that lowers the cost by less, in nats, is the last.
pub(crate) const CONVERGED: f64 = 0.1;
/// Nats within which two fits that end so are at their optimum: they end 0.3 above it and less.
pub(crate) const WITHIN_OPTIMUM: f64 = 0.5;
/// Damping at first, relative to the diagonal; its factors after a step that lowers the cost, and after one that does not (Marquardt 1963).
pub(crate) const DAMPING: f64 = 1e-3;
pub(crate) const DAMPING_LESS: f64 = 0.2;
pub(crate) const DAMPING_MORE: f64 = 6.0;
/// Longest step of one parameter: of a share of the motor file's value, or of a logarithm.
pub(crate) const LONGEST_STEP: f64 = 1.5;
/// Share of the variance of quantization below which a mean square is none: what keeps its logarithm finite.
pub(crate) const LEAST_SQUARE: f64 = 0.01;
/// Places in its range at which a parameter is tried that the prediction does not depend on smoothly.
pub(crate) const PLACES: usize = 16;
/// Step of a difference quotient as a share: of the parameter's range, or of a known torque; and the largest range for which it is one.
pub(crate) const DIFFERENCE: f64 = 0.01;
pub(crate) const DIFFERENCE_RANGE: f64 = 10.0;
/// Step of the difference quotients of a formula: small beside what a parameter changes by, large beside what floating point leaves.
pub(crate) const FORMULA_STEP: f64 = 1e-5;
/// Most times that runs are cut anew for the nominal fit: the fitted time constant sets the length of segments.
pub(crate) const CUTS: usize = 3;
/// Electrical time constants that a winding's fit starts from, as shares of the mechanical one: of a small gear motor, and of a large motor.
pub(crate) const WINDINGS: [f64; 2] = [0.03, 0.3];

// Priors (`model`), scores, intervals.
/// Most steps to the likeliest way in which base parameters are off, and the last gain in nats.
pub(crate) const PRIOR_STEPS: usize = 200;
pub(crate) const PRIOR_CONVERGED: f64 = 1e-9;
/// Precision of a parameter that no sample of a planned recording shows, so that its normal equations are positive definite.
pub(crate) const LEAST_PRECISION: f64 = 1e-12;
/// Refinements of a score's optimum by one linear step each, and most fits with the noise that the one before leaves itself.
pub(crate) const REFINEMENTS: usize = 2;
/// Coefficients of a segment's cosine transform that are taken by octaves; all beyond are one band.
pub(crate) const COEFFICIENTS: usize = 512;
/// Time constants in s that the linearized plant may have.
pub(crate) const TIME_CONSTANTS_S: (f64, f64) = (1e-4, 100.0);
/// Where in a count the encoder stands in simulated recordings: the middles of quarters.
pub(crate) const PHASES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
/// First share of a range, and bisections, of the end of a profile interval.
pub(crate) const PROFILE_FIRST: f64 = 1e-3;
pub(crate) const BISECTIONS: usize = 8;
/// Draws of the bootstrap.
pub(crate) const DRAWS: usize = 1000;

// Noise (`noise`): nodes of the grid of its maximum likelihood.
/// Correlation times in s: a tooth, a revolution, a breath of the supply, drift.
pub(crate) const LOAD_TIMES_S: [f64; 4] = [0.05, 0.2, 0.6, 2.0];
/// Strengths: doublings from a hundredth of the usual load, and factors between them.
pub(crate) const LOAD_LEVELS: i32 = 12;
pub(crate) const LEAST_LOAD: f64 = 0.01;
pub(crate) const LOAD_FACTORS: [f64; 4] = [0.5, 0.7, 1.4, 2.0];
/// Recordings that are drawn to find what random errors leave.
pub(crate) const RECORDINGS: usize = 32;
/// First step of a random effect's parameter, as a share of its range.
pub(crate) const RANDOM_STEP: f64 = 0.25;
/// Scatter of logged speeds, in halvings of the top speed: from a sixteenth to what ten bits resolve.
pub(crate) const SCATTER_LEVELS: std::ops::RangeInclusive<i32> = 4..=10;

// Search (`search`).
/// Rounds of adding, dropping and exchanging; the best set stays after two or three.
pub(crate) const ROUNDS: usize = 5;
/// Sets that are fitted whatever their screening score.
pub(crate) const FITTED_ANYWAY: usize = 4;
/// Sets near the best that are fitted without each of their members; starts of one set that are fitted.
pub(crate) const SIMPLIFIED: usize = 2;
pub(crate) const STARTS_PER_SET: usize = 2;
/// Pairs that are extended to triples.
pub(crate) const EXTENDED: usize = 8;
/// Largest coefficient of a start's column; beyond, another start is nearer.
pub(crate) const LARGEST_COEFFICIENT: f64 = 2.0;
/// Shares of a range from which the first parameter of an effect starts; closer where the prediction does not depend on it smoothly;
/// of either sign; and further parameters.
pub(crate) const STARTS: [f64; 3] = [0.15, 0.5, 0.85];
pub(crate) const CLOSE_STARTS: [f64; 5] = [0.08, 0.25, 0.45, 0.65, 0.85];
pub(crate) const SIGNED_STARTS: [f64; 4] = [-0.5, -0.12, 0.12, 0.5];
pub(crate) const FURTHER_STARTS: [f64; 2] = [0.2, 0.7];
/// Mean square relative to quantization above which no simulated recording of a model is at the noise floor, but where starts decide.
pub(crate) const FLOOR_WITHIN: f64 = 2.0;
/// Most samples of a window on either side: of ever finer sampling it would be quadratic.
pub(crate) const WINDOW_SAMPLES: f64 = 1000.0;

// Equation-error regression (`inverse`), which gives starts.
/// Largest quantization error of an acceleration, as a share of its size.
pub(crate) const ACCELERATION_NOISE: f64 = 0.1;
/// Half the narrowest window in samples, and the widest in s.
pub(crate) const NARROWEST_SAMPLES: f64 = 4.0;
pub(crate) const WIDEST_S: f64 = 0.5;
/// Fewest windows that determine anything: five for each coefficient.
pub(crate) const LEAST_ROWS: usize = 20;
/// Degrees of freedom of Student's weights, and how often they are found anew.
pub(crate) const WEIGHTS_FREEDOM: f64 = 3.0;
pub(crate) const REWEIGHTED: usize = 5;

// Experiments (`design`).
/// Most samples of a planned recording that is simulated, most sets that it is to separate, profiles tried with changes on the bench.
pub(crate) const PLANNED_SAMPLES: usize = 1_500;
pub(crate) const SETS_TO_SEPARATE: usize = 6;
pub(crate) const CHANGED_PROFILES: usize = 3;
