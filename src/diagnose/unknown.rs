//! A rival of every named effect: something that is not in the catalogue.
//!
//! Its model is the best named one plus an acceleration that nobody has written an equation for, a sum of the shapes of a
//! group (`shapes.rs`), each with a Gaussian prior, a large one or a small one. It is linear, and the named model gives way
//! linearly beside it, so that its evidence beside the named model's is in closed form (`marginal.rs`).
//! The load may wander as it likes with it: what the named model leaves to a strong wander, a shape with a weak one may
//! explain better.

use rayon::prelude::*;

use super::candidate::excess_wander;
use super::fit::Fit;
use super::levels::climb;
use super::marginal::{Beside, Named};
use super::oscillation::oscillation;
use super::problem::Problem;
use super::shapes::{Dependence, Gains, Group};
use super::ties::{left_after, whitened_difference};

/// What a flexible acceleration adds to a fit.
#[derive(Debug, Clone)]
pub(super) struct Flexible {
    /// Logarithm of the Bayes factor for the best group of columns against none.
    pub log_gain: f64,
    /// That group.
    pub group: Group,
    /// The likeliest size of its coefficients' prior.
    pub size: f64,
    /// The wander of the fit.
    pub wander: f64,
    /// Gain of what depends on each of speed, angle, time and command.
    pub gains: Vec<(Dependence, f64)>,
    /// The best of them for shapes of the largest size alone: whether much is left.
    pub gain_of_large: f64,
}

/// How much each kind of flexible acceleration would explain of what a fit leaves.
pub(super) fn flexible(problem: &Problem<'_>, fit: &Fit, largest_acceleration: f64) -> Flexible {
    let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let whiteners = problem.whiteners(&level);
    let residual = problem.innovations(fit);
    let named = problem
        .jacobian(&fit.hypothesis, &fit.p, &whiteners)
        .and_then(|jacobian| Named::new(fit, jacobian, &residual));
    let smooth = (Group::SMOOTH.into_par_iter().with_max_len(1)).map(|group| {
        let columns = group.columns(problem, &level, largest_acceleration);
        let beside = Beside::new(&residual, &columns, named.as_ref());
        Gains::of(group, |size| {
            beside.solved(size).map_or(0.0, |found| found.log_gain)
        })
    });
    let oscillating = || {
        oscillation(
            problem,
            &level,
            &residual,
            named.as_ref(),
            largest_acceleration,
        )
    };
    let (mut all, oscillating) = rayon::join(|| smooth.collect::<Vec<Gains>>(), oscillating);
    all.extend(oscillating);
    let best = all.iter().max_by(|a, b| a.log_gain.total_cmp(&b.log_gain));
    let of = |dependence: Dependence| {
        let own = all.iter().filter(|g| g.group.depends_on() == dependence);
        let gain = own.map(|g| g.log_gain).fold(f64::NEG_INFINITY, f64::max);
        (dependence, gain)
    };
    Flexible {
        log_gain: best.map_or(0.0, |best| best.log_gain),
        group: best.map_or(Group::Smooth(Dependence::Time), |best| best.group),
        size: best.map_or(1.0, |best| best.size),
        wander: fit.wander,
        gains: Dependence::ALL.map(of).to_vec(),
        gain_of_large: (all.iter()).fold(f64::NEG_INFINITY, |most, g| most.max(g.of_large)),
    }
}

/// The flexible acceleration that is likeliest with a wander of its own, and by how many nats it is likelier than the
/// named set's best fit: from that fit's own level to stronger and to weaker ones as long as it gets likelier.
pub(super) fn likeliest(problem: &Problem<'_>, best: &Fit, scale: f64) -> (Flexible, f64) {
    let own = flexible(problem, best, scale);
    // A named set pays for a wander that is not ordinary, the unknown does not.
    let excess = excess_wander(problem, best.wander, scale);
    let at = |level: usize| {
        let fit = problem.on_wander(best, problem.levels[level])?;
        let with = flexible(problem, &fit, scale);
        let gain = fit.log_evidence - best.log_evidence + with.log_gain + excess;
        Some((gain, with))
    };
    let first = problem.level_of(best.wander);
    let (own_gain, levels) = (own.log_gain + excess, problem.levels.len());
    let (mut stronger, mut weaker) = ((own_gain, own.clone()), (own_gain, own));
    rayon::join(
        || climb(&mut stronger, (0..first).rev(), at),
        || climb(&mut weaker, first + 1..levels, at),
    );
    let (gain, with) = if weaker.0 > stronger.0 {
        weaker
    } else {
        stronger
    };
    (with, gain)
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
    groups: &[Group],
    largest_acceleration: f64,
) -> Option<Flexed> {
    with_shapes(problem, fit, largest_acceleration, groups, 1.0)
}

impl Flexible {
    /// Every smooth group, and the oscillation where that is the likeliest.
    pub fn all_groups(&self) -> Vec<Group> {
        let mut all = Group::SMOOTH.to_vec();
        if !all.contains(&self.group) {
            all.push(self.group);
        }
        all
    }

    /// The named model's fit on the wander that suits the likeliest group of shapes, and what both leave; `best` is its fit
    /// on its own.
    pub fn beside(&self, problem: &Problem<'_>, best: &Fit, scale: f64) -> Option<(Fit, Flexed)> {
        let fit = problem.on_wander(best, self.wander)?;
        let with = with_shapes(problem, &fit, scale, &[self.group], self.size)?;
        Some((fit, with))
    }
}

fn with_shapes(
    problem: &Problem<'_>,
    fit: &Fit,
    largest_acceleration: f64,
    groups: &[Group],
    size: f64,
) -> Option<Flexed> {
    let level = problem.noise(&fit.hypothesis, &fit.p, fit.wander);
    let whiteners = problem.whiteners(&level);
    let residual = problem.innovations(fit);
    let jacobian = problem.jacobian(&fit.hypothesis, &fit.p, &whiteners)?;
    let named = Named::new(fit, jacobian, &residual)?;
    let all: Vec<Vec<f64>> = (groups.iter())
        .flat_map(|group| {
            group
                .columns(problem, &level, largest_acceleration)
                .to_vec()
        })
        .collect();
    let found = Beside::new(&residual, &all, Some(&named)).solved(size)?;
    Some(Flexed {
        log_gain: found.log_gain,
        residual: found.left(&residual, &all, Some(&named)),
    })
}

/// The separation of a set from a smaller one beside a flexible acceleration of every kind at once (`ties.rs`): what is left of
/// the difference of their predictions, in standard deviations of the noise, once that acceleration and the smaller set's
/// numbers have given way.
pub(super) fn separation_beside(
    problem: &Problem<'_>,
    set: &Fit,
    smaller: &Fit,
    groups: &[Group],
    largest_acceleration: f64,
) -> Option<f64> {
    let level = problem.noise(&set.hypothesis, &set.p, set.wander);
    let whiteners = problem.whiteners(&level);
    let mut all = problem.jacobian(&smaller.hypothesis, &smaller.p, &whiteners)?;
    let named = all.len();
    for group in groups {
        all.extend(
            group
                .columns(problem, &level, largest_acceleration)
                .to_vec(),
        );
    }
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
    use super::super::samples::{fit, motor_with, problem, ready, recording};
    use super::super::scales::largest_acceleration;
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
        let beside = separation_beside(&problem, &with, &without, &Group::SMOOTH, scale);
        let beside = beside.expect("solved");
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
}
