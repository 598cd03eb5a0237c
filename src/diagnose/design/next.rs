//! After a search: the profile that best separates what is still in play.
//!
//! In play are the sets that the search could not tell apart, those that are not implausible, and those near the best that the
//! runs do not separate from it. Each one's fit is simulated on every profile of a small family within supply, duration and
//! sample time; its numbers may give way as far as the runs so far leave them free. Chosen is the profile with the largest
//! smallest separation over the pairs that any of them separates. Where none separates any, the same is asked with a known
//! change on the bench: a disc of known inertia, a known load, another supply.
//!
//! Where the runs are few and show no effect at all, chosen is the profile that shows most of the effects that these runs would
//! hide.

use super::bench::{Bench, Chosen};
use super::hidden::Hidden;
use super::in_play::in_play;
use super::planned::Sampling;
use crate::diagnose::fit::Base;
use crate::diagnose::pieces::Pieces;
use crate::diagnose::report::NextExperiment;
use crate::diagnose::selection::Forward;
use crate::diagnose::settings::{ASKED_S, FEW_PIECES, MOST_ASKED_SAMPLES};
use crate::motor::CommandKind;
use crate::plain::quoted;
use crate::recording::Run;

/// What to record next; `None` where nothing is left to tell apart, or nothing would. `share_of` is the probability of a set, of none
/// where it is empty.
pub(crate) fn next_experiment(
    runs: &[Run],
    pieces: &Pieces,
    base: &Base,
    found: &Forward,
    share_of: &dyn Fn(&[&'static str]) -> f64,
) -> Option<NextExperiment> {
    let first = runs.first()?;
    if base.kind != CommandKind::Voltage {
        return None;
    }
    // As the times say, not as a header states, to a microsecond: what a board can be asked for.
    let shortest = pieces.runs.iter().map(|run| run.sample_time_s);
    let sample_time_s = (1e6 * shortest.fold(f64::INFINITY, f64::min))
        .round()
        .max(1.0)
        / 1e6;
    let lengths = pieces.runs.iter().filter_map(|run| run.t_s.last());
    let longest_s = lengths.fold(0.0, |most: f64, t_s| most.max(*t_s));
    let duration_s = (longest_s.ceil().clamp(ASKED_S.0, ASKED_S.1))
        .min(whole_seconds(MOST_ASKED_SAMPLES * sample_time_s));
    let (sets, open) = in_play(pieces, found, share_of);
    let bench = Bench {
        base,
        sets,
        open,
        at: Sampling {
            sample_time_s,
            samples: (duration_s / sample_time_s).round() as usize,
            counts_per_rev: first.counts_per_rev,
            supply_v: first.supply_v.unwrap_or(base.motor.parameters.supply_v),
        },
        duration_s,
    };
    let chosen = bench.telling_apart().or_else(|| {
        let is_open = found.sets.is_empty() && pieces.pieces.len() < FEW_PIECES;
        is_open.then(|| bench.showing(&Hidden::from(pieces, base, &found.best)))?
    })?;
    let Chosen {
        profile,
        change,
        told,
        separation,
    } = chosen;
    let supply = match change.supply_v() {
        Some(supply_v) => format!(" --supply {supply_v}"),
        None => String::new(),
    };
    Some(NextExperiment {
        command: format!(
            "motorlab capture PORT --profile {}{supply} --ts {sample_time_s} -o next.csv",
            quoted(&profile)
        ),
        profile,
        sample_time_s,
        duration_s,
        change: change.said(),
        tells_apart: told.into_iter().map(str::to_owned).collect(),
        expected_separation: separation,
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
