//! The verdict: a pure function of the error budget and the posterior.

use super::classes::{class_of, members_of};
use super::relevance::exceeds;
use super::report::Verdict;
use super::settings::Settings;

/// A set of effects with its posterior probability.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weighed {
    pub ids: Vec<&'static str>,
    pub probability: f64,
    /// Members with a parameter at a bound of its range.
    pub at_bound: Vec<&'static str>,
}

/// An identified effect, or a class that stands for one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Identified {
    /// The effect, or the most probable member of the class.
    pub effect: &'static str,
    /// The class, where its members are not separated.
    pub class: Option<&'static str>,
    pub probability: f64,
}

/// Probability that one of some effects is present.
pub(crate) fn inclusion(sets: &[Weighed], ids: &[&str]) -> f64 {
    let with = |set: &&Weighed| set.ids.iter().any(|id| ids.contains(id));
    total(sets.iter().filter(with))
}

/// Sum of probabilities, which rounding takes neither below 0 nor above 1.
fn total<'a>(sets: impl Iterator<Item = &'a Weighed>) -> f64 {
    let sum = sets.fold(0.0, |sum, set| sum + set.probability);
    f64::min(sum, 1.0)
}

/// Effects and classes that are identified, by probability.
pub(crate) fn identified(sets: &[Weighed], settings: &Settings) -> Vec<Identified> {
    let mut ids: Vec<&'static str> = sets.iter().flat_map(|set| set.ids.clone()).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.sort_by(|a, b| inclusion(sets, &[b]).total_cmp(&inclusion(sets, &[a])));
    let mut found: Vec<Identified> = Vec::new();
    for effect in ids {
        let own = inclusion(sets, &[effect]);
        let class = class_of(effect);
        let is_counted = |other: &Identified| class.is_some() && class_of(other.effect) == class;
        if found.iter().any(is_counted) && own < settings.identified {
            continue;
        }
        let of_class = class.map_or(own, |class| inclusion(sets, members_of(class)));
        let is_separated = own >= settings.confident * of_class || found.iter().any(is_counted);
        let probability = if is_separated { own } else { of_class };
        let one = [effect];
        let counted = match class.filter(|_| !is_separated) {
            Some(class) => members_of(class),
            None => &one,
        };
        let bounded = probability_at_bound(sets, counted);
        if probability - bounded < settings.identified {
            continue;
        }
        found.push(Identified {
            effect,
            class: class.filter(|_| !is_separated),
            probability,
        });
        // Effects that exclude each other are not named together.
        if joint(sets, &found) < settings.identified {
            found.pop();
        }
    }
    found
}

/// Probability that one of some effects is present with its parameter at a bound.
fn probability_at_bound(sets: &[Weighed], ids: &[&str]) -> f64 {
    let bounded = |set: &&Weighed| set.at_bound.iter().any(|id| ids.contains(id));
    total(sets.iter().filter(bounded))
}

/// Probability that all identified effects, or members of their classes, are present.
pub(crate) fn joint(sets: &[Weighed], identified: &[Identified]) -> f64 {
    let has = |set: &Weighed, one: &Identified| match one.class {
        Some(class) => set.ids.iter().any(|id| members_of(class).contains(id)),
        None => set.ids.contains(&one.effect),
    };
    total(
        sets.iter()
            .filter(|set| identified.iter().all(|one| has(set, one))),
    )
}

/// Evidence for a verdict. Shares are of the nominal reducible squared error, held out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence<'a> {
    /// Whether the nominal model is within the noise floor.
    pub is_nominal_at_floor: bool,
    /// Removed by re-identified parameters.
    pub parameters: f64,
    /// Left by re-identified parameters.
    pub beyond_parameters: f64,
    /// Left; 0 within the noise floor.
    pub unexplained: f64,
    pub identified: &'a [Identified],
    /// Probability that no effect is present.
    pub none: f64,
    /// Of a comparison with reference runs, whether re-identified parameters leave no more than the reference leaves in its own runs.
    pub is_as_reference: Option<bool>,
}

/// The verdict on runs without a fatal finding (contract).
pub(crate) fn verdict(evidence: &Evidence, settings: &Settings) -> Verdict {
    let Evidence { none, .. } = *evidence;
    let verdict = verdict_of_runs(evidence, settings);
    let Some(is_as_reference) = evidence.is_as_reference else {
        return verdict;
    };
    match verdict {
        Verdict::Parameters if none < settings.identified => Verdict::Ambiguous,
        Verdict::NoGap | Verdict::Parameters => Verdict::NoChange,
        // Error that is unexplained in the reference runs is no change either.
        Verdict::OutsideCatalogue if none >= settings.confident || is_as_reference => {
            Verdict::NoChange
        }
        other => other,
    }
}

fn verdict_of_runs(evidence: &Evidence, settings: &Settings) -> Verdict {
    if evidence.is_nominal_at_floor {
        return Verdict::NoGap;
    }
    if !evidence.identified.is_empty() {
        return match evidence.unexplained < settings.unexplained_share {
            true => Verdict::Effect,
            false => Verdict::Partial,
        };
    }
    // The residual of re-identified parameters is as small as that of an identified effect may be.
    let is_little_left = evidence.beyond_parameters < settings.unexplained_share;
    if is_little_left && evidence.parameters > 0.0 {
        return Verdict::Parameters;
    }
    if evidence.none < settings.identified {
        return Verdict::Ambiguous;
    }
    match evidence.unexplained <= settings.parameters_share {
        true => Verdict::Parameters,
        false => Verdict::OutsideCatalogue,
    }
}

/// The probability of what a verdict says (contract): that the identified effects are present, that any is, or that none is.
pub(crate) fn probability(
    verdict: Verdict,
    sets: &[Weighed],
    identified: &[Identified],
    none: f64,
) -> f64 {
    match verdict {
        Verdict::Effect | Verdict::Partial => joint(sets, identified),
        Verdict::Ambiguous => 1.0 - none,
        _ => none,
    }
}

/// The last of some effects that removes no more than this share of the held-out error that is left before it: of each the share that it
/// removes and the share that was left before it.
pub(crate) fn immaterial(effects: &[(f64, f64)], least: f64) -> Option<usize> {
    let is_immaterial = |(removed, left): &(f64, f64)| *removed <= least * left;
    effects.iter().rposition(is_immaterial)
}

/// The last effect that adds to the held-out mean square of the model that it extends, or to the noise floor in counts RMS, by more than
/// their sampling error. Nested models: nominal, re-identified parameters, with one effect after the other.
pub(crate) fn adds_error(
    squares: &[f64],
    floors: &[f64],
    n_eff: f64,
    settings: &Settings,
) -> Option<usize> {
    let adds = |m: usize| {
        let before = squares[m - 1].max(floors[m].powi(2));
        exceeds(squares[m], before, n_eff, settings)
    };
    (2..squares.len()).rposition(adds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(ids: &[&'static str], probability: f64) -> Weighed {
        Weighed {
            ids: ids.to_vec(),
            probability,
            at_bound: Vec::new(),
        }
    }

    #[test]
    fn the_table_of_verdicts() {
        let settings = Settings::default();
        let named = [Identified {
            effect: "stribeck",
            class: None,
            probability: 0.9,
        }];
        let shares = |parameters: f64, effects: f64| Evidence {
            is_nominal_at_floor: false,
            parameters,
            beyond_parameters: 1.0 - parameters,
            unexplained: 1.0 - parameters - effects,
            identified: &[],
            none: 0.0,
            is_as_reference: None,
        };
        let at_floor = Evidence {
            is_nominal_at_floor: true,
            ..shares(0.0, 0.0)
        };
        let (outside, changed) = (Verdict::OutsideCatalogue, Verdict::Ambiguous);
        // The verdict of runs alone, beside a reference that leaves as much, and beside one that leaves less.
        for (budget, identified, none, expected) in [
            (
                at_floor,
                &named[..],
                0.0,
                [Verdict::NoGap, Verdict::NoChange, Verdict::NoChange],
            ),
            (shares(0.3, 0.65), &named, 0.1, [Verdict::Effect; 3]),
            (shares(0.3, 0.5), &named, 0.1, [Verdict::Partial; 3]),
            (
                shares(0.95, 0.0),
                &[],
                0.9,
                [Verdict::Parameters, Verdict::NoChange, Verdict::NoChange],
            ),
            (
                shares(0.2, 0.0),
                &[],
                0.9,
                [outside, Verdict::NoChange, Verdict::NoChange],
            ),
            (
                shares(0.2, 0.0),
                &[],
                0.6,
                [outside, Verdict::NoChange, outside],
            ),
            (shares(0.2, 0.0), &[], 0.2, [Verdict::Ambiguous; 3]),
            (shares(0.85, 0.0), &[], 0.2, [Verdict::Ambiguous; 3]),
            (
                shares(0.95, 0.0),
                &[],
                0.2,
                [Verdict::Parameters, changed, changed],
            ),
        ] {
            let found = [None, Some(true), Some(false)].map(|is_as_reference| {
                let evidence = Evidence {
                    identified,
                    none,
                    is_as_reference,
                    ..budget
                };
                verdict(&evidence, &settings)
            });
            assert_eq!(found, expected, "{budget:?} {none}");
        }
    }

    /// By hand: of 0.3 that is left the second effect removes 0.02, which is less than a tenth.
    #[test]
    fn an_effect_that_removes_less_than_a_tenth_of_what_is_left_is_immaterial() {
        assert_eq!(immaterial(&[(0.5, 0.8), (0.02, 0.3)], 0.1), Some(1));
        assert_eq!(immaterial(&[(-0.1, 0.8), (0.2, 0.9)], 0.1), Some(0));
        assert_eq!(immaterial(&[(0.5, 0.8), (0.25, 0.3)], 0.1), None);
        assert_eq!(immaterial(&[(0.5, 0.8), (0.02, 0.3)], 0.0), None);
        assert_eq!(immaterial(&[(-0.1, 0.8), (0.02, 0.9)], 0.0), Some(0));
        assert_eq!(immaterial(&[], 0.1), None);
    }

    /// By hand: with 100 observations a mean square is known to 1.645 sqrt(2/100) = 23 %.
    #[test]
    fn an_effect_that_adds_to_the_held_out_error_is_found() {
        let settings = Settings::default();
        let found = |squares: &[f64]| adds_error(squares, &[0.3; 4], 100.0, &settings);
        assert_eq!(found(&[9.0, 4.0, 16.0]), Some(0));
        assert_eq!(found(&[9.0, 4.0, 2.0, 2.6]), Some(1));
        assert_eq!(found(&[9.0, 4.0, 2.0, 2.4]), None);
        // Within the noise floor.
        assert_eq!(found(&[9.0, 0.04, 0.1]), None);
        assert_eq!(found(&[9.0, 4.0]), None);
    }

    /// Two members of a class that share its probability are named by the class; one that has nearly all of it by itself.
    #[test]
    fn a_class_stands_for_members_that_are_not_separated() {
        let settings = Settings::default();
        let tied = [
            set(&["dead_zone"], 0.45),
            set(&["stribeck"], 0.4),
            set(&[], 0.15),
        ];
        let found = identified(&tied, &settings);
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].effect, found[0].class),
            ("dead_zone", Some("start"))
        );
        assert!((found[0].probability - 0.85).abs() < 1e-12);
        assert!((joint(&tied, &found) - 0.85).abs() < 1e-12);
        let clear = [set(&["dead_zone"], 0.95), set(&["stribeck"], 0.05)];
        let found = identified(&clear, &settings);
        assert_eq!(found[0].class, None);
        let mut bounded = clear.to_vec();
        bounded[0].at_bound = vec!["dead_zone"];
        assert!(identified(&bounded, &settings).is_empty());
        let pair = [set(&["inertia", "cogging"], 0.6), set(&["inertia"], 0.4)];
        let found = identified(&pair, &settings);
        assert_eq!(found.len(), 2);
        assert!((joint(&pair, &found) - 0.6).abs() < 1e-12);
    }
}
