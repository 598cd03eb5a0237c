//! Runs cut into the pieces that are fitted, predicted and drawn again.
//!
//! A piece starts from the angle and the speed measured at its first sample; what cannot be measured (heat, current, the side of a
//! gap, a command under way) goes on from what came before (multiple shooting: Bock, 1983).

mod regimes;
mod thin;
mod work;

pub(crate) use regimes::regimes;
pub(crate) use thin::Thinned;
pub(crate) use work::Work;

use crate::check::host_clock::host_clock;
use crate::least_squares::{Record, start_of};
use crate::motor::fit::{Reset, Simulator};
use crate::motor::{Drive, KnownDifferences, Model, Motor, SimulationError};
use crate::recording::Run;

use super::error::{DiagnoseError, name_of};
use super::noise::Noise;
use super::settings::{
    FEW_PIECES, FOLDS, LONGEST_TIME_CONSTANT_S, PIECE_S, PIECE_SAMPLES, PIECE_TIME_CONSTANTS,
    REST_SAMPLES, ROUNDING, SPEED_WINDOW_S, START_SPEED_SHARE, START_WINDOW_S, STRETCH_SAMPLES,
};

/// One run made ready.
#[derive(Debug, Clone)]
pub(crate) struct Recording {
    pub t_s: Vec<f64>,
    pub command: Vec<f64>,
    /// Counts from the first sample.
    pub counts: Vec<f64>,
    /// Counts that the first sample showed.
    pub first_counts: f64,
    /// Speed in counts/s, smoothed.
    pub speed: Vec<f64>,
    /// Whether the shaft moves.
    pub moving: Vec<bool>,
    pub sample_time_s: f64,
    /// Rad a count.
    pub rad: f64,
    /// The supply in V that the run states.
    pub supply_v: Option<f64>,
    /// What is known to differ in it.
    pub known: KnownDifferences,
    /// Error of the board's clock as the host saw it, and over how many seconds.
    pub clock: Option<(f64, f64)>,
    /// Whether the position is integrated from logged speeds.
    pub is_integrated: bool,
    /// Whether the shaft turns by half a turn or more from one sample to the next.
    pub goes_round: bool,
    /// Largest speed in counts/s, 1 at least.
    pub top: f64,
    pub simulator: Simulator,
}

/// A stretch of one run.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub run: usize,
    pub from: usize,
    pub to: usize,
    /// Where its samples begin among those of all pieces.
    pub at: usize,
    /// Its fold, where pieces are enough to be held out whole.
    pub fold: usize,
    /// Uncertainty of its start speed in counts/s.
    pub start_speed_sd: f64,
}

/// What is held out together: a piece, or where pieces are few some samples of one. Of a step the start is in one piece, which no fit on
/// the others foresees.
#[derive(Debug, Clone)]
pub(crate) struct Stretch {
    pub piece: usize,
    /// Its samples among those of all pieces.
    pub samples: std::ops::Range<usize>,
    pub fold: usize,
}

/// All pieces of all runs.
#[derive(Debug, Clone)]
pub(crate) struct Pieces {
    pub runs: Vec<Recording>,
    pub pieces: Vec<Piece>,
    pub stretches: Vec<Stretch>,
    /// Samples in all.
    pub len: usize,
    /// Counts from the piece's first sample, piece after piece.
    pub counts: Vec<f64>,
    /// How much of a look of its own each sample is.
    pub weight: Vec<f64>,
    /// By up to how many seconds samples are late by the line alone: of times that are arrivals at the host.
    pub arrivals_s: f64,
    pub folds: usize,
    /// What is simulated of these, and of copies of them.
    pub work: Work,
}

impl Recording {
    fn new(run: &Run) -> Result<Self, SimulationError> {
        let first = run.counts.first().copied().unwrap_or(0);
        let counts: Vec<f64> = (run.counts.iter())
            .map(|&n| (i128::from(n) - i128::from(first)) as f64)
            .collect();
        let mut steps: Vec<f64> = run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let sample_time_s = steps
            .get(steps.len() / 2)
            .copied()
            .unwrap_or(run.sample_time_s);
        let half = ((SPEED_WINDOW_S / sample_time_s).round() as usize).clamp(1, 1000);
        let last = counts.len().saturating_sub(1);
        let (mut speed, mut moving) = (Vec::new(), Vec::new());
        for k in 0..counts.len() {
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let span_s = (run.t_s[to] - run.t_s[from]).max(sample_time_s);
            speed.push((counts[to] - counts[from]) / span_s);
            // More than the one count that an edge on the boundary dithers by, there and back included: a shaft that turns round does
            // not rest.
            let seen = &counts[from..=to];
            let (low, high) = (seen.iter())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), n| {
                    (a.min(*n), b.max(*n))
                });
            moving.push(high - low >= 1.5);
        }
        let command = run.driving_command();
        let drive = Drive {
            t_s: &run.t_s,
            command: &command,
            kind: run.command_kind,
        };
        let simulator = Simulator::new(&drive, Model::SecondOrder)?
            .knowing(run.known.clone())
            .filtering_samples(run.is_integrated_backward());
        let half_turn = 0.5 * run.counts_per_rev;
        Ok(Self {
            is_integrated: run.is_integrated(),
            goes_round: (counts.windows(2)).any(|pair| (pair[1] - pair[0]).abs() >= half_turn),
            top: speed.iter().fold(1.0_f64, |most, v| most.max(v.abs())),
            t_s: run.t_s.clone(),
            command: command.into_owned(),
            counts,
            first_counts: first as f64,
            speed,
            moving,
            sample_time_s,
            rad: std::f64::consts::TAU / run.counts_per_rev,
            supply_v: run.supply_v,
            known: run.known.clone(),
            clock: host_clock(run),
            simulator,
        })
    }

    /// Speed at a sample in counts/s, and its uncertainty. A run begins as its first samples say; later a line through the samples
    /// around gives the speed, and by how much those before and those behind differ says how far to trust it.
    fn start_speed(&self, k: usize) -> (f64, f64) {
        if k == 0 {
            let counts_per_rev = std::f64::consts::TAU / self.rad;
            let record = Record::from_rest(&self.t_s, &self.command, &self.counts, counts_per_rev);
            let start = start_of(&record);
            return (start.speed_counts_s, start.variance.sqrt());
        }
        if !self.moving[k] {
            return (0.0, 0.0);
        }
        let half = ((START_WINDOW_S / self.sample_time_s).ceil() as usize).max(2);
        let (from, to) = (
            k.saturating_sub(half),
            (k + half).min(self.counts.len() - 1),
        );
        let line = |from: usize, to: usize| slope(&self.t_s[from..=to], &self.counts[from..=to]);
        let share = START_SPEED_SHARE * self.top;
        match (line(from, to), line(from, k), line(k, to)) {
            (Some((speed, sd)), Some((before, _)), Some((behind, _))) => {
                let bend = 0.5 * (behind - before);
                (speed, sd.hypot(share).hypot(bend))
            }
            _ => (self.speed[k], (1.0 / (2.0 * SPEED_WINDOW_S)).hypot(share)),
        }
    }
}

impl Recording {
    /// By how many counts (one sigma) the scatter of a logged speed moves the position that is integrated from it, at a sample.
    pub fn scatter(&self, noise: Noise, k: usize) -> f64 {
        if !self.is_integrated || !self.moving[k] {
            return 0.0;
        }
        noise.speed_counts_s * (self.t_s[k] - self.t_s[k - 1])
    }

    /// Where the shaft is put at a sample, with the uncertainty of its speed in counts/s.
    fn start(&self, sample: usize) -> (Reset, f64) {
        let (speed, sd) = self.start_speed(sample);
        let reset = Reset {
            sample,
            angle_rad: (self.first_counts + self.counts[sample]) * self.rad,
            speed_rad_s: speed * self.rad,
        };
        (reset, sd)
    }
}

/// The stretches of pieces, dealt to folds in turn.
fn stretches(pieces: &[Piece]) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let n = piece.to - piece.from;
        let count = if pieces.len() < FEW_PIECES {
            (n / STRETCH_SAMPLES).max(1)
        } else {
            1
        };
        for j in 0..count {
            found.push(Stretch {
                piece: k,
                samples: piece.at + j * n / count..piece.at + (j + 1) * n / count,
                fold: found.len() % FOLDS,
            });
        }
    }
    found
}

/// How many samples from the first on are one look at a shaft that rests: those of one count, or of two beside each other between
/// which the encoder dithers.
fn at_rest(seen: &[f64]) -> usize {
    let first = seen[0];
    let same = seen.iter().take_while(|n| **n == first).count();
    let Some(&second) = seen.get(same) else {
        return same;
    };
    let mut after = seen[same..].iter().skip_while(|n| **n == second);
    if (second - first).abs() == 1.0 && after.next() == Some(&first) {
        let of_both = seen.iter().take_while(|n| **n == first || **n == second);
        return of_both.count();
    }
    same
}

/// Width in s of an even spread of arrivals about even times that makes the intervals scatter as they do.
fn scatter_s(t_s: &[f64]) -> f64 {
    let n = (t_s.len() - 1) as f64;
    let mean = (t_s[t_s.len() - 1] - t_s[0]) / n;
    let squares = t_s
        .windows(2)
        .map(|pair| (pair[1] - pair[0] - mean).powi(2));
    // An interval has the scatter of two arrivals, and an even spread of width 1 has the variance 1/12.
    (squares.sum::<f64>() / n / 2.0 * 12.0).sqrt()
}

/// Slope of a line through samples, with its standard deviation by rounding.
fn slope(t_s: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let n = t_s.len() as f64;
    let (mt, my) = (t_s.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let stt: f64 = t_s.iter().map(|t| (t - mt).powi(2)).sum();
    let sty: f64 = t_s.iter().zip(y).map(|(t, y)| (t - mt) * (y - my)).sum();
    (stt > 0.0).then(|| (sty / stt, (ROUNDING / stt).sqrt()))
}

impl Pieces {
    /// Cuts runs of a motor.
    pub fn new(runs: &[Run], motor: &Motor) -> Result<Self, DiagnoseError> {
        let mut recordings = Vec::new();
        for (k, run) in runs.iter().enumerate() {
            let made = Recording::new(run).map_err(|source| DiagnoseError::Simulation {
                run: name_of(k, run),
                source,
            });
            recordings.push(made?);
        }
        let p = &motor.parameters;
        let coupling = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
        let damping = (p.viscous_friction_nm_s_per_rad + coupling).max(f64::MIN_POSITIVE);
        let time_constant_s = p.inertia_kg_m2 / damping;
        let length_s =
            PIECE_S.max(PIECE_TIME_CONSTANTS * time_constant_s.min(LONGEST_TIME_CONSTANT_S));
        let mut pieces = Vec::new();
        let mut len = 0;
        for (number, run) in recordings.iter_mut().enumerate() {
            let n = run.t_s.len();
            let least = ((length_s / run.sample_time_s).round() as usize).max(PIECE_SAMPLES);
            let count = (n / least).max(1);
            let mut resets = Vec::new();
            for j in 0..count {
                let (from, to) = (j * n / count, (j + 1) * n / count);
                let (reset, sd) = run.start(from);
                resets.push(reset);
                pieces.push(Piece {
                    run: number,
                    from,
                    to,
                    at: len,
                    fold: 0,
                    start_speed_sd: sd,
                });
                len += to - from;
            }
            let first = resets.remove(0);
            run.simulator = (run.simulator.clone())
                .starting(first.angle_rad, first.speed_rad_s)
                .resetting(resets);
        }
        let arrivals_s = (runs.iter().filter(|run| run.is_host_timed()))
            .map(|run| scatter_s(&run.t_s))
            .fold(0.0, f64::max);
        Ok(Self::of(recordings, pieces, arrivals_s))
    }

    /// Of pieces of recordings, dealt to folds in turn.
    fn of(recordings: Vec<Recording>, mut pieces: Vec<Piece>, arrivals_s: f64) -> Self {
        let len = pieces.iter().map(|piece| piece.to - piece.from).sum();
        let folds = FOLDS.min(pieces.len());
        for (k, piece) in pieces.iter_mut().enumerate() {
            piece.fold = k % folds.max(1);
        }
        let stretches = stretches(&pieces);
        let mut counts = Vec::with_capacity(len);
        let mut weight = Vec::with_capacity(len);
        for piece in &pieces {
            let seen = &recordings[piece.run].counts[piece.from..piece.to];
            counts.extend(seen.iter().map(|n| n - seen[0]));
            let mut k = 0;
            while k < seen.len() {
                let same = at_rest(&seen[k..]);
                weight.extend(std::iter::repeat_n(
                    (REST_SAMPLES / same as f64).min(1.0),
                    same,
                ));
                k += same;
            }
        }
        Self {
            arrivals_s,
            runs: recordings,
            pieces,
            stretches,
            len,
            counts,
            weight,
            folds,
            work: Work::default(),
        }
    }

    /// The pieces as a plain fit needs them, each beginning with the speed that is measured there; `counts` are those of the pieces with
    /// half a count of rounding put back.
    pub fn records<'a>(&'a self, counts: &'a [f64]) -> Vec<Record<'a>> {
        let record = |piece: &Piece| {
            let run = &self.runs[piece.run];
            let (t_s, command) = (
                &run.t_s[piece.from..piece.to],
                &run.command[piece.from..piece.to],
            );
            let per_rev = std::f64::consts::TAU / run.rad;
            Record::from_rest(t_s, command, &counts[self.range(piece)], per_rev)
                .starting(run.start_speed(piece.from).0)
        };
        self.pieces.iter().map(record).collect()
    }

    /// Samples of a piece among those of all.
    pub fn range(&self, piece: &Piece) -> std::ops::Range<usize> {
        piece.at..piece.at + (piece.to - piece.from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dither_of_one_edge_is_one_look() {
        assert_eq!(at_rest(&[4.0, 4.0, 4.0, 9.0]), 3);
        assert_eq!(at_rest(&[4.0, 5.0, 4.0, 4.0, 5.0, 6.0]), 5);
        // A shaft that turns slowly says something with every edge.
        assert_eq!(at_rest(&[4.0, 4.0, 5.0, 5.0, 6.0]), 2);
        assert_eq!(at_rest(&[4.0, 6.0, 4.0]), 1);
    }
}
