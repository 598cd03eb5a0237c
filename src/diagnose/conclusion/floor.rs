//! What is not asked to be explained: what rounding leaves, what repeats of the same commands differ by, what is good enough; and
//! beside it what a load that wanders leaves.

use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64Mcg;

use super::Grounds;
use crate::diagnose::fit::Fit;
use crate::diagnose::noise::Noise;
use crate::diagnose::pieces::{Pieces, Recording};
use crate::diagnose::report::{FloorParts, GoodEnough};
use crate::diagnose::settings::{REPEATED_SHARE, SAME_COMMAND};
use crate::diagnose::validation::left_by_chance;
use crate::recording::Run;

impl FloorParts {
    /// The largest of the parts, in counts.
    pub(crate) fn largest(&self) -> f64 {
        let stated = [self.repeats, self.good_enough];
        stated.into_iter().flatten().fold(self.rounding, f64::max)
    }
}

/// What two runs differ by that repeat each other, as one run's share: by piece the sum of the squares in counts^2, and the samples.
#[derive(Debug, Clone)]
pub(crate) struct Apart(Vec<(f64, f64)>);

impl Apart {
    /// In counts RMS over pieces that count as they are weighed.
    fn rms(&self, mut weight: impl FnMut() -> f64) -> f64 {
        let (mut squares, mut samples) = (0.0, 0.0);
        for (of_piece, n) in &self.0 {
            let weight = weight();
            squares += weight * of_piece;
            samples += weight * n;
        }
        (squares / samples).sqrt()
    }
}

/// The floor, and what tells how well it is known.
#[derive(Debug, Clone)]
pub(crate) struct Floor {
    pub parts: FloorParts,
    /// Pairs of runs that repeat each other.
    apart: Vec<Apart>,
}

impl Floor {
    /// The floor of these runs. What rounding leaves is that of the motor without effects: where one slips or jumps, a start's error
    /// grows beyond what rounding makes.
    pub fn of(grounds: &Grounds<'_>) -> Self {
        let mut apart = repeats(grounds.runs, grounds.all, grounds.repeats);
        let of_reference = grounds.reference.map(|reference| &reference.repeats);
        apart.extend(of_reference.into_iter().flatten().cloned());
        let parts = FloorParts {
            rounding: grounds.found.still.sqrt(),
            repeats: repeated(&apart, || 1.0),
            good_enough: grounds.good_enough.map(|good| match good {
                GoodEnough::Counts(counts) => counts,
                GoodEnough::Share(share) => share * travel(grounds.all),
            }),
        };
        Self { parts, apart }
    }

    /// The floor in counts RMS with the pieces of the repeats drawn again, by the Bayesian bootstrap (Rubin, 1981).
    pub fn drawn(&self, random: &mut Pcg64Mcg) -> f64 {
        let repeats = repeated(&self.apart, || Exp1.sample(random));
        FloorParts {
            repeats,
            ..self.parts
        }
        .largest()
    }
}

/// What repeats differ by: a figure a pair, of which the median counts, so that one pair does not decide. None without repeats.
fn repeated(apart: &[Apart], mut weight: impl FnMut() -> f64) -> Option<f64> {
    let by_pair: Vec<f64> = apart.iter().map(|pair| pair.rms(&mut weight)).collect();
    (!by_pair.is_empty()).then(|| median(by_pair))
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

/// What runs that repeat each other differ by. Those do that have the same commands, but for those with another known disc, load or
/// supply, and those of which it is said (`said`: numbers of runs that all repeat each other).
pub(crate) fn repeats(runs: &[Run], pieces: &Pieces, said: &[Vec<usize>]) -> Vec<Apart> {
    let mut found = Vec::new();
    for (i, a) in pieces.runs.iter().enumerate() {
        for (j, b) in pieces.runs.iter().enumerate().skip(i + 1) {
            let is_said = said
                .iter()
                .any(|group| group.contains(&i) && group.contains(&j));
            if !is_said && (runs[i].known != runs[j].known || !is_repeated(a, b)) {
                continue;
            }
            let mut by_piece = Vec::new();
            for piece in pieces.pieces.iter().filter(|piece| piece.run == i) {
                let to = piece.to.min(b.t_s.len());
                if piece.from >= to {
                    continue;
                }
                let apart = |k: usize| a.counts[k] - b.counts[k];
                let first = apart(piece.from);
                let squares = (piece.from..to).map(|k| 0.5 * (apart(k) - first).powi(2));
                by_piece.push((squares.sum(), (to - piece.from) as f64));
            }
            if !by_piece.is_empty() {
                found.push(Apart(by_piece));
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
    let beside = left_by_chance(pieces, fit, fit.noise) - left_by_chance(pieces, fit, Noise::NONE);
    beside.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::motor::Motor;
    use rand::SeedableRng;

    impl From<FloorParts> for Floor {
        fn from(parts: FloorParts) -> Self {
            let apart = Vec::new();
            Self { parts, apart }
        }
    }

    /// A floor that one piece of ten makes alone is not known well; one that all make alike is.
    #[test]
    fn a_floor_is_known_as_well_as_its_pieces_agree() {
        let spread = |by_piece: Vec<(f64, f64)>| {
            let parts = FloorParts {
                rounding: 0.3,
                repeats: repeated(&[Apart(by_piece.clone())], || 1.0),
                good_enough: None,
            };
            let apart = vec![Apart(by_piece)];
            let floor = Floor { parts, apart };
            let mut random = Pcg64Mcg::seed_from_u64(1);
            let mut drawn: Vec<f64> = (0..1000).map(|_| floor.drawn(&mut random)).collect();
            drawn.sort_by(f64::total_cmp);
            (drawn[25], parts.largest(), drawn[974])
        };
        let (lo, middle, hi) = spread(vec![(400.0, 100.0); 10]);
        assert!((middle - 2.0).abs() < 1e-12 && (hi - lo) < 1e-9);
        let mut by_piece = vec![(0.0, 100.0); 9];
        by_piece.push((4000.0, 100.0));
        let (lo, middle, hi) = spread(by_piece);
        assert!(
            (middle - 2.0).abs() < 1e-12 && lo < 1.0 && hi > 3.0,
            "{lo} {hi}"
        );
    }

    fn floor_of(runs: &[Run], said: &[Vec<usize>]) -> Option<f64> {
        let pieces = Pieces::new(runs, &Motor::default()).expect("runs");
        repeated(&repeats(runs, &pieces, said), || 1.0)
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
}
