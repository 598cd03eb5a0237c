//! What the best set so far leaves, and how much more searching that is worth.
//!
//! Two effects of the catalogue leave nothing once both are found, which a first round of growth nearly always does. What is outside
//! the catalogue goes to the strongest wander, or to edges lost by chance and samples taken late: these can stand for anything at
//! all, so that further effects have little to show for themselves, and what is said in the end is as a rule what single effects
//! said (counts: `docs/diagnosis.md`, section 5). So the first round has less work to spend then, and what follows
//! it is at most a third effect, or the effect beside such noise grown by itself.

use super::candidate::Candidate;
use super::effort::MOST;
use super::growth::Field;

/// Shares of the limit that a first round may go on to where there is little to find.
const WORTH_ASTRAY: f64 = 0.6;
const WORTH_COVERED_UP: f64 = 0.5;

/// How a search stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Outlook {
    /// The best set leaves nothing, or something that an effect may explain.
    #[default]
    Open,
    /// What it leaves went to the strongest wander.
    Astray,
    /// What it leaves went to noise of its own: edges lost by chance, samples taken late.
    CoveredUp,
}

impl Outlook {
    /// With this set as the best. Where work has no limit, or on pieces with the noise of a rough recording, it is always open.
    pub fn with(field: &Field<'_>, best: &Candidate) -> Self {
        let (problem, fit) = (field.problem, &best.fit);
        if problem.effort.is_unlimited() || problem.is_rough() || field.is_enough(best) {
            return Self::Open;
        }
        let strongest = problem.levels.first();
        if fit.hypothesis.noise_numbers().next().is_some() {
            Self::CoveredUp
        } else if strongest.is_some_and(|level| fit.wander >= *level) {
            Self::Astray
        } else {
            Self::Open
        }
    }

    /// The share of the limit up to which a first round of growth may go on.
    pub fn share(self) -> f64 {
        match self {
            Self::Open => MOST,
            Self::Astray => WORTH_ASTRAY,
            Self::CoveredUp => WORTH_COVERED_UP,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::effort::Effort;
    use super::super::samples::{fit, index, motor_with, problem, ready, recording};
    use super::*;

    #[test]
    fn a_right_set_is_open_what_went_to_the_wander_astray_and_what_went_to_noise_covered_up() {
        let gravity = ("gravity_load", &[0.05, 0.4][..]);
        let late = ("sample_jitter", &[2e-3][..]);
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&motor_with(&[gravity])));
        let outlook = |effort: Effort, effects: &[(&str, &[f64])]| {
            let problem = problem(&nominal, &runs).with_effort(&Arc::new(effort));
            let field = Field::new(&problem, &[]);
            let best = Candidate {
                effects: effects.iter().map(|(id, _)| index(id)).collect(),
                fit: fit(&problem, effects),
                log_weight: 0.0,
                probability: 0.0,
            };
            Outlook::with(&field, &best)
        };
        let limited = || Effort::limited_for(6500);
        assert_eq!(outlook(limited(), &[gravity]), Outlook::Open);
        assert_eq!(outlook(limited(), &[]), Outlook::Astray);
        assert_eq!(outlook(limited(), &[late]), Outlook::CoveredUp);
        assert_eq!(outlook(Effort::default(), &[]), Outlook::Open);
    }
}
