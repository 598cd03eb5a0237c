//! After a diagnosis: the profile that best separates what is still in play.
//!
//! In play are the sets that the runs leave plausible, and those tied with the best of them. Each one's best
//! fit is simulated on every profile of a small family within supply, duration and sample time; its numbers
//! may give way as far as the runs so far leave them free (the inverse of its posterior covariance).
//! Chosen is the profile with the largest smallest separation over the pairs that any of them separates.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::planned::{Planned, Sampling, View};
use crate::board::Profile;
use crate::diagnose::NextExperiment;
use crate::diagnose::candidate::Candidate;
use crate::diagnose::conclusions::ids;
use crate::diagnose::noise::NoiseLevel;
use crate::diagnose::problem::Problem;
use crate::diagnose::rank::Ranking;
use crate::diagnose::ties::{TIE, separation};
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
    let tried: Vec<(String, Vec<f64>)> = FAMILY
        .par_iter()
        .filter_map(|word| {
            let name = format!("{word},{duration_s}s");
            let supply_v = motor.parameters.supply_v;
            let profile = Profile::named(&name, supply_v, duration_s).ok()?;
            let planned = Planned::new(&motor, &profile, at, problem.damping, level)?;
            Some((name, separations(problem, &planned, &sets)?))
        })
        .collect();
    choose(&sets, tried).map(|chosen| NextExperiment {
        command: format!(
            "motorlab capture PORT --profile {} --ts {sample_time_s} -o next.csv",
            chosen.0
        ),
        profile: chosen.0,
        sample_time_s,
        duration_s,
        tells_apart: chosen.1.into_iter().map(str::to_owned).collect(),
        expected_separation: chosen.2,
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

/// The profile with the largest smallest separation over the pairs that some profile separates, what it
/// tells apart, and that separation.
fn choose(
    sets: &[&Candidate],
    tried: Vec<(String, Vec<f64>)>,
) -> Option<(String, Vec<&'static str>, f64)> {
    let count = pairs(sets.len()).count();
    let separable = |least: f64| -> Vec<usize> {
        let some = |k: &usize| tried.iter().any(|(_, d)| d[*k] >= least);
        (0..count).filter(some).collect()
    };
    // A pair that every profile leaves tied must not choose for the others.
    let hopeful = [TIE, FAINT]
        .map(separable)
        .into_iter()
        .find(|k| !k.is_empty())?;
    let smallest = |d: &[f64]| {
        let of_pairs = hopeful.iter().map(|&k| d[k]);
        of_pairs.fold(f64::INFINITY, f64::min)
    };
    let (name, d) = tried
        .into_iter()
        .max_by(|a, b| smallest(&a.1).total_cmp(&smallest(&b.1)))?;
    let expected = smallest(&d);
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
    Some((name, told, expected))
}
