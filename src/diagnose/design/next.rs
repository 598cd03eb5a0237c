//! Next experiment: the profile that best separates the remaining sets of a diagnosis.
//!
//! Each set's fit is simulated on a family of profiles within the supply; the precision of its parameters is that of
//! the runs so far. The profile with the largest `sum over pairs of p_i p_j (1 - exp(-D_ij^2/8))` is chosen:
//! `exp(-D^2/8)` is the overlap (Bhattacharyya coefficient) of two normal distributions whose means are `D` standard
//! deviations apart. If no profile separates the two most probable sets, known changes on the bench are tried as
//! well.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::change::known_changes;
use super::planned::{Errors, Planned, Prediction, Sampling};
use crate::board::Profile;
use crate::diagnose::classes::symmetric_of;
use crate::diagnose::fit::Fit;
use crate::diagnose::noise::Noise;
use crate::diagnose::pipeline::{Prepared, Searched};
use crate::diagnose::report::{KnownChange, NextExperiment};
use crate::diagnose::score::scale_free;
use crate::diagnose::search::Scored;
use crate::diagnose::settings::conventions::LISTED_FROM;
use crate::diagnose::settings::solver::{CHANGED_PROFILES, PLANNED_SAMPLES, SETS_TO_SEPARATE};
use crate::diagnose::verdict::Weighed;
use crate::motor::CommandKind;
use crate::plain::quoted;
use crate::units::ROUNDING_VARIANCE;

/// The family of profiles, as for `capture --profile`, a few of each kind.
const FAMILY: [&str; 12] = [
    "reversing",
    "reversing@0.5",
    "staircase",
    "ramp@0.3",
    "square@0.4",
    "step",
    "threshold@0.2",
    "crawl@0.2",
    "coasts",
    "jog@0.4",
    "chirp",
    "brakes",
];

/// A simulated experiment.
#[derive(Debug, Clone)]
struct Tried {
    word: &'static str,
    change: Option<KnownChange>,
    /// Separation of every pair of sets in the order of [`pairs`].
    separations: Vec<f64>,
}

/// The remaining sets and the settings of their recording.
struct Bench<'a> {
    prepared: &'a Prepared<'a>,
    searched: &'a Searched,
    /// Sets with their probabilities, the most probable first.
    sets: Vec<(&'a Scored, f64)>,
    at: Sampling,
    duration_s: f64,
    /// Effects about which no recording needs to decide.
    settled: &'a [&'a str],
}

/// Next experiment; `None` if at most one set remains, or if no experiment separates any two. Sets that differ in
/// `settled` effects only are not separated.
pub(crate) fn next_experiment(
    prepared: &Prepared,
    searched: &Searched,
    posterior: &[Weighed],
    settled: &[&str],
) -> Option<NextExperiment> {
    let Prepared {
        all, base, runs, ..
    } = prepared;
    let settings = &base.settings;
    let sets = in_play(&searched.found.sets, posterior);
    if sets.len() < 2 || base.kind != CommandKind::Voltage {
        return None;
    }
    // From the times, rounded to a microsecond: a possible setting of a board.
    let shortest = all.runs.iter().map(|run| run.sample_time_s);
    let sample_time_s = (1e6 * shortest.fold(f64::INFINITY, f64::min))
        .round()
        .max(1.0)
        / 1e6;
    let lengths = all.runs.iter().filter_map(|run| run.t_s.last());
    let longest_s = lengths.fold(0.0_f64, |most, t_s| most.max(*t_s)).ceil();
    let duration_s = longest_s
        .max(settings.folds as f64 * settings.segment_s)
        .min(settings.longest_experiment_s);
    // Long recordings are simulated at a coarser sample time, which gives a lower bound of the separation.
    let planned_s = sample_time_s.max(duration_s / PLANNED_SAMPLES as f64);
    let bench = Bench {
        prepared,
        searched,
        sets,
        at: Sampling {
            sample_time_s: planned_s,
            samples: (duration_s / planned_s).round() as usize,
            counts_per_rev: runs[0].counts_per_rev,
            supply_v: base.motor.parameters.supply_v,
        },
        duration_s,
        settled,
    };
    let chosen = bench.chosen()?;
    let profile = bench.profile(chosen.word);
    let (tells_apart, expected_separation) = bench.separated(&chosen);
    let supply = match &chosen.change {
        Some(change) if change.key == "supply_v" => format!(" --supply {}", change.value),
        _ => String::new(),
    };
    Some(NextExperiment {
        command: format!(
            "motorlab capture PORT --profile {}{supply} --ts {sample_time_s} -o next.csv",
            quoted(&profile)
        ),
        profile,
        sample_time_s,
        duration_s,
        tells_apart,
        expected_separation,
        change: chosen.change,
    })
}

/// The sets to separate, the most probable first.
fn in_play<'a>(sets: &'a [Scored], posterior: &[Weighed]) -> Vec<(&'a Scored, f64)> {
    let mut found: Vec<(&Scored, f64)> = (sets.iter())
        .zip(posterior.iter().map(|set| set.probability))
        .collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.retain(|set| set.1 >= LISTED_FROM);
    found.truncate(SETS_TO_SEPARATE);
    found
}

/// Whether one set has all effects of another, or an asymmetric one in place of the plain one: it includes the other
/// for some values of its parameters.
fn contains(large: &[&str], small: &[&str]) -> bool {
    let has = |id: &&str| {
        let mut own = large.iter();
        own.any(|other| other == id || symmetric_of(other) == Some(*id))
    };
    small != large && small.iter().all(has)
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}

impl Bench<'_> {
    fn chosen(&self) -> Option<Tried> {
        let least = self.prepared.base.settings.separable;
        let mut plain = self.tried(FAMILY.iter().map(|word| (*word, None)).collect());
        plain.sort_by(|a, b| self.value(b).total_cmp(&self.value(a)));
        // The pair of the two most probable sets is the first; nested ones agree if the larger's additional effect is
        // small, for any recording.
        let [one, other] = [0, 1].map(|k| self.sets[k].0.fit.ids());
        let is_nested = contains(&one, &other) || contains(&other, &one);
        if !is_nested && self.is_open((0, 1)) && plain.iter().all(|one| one.separations[0] < least)
        {
            let best = &self.sets[0].0.fit;
            let mut motor = best.model.motor(&best.x);
            motor.parameters.supply_v = self.at.supply_v;
            let changes = known_changes(&motor, self.prepared.base.settings.other_supply);
            let words = plain.iter().take(CHANGED_PROFILES).map(|one| one.word);
            let all = words.flat_map(|word| changes.iter().map(move |c| (word, Some(c.clone()))));
            let changed = self.tried(all.collect()).into_iter();
            let best = changed.max_by(|a, b| self.value(a).total_cmp(&self.value(b)));
            if let Some(best) = best.filter(|one| one.separations[0] >= least) {
                return Some(best);
            }
        }
        let separates = |one: &Tried| {
            let mut pairs = pairs(self.sets.len()).zip(&one.separations);
            pairs.any(|(pair, d)| *d >= least && self.is_open(pair))
        };
        plain.into_iter().find(separates)
    }

    fn profile(&self, word: &str) -> String {
        format!("{word},{}s", self.duration_s)
    }

    fn tried(&self, experiments: Vec<(&'static str, Option<KnownChange>)>) -> Vec<Tried> {
        (experiments.into_par_iter())
            .filter_map(|(word, change)| {
                let separations = self.separations(word, change.as_ref())?;
                Some(Tried {
                    word,
                    change,
                    separations,
                })
            })
            .collect()
    }

    /// The separation of every pair of sets on a planned run: the smaller of the two directions, or that of the
    /// larger set as the truth from one that it contains.
    fn separations(&self, word: &str, change: Option<&KnownChange>) -> Option<Vec<f64>> {
        let base = &self.prepared.base;
        let supply_v = match change {
            Some(change) if change.key == "supply_v" => change.value,
            _ => self.at.supply_v,
        };
        let profile = Profile::named(&self.profile(word), supply_v, self.duration_s).ok()?;
        let best = &self.sets[0].0.fit;
        let motor = best.model.motor(&best.x);
        let planned = Planned::new(base, &motor, &profile, self.at, self.errors(), change)?;
        let judge = &self.searched.found.judge;
        let prediction = |(set, _): &(&Scored, f64)| {
            let Scored {
                fit, likelihood, ..
            } = set;
            let numbers = (&fit.model, fit.x.as_slice());
            match judge.is_likelihood {
                true => planned.prediction(numbers, Some(&likelihood.optimum.hessian)),
                false => {
                    planned.prediction(numbers, Some(&scale_free(base, fit, judge.n_eff).hessian))
                }
            }
        };
        let predictions: Vec<Prediction> =
            self.sets.iter().map(prediction).collect::<Option<_>>()?;
        (self.searched.segments.work).add_all(&planned.segments.work);
        let ids: Vec<Vec<&str>> = self.sets.iter().map(|set| set.0.fit.ids()).collect();
        let one_way = |truth: usize, rival: usize| match contains(&ids[rival], &ids[truth]) {
            true => f64::INFINITY,
            false => planned.separation(&predictions[truth], &predictions[rival]),
        };
        let both = |(i, j)| f64::min(one_way(i, j), one_way(j, i));
        Some(pairs(self.sets.len()).map(both).collect())
    }

    /// The units of the score that was used for the sets.
    fn errors(&self) -> Errors {
        let Searched {
            segments, found, ..
        } = self.searched;
        let best: &Scored = self.sets[0].0;
        if found.judge.is_likelihood {
            // A short run does not show the random load.
            let least = Noise::of_a_clean_bench(&self.prepared.base.settings);
            let own = best.likelihood.noise;
            return Errors::Noise(if own.strength < least.strength {
                least
            } else {
                own
            });
        }
        let fit: &Fit = &best.fit;
        let mean_square = fit.mean_square().max(ROUNDING_VARIANCE);
        Errors::ScaleFree(found.judge.n_eff / (segments.len as f64 * mean_square))
    }

    /// Whether two sets differ in an effect that is not settled.
    fn is_open(&self, (i, j): (usize, usize)) -> bool {
        let open = |k: usize| -> BTreeSet<&str> {
            let ids = self.sets[k].0.fit.ids().into_iter();
            ids.filter(|id| !self.settled.contains(id)).collect()
        };
        open(i) != open(j)
    }

    /// Expected probability of the open pairs that an experiment separates.
    fn value(&self, one: &Tried) -> f64 {
        let pairs = pairs(self.sets.len()).zip(&one.separations);
        pairs
            .filter(|(pair, _)| self.is_open(*pair))
            .map(|((i, j), d)| self.sets[i].1 * self.sets[j].1 * (1.0 - (-d * d / 8.0).exp()))
            .sum()
    }

    /// Effects that differ between the separated sets, and the smallest of those separations.
    fn separated(&self, one: &Tried) -> (Vec<String>, f64) {
        let ids: Vec<Vec<&str>> = self.sets.iter().map(|set| set.0.fit.ids()).collect();
        let (mut found, mut smallest) = (Vec::new(), f64::INFINITY);
        for ((i, j), separation) in pairs(ids.len()).zip(&one.separations) {
            if *separation < self.prepared.base.settings.separable || !self.is_open((i, j)) {
                continue;
            }
            smallest = smallest.min(*separation);
            for (mine, theirs) in [(&ids[i], &ids[j]), (&ids[j], &ids[i])] {
                let differs = |id: &&&str| !theirs.contains(id) && !self.settled.contains(id);
                found.extend(mine.iter().filter(differs).copied());
                found.extend(mine.is_empty().then_some("none"));
            }
        }
        found.sort_unstable();
        found.dedup();
        (found.into_iter().map(str::to_owned).collect(), smallest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::document::weighed;
    use crate::diagnose::pipeline::searched;
    use crate::diagnose::samples::{motor_with, recording};
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    #[test]
    fn a_set_contains_its_subsets_and_the_plain_form_of_effects_by_direction() {
        assert!(contains(&["backlash", "inertia"], &["inertia"]));
        assert!(contains(&["asymmetric_friction"], &[]));
        assert!(contains(&["asymmetric_voltage_drop"], &["voltage_drop"]));
        assert!(!contains(&["inertia"], &["inertia"]));
        assert!(!contains(&["inertia"], &["backlash"]));
    }

    /// For a step in one direction, friction and a voltage drop are one parameter; the proposed recording separates
    /// them.
    #[test]
    fn a_recording_that_separates_the_sets_is_proposed() {
        let settings = Settings::default();
        let mut run = recording(&motor_with(&[("voltage_drop", &[0.8])]), 1500);
        run.supply_v = Some(4.5);
        let run = [run];
        let prepared = Prepared::new(&run, &Motor::default(), &settings, false).expect("a run");
        let found = searched(&prepared, 0.0, &[], &|_| (), &|_| ()).expect("a search");
        let mut posterior = weighed(&found.found.sets, &settings);
        // As if the best set and the best one without its effect were equally probable, and all others impossible.
        let best = posterior[0].ids.clone();
        let rival = (posterior.iter()).position(|set| best.iter().all(|id| !set.ids.contains(id)));
        let rival = rival.expect("another explanation");
        for (k, set) in posterior.iter_mut().enumerate() {
            set.probability = if k == 0 || k == rival { 0.5 } else { 0.0 };
        }
        let next = next_experiment(&prepared, &found, &posterior, &[]).expect("an experiment");
        assert!(next.expected_separation >= settings.separable, "{next:?}");
        assert!(!next.tells_apart.is_empty(), "{next:?}");
        assert!(next.command.contains(&next.profile), "{next:?}");
        posterior[0].probability = 1.0;
        posterior
            .iter_mut()
            .skip(1)
            .for_each(|set| set.probability = 0.0);
        assert_eq!(next_experiment(&prepared, &found, &posterior, &[]), None);
    }
}
