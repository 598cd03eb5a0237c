//! After a diagnosis: the profile that best separates what is still in play.
//!
//! In play are the sets that the runs leave plausible, and those tied with the best of them. Each one's best
//! fit is simulated on every profile of a small family within supply, duration and sample time; its numbers
//! may give way as far as the runs so far leave them free (the inverse of its posterior covariance).
//! Chosen is the profile with the largest smallest separation over the pairs that any of them separates. Where none separates
//! any, the same is asked with a known change on the bench: a disc of known inertia, a known load, another supply.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::planned::{Planned, Sampling, View};
use crate::board::Profile;
use crate::diagnose::candidate::Candidate;
use crate::diagnose::conclusions::ids;
use crate::diagnose::noise::NoiseLevel;
use crate::diagnose::problem::Problem;
use crate::diagnose::rank::Ranking;
use crate::diagnose::ties::{TIE, separation};
use crate::diagnose::{KnownChange, NextExperiment};
use crate::motor::{KnownDifferences, Motor};
use crate::recording::CommandKind;

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
/// Shortest and longest recording that is asked for, in s.
const DURATION_S: (f64, f64) = (4.0, 20.0);
/// Most samples of it: a sample time is not asked for that would need more.
const MOST_SAMPLES: f64 = 20_000.0;
/// Sets less likely than the best by this factor are out of play unless they are tied with it.
const PLAUSIBLE: f64 = 0.02;
/// Sets this many nats behind the best are looked at for ties.
const IN_PLAY_NATS: f64 = 12.0;
/// Most sets that are compared.
const MOST_SETS: usize = 6;
/// Where no profile separates any pair plainly, one is still asked for that separates some by this much.
const FAINT: f64 = 1.0;

/// What to record next; `None` where nothing is left to tell apart, or no profile would.
pub(in crate::diagnose) fn next_experiment(
    problem: &Problem<'_>,
    ranking: &Ranking,
) -> Option<NextExperiment> {
    let sets = in_play(problem, ranking);
    let best = *sets.first()?;
    let shortest = problem.runs.iter().map(|run| run.sample_time_s);
    let sample_time_s = shortest.fold(f64::INFINITY, f64::min);
    let lengths = problem.runs.iter().filter_map(|run| run.t_s.last());
    let longest_s = lengths.fold(0.0, |most, t_s| f64::max(most, *t_s));
    if sets.len() < 2
        || problem
            .runs
            .iter()
            .any(|run| run.kind != CommandKind::Voltage)
    {
        return None;
    }
    let duration_s = longest_s
        .ceil()
        .clamp(DURATION_S.0, DURATION_S.1)
        .min(whole_seconds(MOST_SAMPLES * sample_time_s));
    let samples = (duration_s / sample_time_s).round() as usize;
    let mut motor = best.fit.hypothesis.motor(problem.nominal, &best.fit.p);
    if let Some(run) = problem.runs.first() {
        motor.parameters.counts_per_rev = run.counts_per_rev;
        motor.parameters.supply_v = run.supply_v.unwrap_or(motor.parameters.supply_v);
    }
    let level = NoiseLevel {
        wander: best.fit.wander,
        lost_share: 0.0,
        late_s: 0.0,
        supply: 0.0,
        rounding: problem.rounding,
        rough: problem.rough,
        goes_on: false,
    };
    let at = Sampling {
        sample_time_s,
        samples,
    };
    let try_all = |changes: &[Change]| -> Vec<Tried> {
        let words = FAMILY
            .iter()
            .flat_map(|word| changes.iter().map(move |change| (word, change)));
        let words: Vec<(&&str, &Change)> = words.collect();
        words
            .into_par_iter()
            .filter_map(|(word, change)| {
                let name = format!("{word},{duration_s}s");
                let known = change.known()?;
                let supply_v = known.supply_v().unwrap_or(motor.parameters.supply_v);
                let profile = Profile::named(&name, supply_v, duration_s).ok()?;
                let planned = Planned::new(&motor, &profile, at, problem.damping, level, &known)?;
                Some(Tried {
                    profile: name,
                    change: *change,
                    separations: separations(problem, &planned, &sets)?,
                })
            })
            .collect()
    };
    let plain = try_all(&[Change::None]);
    // Nobody takes a bench apart for what another profile tells.
    let chosen = choose(&sets, &plain, TIE)
        .or_else(|| choose(&sets, &try_all(&changes(&motor, &sets)), TIE))
        .or_else(|| choose(&sets, &plain, FAINT))?;
    Some(NextExperiment {
        command: chosen.tried.command(sample_time_s),
        profile: chosen.tried.profile,
        sample_time_s,
        duration_s,
        change: chosen.tried.change.said(),
        tells_apart: chosen.told.into_iter().map(str::to_owned).collect(),
        expected_separation: chosen.separation,
    })
}

/// Whole seconds, where there is one.
fn whole_seconds(duration_s: f64) -> f64 {
    if duration_s < 1.0 {
        duration_s
    } else {
        duration_s.floor()
    }
}

/// What is changed on the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// Nothing.
    None,
    /// A key of [`KnownDifferences`] has this value.
    Known(&'static str, f64),
}

impl Change {
    fn known(self) -> Option<KnownDifferences> {
        let mut known = KnownDifferences::default();
        if let Self::Known(key, value) = self {
            known.set(key, value).ok()?;
        }
        Some(known)
    }

    fn said(self) -> Option<KnownChange> {
        match self {
            Self::None => None,
            Self::Known(key, value) => Some(KnownChange {
                key: key.to_owned(),
                value,
            }),
        }
    }
}

/// Torque of the load that is proposed, as a share of what the motor has at stall: it lifts it, and feels it.
const LOAD_SHARE: f64 = 0.3;
/// The other supply that is proposed, as a share.
const SUPPLY_SHARE: f64 = 0.5;

/// The known changes that are tried: as much inertia again, a load on an arm (unless something hangs there already), and
/// another supply. Figures are rounded to one digit: they are to be made.
fn changes(motor: &Motor, sets: &[&Candidate]) -> Vec<Change> {
    let p = &motor.parameters;
    let stall_nm = p.torque_constant_nm_per_a * p.supply_v / p.resistance_ohm;
    let hangs = sets.iter().any(|set| ids(set).contains(&"gravity_load"));
    let load = Change::Known("gravity_torque_nm", one_digit(LOAD_SHARE * stall_nm));
    [
        Some(Change::Known(
            "inertia_added_kg_m2",
            one_digit(p.inertia_kg_m2),
        )),
        (!hangs).then_some(load),
        Some(Change::Known("supply_v", SUPPLY_SHARE * p.supply_v)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn one_digit(value: f64) -> f64 {
    let unit = 10f64.powi(value.log10().floor() as i32);
    // By way of text, or it has fifteen digits.
    let digits = format!("{:e}", (value / unit).round() * unit);
    digits.parse().unwrap_or(value)
}

/// An experiment that was simulated.
#[derive(Debug, Clone)]
struct Tried {
    profile: String,
    change: Change,
    /// Of every pair of sets.
    separations: Vec<f64>,
}

impl Tried {
    /// The command that records it.
    fn command(&self, sample_time_s: f64) -> String {
        let supply = match self.change {
            Change::Known("supply_v", supply_v) => format!(" --supply {supply_v}"),
            _ => String::new(),
        };
        format!(
            "motorlab capture PORT --profile {}{supply} --ts {sample_time_s} -o next.csv",
            self.profile
        )
    }
}

/// The sets that are still plausible, or tied with the best, likeliest first.
fn in_play<'a>(problem: &Problem<'_>, ranking: &'a Ranking) -> Vec<&'a Candidate> {
    let Some(best) = ranking.candidates.first() else {
        return Vec::new();
    };
    let near = ranking
        .candidates
        .iter()
        .take_while(|c| c.log_weight >= best.log_weight - IN_PLAY_NATS);
    near.filter(|c| {
        c.probability >= PLAUSIBLE * best.probability
            || separation(problem, &best.fit, &c.fit).is_some_and(|d| d < TIE)
    })
    .take(MOST_SETS)
    .collect()
}

/// Every pair of sets in turn.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}

/// The separation of every pair of sets on a planned run, the smaller of the two ways round.
fn separations(problem: &Problem<'_>, planned: &Planned, sets: &[&Candidate]) -> Option<Vec<f64>> {
    let views: Vec<View> = sets
        .iter()
        .map(|set| planned.view(problem.nominal, &set.fit.hypothesis, &set.fit.p))
        .collect::<Option<_>>()?;
    let known: Vec<DMatrix<f64>> = sets
        .iter()
        .map(|set| set.fit.covariance.clone().try_inverse())
        .collect::<Option<_>>()?;
    let one_way = |truth: usize, rival: usize| {
        planned.separation(&views[truth], &views[rival], |i, j| known[rival][(i, j)])
    };
    pairs(sets.len())
        .map(|(i, j)| Some(one_way(i, j)?.min(one_way(j, i)?)))
        .collect()
}

/// What is to be recorded, and what for.
struct Chosen {
    tried: Tried,
    told: Vec<&'static str>,
    separation: f64,
}

/// The experiment with the largest smallest separation over the pairs that some experiment separates by `least`, what it
/// tells apart, and that separation.
fn choose(sets: &[&Candidate], tried: &[Tried], least: f64) -> Option<Chosen> {
    let count = pairs(sets.len()).count();
    // A pair that every profile leaves tied must not choose for the others.
    let separable = |k: &usize| tried.iter().any(|one| one.separations[*k] >= least);
    let hopeful: Vec<usize> = (0..count).filter(separable).collect();
    if hopeful.is_empty() {
        return None;
    }
    let smallest = |one: &Tried| {
        let of_pairs = hopeful.iter().map(|&k| one.separations[k]);
        of_pairs.fold(f64::INFINITY, f64::min)
    };
    let best = tried
        .iter()
        .max_by(|a, b| smallest(a).total_cmp(&smallest(b)))?;
    let mut told: Vec<&'static str> = Vec::new();
    for (k, (i, j)) in pairs(sets.len()).enumerate() {
        if hopeful.contains(&k) {
            for (one, other) in [(i, j), (j, i)] {
                let (mine, theirs) = (ids(sets[one]), ids(sets[other]));
                told.extend(mine.iter().filter(|id| !theirs.contains(*id)));
                if mine.is_empty() {
                    told.push("none");
                }
            }
        }
    }
    told.sort_unstable();
    told.dedup();
    Some(Chosen {
        tried: best.clone(),
        told,
        separation: smallest(best),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_be_made_has_one_digit() {
        for (value, short) in [
            (0.002_19, 0.002),
            (0.0945, 0.09),
            (7.6e-6, 8e-6),
            (96.0, 100.0),
        ] {
            assert_eq!(one_digit(value), short);
        }
    }
}
