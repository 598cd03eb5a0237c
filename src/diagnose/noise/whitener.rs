//! The Kalman filter that turns the residual of a piece into independent numbers of variance 1.
//!
//! State: error of the angle in counts, of the speed in counts/s, and an acceleration that wanders (Ornstein and Uhlenbeck), in
//! counts/s^2. The motor's own damping takes errors of the speed away: `v' = -v/tau + d`, `d' = -d/T + noise`. A shaft that rests does
//! not move for it. The residual is that of the angle, with rounding of variance 1/12 (Widrow).

use super::Noise;
use super::passing::{Covariance, LogProduct, Passing, Step};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::ROUNDING;

/// What the filter has to know of motor and encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surroundings {
    /// Mechanical time constant in s.
    pub time_constant_s: f64,
    /// Acceleration in counts/s^2 that is stall torque.
    pub stall_counts_s2: f64,
    /// Samples are late by up to this, in s.
    pub jitter_s: f64,
    /// Share of edges lost by chance.
    pub loss: f64,
}

impl Surroundings {
    /// Whether others scatter where these do not, by samples that are late or edges that are lost.
    pub fn is_stiller_than(&self, others: &Self) -> bool {
        let begins = |before: f64, then: f64| before == 0.0 && then > 0.0;
        begins(self.jitter_s, others.jitter_s) || begins(self.loss, others.loss)
    }
}

/// Gains for every sample.
#[derive(Debug, Clone)]
pub(crate) struct Whitener {
    steps: Vec<Step>,
    /// First sample of each piece.
    starts: Vec<usize>,
    /// Mechanical time constant in s.
    pub time_constant_s: f64,
    /// Logarithm of the determinant of the covariance, by stretches of the pieces.
    pub log_det: Vec<f64>,
}

impl Whitener {
    pub fn new(pieces: &Pieces, around: &Surroundings, noise: Noise) -> Self {
        Self::with(pieces, around, noise, |speed, weight| {
            let late = speed * around.jitter_s;
            ROUNDING / weight + late * late / 12.0
        })
    }

    /// Every sample alike, with this variance in counts^2, nothing that wanders, and a start that is measured.
    pub fn even(pieces: &Pieces, around: &Surroundings, variance: f64) -> Self {
        let around = Surroundings {
            loss: 0.0,
            ..*around
        };
        Self::with(pieces, &around, Noise::NONE, |_, _| variance)
    }

    /// With the variance of a sample, in counts^2, by its speed in counts/s and its weight.
    fn with(
        pieces: &Pieces,
        around: &Surroundings,
        noise: Noise,
        variance: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let mut steps = Vec::with_capacity(pieces.len);
        let mut starts = Vec::new();
        let mut log_det = Vec::new();
        let sigma = noise.strength * around.stall_counts_s2;
        let mut passing = Passing::new(around.time_constant_s, noise.time_s);
        let mut ends = pieces.stretches.iter().map(|stretch| stretch.samples.end);
        let mut end = ends.next();
        for piece in &pieces.pieces {
            let run = &pieces.runs[piece.run];
            starts.push(piece.at);
            let mut p = Covariance {
                xx: ROUNDING,
                vv: piece.start_speed_sd.powi(2),
                dd: sigma * sigma,
                ..Covariance::default()
            };
            let mut log = LogProduct::default();
            steps.push(Step {
                f22: 1.0,
                f11: 1.0,
                ..Step::default()
            });
            for k in piece.from + 1..piece.to {
                let mut step = passing.step(run.t_s[k] - run.t_s[k - 1], run.moving[k]);
                p = p.after(&step);
                p.dd += sigma * sigma * (1.0 - step.f22 * step.f22);
                p.xx += run.scatter(noise, k).powi(2);
                if around.loss > 0.0 {
                    p.xx += around.loss * (run.counts[k] - run.counts[k - 1]).abs();
                }
                let r = variance(run.speed[k], pieces.weight[piece.at + k - piece.from]);
                let s = p.xx + r;
                step.gain = p.see(s);
                step.scale = 1.0 / s.sqrt();
                log.times(s);
                steps.push(step);
                if Some(steps.len()) == end {
                    log_det.push(std::mem::take(&mut log).sum());
                    end = ends.next();
                }
            }
        }
        Self {
            steps,
            starts,
            time_constant_s: around.time_constant_s,
            log_det,
        }
    }

    /// Variance of each innovation in counts^2; 0 for a piece's first sample.
    pub fn variances(&self) -> impl Iterator<Item = f64> {
        let scales = self.steps.iter().map(|step| step.scale);
        scales.map(|scale| if scale > 0.0 { scale.powi(-2) } else { 0.0 })
    }

    /// The innovations of a column, each over its standard deviation.
    pub fn whiten(&self, column: &[f64]) -> Vec<f64> {
        let [out] = self.whiten_together([column]);
        out
    }

    /// The same of several columns.
    pub fn whiten_all<'a>(&self, columns: impl IntoIterator<Item = &'a Vec<f64>>) -> Vec<Vec<f64>> {
        let columns: Vec<&Vec<f64>> = columns.into_iter().collect();
        let mut out = Vec::with_capacity(columns.len());
        let fours = columns.chunks_exact(4);
        let rest = fours.remainder();
        for four in fours {
            out.extend(self.whiten_together([four[0], four[1], four[2], four[3]]));
        }
        out.extend(rest.iter().map(|column| self.whiten(column)));
        out
    }

    /// The same of some columns in step: what one waits for, another does.
    fn whiten_together<const C: usize>(&self, columns: [&[f64]; C]) -> [Vec<f64>; C] {
        let len = self.steps.len();
        let columns = columns.map(|column| &column[..len]);
        let mut out = [(); C].map(|()| vec![0.0; len]);
        let mut starts = self.starts.iter().copied().peekable();
        let mut s = [[0.0; C]; 3];
        for (k, step) in self.steps.iter().enumerate() {
            if starts.next_if_eq(&k).is_some() {
                s = [[0.0; C]; 3];
                continue;
            }
            for c in 0..C {
                let x = s[0][c] + step.f01 * s[1][c] + step.f02 * s[2][c];
                let v = step.f11 * s[1][c] + step.f12 * s[2][c];
                let d = step.f22 * s[2][c];
                let e = columns[c][k] - x;
                s[0][c] = x + step.gain[0] * e;
                s[1][c] = v + step.gain[1] * e;
                s[2][c] = d + step.gain[2] * e;
                out[c][k] = e * step.scale;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::{Starts, response};
    use crate::diagnose::pieces::Pieces;
    use crate::diagnose::validation::residual_by_chance;
    use crate::motor::{CommandKind, Drive, Motor, SimulationOptions, simulate};
    use crate::recording::Run;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    /// The handout's motor on levels of both signs, with rests.
    fn recorded() -> Run {
        let t_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.003).collect();
        let levels = [4.5, 0.0, -2.0, 0.5, 3.0, -4.0, 0.2, 1.5];
        let command: Vec<f64> = (0..4000).map(|k| levels[k / 170 % 8]).collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let counts = simulate(&Motor::default(), &drive, &SimulationOptions::default())
            .expect("a motor")
            .counts;
        Run {
            sample_time_s: 0.003,
            counts_per_rev: 720.0,
            t_s,
            command,
            counts,
            ..Run::default()
        }
    }

    /// What is drawn by the noise's own law comes out white: the mean square where the shaft moves is 1, and so is that of a projection on
    /// something slow.
    #[test]
    fn noise_of_its_own_law_comes_out_white() {
        let pieces = Pieces::new(&[recorded()], &Motor::default()).expect("a run");
        let predicted =
            response(&pieces, &Motor::default(), &Starts::measured(&pieces)).expect("a motor");
        let around = Surroundings {
            time_constant_s: 0.034,
            stall_counts_s2: 18_000.0,
            jitter_s: 0.0,
            loss: 0.0,
        };
        for strength in [0.0, 0.003, 0.05] {
            let noise = Noise {
                strength,
                time_s: 0.2,
                ..Noise::NONE
            };
            let whitener = Whitener::new(&pieces, &around, noise);
            let ramp: Vec<f64> = (pieces.pieces.iter())
                .flat_map(|piece| (0..piece.to - piece.from).map(|k| k as f64))
                .collect();
            let ramp = whitener.whiten(&ramp);
            let length = ramp.iter().map(|v| v * v).sum::<f64>().sqrt();
            let (mut square, mut slow, mut looks) = (0.0, 0.0, 0.0);
            for seed in 0..100 {
                let mut random = Pcg64Mcg::seed_from_u64(seed);
                let residual = residual_by_chance(&pieces, &predicted, &around, noise, &mut random);
                let white = whitener.whiten(&residual);
                square += white.iter().map(|e| e * e).sum::<f64>();
                looks += pieces.weight.iter().sum::<f64>();
                slow += (white.iter().zip(&ramp).map(|(e, r)| e * r).sum::<f64>() / length).powi(2);
            }
            assert!(
                (0.6..1.4).contains(&(square / looks)),
                "{strength}: {}",
                square / looks
            );
            let slow = slow / 100.0;
            assert!(slow < 2.0, "{strength}: {slow}");
            // Rounding alone has less of what is slow than white noise has.
            assert!(slow > 0.3 || strength == 0.0, "{strength}: {slow}");
        }
    }

    /// Rounding alone, no motion to err in: the filter is the mean, and innovation `n` has variance `(1 + 1/(n + 1))/12` (closed form).
    #[test]
    fn without_wander_the_filter_is_the_running_mean() {
        let run = Run {
            sample_time_s: 0.01,
            counts_per_rev: 720.0,
            t_s: (0..60).map(|k| f64::from(k) * 0.01).collect(),
            command: vec![1.0; 60],
            counts: (0..60).map(|k| 3 * k).collect(),
            ..Run::default()
        };
        let mut pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        pieces.pieces[0].start_speed_sd = 0.0;
        let around = Surroundings {
            time_constant_s: 0.034,
            stall_counts_s2: 18_000.0,
            jitter_s: 0.0,
            loss: 0.0,
        };
        let whitener = Whitener::new(&pieces, &around, Noise::NONE);
        let column: Vec<f64> = (0..60).map(|k| f64::from(k % 5)).collect();
        let white = whitener.whiten(&column);
        let mut sum = 0.0;
        for n in 1..60 {
            let looks = n as f64;
            // The start of the piece is a look of its own, at 0.
            let expected = (column[n] - sum / looks) / (ROUNDING * (1.0 + 1.0 / looks)).sqrt();
            assert!(
                (white[n] - expected).abs() < 1e-9,
                "{n}: {} {expected}",
                white[n]
            );
            sum += column[n];
        }
    }
}
