//! A rival of every named effect: something that is not in the catalogue.
//!
//! Its model is the best named one plus an acceleration that nobody has written an equation for, a sum of
//! bumps over speed, harmonics of the angle, slow waves of time and shapes of the command, each with a
//! Gaussian prior of variance 1 in its unit, a large one or a small one ([`SIZES`]). It is linear, and the named model gives
//! way linearly beside it (columns `J`, prior `P`), so that its evidence beside the named model's is
//! `ln B = 1/2 b' S^-1 b - 1/2 ln|S|`, `S = C'C + I - C'J (J'J + P)^-1 J'C`, `b = C'(r - J dp)`, with the whitened columns
//! `C` and the step `dp = (J'J + P)^-1 (J'r - P (p - c))` that the named model would still take itself, none at its optimum.
//! The load may wander as it likes with it: what the named model leaves to a strong wander, a shape with a weak one may
//! explain better.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use rayon::prelude::*;

use super::candidate::excess_wander;
use super::data::RunData;
use super::fit::{Fit, Problem, normal_equations};
use super::noise::{Carried, Response, Whitener};
use super::sums::{dot, gram};
use super::ties::{left_after, whitened_difference};

/// On what the columns of a group depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dependence {
    /// Speed.
    Speed,
    /// Angle.
    Angle,
    /// Time.
    Time,
    /// Command.
    Command,
}

impl Dependence {
    const ALL: [Self; 4] = [Self::Speed, Self::Angle, Self::Time, Self::Command];

    /// The stage that an acceleration which depends on this points to.
    pub fn stage(self) -> &'static str {
        match self {
            Self::Speed | Self::Angle => "mechanical",
            Self::Time => "electrical",
            Self::Command => "driver",
        }
    }

    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Angle => "angle",
            Self::Time => "time",
            Self::Command => "voltage",
        }
    }
}

/// What a flexible acceleration adds to a fit.
#[derive(Debug, Clone)]
pub(super) struct Flexible {
    /// Logarithm of the Bayes factor for the best group of columns against none.
    pub log_gain: f64,
    /// On what that group depends.
    pub depends_on: Dependence,
    /// The likeliest size of its coefficients' prior.
    pub size: f64,
    /// The wander of the fit.
    pub wander: f64,
    /// Gain of each group.
    pub gains: Vec<(Dependence, f64)>,
    /// The best of them for shapes of the largest size alone: whether much is left.
    pub gain_of_large: f64,
}

/// Standard deviation of each column's coefficient, as a share of the largest acceleration.
const PRIOR_SHARE: f64 = 0.03;
/// How much smaller it may be besides, one as plausible as the other.
const SIZES: [f64; 3] = [1.0, 0.2, 0.04];

/// How much each kind of flexible acceleration would explain of what a fit leaves.
pub(super) fn flexible(problem: &Problem<'_>, fit: &Fit, largest_acceleration: f64) -> Flexible {
    let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let whiteners = problem.whiteners(&level);
    let residual = problem.innovations(fit);
    let named = problem
        .jacobian(&fit.hypothesis, &fit.p, &whiteners)
        .and_then(|jacobian| Named::new(fit, jacobian, &residual));
    let by_size: Vec<(Dependence, [f64; SIZES.len()])> = Dependence::ALL
        .into_par_iter()
        .with_max_len(1)
        .map(|dependence| {
            let columns = columns(problem, &whiteners, dependence, largest_acceleration);
            let beside = Beside::new(&residual, &columns, named.as_ref());
            let gain = |size| beside.solved(size).map_or(0.0, |found| found.log_gain);
            (dependence, SIZES.map(gain))
        })
        .collect();
    // The likeliest size for all, at the price of the choice.
    let likeliest: Vec<(Dependence, f64, f64)> = (by_size.iter())
        .map(|(dependence, gains)| {
            let by_size = SIZES.into_iter().zip(gains.iter().copied());
            let (size, gain) =
                by_size.fold(
                    (1.0, f64::NEG_INFINITY),
                    |a, b| {
                        if b.1 > a.1 { b } else { a }
                    },
                );
            (*dependence, size, gain - (SIZES.len() as f64).ln())
        })
        .collect();
    let of_large = by_size.iter().map(|(_, gains)| gains[0]);
    let best = likeliest.iter().copied().max_by(|a, b| a.2.total_cmp(&b.2));
    let (depends_on, size, log_gain) = best.unwrap_or((Dependence::Time, 1.0, 0.0));
    Flexible {
        log_gain,
        depends_on,
        size,
        wander: fit.wander,
        gains: likeliest.iter().map(|(on, _, gain)| (*on, *gain)).collect(),
        gain_of_large: of_large.fold(f64::NEG_INFINITY, f64::max),
    }
}

/// The flexible acceleration that is likeliest with a wander of its own, and by how many nats it is likelier than the
/// named set's best fit.
pub(super) fn likeliest(problem: &Problem<'_>, best: &Fit, scale: f64) -> (Flexible, f64) {
    let own = flexible(problem, best, scale);
    // A named set pays for a wander that is not ordinary, the unknown does not.
    let excess = excess_wander(problem, best.wander, scale);
    let gain = own.log_gain + excess;
    let others = problem
        .levels
        .par_iter()
        .filter(|level| **level != best.wander);
    others
        .filter_map(|&level| {
            let fit = problem.on_wander(best, level)?;
            let with = flexible(problem, &fit, scale);
            let gain = fit.log_evidence - best.log_evidence + with.log_gain + excess;
            Some((with, gain))
        })
        .collect::<Vec<_>>()
        .into_iter()
        .fold((own, gain), |a, b| if b.1 > a.1 { b } else { a })
}

fn shapes(dependence: Dependence) -> usize {
    match dependence {
        Dependence::Speed => 10,
        Dependence::Angle => 12,
        Dependence::Time => 12,
        Dependence::Command => 4,
    }
}

/// Shape `j` of a dependence at sample `k`, of size about 1.
fn shape(dependence: Dependence, j: usize, run: &RunData, k: usize) -> f64 {
    match dependence {
        Dependence::Speed => {
            let x = run.speed_counts_s[k] / run.top_speed_counts_s;
            // Closer together near standstill, where friction has its features.
            const CENTRES: [f64; 10] = [-1.0, -0.5, -0.2, -0.07, -0.02, 0.02, 0.07, 0.2, 0.5, 1.0];
            let centre = CENTRES[j];
            let width = 0.5 * f64::abs(centre) + 0.02;
            (-0.5 * ((x - centre) / width).powi(2)).exp()
        }
        Dependence::Angle => {
            let counts = run.first_counts + run.counts[k];
            let angle = counts * std::f64::consts::TAU / run.counts_per_rev;
            let order = (j / 2 + 1) as f64;
            if j.is_multiple_of(2) {
                (order * angle).sin()
            } else {
                (order * angle).cos()
            }
        }
        Dependence::Time => {
            let x = run.t_s[k] / run.t_s.last().copied().unwrap_or(1.0).max(1e-9);
            let direction = run.speed_counts_s[k].signum();
            // What a torque constant or a resistance that drifts does goes with the command and the speed.
            if let Some(drift) = j.checked_sub(8) {
                let wave = ((drift / 2 + 1) as f64 * std::f64::consts::PI * x).cos();
                return wave
                    * if drift.is_multiple_of(2) {
                        run.command[k] / run.largest_command
                    } else {
                        run.speed_counts_s[k] / run.top_speed_counts_s
                    };
            }
            let wave = ((j / 2 + 1) as f64 * std::f64::consts::PI * x).cos();
            if j.is_multiple_of(2) {
                wave
            } else {
                wave * direction
            }
        }
        Dependence::Command => {
            let x = run.command[k] / run.largest_command;
            match j {
                0 => x * x.abs(),
                1 => x.powi(3),
                2 => x.signum() * f64::from(u8::from(x != 0.0)),
                _ => x.abs(),
            }
        }
    }
}

/// The columns of the named model, the factors of `J'J + P`, and the step to its optimum.
struct Named {
    jacobian: Vec<Vec<f64>>,
    factors: Cholesky<f64, Dyn>,
    step: DVector<f64>,
}

impl Named {
    /// Of a fit that leaves `r`. Numbers that stand beyond the edge of their range give way little against it.
    fn new(fit: &Fit, jacobian: Vec<Vec<f64>>, r: &[f64]) -> Option<Self> {
        let (_, slope) = normal_equations(&fit.hypothesis, &jacobian, r, &fit.p);
        let edge = |k: usize| {
            let (outside, edge) = fit.hypothesis.outside(k, &fit.p);
            if outside == 0.0 {
                0.0
            } else {
                1.0 / (edge * edge)
            }
        };
        let normal = gram(&jacobian, |i, j| {
            fit.hypothesis.precision(i, j) + if i == j { edge(i) } else { 0.0 }
        });
        let factors = normal.cholesky()?;
        Some(Self {
            step: factors.solve(&slope),
            factors,
            jacobian,
        })
    }
}

/// What columns come to beside a named model.
struct Solved {
    /// Logarithm of the Bayes factor against none of them.
    log_gain: f64,
    /// Their likeliest coefficients.
    coefficients: DVector<f64>,
    /// By how much the numbers of the named model give way.
    given_way: Option<DVector<f64>>,
}

/// Columns beside a named model, which goes to its own optimum first.
struct Beside<'a> {
    /// `C'C - C'J (J'J + P)^-1 J'C`.
    shared: DMatrix<f64>,
    b: DVector<f64>,
    named: Option<(&'a Named, DMatrix<f64>)>,
}

impl<'a> Beside<'a> {
    fn new(r: &[f64], columns: &[Vec<f64>], named: Option<&'a Named>) -> Self {
        let mut shared = gram(columns, |_, _| 0.0);
        let mut b = DVector::from_fn(columns.len(), |k, _| dot(&columns[k], r));
        let named = named.map(|named| {
            let cross = DMatrix::from_fn(named.jacobian.len(), columns.len(), |i, j| {
                dot(&named.jacobian[i], &columns[j])
            });
            let answer = named.factors.solve(&cross);
            shared -= cross.transpose() * &answer;
            b -= cross.transpose() * &named.step;
            (named, answer)
        });
        Self { shared, b, named }
    }

    /// With a prior of this size.
    fn solved(&self, size: f64) -> Option<Solved> {
        let n = self.b.len();
        let schur = &self.shared * (size * size) + DMatrix::identity(n, n);
        let cholesky = schur.cholesky()?;
        let half_log_determinant: f64 = cholesky.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
        let coefficients = cholesky.solve(&self.b) * (size * size);
        let given_way =
            |(named, answer): &(&Named, DMatrix<f64>)| &named.step - answer * &coefficients;
        Some(Solved {
            log_gain: 0.5 * coefficients.dot(&self.b) - half_log_determinant,
            given_way: self.named.as_ref().map(given_way),
            coefficients,
        })
    }
}

/// Whitened answers of the runs to each shape of an acceleration that depends on this.
fn columns(
    problem: &Problem<'_>,
    whiteners: &[Whitener],
    dependence: Dependence,
    largest_acceleration: f64,
) -> Vec<Vec<f64>> {
    let count = shapes(dependence);
    let mut columns = vec![Vec::new(); count];
    let mut carried = vec![Carried::default(); count];
    let responses = Response::all(problem.runs, problem.damping);
    for ((run, response), whitener) in problem.runs.iter().zip(&responses).zip(whiteners) {
        for (j, (all, carried)) in columns.iter_mut().zip(&mut carried).enumerate() {
            let acceleration: Vec<f64> = (0..run.len())
                .map(|k| largest_acceleration * PRIOR_SHARE * shape(dependence, j, run, k))
                .collect();
            let mut column = response.to(&acceleration);
            whitener.whiten_on(carried, &mut column);
            all.extend(column);
        }
    }
    columns
}

/// A fit with a flexible acceleration beside it.
#[derive(Debug, Clone)]
pub(super) struct Flexed {
    /// Logarithm of the Bayes factor against the fit alone.
    pub log_gain: f64,
    /// What both together leave, whitened, run by run end to end.
    pub residual: Vec<f64>,
}

/// A fit beside a flexible acceleration that depends on speed, angle, time and command at once; `None` where that cannot be
/// solved.
pub(super) fn flexed(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
) -> Option<Flexed> {
    with_shapes(problem, fit, largest_acceleration, &Dependence::ALL, 1.0)
}

impl Flexible {
    /// The named model's fit on the wander that suits the likeliest group of shapes, and what both leave; `best` is its fit
    /// on its own.
    pub fn beside(&self, problem: &Problem<'_>, best: &Fit, scale: f64) -> Option<(Fit, Flexed)> {
        let fit = problem.on_wander(best, self.wander)?;
        let with = with_shapes(problem, &fit, scale, &[self.depends_on], self.size)?;
        Some((fit, with))
    }
}

fn with_shapes(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
    dependences: &[Dependence],
    size: f64,
) -> Option<Flexed> {
    let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let whiteners = problem.whiteners(&level);
    let mut residual = problem.innovations(fit);
    let jacobian = problem.jacobian(&fit.hypothesis, &fit.p, &whiteners)?;
    let named = Named::new(fit, jacobian, &residual)?;
    let all: Vec<Vec<f64>> = (dependences.iter())
        .flat_map(|&dependence| columns(problem, &whiteners, dependence, largest_acceleration))
        .collect();
    let found = Beside::new(&residual, &all, Some(&named)).solved(size)?;
    let mut take = |columns: &[Vec<f64>], by: &DVector<f64>| {
        for (column, share) in columns.iter().zip(by.iter()) {
            for (left, x) in residual.iter_mut().zip(column) {
                *left -= share * x;
            }
        }
    };
    take(&all, &found.coefficients);
    if let Some(given_way) = &found.given_way {
        take(&named.jacobian, given_way);
    }
    Some(Flexed {
        log_gain: found.log_gain,
        residual,
    })
}

/// The separation of a set from a smaller one beside a flexible acceleration of every kind at once (`ties.rs`): what is left of
/// the difference of their predictions, in standard deviations of the noise, once that acceleration and the smaller set's
/// numbers have given way.
pub(super) fn separation_beside(
    problem: &Problem<'_>,
    set: &Fit,
    smaller: &Fit,
    largest_acceleration: f64,
) -> Option<f64> {
    let level = problem.noise(&set.hypothesis, &set.p, set.wander);
    let whiteners = problem.whiteners(&level);
    let mut all = problem.jacobian(&smaller.hypothesis, &smaller.p, &whiteners)?;
    let named = all.len();
    let flexible = Dependence::ALL
        .into_iter()
        .flat_map(|dependence| columns(problem, &whiteners, dependence, largest_acceleration));
    all.extend(flexible);
    let difference = whitened_difference(set, smaller, &whiteners);
    left_after(&difference, &all, |i, j| {
        if i < named && j < named {
            smaller.hypothesis.precision(i, j)
        } else {
            f64::from(u8::from(i == j))
        }
    })
}

#[cfg(test)]
mod tests {
    use std::ops::Mul;

    use super::super::samples::{fit, motor_with, problem, ready, recording};
    use super::super::search::largest_acceleration;
    use super::super::ties::separation;
    use super::*;

    /// How far a set with this effect is from none, and what is left of that beside a flexible acceleration.
    fn separations(effect: (&str, &[f64])) -> (f64, f64) {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[effect])));
        let problem = problem(&nominal, &runs);
        let (with, without) = (fit(&problem, &[effect]), fit(&problem, &[]));
        let scale = largest_acceleration(&nominal, &runs);
        let alone = separation(&problem, &with, &without).expect("solved");
        let beside = separation_beside(&problem, &with, &without, scale).expect("solved");
        (alone, beside)
    }

    /// Friction by direction is a function of signed speed, as the bumps are; a cogging of 13 a turn is no harmonic of theirs.
    #[test]
    fn what_the_shapes_can_do_is_near_and_what_they_cannot_do_is_far() {
        let (alone, beside) = separations(("asymmetric_friction", &[0.3]));
        assert!(beside < 0.2 * alone, "{beside} of {alone}");
        let (alone, beside) = separations(("cogging", &[3e-4, 13.0, 0.5]));
        assert!(beside > 0.8 * alone, "{beside} of {alone}");
    }

    /// Logarithm of a Gaussian density with mean nought, from its covariance.
    fn log_density(r: &[f64], covariance: DMatrix<f64>) -> f64 {
        let r = DVector::from_column_slice(r);
        let log_determinant = covariance.determinant().ln();
        let squares = r.dot(&covariance.try_inverse().expect("regular").mul(&r));
        -0.5 * (squares + log_determinant)
    }

    /// Of a linear model the Bayes factor is that of two Gaussian densities of the data with everything marginalised, from
    /// wherever the named model's numbers start and whatever the size of the columns' prior.
    #[test]
    fn the_gain_is_that_of_the_marginal_densities() {
        const SIZE: f64 = 0.3;
        let n = 12;
        let wave = |k: f64| (0..n).map(|i| (k * i as f64).sin()).collect::<Vec<f64>>();
        let (jacobian, columns) = (
            vec![wave(0.3), wave(0.9)],
            vec![wave(0.5), wave(1.7), wave(2.6)],
        );
        let r: Vec<f64> = (0..n).map(|i| 3.0 * (0.4 * i as f64).cos() + 0.2).collect();
        let precision = 4.0;
        let normal = gram(&jacobian, |i, j| if i == j { precision } else { 0.0 });
        let factors = normal.cholesky().expect("regular");
        let slope = DVector::from_fn(2, |i, _| dot(&jacobian[i], &r));
        let spread = |columns: &[Vec<f64>], variance: f64| {
            DMatrix::from_fn(n, n, |i, k| {
                variance * columns.iter().map(|c| c[i] * c[k]).sum::<f64>()
            })
        };
        let named = DMatrix::identity(n, n) + spread(&jacobian, 1.0 / precision);
        let expected =
            log_density(&r, &named + spread(&columns, SIZE * SIZE)) - log_density(&r, named);
        let named = Named {
            step: factors.solve(&slope),
            jacobian,
            factors,
        };
        let found = Beside::new(&r, &columns, Some(&named)).solved(SIZE);
        let gain = found.expect("solved").log_gain;
        assert!((gain - expected).abs() < 1e-9, "{gain} {expected}");
    }
}
