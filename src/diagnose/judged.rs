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

/// How many times as much as the motor refitted alone a set leaves of kept data that these refute.
const REFUTED: f64 = 2.0;

impl Ranking {
    /// Weighs the unknown against the named sets. `by_chance` in counts RMS is what the best set itself says that no model can
    /// predict: down to twice that it has explained what there is to explain, unless the angle jumps as no noise does.
    pub fn judge(&mut self, gap: &Gap, by_chance: f64) {
        let named = self
            .candidates
            .first()
            .is_some_and(|best| !best.effects.is_empty());
        if gap.before < gap.floor + JUDGED_COUNTS {
            return;
        }
        let is_chance = !named || gap.after_effect < CHANCE * by_chance;
        let short = if is_chance {
            0.0
        } else if is_refuted(gap) {
            short_by(gap.closed, 0.0)
        } else {
            short_by(gap.closed, gap.closed_deviation)
        };
        let well = ((gap.closed - WELL_EXPLAINED) / (1.0 - WELL_EXPLAINED)).clamp(0.0, 1.0);
        let jumped = (self.jumps * (1.0 - well)).min(MOST_NATS);
        let more = (short + jumped - OTHER_LAW_NATS * well).exp();
        let total = 1.0 + self.unknown * (more - 1.0);
        self.unknown *= more / total;
        for candidate in &mut self.candidates {
            candidate.probability /= total;
        }
    }
}

/// Whether the best set leaves so much more of kept data than the motor refitted alone that it is no part of what is there.
/// That its numbers are known badly is no excuse then: those without the effects are among them.
pub(super) fn is_refuted(gap: &Gap) -> bool {
    gap.after_effect > REFUTED * gap.after_parameters
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
    use super::*;

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
}
