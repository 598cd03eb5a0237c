//! The verdict: what the probabilities and the floor come to, and how sure that is.
//!
//! What the floor hides is no gap, however significant: with many counts a turn everything is significant.

use super::Weights;
use super::causes::common;
use crate::diagnose::report::{Gap, Verdict};
use crate::diagnose::settings::PARTIAL_SURE;

/// A verdict with what it says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Said {
    pub verdict: Verdict,
    /// Probability of what it says.
    pub probability: f64,
    /// Effects that it names.
    pub effects: Vec<&'static str>,
    /// Whether it is the floor that says so, with something significant below it.
    pub is_by_floor: bool,
}

/// What is asked beside the probabilities.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    /// Probability that the nominal model, and that the refitted one, leave no more than the floor.
    pub below_floor: [f64; 2],
    /// Whether the refitted numbers are as the motor file's tolerances have them, so that no effect explains them better.
    pub are_numbers_plausible: bool,
    /// Whether the nominal model does as well as the refitted one.
    pub is_nominal_right: bool,
    /// Whether the runs are one piece, which shows nothing twice.
    pub is_one_piece: bool,
    /// Probability that what is named predicts no worse than without it.
    pub borne_out: f64,
    /// Probability that no known effect plays a part in what is unknown.
    pub without_any_known: f64,
    /// Nothing is said with more than this.
    pub most_sure: f64,
}

/// The verdict of a search that ended with `sets`, which are not told apart.
pub(crate) fn verdict(
    weights: &Weights,
    sets: &[Vec<&'static str>],
    gap: &Gap,
    asked: Asked,
) -> Said {
    let said = |verdict: Verdict, probability: f64, effects: Vec<&'static str>| Said {
        verdict,
        probability: probability.min(asked.most_sure),
        effects,
        is_by_floor: false,
    };
    let by_floor = |verdict: Verdict, probability: f64| Said {
        is_by_floor: true,
        ..said(verdict, probability, Vec::new())
    };
    let outside = || {
        let alone = weights.unknown * asked.without_any_known;
        said(Verdict::OutsideCatalogue, alone, Vec::new())
    };
    let is_something = !sets.is_empty() || weights.unknown > weights.none;
    if is_something && gap.before <= gap.floor {
        return by_floor(Verdict::NoGap, asked.below_floor[0]);
    }
    if is_something && asked.are_numbers_plausible && gap.after_parameters <= gap.floor {
        return by_floor(Verdict::Parameters, asked.below_floor[1]);
    }
    match sets {
        [] if weights.unknown > weights.none => outside(),
        [] if asked.is_nominal_right => said(Verdict::NoGap, weights.none, Vec::new()),
        [] => said(Verdict::Parameters, weights.none, Vec::new()),
        // What predicts no better than nothing is no part of it.
        _ if weights.unknown > 0.5 && asked.borne_out < 0.5 => outside(),
        sets if weights.unknown > 0.5 => {
            let there = match sets {
                [set] => weights.inclusion(set),
                sets => weights.of(sets) / (1.0 - weights.unknown).max(f64::MIN_POSITIVE),
            };
            let there = (there * asked.borne_out).min(PARTIAL_SURE);
            said(Verdict::Partial, there, common(sets))
        }
        // What is asserted is likelier than not.
        [set] if !asked.is_one_piece && weights.of(sets) > 0.5 => {
            said(Verdict::Effect, weights.of(sets), set.clone())
        }
        sets => said(Verdict::Ambiguous, weights.of(sets), Vec::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::conclusion::samples::gap;

    const A: &str = "dead_zone";
    const B: &str = "stribeck";
    const ASKED: Asked = Asked {
        below_floor: [0.97, 0.96],
        are_numbers_plausible: true,
        is_nominal_right: false,
        is_one_piece: false,
        borne_out: 1.0,
        without_any_known: 1.0,
        most_sure: 1.0,
    };

    fn weights(none: f64, unknown: f64, sets: &[(&[&'static str], f64)]) -> Weights {
        let sets = sets
            .iter()
            .map(|(set, share)| (set.to_vec(), *share))
            .collect();
        Weights {
            none,
            unknown,
            sets,
        }
    }

    fn of(
        weights: &Weights,
        sets: &[&[&'static str]],
        gap: &Gap,
        asked: Asked,
    ) -> (Verdict, f64, usize) {
        let sets: Vec<Vec<&'static str>> = sets.iter().map(|set| set.to_vec()).collect();
        let said = verdict(weights, &sets, gap, asked);
        (
            said.verdict,
            (said.probability * 1e6).round() / 1e6,
            said.effects.len(),
        )
    }

    #[test]
    fn each_verdict_has_its_probability() {
        let nothing = weights(0.95, 0.05, &[]);
        let right = Asked {
            is_nominal_right: true,
            ..ASKED
        };
        let wide = gap([9.0, 5.0, 0.4], 0.3);
        assert_eq!(of(&nothing, &[], &wide, right), (Verdict::NoGap, 0.95, 0));
        assert_eq!(
            of(&nothing, &[], &wide, ASKED),
            (Verdict::Parameters, 0.95, 0)
        );
        let outside = weights(0.1, 0.9, &[]);
        assert_eq!(
            of(&outside, &[], &wide, right),
            (Verdict::OutsideCatalogue, 0.9, 0)
        );
        let promising = Asked {
            without_any_known: 0.5,
            ..right
        };
        assert_eq!(
            of(&outside, &[], &wide, promising),
            (Verdict::OutsideCatalogue, 0.45, 0)
        );
        let one = weights(0.0, 0.1, &[(&[A], 0.8), (&[A, B], 0.1)]);
        assert_eq!(of(&one, &[&[A]], &wide, ASKED), (Verdict::Effect, 0.8, 1));
        assert_eq!(
            of(&one, &[&[A, B]], &wide, ASKED),
            (Verdict::Ambiguous, 0.1, 0)
        );
        let two = weights(0.0, 0.1, &[(&[A], 0.5), (&[B], 0.4)]);
        assert_eq!(
            of(&two, &[&[A], &[B]], &wide, ASKED),
            (Verdict::Ambiguous, 0.9, 0)
        );
        let more = weights(0.0, 0.6, &[(&[A], 0.2), (&[A, B], 0.1), (&[B], 0.1)]);
        assert_eq!(
            of(&more, &[&[A]], &wide, ASKED),
            (Verdict::Partial, 0.75, 1)
        );
        assert_eq!(
            of(&more, &[&[A], &[B]], &wide, ASKED),
            (Verdict::Partial, 0.75, 0)
        );
        let worse = Asked {
            borne_out: 0.4,
            ..ASKED
        };
        assert_eq!(
            of(&more, &[&[A]], &wide, worse),
            (Verdict::OutsideCatalogue, 0.6, 0)
        );
        let few = Asked {
            most_sure: 0.9,
            is_one_piece: true,
            ..ASKED
        };
        let sure = weights(0.0, 0.05, &[(&[A], 0.95)]);
        assert_eq!(of(&sure, &[&[A]], &wide, few), (Verdict::Ambiguous, 0.9, 0));
    }

    /// Below the floor nothing is a gap, however significant.
    #[test]
    fn the_floor_comes_first() {
        let sure = weights(0.0, 0.01, &[(&[A], 0.99)]);
        let [below, between, above] = [
            gap([2.0, 1.5, 0.4], 3.0),
            gap([9.0, 1.5, 0.4], 3.0),
            gap([9.0, 5.0, 0.4], 3.0),
        ];
        assert_eq!(of(&sure, &[&[A]], &below, ASKED), (Verdict::NoGap, 0.97, 0));
        assert_eq!(
            of(&sure, &[&[A]], &between, ASKED),
            (Verdict::Parameters, 0.96, 0)
        );
        assert_eq!(
            of(&sure, &[&[A]], &above, ASKED),
            (Verdict::Effect, 0.99, 1)
        );
    }
}
