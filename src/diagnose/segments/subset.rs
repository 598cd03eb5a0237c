//! A stratified subset of the segments of long recordings.
//!
//! Strata are the regimes in each quarter of the command range in either direction: each has the same number of
//! segments as far as available, distributed uniformly over time. The hidden state at a segment's start (delayed
//! command, current, side of a backlash) comes from a lead that is simulated and not compared; temperatures continue
//! through omitted parts by their means of squares.

use std::collections::{BTreeMap, BTreeSet};

use super::{Recording, Segment, Segments, regimes, time_constant_s};
use crate::diagnose::error::{DiagnoseError, name_of};
use crate::diagnose::report::Regime;
use crate::motor::fit::{Reset, Simulator, Skipped};
use crate::motor::{Drive, Model, Motor, SimulationError};
use crate::recording::Run;

/// A subset of the segments, with the recordings cut to it.
#[derive(Debug)]
pub(crate) struct Subset {
    pub segments: Segments,
    /// The cut runs, with consecutive times.
    pub runs: Vec<Run>,
}

impl Subset {
    /// A subset of at most this number of samples; `None` if the runs have no more. If a residual is given, half of
    /// the samples are the segments with the largest one.
    pub fn new(
        all: &Segments,
        runs: &[Run],
        motor: &Motor,
        most_samples: usize,
        residual: Option<&[f64]>,
    ) -> Result<Option<Self>, DiagnoseError> {
        if all.len <= most_samples {
            return Ok(None);
        }
        let first = residual.map_or_else(Vec::new, |r| largest(all, r, most_samples / 2));
        Self::of(all, runs, motor, &drawn(all, most_samples, &first, false)).map(Some)
    }

    /// A subset for a quick answer: a share of the samples otherwise searched, as whole segments, with each run,
    /// regime and command level, and at least one segment per fold of the cross-validation. `None` if that is
    /// everything.
    pub fn quick(
        all: &Segments,
        runs: &[Run],
        motor: &Motor,
    ) -> Result<Option<Self>, DiagnoseError> {
        let settings = &all.runs[0].settings;
        let searched = all.len.min(settings.searched_samples);
        let share = (settings.quick_share * searched as f64).ceil() as usize;
        let of_folds = settings.folds * all.len.div_ceil(all.segments.len().max(1));
        let drawn = drawn(all, share.max(of_folds), &[], true);
        if drawn.len() == all.segments.len() {
            return Ok(None);
        }
        Self::of(all, runs, motor, &drawn).map(Some)
    }

    fn of(
        all: &Segments,
        runs: &[Run],
        motor: &Motor,
        drawn: &BTreeSet<usize>,
    ) -> Result<Self, DiagnoseError> {
        let (mut recordings, mut segments, mut shorter) = (Vec::new(), Vec::new(), Vec::new());
        let mut at = 0;
        for (number, run) in runs.iter().enumerate() {
            let of_run = drawn.iter().map(|k| &all.segments[*k]);
            let windows: Vec<&Segment> = of_run.filter(|segment| segment.run == number).collect();
            if windows.is_empty() {
                continue;
            }
            let cut = Cut::new(run, &all.runs[number], &windows);
            let cut = cut.map_err(|source| DiagnoseError::Simulation {
                run: name_of(number, run),
                source,
            })?;
            for (segment, from) in windows.iter().zip(cut.begins) {
                segments.push(Segment {
                    run: recordings.len(),
                    from,
                    to: from + segment.len(),
                    at,
                    ..(*segment).clone()
                });
                at += segment.len();
            }
            recordings.push(cut.recording);
            shorter.push(cut.run);
        }
        let mut segments = Segments::of(recordings, segments, all.arrivals_s)
            .with_time_constant(time_constant_s(motor));
        segments.work = all.work.clone();
        Ok(Self {
            segments,
            runs: shorter,
        })
    }
}

/// A stratum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Cell {
    /// A regime and a part of the command range.
    Motion(Regime, i32),
    /// A run.
    Run(usize),
}

/// Indices of the segments of the subset, ascending. `covers`: every stratum and every run is included, at any size.
fn drawn(all: &Segments, most_samples: usize, first: &[usize], covers: bool) -> BTreeSet<usize> {
    let mut cells: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    let commands = all.runs.iter().flat_map(|run| &run.command);
    let largest = commands.fold(f64::MIN_POSITIVE, |most, u| most.max(u.abs()));
    let mut of_segment: Vec<Vec<Cell>> = Vec::with_capacity(all.segments.len());
    let mut segments = all.segments.iter().enumerate().peekable();
    for (number, run) in all.runs.iter().enumerate() {
        let regimes = regimes(run);
        while let Some((k, segment)) = segments.next_if(|(_, segment)| segment.run == number) {
            let cell = |k: usize| {
                let level = run.settings.command_levels * run.command[k] / largest;
                let level = level.signum() as i32 * level.abs().ceil() as i32;
                Cell::Motion(regimes[k], level)
            };
            let of_run = covers.then_some(Cell::Run(number));
            let seen: BTreeSet<Cell> = (segment.from..segment.to).map(cell).chain(of_run).collect();
            for cell in &seen {
                cells.entry(*cell).or_default().push(k);
            }
            of_segment.push(seen.into_iter().collect());
        }
    }
    let mut drawn = BTreeSet::new();
    let mut of_cell: BTreeMap<Cell, BTreeSet<usize>> = BTreeMap::new();
    let mut samples = 0;
    let mut first = first.iter().copied();
    while !cells.is_empty() {
        let is_covered = || !covers || cells.keys().all(|cell| of_cell.contains_key(cell));
        if samples >= most_samples && is_covered() {
            break;
        }
        let segment = first.next().or_else(|| {
            let taken = |cell: &Cell| of_cell.get(cell).map_or(0, BTreeSet::len);
            // Among those with the fewest chosen, the one with the fewest available.
            let fewest = cells
                .iter()
                .min_by_key(|(cell, of)| (taken(cell), of.len()));
            let cell = *fewest?.0;
            let found = farthest(&cells[&cell], of_cell.get(&cell));
            if found.is_none() {
                cells.remove(&cell);
            }
            found
        });
        if let Some(segment) = segment.filter(|segment| drawn.insert(*segment)) {
            samples += all.segments[segment].len();
            for cell in &of_segment[segment] {
                of_cell.entry(*cell).or_default().insert(segment);
            }
        }
    }
    drawn
}

/// Segments with the largest mean square of a residual, with at most this number of samples together.
fn largest(all: &Segments, residual: &[f64], most_samples: usize) -> Vec<usize> {
    let mean_square = |k: &usize| {
        let r = &residual[all.segments[*k].range()];
        r.iter().map(|r| r * r).sum::<f64>() / r.len().max(1) as f64
    };
    let mut order: Vec<usize> = (0..all.segments.len()).collect();
    order.sort_by(|a, b| mean_square(b).total_cmp(&mean_square(a)));
    let mut samples = 0;
    order
        .into_iter()
        .take_while(|k| {
            let is_room = samples < most_samples;
            samples += all.segments[*k].len();
            is_room
        })
        .collect()
}

/// The segment farthest from the chosen ones; the middle one if there are none.
fn farthest(segments: &[usize], drawn: Option<&BTreeSet<usize>>) -> Option<usize> {
    let Some(drawn) = drawn else {
        return segments.get(segments.len() / 2).copied();
    };
    let apart = |k: &usize| {
        let before = drawn.range(..=*k).next_back().map(|other| k - other);
        let behind = drawn.range(*k..).next().map(|other| other - k);
        before.into_iter().chain(behind).min().unwrap_or(usize::MAX)
    };
    let farthest = (segments.iter()).max_by_key(|k| (apart(k), std::cmp::Reverse(**k)))?;
    (apart(farthest) > 0).then_some(*farthest)
}

/// One recording cut to some segments and their leads.
struct Cut {
    recording: Recording,
    run: Run,
    /// Start of each segment.
    begins: Vec<usize>,
}

impl Cut {
    fn new(run: &Run, whole: &Recording, windows: &[&Segment]) -> Result<Self, SimulationError> {
        let lead = (whole.settings.lead_s / whole.sample_time_s).ceil() as usize;
        let (mut picked, mut begins) = (Vec::new(), Vec::new());
        let (mut resets, mut skipped) = (Vec::new(), Vec::new());
        let mut put = |sample: usize, at: usize| {
            let (reset, _) = whole.start(at);
            resets.push(Reset { sample, ..reset });
        };
        let (mut t_s, mut end, mut shift_s) = (Vec::new(), 0, whole.t_s[0]);
        for segment in windows {
            let from = segment.from.saturating_sub(lead).max(end);
            if from > end {
                let block = segment.len();
                skipped.extend(skips(whole, end..from, block, picked.len()));
                shift_s += whole.t_s[from] - whole.t_s[end];
            }
            if from > end || end == 0 {
                put(picked.len(), from);
            }
            let begins_at = picked.len() + segment.from - from;
            if segment.from > from || (from == end && end > 0) {
                put(begins_at, segment.from);
            }
            begins.push(begins_at);
            t_s.extend((from..segment.to).map(|k| whole.t_s[k] - shift_s));
            picked.extend(from..segment.to);
            end = segment.to;
        }
        let of = |column: &[f64]| -> Vec<f64> { picked.iter().map(|k| column[*k]).collect() };
        let command = of(&whole.command);
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: run.command_kind,
        };
        let first = resets[0];
        let restarts = resets.iter().map(|reset| reset.sample).collect();
        let simulator = Simulator::new(&drive, Model::SecondOrder)?
            .with_steps_of(&whole.simulator)
            .with_start(first.angle_rad, first.speed_rad_s)
            .with_resets(resets)
            .with_skipped(skipped);
        let recording = Recording {
            t_s: of(&whole.t_s),
            counts: of(&whole.counts),
            speed: of(&whole.speed),
            moving: picked.iter().map(|k| whole.moving[*k]).collect(),
            command: command.clone(),
            continuous: Simulator::new(&drive, Model::SecondOrder)?
                .with_steps_of(&whole.continuous)
                .with_start(first.angle_rad, first.speed_rad_s),
            simulator,
            restarts,
            off: Vec::new(),
            first_counts: whole.first_counts,
            sample_time_s: whole.sample_time_s,
            rad: whole.rad,
            supply_v: whole.supply_v,
            known: whole.known.clone(),
            is_closed_loop: whole.is_closed_loop,
            clock: whole.clock,
            is_integrated: whole.is_integrated,
            is_integrated_backward: whole.is_integrated_backward,
            speed_resolution: whole.speed_resolution,
            top: whole.top,
            first_speed: whole.first_speed,
            settings: whole.settings,
        };
        let shorter = Run {
            sample_time_s: run.sample_time_s,
            counts_per_rev: run.counts_per_rev,
            supply_v: run.supply_v,
            command_kind: run.command_kind,
            known: run.known.clone(),
            counts: picked.iter().map(|k| run.counts[*k]).collect(),
            t_s,
            command,
            ..Run::default()
        };
        Ok(Self {
            recording,
            run: shorter,
            begins,
        })
    }
}

/// Omitted samples of a recording before a sample, in blocks.
fn skips(
    whole: &Recording,
    left_out: std::ops::Range<usize>,
    block: usize,
    before: usize,
) -> impl Iterator<Item = Skipped> {
    // Samples far enough apart for quantization to contribute little to the square of the speed.
    let apart = ((whole.settings.start_window_s / whole.sample_time_s).round() as usize).max(1);
    let end = left_out.end;
    left_out.step_by(block).map(move |from| {
        let to = (from + block).min(end);
        let turned = |from: usize, to: usize| (whole.counts[to] - whole.counts[from]) * whole.rad;
        let lasts_s = |from: usize, to: usize| whole.t_s[to] - whole.t_s[from];
        let mut sums = [0.0; 3];
        for k in from..to {
            let u = whole.command[k];
            sums[0] += u * u * lasts_s(k, k + 1);
            sums[1] += u * turned(k, k + 1);
        }
        for k in (from..to).step_by(apart) {
            let until = (k + apart).min(to);
            sums[2] += turned(k, until).powi(2) / lasts_s(k, until);
        }
        let span_s = lasts_s(from, to);
        Skipped {
            before,
            span_s,
            means: sums.map(|sum| sum / span_s),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::settings::Settings;
    use crate::motor::{CommandKind, SimulationOptions, simulate};

    /// A run of consecutive levels of 1.5 s.
    fn run(levels: &[f64]) -> Run {
        let command: Vec<f64> = levels.iter().flat_map(|level| vec![*level; 150]).collect();
        let t_s: Vec<f64> = (0..command.len()).map(|k| 0.01 * k as f64).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let simulated = simulate(&Motor::default(), &drive, &SimulationOptions::default());
        Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            counts: simulated.expect("a motor").counts,
            t_s,
            command,
            ..Run::default()
        }
    }

    /// Long runs of one level, and short ones with a unique level each.
    #[test]
    fn a_quick_subset_has_every_run_and_every_command_level() {
        let settings = Settings::default();
        let long = run(&[4.5; 60]);
        let runs = [
            long.clone(),
            run(&[1.0]),
            long,
            run(&[-2.0]),
            run(&[-4.0]),
            run(&[2.5]),
        ];
        let all = Segments::new(&runs, &Motor::default(), &settings).expect("runs");
        let quick = Subset::quick(&all, &runs, &Motor::default()).expect("runs");
        let quick = quick.expect("a part").segments;
        assert!(5 * quick.len < all.len, "{} of {}", quick.len, all.len);
        assert_eq!(quick.runs.len(), runs.len());
        for level in [4.5, 1.0, -2.0, -4.0, 2.5] {
            let has = |segment: &Segment| {
                quick.runs[segment.run].command[segment.from..segment.to].contains(&level)
            };
            assert!(quick.segments.iter().any(has), "{level} V");
        }
    }
}
