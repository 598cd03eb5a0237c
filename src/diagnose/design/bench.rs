//! Experiments on a motor as the runs so far say it is, each simulated with all that is in play.

use rayon::prelude::*;

use super::change::{Change, known_changes};
use super::hidden::Hidden;
use super::in_play::is_within;
use super::planned::{ORDINARY, Planned, Sampling, View};
use crate::board::Profile;
use crate::diagnose::fit::{Base, Fit};
use crate::diagnose::settings::{FAINT, SHORT_LIST, TIE};

/// The family: words that `capture --profile` knows.
const FAMILY: [&str; 24] = [
    "reversing",
    "reversing@0.5",
    "staircase",
    "ramp",
    "ramp@0.3",
    "square",
    "square@0.4",
    "step",
    "step@0.3",
    "step@0.15",
    "threshold@0.1",
    "threshold@0.2",
    "threshold@0.4",
    "crawl@0.1",
    "crawl@0.2",
    "crawl@0.4",
    "coasts",
    "coasts@0.4",
    "jog",
    "jog@0.4",
    "jog@0.2",
    "chirp",
    "chirp@0.4",
    "brakes",
];

/// An experiment that was simulated.
#[derive(Debug, Clone)]
struct Tried {
    profile: String,
    change: Change,
    /// Of every pair of sets.
    separations: Vec<f64>,
}

impl Tried {
    /// The smallest separation of some pairs.
    fn smallest(&self, pairs: &[usize]) -> f64 {
        let separations = pairs.iter().map(|&k| self.separations[k]);
        separations.fold(f64::INFINITY, f64::min)
    }
}

/// What is to be recorded, and what for.
pub(super) struct Chosen {
    pub profile: String,
    pub change: Change,
    pub told: Vec<&'static str>,
    pub separation: f64,
}

/// The motor as it stands there, what is in play, and how it would be recorded.
pub(super) struct Bench<'a> {
    pub base: &'a Base,
    /// The best first.
    pub sets: Vec<&'a Fit>,
    /// How many of them the search itself leaves open.
    pub open: usize,
    pub at: Sampling,
    pub duration_s: f64,
}

impl Bench<'_> {
    /// The experiment that best parts what is in play.
    pub fn telling_apart(&self) -> Option<Chosen> {
        let all = self.sets.len();
        if all < 2 {
            return None;
        }
        let plain = self.try_all(&[Change::None]);
        // Nobody takes a bench apart for what another profile tells, nor for what hardly is in question.
        let is_left_open = self.open > 1 && self.told(&plain, TIE, self.open).is_empty();
        let changed = || match is_left_open {
            true => self.choose(&self.try_all(&self.changes()), TIE, self.open),
            false => None,
        };
        changed()
            .or_else(|| self.choose(&plain, TIE, all))
            .or_else(|| self.choose(&plain, FAINT, all))
    }

    fn changes(&self) -> Vec<Change> {
        let is_hanging = |set: &&Fit| set.model.ids().contains(&"gravity_load");
        let best = self.sets[0];
        known_changes(
            &best.model.motor(&best.x),
            self.at.supply_v,
            self.sets.iter().any(is_hanging),
        )
    }

    /// The few that come first, with the separations of refitted rivals.
    fn short_list(&self, mut tried: Vec<&Tried>) -> Vec<Tried> {
        tried.truncate(SHORT_LIST);
        (tried.into_par_iter())
            .filter_map(|one| {
                let separations = self.separations(&one.profile, one.change, true)?;
                Some(Tried {
                    separations,
                    ..one.clone()
                })
            })
            .collect()
    }

    /// The profile that shows most of what the runs so far would hide, and shows it best.
    pub fn showing(&self, hidden: &Hidden<'_>) -> Option<Chosen> {
        let tried = FAMILY.par_iter().filter_map(|word| {
            let profile = format!("{word},{}s", self.duration_s);
            let shown = hidden.shown(&self.planned(&profile, Change::None)?);
            let how_well: f64 = shown.iter().map(|(_, d)| d.ln()).sum();
            Some((shown, how_well, profile))
        });
        let (shown, _, profile) = tried
            .filter(|(shown, _, _)| !shown.is_empty())
            .max_by(|a, b| a.0.len().cmp(&b.0.len()).then(a.1.total_cmp(&b.1)))?;
        let separations = shown.iter().map(|(_, d)| *d);
        let separation = separations.fold(f64::INFINITY, f64::min);
        let mut told: Vec<&str> = shown.into_iter().map(|(id, _)| id).collect();
        told.dedup();
        told.push("none");
        Some(Chosen {
            profile,
            change: Change::None,
            told,
            separation,
        })
    }

    /// A profile's run with what is changed in it, as the best makes it.
    fn planned(&self, profile: &str, change: Change) -> Option<Planned> {
        let supply_v = change.supply_v().unwrap_or(self.at.supply_v);
        let profile = Profile::named(profile, supply_v, self.duration_s).ok()?;
        let best = self.sets.first()?;
        let numbers = (&best.model, best.x.as_slice());
        let known = change.known()?;
        // A short run does not show how the load wanders.
        let noise = if best.noise.strength < ORDINARY.strength {
            ORDINARY
        } else {
            best.noise
        };
        Planned::new(self.base, numbers, &profile, self.at, noise, &known)
    }

    fn try_all(&self, changes: &[Change]) -> Vec<Tried> {
        let words = FAMILY.iter();
        let tried: Vec<(&str, Change)> = words
            .flat_map(|word| changes.iter().map(move |change| (*word, *change)))
            .collect();
        (tried.into_par_iter())
            .filter_map(|(word, change)| {
                let profile = format!("{word},{}s", self.duration_s);
                let separations = self.separations(&profile, change, false)?;
                Some(Tried {
                    profile,
                    change,
                    separations,
                })
            })
            .collect()
    }

    /// The separation of every pair of sets on a planned run: the smaller of the two ways round, or of the larger set as the
    /// truth from one that it contains.
    fn separations(&self, profile: &str, change: Change, refits: bool) -> Option<Vec<f64>> {
        let Self { base, sets, .. } = self;
        let planned = self.planned(profile, change)?;
        // Numbers are as free as the runs so far leave them.
        let view = |set: &&Fit| planned.rival(base, (&set.model, &set.x), &set.hessian);
        let views: Vec<View> = sets.iter().map(view).collect::<Option<_>>()?;
        let one_way = |truth: usize, rival: usize| {
            if is_within(sets[truth], sets[rival]) {
                return f64::INFINITY;
            }
            let (seen, set) = (&views[truth], sets[rival]);
            let refitted =
                || planned.separation_refitted(base, seen, (&set.model, &set.x), &set.hessian);
            let straight = || planned.separation(seen, &views[rival]);
            (refits.then(refitted).flatten()).unwrap_or_else(straight)
        };
        let both = |(i, j)| f64::min(one_way(i, j), one_way(j, i));
        Some(pairs(sets.len()).map(both).collect())
    }

    /// Pairs of the first `among` sets that some experiment separates by `least`: one that all leave tied must not choose for the
    /// others.
    fn told(&self, tried: &[Tried], least: f64, among: usize) -> Vec<usize> {
        let is_told = |k: usize| tried.iter().any(|one| one.separations[k] >= least);
        let pairs = pairs(self.sets.len()).enumerate();
        let of_these = pairs.filter(|(k, (_, j))| *j < among && is_told(*k));
        of_these.map(|(k, _)| k).collect()
    }

    /// Experiments by their smallest separation over the pairs that are told, the largest first; but before that, what the search
    /// leaves open is to be told at all.
    fn in_order<'t>(&self, tried: &'t [Tried], least: f64, among: usize) -> Vec<&'t Tried> {
        let told = self.told(tried, least, among);
        let open = self.told(tried, least, among.min(self.open));
        let key = |one: &Tried| (one.smallest(&open).min(FAINT), one.smallest(&told));
        let mut order: Vec<&Tried> = tried.iter().collect();
        order.sort_by(|a, b| {
            let (a, b) = (key(a), key(b));
            b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
        });
        order
    }

    /// The experiment that comes first among those that separate a pair of the first `among` sets by `least`, what it tells apart,
    /// and by how much at least.
    fn choose(&self, tried: &[Tried], least: f64, among: usize) -> Option<Chosen> {
        if self.told(tried, least, among).is_empty() {
            return None;
        }
        let tried = self.short_list(self.in_order(tried, least, among));
        let hopeful = self.told(&tried, least, among);
        let best = *self.in_order(&tried, least, among).first()?;
        if hopeful.is_empty() {
            return None;
        }
        let named: Vec<Vec<&str>> = self.sets.iter().map(|set| set.model.ids()).collect();
        let mut told: Vec<&'static str> = Vec::new();
        let pairs = pairs(named.len()).enumerate();
        for (_, (i, j)) in pairs.filter(|(k, _)| hopeful.contains(k)) {
            for (mine, theirs) in [(&named[i], &named[j]), (&named[j], &named[i])] {
                told.extend(mine.iter().filter(|id| !theirs.contains(id)));
                if mine.is_empty() {
                    told.push("none");
                }
            }
        }
        told.sort_unstable();
        told.dedup();
        Some(Chosen {
            profile: best.profile.clone(),
            change: best.change,
            told,
            separation: best.smallest(&hopeful),
        })
    }
}

/// Every pair of sets in turn.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}
