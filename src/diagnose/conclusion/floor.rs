//! What is not asked to be explained: what rounding leaves, what repeats of the same commands differ by, what is good enough; and
//! beside it what a load that wanders leaves.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::Grounds;
use crate::diagnose::fit::{Fit, Left, less_start};
use crate::diagnose::noise::Noise;
use crate::diagnose::pieces::{Pieces, Recording, Thinned};
use crate::diagnose::report::{FloorParts, GoodEnough};
use crate::diagnose::settings::{NULLS, REPEATED_SHARE, ROUNDING, SAME_COMMAND, START_PHASES};
use crate::diagnose::validation::residual_by_chance;
use crate::motor::fit::{Simulator, Workspace};
use crate::motor::{CommandKind, Drive, Model, Motor, SimulationError};
use crate::recording::Run;

impl FloorParts {
    /// The largest of the parts, in counts.
    pub(crate) fn largest(&self) -> f64 {
        let stated = [self.repeats, self.good_enough];
        stated.into_iter().flatten().fold(self.rounding, f64::max)
    }
}

/// The floor of these runs. What rounding leaves is that of the motor without effects: where one slips or jumps, a start's error grows
/// beyond what rounding makes.
pub(crate) fn floor_parts(grounds: &Grounds<'_>) -> FloorParts {
    let mut apart = repeats(grounds.runs, grounds.all, grounds.repeats);
    apart.extend(
        grounds
            .reference
            .map_or(&[][..], |reference| &reference.repeats),
    );
    let kind = grounds.base.kind;
    let refitted = &grounds.found.refitted;
    let motor = refitted.model.motor(&refitted.x);
    let motor = (&motor, refitted.around.time_constant_s);
    let rounding = match grounds.thinned {
        None => rounding(grounds.runs, grounds.all, motor, kind),
        Some(Thinned { runs, .. }) => (Pieces::new(runs, motor.0).ok())
            .and_then(|pieces| rounding(runs, &pieces, motor, kind)),
    };
    FloorParts {
        // A motor that cannot be simulated so far ahead: rounding of a sample (Widrow).
        rounding: rounding.unwrap_or(ROUNDING.sqrt()),
        repeats: (!apart.is_empty()).then(|| median(apart)),
        good_enough: grounds.good_enough.map(|good| match good {
            GoodEnough::Counts(counts) => counts,
            GoodEnough::Share(share) => share * travel(grounds.all),
        }),
    }
}

/// Travel of a piece in counts, from its lowest to its highest; the median of the pieces.
pub(crate) fn travel(pieces: &Pieces) -> f64 {
    let of_piece = |piece| {
        let counts = &pieces.counts[pieces.range(piece)];
        let (lo, hi) =
            (counts.iter()).fold((0.0_f64, 0.0_f64), |(lo, hi), n| (lo.min(*n), hi.max(*n)));
        hi - lo
    };
    median(pieces.pieces.iter().map(of_piece).collect())
}

/// The middle one; of an even number the mean of the two. 0 of none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// What a motor leaves of recordings of itself, in counts RMS: each run simulated as a whole, rounded down, and predicted in pieces.
fn rounding(
    runs: &[Run],
    pieces: &Pieces,
    (motor, time_constant_s): (&Motor, f64),
    kind: CommandKind,
) -> Option<f64> {
    let mut sum = 0.0;
    for phase in START_PHASES {
        let mut rounded = runs.to_vec();
        for (run, recording) in rounded.iter_mut().zip(&pieces.runs) {
            run.counts = simulated(run, recording, motor, kind, phase).ok()?;
        }
        let own = Pieces::new(&rounded, motor).ok()?;
        let left = Left::of(&own, motor, time_constant_s)?;
        sum += left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64;
    }
    Some((sum / START_PHASES.len() as f64).sqrt())
}

/// Counts of a motor from this share of a count beyond where a run begins.
fn simulated(
    run: &Run,
    recording: &Recording,
    motor: &Motor,
    kind: CommandKind,
    phase: f64,
) -> Result<Vec<i64>, SimulationError> {
    let drive = Drive {
        t_s: &recording.t_s,
        command: &recording.command,
        kind,
    };
    let start = (recording.first_counts + phase) * recording.rad;
    let simulator = Simulator::new(&drive, Model::SecondOrder)?
        .knowing(run.known.clone())
        .starting(start, 0.0);
    let mut angles = vec![0.0; recording.t_s.len()];
    simulator.angles(motor, &mut Workspace::default(), &mut angles)?;
    Ok((angles.iter())
        .map(|angle| (angle / recording.rad).floor() as i64)
        .collect())
}

/// What runs that repeat each other differ by, as one run's share, in counts RMS over pieces: a figure a pair, of which the median
/// counts, so that one pair does not decide. Those repeat each other that have the same commands, but for those with another known
/// disc, load or supply, and those of which it is said (`said`: numbers of runs that all repeat each other).
pub(crate) fn repeats(runs: &[Run], pieces: &Pieces, said: &[Vec<usize>]) -> Vec<f64> {
    let mut found = Vec::new();
    for (i, a) in pieces.runs.iter().enumerate() {
        for (j, b) in pieces.runs.iter().enumerate().skip(i + 1) {
            let is_said = said
                .iter()
                .any(|group| group.contains(&i) && group.contains(&j));
            if !is_said && (runs[i].known != runs[j].known || !is_repeated(a, b)) {
                continue;
            }
            let (mut sum, mut samples) = (0.0, 0);
            for piece in pieces.pieces.iter().filter(|piece| piece.run == i) {
                let to = piece.to.min(b.t_s.len());
                if piece.from >= to {
                    continue;
                }
                let apart = |k: usize| a.counts[k] - b.counts[k];
                let first = apart(piece.from);
                sum += (piece.from..to)
                    .map(|k| (apart(k) - first).powi(2))
                    .sum::<f64>();
                samples += to - piece.from;
            }
            if samples > 0 {
                found.push((0.5 * sum / samples as f64).sqrt());
            }
        }
    }
    found
}

/// Whether two runs have the same commands within one sample, at the same sample time, over nearly the same length.
fn is_repeated(a: &Recording, b: &Recording) -> bool {
    let (n, m) = (a.command.len(), b.command.len());
    let shorter = n.min(m);
    let is_long = shorter as f64 >= REPEATED_SHARE * n.max(m) as f64;
    let is_timed_alike = (a.sample_time_s / b.sample_time_s - 1.0).abs() < SAME_COMMAND;
    let largest = a.command.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let is_same = |k: usize| {
        let near = k.saturating_sub(1)..(k + 2).min(m);
        b.command[near]
            .iter()
            .any(|u| (u - a.command[k]).abs() <= SAME_COMMAND * largest)
    };
    is_long && is_timed_alike && (0..shorter).all(is_same)
}

/// What a load that wanders leaves beside rounding, in counts RMS, by recordings simulated with the noise that was found.
pub(crate) fn wander(pieces: &Pieces, fit: &Fit) -> f64 {
    let predicted = fit.predicted(pieces);
    let mean_square = |noise: Noise| -> f64 {
        let one = |seed: u64| {
            let mut random = Pcg64Mcg::seed_from_u64(0x666c_6f6f ^ seed);
            let left = residual_by_chance(pieces, &predicted, &fit.around, noise, &mut random);
            let left = less_start(pieces, fit.around.time_constant_s, &left);
            left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64
        };
        // Added in the order of the seeds: in that of the threads the last bits would be theirs.
        let each: Vec<f64> = (0..NULLS as u64).into_par_iter().map(one).collect();
        each.iter().sum::<f64>() / NULLS as f64
    };
    (mean_square(fit.noise) - mean_square(Noise::NONE))
        .max(0.0)
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;

    fn floor_of(runs: &[Run], said: &[Vec<usize>]) -> Option<f64> {
        let pieces = Pieces::new(runs, &Motor::default()).expect("runs");
        let found = repeats(runs, &pieces, said);
        (!found.is_empty()).then(|| median(found))
    }

    fn floor(runs: &[Run]) -> Option<f64> {
        floor_of(runs, &[])
    }

    /// Two runs that differ by 2 counts at every other sample differ by 2/sqrt(2) RMS, of which one run's share is 1 (by hand).
    #[test]
    fn repeats_are_told_by_their_commands() {
        let a = recording(&Motor::default(), 500);
        let mut b = a.clone();
        for count in b.counts.iter_mut().skip(1).step_by(2) {
            *count += 2;
        }
        let found = floor(&[a.clone(), b.clone()]).expect("repeats");
        assert!((found - 1.0).abs() < 1e-9, "{found}");
        // Commands one sample late repeat; others do not.
        b.command.rotate_right(1);
        b.command[0] = b.command[1];
        assert!(floor(&[a.clone(), b.clone()]).is_some());
        let mut with_a_disc = a.clone();
        (with_a_disc.known.set("inertia_added_kg_m2", 0.002)).expect("a known key");
        assert_eq!(floor(&[a.clone(), with_a_disc]), None);
        b.command.iter_mut().for_each(|u| *u *= 0.9);
        let both = [a, b];
        assert_eq!(floor(&both), None);
        // But for those of which it is said.
        let said = floor_of(&both, &[vec![0, 1]]).expect("said repeats");
        assert!((said - 1.0).abs() < 1e-9, "{said}");
        assert_eq!(floor_of(&both, &[vec![0, 2]]), None);
    }

    /// One pair that differs widely does not decide.
    #[test]
    fn one_odd_repeat_does_not_decide() {
        let a = recording(&Motor::default(), 500);
        let mut odd = a.clone();
        for (k, count) in odd.counts.iter_mut().enumerate() {
            *count += 3 * k as i64;
        }
        let found = floor(&[a.clone(), a.clone(), a.clone(), a, odd]).expect("repeats");
        assert!(found.abs() < 1e-9, "{found}");
    }

    /// Rounding of a sample alone leaves 1/sqrt(12) counts (Widrow); the starts of pieces are taken off nearly, and no more than that.
    #[test]
    fn rounding_leaves_what_the_closed_form_bounds() {
        let runs = [recording(&Motor::default(), 1000)];
        let pieces = Pieces::new(&runs, &Motor::default()).expect("a run");
        let found = rounding(
            &runs,
            &pieces,
            (&Motor::default(), 0.034),
            CommandKind::Voltage,
        )
        .expect("a motor");
        assert!(
            found > 0.8 * ROUNDING.sqrt() && found < 1.3 * ROUNDING.sqrt(),
            "{found}"
        );
    }
}
