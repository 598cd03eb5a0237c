//! The unknown weighed again by what the best named set explains of data kept from the fit.
//!
//! The evidence asks which of some models is likelier; this asks whether the likeliest is any good. A set that closes little of
//! the gap leaves most of it to something else; one that closes nearly all of it is the cause, even if its law is not quite
//! the catalogue's and the recording has a glitch.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use super::rank::Ranking;
use super::verdict::Gap;

/// Share of the gap that a named cause closes at least, nats for each share that it falls short by, and the gap
/// in counts above the floor from which on that means anything.
const EXPLAINED: f64 = 0.6;
const UNEXPLAINED_NATS: f64 = 50.0;
/// From this share on a named cause is allowed a law that is not quite the catalogue's: up to so many nats.
const WELL_EXPLAINED: f64 = 0.95;
const OTHER_LAW_NATS: f64 = 15.0;
const JUDGED_COUNTS: f64 = 1.0;
/// From so many standard deviations on a normal distribution's tail is its Mills' ratio.
const FAR: f64 = 20.0;
/// More than this jumps do not count.
const MOST_NATS: f64 = 300.0;
/// How much further than by its standard deviation a sum of chances may wander.
const CHANCE: f64 = 2.0;

impl Ranking {
    /// Weighs the unknown against the named sets. `by_chance` in counts RMS is what the best set itself says that no model can
    /// predict: down to twice that it has explained what there is to explain, unless the angle jumps as no noise does.
    ///
    /// Gives by how many nats the unknown is likelier for that.
    pub fn judge(&mut self, gap: &Gap, by_chance: f64) -> f64 {
        let named = self
            .candidates
            .first()
            .is_some_and(|best| !best.effects.is_empty());
        if gap.before < gap.floor + JUDGED_COUNTS {
            return 0.0;
        }
        let short = if !named || is_chance(gap, by_chance) {
            0.0
        } else if gap.after_effect < gap.after_parameters {
            short_by(gap.closed, gap.closed_deviation)
        } else {
            // What predicts no better than the motor without it is not excused by numbers that are known badly.
            short_by(gap.closed, 0.0)
        };
        let well = ((gap.closed - WELL_EXPLAINED) / (1.0 - WELL_EXPLAINED)).clamp(0.0, 1.0);
        let jumped = (self.jumps * (1.0 - well)).min(MOST_NATS);
        // Edges lost by chance close no gap, and are no less the cause for that.
        let excused = if named && is_chance(gap, by_chance) {
            1.0
        } else {
            well
        };
        let nats = short + jumped - OTHER_LAW_NATS * excused;
        let more = nats.exp();
        let total = 1.0 + self.unknown * (more - 1.0);
        self.unknown *= more / total;
        for candidate in &mut self.candidates {
            candidate.probability /= total;
        }
        nats
    }
}

/// Whether what the best set leaves of kept data is no more than what it says that no model can predict.
fn is_chance(gap: &Gap, by_chance: f64) -> bool {
    gap.after_effect < CHANCE * by_chance
}

/// Whether the best set leaves nothing of kept data to explain: the encoder's floor and less than means anything, or what it
/// says that chance leaves.
pub(super) fn is_explained(gap: &Gap, by_chance: f64) -> bool {
    gap.after_effect < gap.floor + JUDGED_COUNTS || is_chance(gap, by_chance)
}

/// By how many nats a share of the gap as small as `closed` speaks for the unknown.
///
/// Shares of [`EXPLAINED`] and more are alike under a set that is the cause, smaller ones the less likely the smaller,
/// `f(x) = exp(-U (E - x))`. What was found is that share and an error of `deviation` s, so that its likelihood is
///
/// `(f * N)(c) = Phi(-d / s) + exp(-U d + U^2 s^2 / 2) Phi(d / s - U s)`,  `d = E - c`.
fn short_by(closed: f64, deviation: f64) -> f64 {
    let (u, d, s) = (UNEXPLAINED_NATS, EXPLAINED - closed, deviation);
    let Ok(normal) = Normal::new(0.0, s) else {
        return u * d.max(0.0);
    };
    let tail = u * s * s - d;
    let smaller = if tail > FAR * s {
        // Mills' ratio: Phi(-t) is phi(t) / t.
        s * s * normal.pdf(d) / tail
    } else {
        (-u * d + 0.5 * (u * s).powi(2)).exp() * normal.cdf(-tail)
    };
    -(normal.cdf(-d) + smaller).ln()
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Candidate;
    use super::super::samples::{
        gap, held_at, index, motor_with, problem, ranking, ready, recording,
    };
    use super::*;

    const STRIBECK: (&str, &[f64]) = ("stribeck", &[0.002, 0.5]);

    /// By how many nats the unknown gets likelier beside a set that leaves so many counts of a hundred, where refitting alone
    /// leaves 50 and the share closed is known to 0.4; `by_chance` is what the set says that no model can predict.
    fn nats(after_effect: f64, by_chance: f64) -> f64 {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let fit = held_at(&problem, &[STRIBECK]);
        let best = Candidate {
            effects: vec![index("stribeck")],
            fit,
            log_weight: 0.0,
            probability: 0.9,
        };
        let mut ranking = ranking(vec![best], 0.1);
        let gap = Gap {
            closed: 1.0 - after_effect / 100.0,
            closed_deviation: 0.4,
            ..gap(after_effect)
        };
        let nats = ranking.judge(&gap, by_chance);
        let best = ranking.candidates[0].probability;
        assert!((ranking.unknown + best - 1.0).abs() < 1e-12);
        assert!(((ranking.unknown / best).ln() - (1.0 / 9.0_f64).ln() - nats).abs() < 1e-9);
        nats
    }

    #[test]
    fn only_what_predicts_better_than_refitting_is_excused_by_what_is_not_known() {
        let nats = |after_effect| nats(after_effect, 0.0);
        assert!((0.0..1.0).contains(&nats(49.0)), "{}", nats(49.0));
        assert_eq!(nats(51.0), UNEXPLAINED_NATS * (EXPLAINED - 0.49));
        assert!((nats(0.0) + OTHER_LAW_NATS).abs() < 0.2, "{}", nats(0.0));
    }

    #[test]
    fn what_chance_leaves_is_excused_like_what_is_closed() {
        assert_eq!(nats(51.0, 26.0), -OTHER_LAW_NATS);
        assert!(nats(51.0, 25.0) > 0.0);
    }

    /// Against the integral of the likelihood over the error of the share, by the trapezoidal rule in steps of 1/2000 of a
    /// standard deviation.
    #[test]
    fn a_share_counts_by_its_likelihood_with_its_error() {
        for (closed, deviation) in [
            (0.42, 0.02),
            (0.42, 0.125),
            (0.0, 0.3),
            (0.55, 0.6),
            (0.9, 0.1),
        ] {
            const STEPS: i32 = 2000;
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in -12 * STEPS..=12 * STEPS {
                let z = f64::from(k) / f64::from(STEPS);
                let weight = (-0.5 * z * z).exp();
                let missing = (EXPLAINED - closed - deviation * z).max(0.0);
                sum += weight * (-UNEXPLAINED_NATS * missing).exp();
                weights += weight;
            }
            let (found, expected) = (short_by(closed, deviation), -(sum / weights).ln());
            assert!(
                (found - expected).abs() < 0.01,
                "{closed} {deviation}: {found}, {expected}"
            );
        }
    }

    #[test]
    fn a_share_that_is_known_counts_in_full() {
        assert!((short_by(0.4, 0.0) - 10.0).abs() < 1e-9);
        assert_eq!(short_by(0.7, 0.0), 0.0);
        assert!((short_by(0.4, 1e-6) - 10.0).abs() < 1e-3);
    }

    #[test]
    fn less_than_a_count_above_the_floor_and_what_chance_leaves_is_nothing_to_explain() {
        for (left, by_chance, expected) in [
            (1.2, 0.0, true),
            (1.4, 0.0, false),
            (50.0, 26.0, true),
            (50.0, 24.0, false),
        ] {
            let found = is_explained(&gap(left), by_chance);
            assert_eq!(found, expected, "{left} with {by_chance} by chance");
        }
    }
}
