//! Long recordings are searched by some of their pieces, drawn evenly over what the motor does and over time.
//!
//! A recording of an hour says the same again and again, but for what lives in few of its pieces. So pieces are drawn by what is in
//! them: each regime under each quarter of the command's range, either way, has as many as any other as long as it has any, and those
//! lie as far apart in time as they can. What a piece begins with but does not measure comes from a lead that is simulated and not
//! looked at: a command under way, the current, the side of a gap. Heat takes longer: what lies between the pieces that are drawn
//! goes on warming the winding, by the means of its squares.

use std::collections::{BTreeMap, BTreeSet};

use super::{Piece, Pieces, Recording, regimes};
use crate::diagnose::error::{DiagnoseError, name_of};
use crate::diagnose::report::Regime;
use crate::diagnose::settings::{COMMAND_LEVELS, LEAD_S, SEARCHED_SAMPLES, START_WINDOW_S};
use crate::motor::fit::{Reset, Simulator, Skipped};
use crate::motor::{Drive, Model, SimulationError};
use crate::recording::Run;

/// What of long recordings is searched.
#[derive(Debug)]
pub(crate) struct Thinned {
    pub pieces: Pieces,
    /// The recordings with nothing but that, at times that leave nothing out.
    pub runs: Vec<Run>,
}

impl Thinned {
    /// Of these pieces of these runs; none where all are searched.
    pub fn new(all: &Pieces, runs: &[Run]) -> Result<Option<Self>, DiagnoseError> {
        if all.len <= SEARCHED_SAMPLES {
            return Ok(None);
        }
        let drawn = drawn(all);
        let (mut recordings, mut pieces, mut shorter) = (Vec::new(), Vec::new(), Vec::new());
        let mut at = 0;
        for (number, run) in runs.iter().enumerate() {
            let of_run = drawn.iter().map(|k| &all.pieces[*k]);
            let windows: Vec<&Piece> = of_run.filter(|piece| piece.run == number).collect();
            if windows.is_empty() {
                continue;
            }
            let cut = Cut::new(run, &all.runs[number], &windows);
            let cut = cut.map_err(|source| DiagnoseError::Simulation {
                run: name_of(number, run),
                source,
            })?;
            for (piece, from) in windows.iter().zip(cut.begins) {
                let len = piece.to - piece.from;
                pieces.push(Piece {
                    run: recordings.len(),
                    from,
                    to: from + len,
                    at,
                    ..(*piece).clone()
                });
                at += len;
            }
            recordings.push(cut.recording);
            shorter.push(cut.run);
        }
        Ok(Some(Self {
            pieces: Pieces::of(recordings, pieces, all.arrivals_s),
            runs: shorter,
        }))
    }
}

/// What a piece has in it: what the motor does, and in which part of its range the command is.
type Cell = (Regime, i32);

/// Numbers of the pieces that are searched, in order.
fn drawn(all: &Pieces) -> BTreeSet<usize> {
    let mut cells: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    let commands = all.runs.iter().flat_map(|run| &run.command);
    let largest = commands.fold(f64::MIN_POSITIVE, |most, u| most.max(u.abs()));
    let mut of_piece: Vec<Vec<Cell>> = Vec::with_capacity(all.pieces.len());
    let mut pieces = all.pieces.iter().enumerate().peekable();
    for (number, run) in all.runs.iter().enumerate() {
        let regimes = regimes(run);
        while let Some((k, piece)) = pieces.next_if(|(_, piece)| piece.run == number) {
            let cell = |k: usize| {
                let level = COMMAND_LEVELS * run.command[k] / largest;
                (
                    regimes[k],
                    level.signum() as i32 * level.abs().ceil() as i32,
                )
            };
            let seen: BTreeSet<Cell> = (piece.from..piece.to).map(cell).collect();
            for cell in &seen {
                cells.entry(*cell).or_default().push(k);
            }
            of_piece.push(seen.into_iter().collect());
        }
    }
    let mut drawn = BTreeSet::new();
    let mut of_cell: BTreeMap<Cell, BTreeSet<usize>> = BTreeMap::new();
    let mut samples = 0;
    while samples < SEARCHED_SAMPLES && !cells.is_empty() {
        let taken = |cell: &Cell| of_cell.get(cell).map_or(0, BTreeSet::len);
        // Of those with as few, the one that has fewest to give.
        let fewest = (cells.iter()).min_by_key(|(cell, pieces)| (taken(cell), pieces.len()));
        let Some(cell) = fewest.map(|(cell, _)| *cell) else {
            break;
        };
        let others = of_cell.get(&cell);
        let Some(piece) = farthest(&cells[&cell], others) else {
            cells.remove(&cell);
            continue;
        };
        drawn.insert(piece);
        samples += all.pieces[piece].to - all.pieces[piece].from;
        for cell in &of_piece[piece] {
            of_cell.entry(*cell).or_default().insert(piece);
        }
    }
    drawn
}

/// The piece that lies farthest from those that are drawn; the middle one where there are none.
fn farthest(pieces: &[usize], drawn: Option<&BTreeSet<usize>>) -> Option<usize> {
    let Some(drawn) = drawn else {
        return pieces.get(pieces.len() / 2).copied();
    };
    let apart = |k: &usize| {
        let before = drawn.range(..=*k).next_back().map(|other| k - other);
        let behind = drawn.range(*k..).next().map(|other| other - k);
        before.into_iter().chain(behind).min().unwrap_or(usize::MAX)
    };
    let farthest = (pieces.iter()).max_by_key(|k| (apart(k), std::cmp::Reverse(**k)))?;
    (apart(farthest) > 0).then_some(*farthest)
}

/// One recording with nothing but some pieces and what leads to them.
struct Cut {
    recording: Recording,
    run: Run,
    /// Where each piece begins.
    begins: Vec<usize>,
}

impl Cut {
    fn new(run: &Run, whole: &Recording, windows: &[&Piece]) -> Result<Self, SimulationError> {
        let lead = (LEAD_S / whole.sample_time_s).ceil() as usize;
        let (mut picked, mut begins) = (Vec::new(), Vec::new());
        let (mut resets, mut skipped) = (Vec::new(), Vec::new());
        let mut put = |sample: usize, at: usize| {
            let (reset, _) = whole.start(at);
            resets.push(Reset { sample, ..reset });
        };
        let (mut t_s, mut end, mut shift_s) = (Vec::new(), 0, whole.t_s[0]);
        for piece in windows {
            let from = piece.from.saturating_sub(lead).max(end);
            if from > end {
                let block = piece.to - piece.from;
                skipped.extend(skips(whole, end..from, block, picked.len()));
                shift_s += whole.t_s[from] - whole.t_s[end];
            }
            if from > end || end == 0 {
                put(picked.len(), from);
            }
            let begins_at = picked.len() + piece.from - from;
            if piece.from > from || (from == end && end > 0) {
                put(begins_at, piece.from);
            }
            begins.push(begins_at);
            t_s.extend((from..piece.to).map(|k| whole.t_s[k] - shift_s));
            picked.extend(from..piece.to);
            end = piece.to;
        }
        let of = |column: &[f64]| -> Vec<f64> { picked.iter().map(|k| column[*k]).collect() };
        let command = of(&whole.command);
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: run.command_kind,
        };
        let first = resets[0];
        let simulator = Simulator::new(&drive, Model::SecondOrder)?
            .cut_from(&whole.simulator)
            .starting(first.angle_rad, first.speed_rad_s)
            .resetting(resets)
            .skipping(skipped);
        let recording = Recording {
            t_s: of(&whole.t_s),
            counts: of(&whole.counts),
            speed: of(&whole.speed),
            moving: picked.iter().map(|k| whole.moving[*k]).collect(),
            command: command.clone(),
            simulator,
            first_counts: whole.first_counts,
            sample_time_s: whole.sample_time_s,
            rad: whole.rad,
            supply_v: whole.supply_v,
            known: whole.known.clone(),
            clock: whole.clock,
            is_integrated: whole.is_integrated,
            goes_round: whole.goes_round,
            top: whole.top,
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

/// What is left out of a recording before a sample, in blocks.
fn skips(
    whole: &Recording,
    left_out: std::ops::Range<usize>,
    block: usize,
    before: usize,
) -> impl Iterator<Item = Skipped> {
    // A speed between samples so far apart that rounding says little of its square.
    let apart = ((START_WINDOW_S / whole.sample_time_s).round() as usize).max(1);
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
    use crate::diagnose::fit::{Starts, response};
    use crate::diagnose::samples::motor_with;
    use crate::motor::{CommandKind, Motor, SimulationOptions, simulate};

    /// An hour of large levels, with small ones from its 40th minute on for 72 s.
    fn hour(motor: &Motor) -> Run {
        let t_s: Vec<f64> = (0..360_000).map(|k| f64::from(k) * 0.01).collect();
        let large = [4.5, 2.0, -3.0, 3.0, -4.5, -2.0, 3.7, -2.5];
        let small = [0.5, 1.2, 0.7, -0.4, -1.1, 0.9, -0.8, 0.3];
        let level = |t_s: f64| {
            let levels = match (2400.0..2472.0).contains(&t_s) {
                true => small,
                false => large,
            };
            levels[(t_s / 0.7) as usize % 8]
        };
        let command: Vec<f64> = t_s.iter().map(|t_s| level(*t_s)).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let simulated = simulate(motor, &drive, &SimulationOptions::default()).expect("a motor");
        Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            counts: simulated.counts,
            t_s,
            command,
            ..Run::default()
        }
    }

    /// Of an hour a bounded part is searched: of all of its time, and as much of what is in few of its pieces as of anything else.
    #[test]
    fn an_hour_is_searched_by_pieces_of_every_kind() {
        let runs = [hour(&Motor::default())];
        let all = Pieces::new(&runs, &Motor::default()).expect("a run");
        let thinned = Thinned::new(&all, &runs).expect("a run").expect("long");
        let searched = &thinned.pieces;
        assert_eq!(all.pieces.len(), 3600);
        assert_eq!(searched.len, SEARCHED_SAMPLES);
        assert_eq!(searched.pieces.len(), SEARCHED_SAMPLES / 100);
        let begins = |piece: &Piece| searched.runs[0].t_s[piece.from];
        let within = |from_s: f64, to_s: f64| {
            let begins = searched.pieces.iter().map(begins);
            begins.filter(|t_s| (from_s..to_s).contains(t_s)).count()
        };
        for tenth in (0..10).map(|k| 360.0 * f64::from(k)) {
            assert!(within(tenth, tenth + 360.0) >= 5, "{tenth}");
        }
        let of_small = within(2399.0, 2472.0);
        assert!(of_small > 30, "{of_small} of 73");
        // Each piece says what it says in the whole.
        for piece in &searched.pieces {
            let from = (begins(piece) / 0.01).round() as usize;
            let whole = all.pieces.iter().find(|other| other.from == from);
            let whole = whole.expect("a piece of the whole");
            assert_eq!(
                searched.counts[searched.range(piece)],
                all.counts[all.range(whole)]
            );
            assert_eq!(piece.start_speed_sd, whole.start_speed_sd);
        }
        let shorter = Pieces::new(&[hour_of(&runs[0], 16_000)], &Motor::default()).expect("a run");
        let thinned = Thinned::new(&shorter, &runs).expect("a run");
        assert!(thinned.is_none());
    }

    fn hour_of(run: &Run, samples: usize) -> Run {
        Run {
            t_s: run.t_s[..samples].to_vec(),
            command: run.command[..samples].to_vec(),
            counts: run.counts[..samples].to_vec(),
            ..run.clone()
        }
    }

    /// What nobody measures at a piece's start is there as it is where the whole recording is simulated: heat, the side of a gap, a
    /// command under way.
    #[test]
    fn what_is_hidden_goes_on_through_what_is_left_out() {
        for (id, values) in [
            ("winding_heating", &[0.5, 60.0][..]),
            ("magnet_weakening", &[0.3, 20.0]),
            ("backlash", &[0.05, 0.5, 0.0]),
            ("transport_delay", &[0.1]),
        ] {
            let motor = motor_with(&[(id, values)]);
            let runs = [hour_of(&hour(&motor), 60_000)];
            let all = Pieces::new(&runs, &Motor::default()).expect("a run");
            let thinned = Thinned::new(&all, &runs).expect("a run").expect("long");
            let starts = Starts::measured(&thinned.pieces);
            let whole = response(&all, &motor, &Starts::measured(&all)).expect("a motor");
            let part = response(&thinned.pieces, &motor, &starts).expect("a motor");
            let plain = response(&thinned.pieces, &Motor::default(), &starts).expect("a motor");
            let (mut apart, mut does) = (0.0, 0.0);
            for piece in &thinned.pieces.pieces {
                let from_s = thinned.pieces.runs[0].t_s[piece.from];
                let mut others = all.pieces.iter();
                let other = others.find(|other| all.runs[0].t_s[other.from] == from_s);
                let own = thinned.pieces.range(piece);
                let own_whole = all.range(other.expect("a piece of the whole"));
                for (k, j) in own.zip(own_whole) {
                    apart += (part[k] - whole[j]).powi(2);
                    does += (part[k] - plain[k]).powi(2);
                }
            }
            let [apart, does] = [apart, does].map(|sum| (sum / part.len() as f64).sqrt());
            assert!(apart < 0.1 && does > 10.0 * apart, "{id}: {apart} {does}");
        }
    }
}
