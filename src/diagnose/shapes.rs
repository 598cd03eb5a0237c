//! The shapes of an acceleration that nobody has written an equation for (`unknown.rs`): bumps over speed, harmonics of the
//! angle, slow waves of time, shapes of the command, and an oscillation of some frequency.

use std::sync::Arc;

use super::data::RunData;
use super::noise::{Carried, NoiseLevel, Whitener};
use super::problem::{Columns, Problem};

/// Standard deviation of each shape's coefficient, as a share of the largest acceleration.
const PRIOR_SHARE: f64 = 0.03;
/// How much smaller the standard deviation of each coefficient may be besides, one as plausible as the other.
const SIZES: [f64; 3] = [1.0, 0.2, 0.04];
/// Highest frequency that samples tell of, as a share of their rate.
pub(super) const FASTEST: f64 = 0.25;
/// How many runs, the longest, may swing each in its own way.
const SWINGING_RUNS: usize = 6;

/// On what an acceleration depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Dependence {
    /// Speed.
    Speed,
    /// Angle.
    Angle,
    /// Time.
    Time,
    /// Command.
    Command,
}

impl Dependence {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Speed, Self::Angle, Self::Time, Self::Command];

    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Angle => "angle",
            Self::Time => "time",
            Self::Command => "voltage",
        }
    }
}

/// A group of shapes with a prior in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Group {
    /// Smooth functions of one thing.
    Smooth(Dependence),
    /// A swing at this frequency in Hz, of an amplitude and a phase of its own in each run.
    Oscillation(f64),
}

impl Group {
    /// All that are smooth.
    pub const SMOOTH: [Self; 4] = [
        Self::Smooth(Dependence::Speed),
        Self::Smooth(Dependence::Angle),
        Self::Smooth(Dependence::Time),
        Self::Smooth(Dependence::Command),
    ];

    /// On what it depends.
    pub fn depends_on(self) -> Dependence {
        match self {
            Self::Smooth(dependence) => dependence,
            Self::Oscillation(_) => Dependence::Time,
        }
    }

    /// The frequency in Hz at which it swings, if it does.
    pub fn oscillation_hz(self) -> Option<f64> {
        match self {
            Self::Smooth(_) => None,
            Self::Oscillation(hz) => Some(hz),
        }
    }

    /// The stage that an acceleration of these shapes points to.
    pub fn stage(self) -> &'static str {
        match self {
            Self::Smooth(Dependence::Speed | Dependence::Angle) | Self::Oscillation(_) => {
                "mechanical"
            }
            Self::Smooth(Dependence::Time) => "electrical",
            Self::Smooth(Dependence::Command) => "driver",
        }
    }

    /// Whitened answers of the runs to each shape on a level of the noise, in standard deviations of its prior.
    pub fn columns(
        self,
        problem: &Problem<'_>,
        level: &NoiseLevel,
        largest_acceleration: f64,
    ) -> Arc<Columns> {
        let whiteners = problem.whiteners(level);
        match self {
            Self::Smooth(dependence) => {
                let make = || smooth_columns(problem, &whiteners, dependence, largest_acceleration);
                if level.is_shared() && problem.keeps_columns() {
                    problem
                        .shapes
                        .of((level.wander.to_bits(), dependence), make)
                } else {
                    Arc::new(make())
                }
            }
            Self::Oscillation(hz) => Arc::new(swinging_columns(
                problem,
                &whiteners,
                hz,
                largest_acceleration,
            )),
        }
    }
}

/// What a group gains.
pub(super) struct Gains {
    pub group: Group,
    /// With the size that suits it best, at the price of the choice.
    pub log_gain: f64,
    /// That size.
    pub size: f64,
    /// With the largest size.
    pub of_large: f64,
}

impl Gains {
    /// Of a group that gains so much with a size.
    pub fn of(group: Group, gain: impl Fn(f64) -> f64) -> Self {
        let (mut size, mut most) = (1.0, f64::NEG_INFINITY);
        for tried in SIZES {
            let gain = gain(tried);
            if gain > most {
                (size, most) = (tried, gain);
            }
        }
        Self {
            group,
            log_gain: most - (SIZES.len() as f64).ln(),
            size,
            of_large: gain(SIZES[0]),
        }
    }
}

fn shapes(dependence: Dependence) -> usize {
    match dependence {
        Dependence::Speed => 10,
        Dependence::Angle => 12,
        Dependence::Time => 12,
        Dependence::Command => 4,
    }
}

/// Shape `j` of a dependence at sample `k`, of size about 1.
fn shape(dependence: Dependence, j: usize, run: &RunData, k: usize) -> f64 {
    match dependence {
        Dependence::Speed => {
            let x = run.speed_counts_s[k] / run.top_speed_counts_s;
            // Closer together near standstill, where friction has its features.
            const CENTRES: [f64; 10] = [-1.0, -0.5, -0.2, -0.07, -0.02, 0.02, 0.07, 0.2, 0.5, 1.0];
            let centre = CENTRES[j];
            let width = 0.5 * f64::abs(centre) + 0.02;
            (-0.5 * ((x - centre) / width).powi(2)).exp()
        }
        Dependence::Angle => {
            let counts = run.first_counts + run.counts[k];
            let angle = counts * std::f64::consts::TAU / run.counts_per_rev;
            let order = (j / 2 + 1) as f64;
            if j.is_multiple_of(2) {
                (order * angle).sin()
            } else {
                (order * angle).cos()
            }
        }
        Dependence::Time => {
            let x = run.t_s[k] / run.t_s.last().copied().unwrap_or(1.0).max(1e-9);
            let direction = run.speed_counts_s[k].signum();
            // What a torque constant or a resistance that drifts does goes with the command and the speed.
            if let Some(drift) = j.checked_sub(8) {
                let wave = ((drift / 2 + 1) as f64 * std::f64::consts::PI * x).cos();
                return wave
                    * if drift.is_multiple_of(2) {
                        run.command[k] / run.largest_command
                    } else {
                        run.speed_counts_s[k] / run.top_speed_counts_s
                    };
            }
            let wave = ((j / 2 + 1) as f64 * std::f64::consts::PI * x).cos();
            if j.is_multiple_of(2) {
                wave
            } else {
                wave * direction
            }
        }
        Dependence::Command => {
            let x = run.command[k] / run.largest_command;
            match j {
                0 => x * x.abs(),
                1 => x.powi(3),
                2 => x.signum() * f64::from(u8::from(x != 0.0)),
                _ => x.abs(),
            }
        }
    }
}

fn smooth_columns(
    problem: &Problem<'_>,
    whiteners: &[Whitener],
    dependence: Dependence,
    largest_acceleration: f64,
) -> Vec<Vec<f64>> {
    let count = shapes(dependence);
    let mut columns = vec![Vec::new(); count];
    let mut carried = vec![Carried::default(); count];
    let answering = problem.runs.iter().zip(problem.responses.iter());
    for ((run, response), whitener) in answering.zip(whiteners) {
        let answer = |j: usize| {
            let acceleration: Vec<f64> = (0..run.len())
                .map(|k| largest_acceleration * PRIOR_SHARE * shape(dependence, j, run, k))
                .collect();
            response.to(&acceleration)
        };
        let mut answers: Vec<Vec<f64>> = (0..count).map(answer).collect();
        whitener.whiten_all_on(&mut carried, &mut answers);
        for (all, answer) in columns.iter_mut().zip(answers) {
            all.extend(answer);
        }
    }
    columns
}

/// Whether the samples of a run tell of a frequency.
pub(super) fn is_told(run: &RunData, hz: f64) -> bool {
    hz * run.sample_time_s <= FASTEST
}

/// The runs that may swing at a frequency each in its own way: the longest of those that tell of it.
pub(super) fn swinging(runs: &[RunData], hz: f64) -> Vec<usize> {
    let mut found: Vec<usize> = (0..runs.len()).filter(|&k| is_told(&runs[k], hz)).collect();
    found.sort_by(|&a, &b| runs[b].length_s().total_cmp(&runs[a].length_s()));
    found.truncate(SWINGING_RUNS);
    found
}

/// Whitened answers to a sine and a cosine of this frequency in each run that may swing so, in standard deviations of their
/// prior.
fn swinging_columns(
    problem: &Problem<'_>,
    whiteners: &[Whitener],
    hz: f64,
    largest_acceleration: f64,
) -> Vec<Vec<f64>> {
    let runs = problem.runs;
    let total: usize = runs.iter().map(RunData::len).sum();
    let swinging = swinging(runs, hz);
    let mut all = Vec::with_capacity(2 * swinging.len());
    let mut from = 0;
    for (k, run) in runs.iter().enumerate() {
        if swinging.contains(&k) {
            for shift in [0.0, std::f64::consts::FRAC_PI_2] {
                let swing = |t_s: &f64| (std::f64::consts::TAU * hz * t_s + shift).sin();
                let swings = run.t_s.iter().map(swing);
                let acceleration: Vec<f64> = swings
                    .map(|x| largest_acceleration * PRIOR_SHARE * x)
                    .collect();
                let mut own = problem.responses[k].to(&acceleration);
                whiteners[k].whiten_on(&mut Carried::default(), &mut own);
                let mut column = vec![0.0; total];
                column[from..from + own.len()].copy_from_slice(&own);
                all.push(column);
            }
        }
        from += run.len();
    }
    all
}
