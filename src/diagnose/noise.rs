//! What disturbs a recording besides the model: rounding, and a load that wanders.
//!
//! The difference between counts and model is a position error `p` (counts), driven by a speed error
//! `v` and a wandering acceleration `d` (an Ornstein-Uhlenbeck process):
//!
//! `p' = v,  v' = -a v + d,  d' = -d/tau + white noise,  r_k = p(t_k) + rounding_k`
//!
//! While the shaft rests, friction holds it: `p` stays and `v` is nought. Where it starts, stops or turns
//! back, `p` takes a jump of half a count: what gives way before it slides has a law that no model knows.
//! Where the motor file says how surely the supply is known, each run has a share `g` of it too little or too much,
//! `v' = -a v + d + g u/u0`. Of a rough recording the speed walks at random too, and the encoder scatters ([`super::disturbance`]).
//!
//! A Kalman filter turns `r` into innovations that are white when the model is right, in linear time; the
//! same gains whiten every column of the Jacobian, so that least squares on innovations is maximum likelihood
//! with correlated errors. A strong wander forgets quickly and judges a model on short horizons; none at all is the
//! open loop through the whole run.
//!
//! Arrival times at the host scatter by `w`, known from their intervals: while the shaft turns at `v` counts/s that is
//! a further error of variance `(v w)^2/12` in each sample.

use super::data::RunData;
use super::disturbance::Disturbance;
use super::tones::Projection;

/// Standard deviation in counts of the position each time the shaft starts, stops or turns back: contacts give
/// way before they slide, by a law of their own.
const SLIP_COUNTS: f64 = 0.5;

/// By how much the position walks at random in counts^2 for each count of travel: uneven slots and teeth, and
/// what a wander with one correlation time leaves out. Without it lost edges would be the name for all that.
const DIFFUSION: f64 = 0.0005;

/// Correlation time of the wandering load in s.
const WANDER_S: f64 = 1.0;

/// Levels of the noise for one candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoiseLevel {
    /// Standard deviation of the wandering acceleration in counts/s^2.
    pub wander: f64,
    /// Rate at which a speed error dies away, 1/s.
    pub damping: f64,
    /// Share of edges lost at random: the position walks by sqrt of the edges lost.
    pub lost_share: f64,
    /// Spread in s of samples taken late at random.
    pub late_s: f64,
    /// Standard deviation of the acceleration in rad/s^2 for each unit of the command: the supply differs by run.
    pub supply: f64,
    /// Variance of rounding as a share of 1/12 beside its tones.
    pub rounding: f64,
    /// What disturbs a rough recording.
    pub rough: Disturbance,
    /// Whether what wanders goes on from piece to piece of a run.
    pub goes_on: bool,
}

impl NoiseLevel {
    /// Whether it is that of every hypothesis on this level of the wander, without noise of an effect's own.
    pub fn is_shared(&self) -> bool {
        self.lost_share == 0.0 && self.late_s == 0.0
    }
}

/// The gains of one run's filter.
#[derive(Debug, Clone)]
pub(super) struct Whitener {
    steps: Vec<Step>,
    tones: Projection,
    /// What is left of the wander of the piece before at the start of this one; none where there is no piece before.
    left: Option<f64>,
    /// Covariance at its last sample.
    end: Covariance,
    /// Sum of ln(2 pi S) over the samples, by their weights, and what the tones add.
    pub log_determinant: f64,
}

#[derive(Debug, Clone, Copy)]
struct Step {
    /// Gains of p, v, d and g.
    gain: [f64; 4],
    /// Square root of the sample's weight over the innovation's variance.
    scale: f64,
    transition: Transition,
}

/// From one sample to the next: `p += pv v + pd x`, `v = vv v + vd x` with `x = d + input g`, `d = dd d`.
#[derive(Debug, Clone, Copy)]
struct Transition {
    pv: f64,
    pd: f64,
    vv: f64,
    vd: f64,
    dd: f64,
    input: f64,
}

impl Transition {
    fn new(dt_s: f64, damping: f64, moving: bool) -> Self {
        let dd = (-dt_s / WANDER_S).exp();
        if !moving {
            return Self {
                pv: 0.0,
                pd: 0.0,
                vv: 0.0,
                vd: 0.0,
                dd,
                input: 0.0,
            };
        }
        let a = damping.max(1e-3);
        let vv = (-a * dt_s).exp();
        let pv = -(-a * dt_s).exp_m1() / a;
        Self {
            pv,
            pd: (dt_s - pv) / a,
            vv,
            vd: pv,
            dd,
            input: 0.0,
        }
    }

    #[inline(always)]
    fn apply(&self, m: [f64; 4]) -> [f64; 4] {
        let [p, v, d, g] = m;
        let x = d + self.input * g;
        [
            p + self.pv * v + self.pd * x,
            self.vv * v + self.vd * x,
            self.dd * d,
            g,
        ]
    }
}

impl Whitener {
    /// The filters of runs, or of pieces of runs, from which to which what wanders may go on.
    pub fn all(runs: &[RunData], level: &NoiseLevel) -> Vec<Self> {
        let mut filters: Vec<Self> = Vec::with_capacity(runs.len());
        for (k, run) in runs.iter().enumerate() {
            let before = k.checked_sub(1).filter(|_| level.goes_on);
            let before = before.map(|k| (&runs[k], &filters[k]));
            filters.push(Self::after(before, run, level));
        }
        filters
    }

    /// Runs the filter's covariances through a run.
    pub fn new(run: &RunData, level: &NoiseLevel) -> Self {
        Self::after(None, run, level)
    }

    fn after(before: Option<(&RunData, &Self)>, run: &RunData, level: &NoiseLevel) -> Self {
        let variance = level.wander * level.wander;
        // Where inside a count the shaft started: evenly in one count.
        let mut c = Covariance::default();
        c[0][0] = 1.0 / 12.0;
        c[1][1] = run.start_variance;
        c[2][2] = variance;
        c[3][3] = f64::from(u8::from(level.supply > 0.0));
        let before = before.and_then(|(last, filter)| Some((run.gap_s(last)?, filter)));
        let left = before.map(|(gap_s, _)| (-gap_s / WANDER_S).exp());
        if let (Some(left), Some((_, filter))) = (left, before) {
            c[2][2] += left * left * (filter.end[2][2] - variance);
            c[3][3] = filter.end[3][3];
            c[2][3] = left * filter.end[2][3];
            c[3][2] = c[2][3];
        }
        let supply = level.supply * run.counts_per_rev / std::f64::consts::TAU;
        let rough = level.rough;
        let mut steps = Vec::with_capacity(run.len());
        let mut log_determinant = 0.0;
        for k in 0..run.len() {
            let dt_s = if k == 0 {
                0.0
            } else {
                run.t_s[k] - run.t_s[k - 1]
            };
            let mut t = Transition::new(dt_s, level.damping, run.moving[k]);
            if k > 0 {
                t.input = supply * run.command[k - 1];
                c = propagate(&c, &t);
                c[2][2] += variance * (1.0 - t.dd * t.dd);
                let travel = run.speed_counts_s[k].abs() * dt_s;
                c[0][0] += (DIFFUSION + level.lost_share * (1.0 - level.lost_share)) * travel;
                if run.moving[k] {
                    let walk = rough.speed_walk(run.is_slow(k)) * dt_s;
                    c[0][0] += walk * dt_s * dt_s / 3.0;
                    c[0][1] += walk * dt_s / 2.0;
                    c[1][0] += walk * dt_s / 2.0;
                    c[1][1] += walk;
                }
                if run.slips(k) {
                    c[0][0] += SLIP_COUNTS * SLIP_COUNTS;
                }
            }
            let late_s = level.late_s.hypot(run.arrivals_scatter_s.unwrap_or(0.0));
            let late = run.speed_counts_s[k] * late_s;
            let own = (level.rounding + late * late) / 12.0 + rough.scatter;
            let weight = run.weight[k];
            let s = c[0][0] + own / weight;
            let gain = [c[0][0] / s, c[1][0] / s, c[2][0] / s, c[3][0] / s];
            let (row, c_before) = (c[0], c[0][0]);
            for (i, g) in gain.iter().enumerate() {
                for j in 0..4 {
                    c[i][j] -= g * row[j];
                }
            }
            let spread = c_before + own;
            log_determinant += weight * (std::f64::consts::TAU * spread).ln();
            steps.push(Step {
                gain,
                scale: (weight / spread).sqrt(),
                transition: t,
            });
        }
        let mut tones = run.tones.clone();
        for tone in &mut tones {
            filter(&steps, [0.0; 4], tone);
        }
        let tones = Projection::new(&tones);
        Self {
            steps,
            left,
            end: c,
            log_determinant: log_determinant + tones.log_determinant,
            tones,
        }
    }

    /// Variance of each innovation in counts^2, divided by the sample's weight.
    pub fn variances(&self) -> impl Iterator<Item = f64> {
        self.steps
            .iter()
            .map(|step| 1.0 / (step.scale * step.scale))
    }

    /// Log-likelihood of each sample's innovation, less what the tones' determinant adds to all together.
    pub fn log_likelihoods<'a>(
        &'a self,
        run: &'a RunData,
        innovations: &'a [f64],
    ) -> impl Iterator<Item = f64> + 'a {
        let samples = self.steps.iter().zip(&run.weight).zip(innovations);
        samples.map(|((step, weight), r)| {
            let spread = weight / (step.scale * step.scale);
            -0.5 * (r * r + weight * (std::f64::consts::TAU * spread).ln())
        })
    }

    /// Turns a column (residual, or a derivative of the prediction) of a run, or of the first piece of one, into its
    /// whitened innovations.
    pub fn whiten(&self, column: &mut [f64]) {
        self.whiten_on(&mut Carried::default(), column);
    }

    /// The same piece by piece: `carried` is what the filters of the pieces before learnt of the same column.
    pub fn whiten_on(&self, carried: &mut Carried, column: &mut [f64]) {
        let mut start = [0.0; 4];
        if let Some(left) = self.left {
            start[2] = left * carried.wander;
            start[3] = carried.supply;
        }
        let end = filter(&self.steps, start, column);
        (carried.wander, carried.supply) = (end[2], end[3]);
        self.tones.apply(column);
    }

    /// The same for many columns, several at a time: what one waits for, another computes.
    pub fn whiten_all_on(&self, carried: &mut [Carried], columns: &mut [Vec<f64>]) {
        let (some, others) = columns.as_chunks_mut::<TOGETHER>();
        let (carried_some, carried_others) = carried.as_chunks_mut::<TOGETHER>();
        for (columns, carried) in some.iter_mut().zip(carried_some) {
            let mut start = [[0.0; TOGETHER]; 4];
            if let Some(left) = self.left {
                start[2] = carried.map(|c| left * c.wander);
                start[3] = carried.map(|c| c.supply);
            }
            let end = filter_together(&self.steps, start, columns);
            for (j, carried) in carried.iter_mut().enumerate() {
                (carried.wander, carried.supply) = (end[2][j], end[3][j]);
            }
            for column in columns {
                self.tones.apply(column);
            }
        }
        for (column, carried) in others.iter_mut().zip(carried_others) {
            self.whiten_on(carried, column);
        }
    }
}

/// How many columns are filtered together.
const TOGETHER: usize = 4;

/// What a filter has learnt of a column, as far as it goes on in the next piece of the run.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Carried {
    wander: f64,
    supply: f64,
}

fn filter(steps: &[Step], start: [f64; 4], column: &mut [f64]) -> [f64; 4] {
    let mut m = start;
    for (k, (value, step)) in column.iter_mut().zip(steps).enumerate() {
        if k > 0 {
            m = step.transition.apply(m);
        }
        let innovation = *value - m[0];
        for (state, gain) in m.iter_mut().zip(step.gain) {
            *state += gain * innovation;
        }
        *value = innovation * step.scale;
    }
    m
}

/// The same of columns of one length, bit by bit.
fn filter_together(
    steps: &[Step],
    start: [[f64; TOGETHER]; 4],
    columns: &mut [Vec<f64>; TOGETHER],
) -> [[f64; TOGETHER]; 4] {
    let [mut p, mut v, mut d, mut g] = start;
    let [a, b, c, e] = columns.each_mut().map(Vec::as_mut_slice);
    let values = a.iter_mut().zip(b).zip(c).zip(e);
    for (k, (step, (((a, b), c), e))) in steps.iter().zip(values).enumerate() {
        let values = [a, b, c, e];
        for (j, value) in values.into_iter().enumerate() {
            if k > 0 {
                [p[j], v[j], d[j], g[j]] = step.transition.apply([p[j], v[j], d[j], g[j]]);
            }
            let innovation = *value - p[j];
            p[j] += step.gain[0] * innovation;
            v[j] += step.gain[1] * innovation;
            d[j] += step.gain[2] * innovation;
            g[j] += step.gain[3] * innovation;
            *value = innovation * step.scale;
        }
    }
    [p, v, d, g]
}

/// Covariance of p, v, d and g.
type Covariance = [[f64; 4]; 4];

/// `T C T'` for the sparse transition.
fn propagate(c: &Covariance, t: &Transition) -> Covariance {
    let columns = [0, 1, 2, 3].map(|j| t.apply([c[0][j], c[1][j], c[2][j], c[3][j]]));
    let mut out = Covariance::default();
    for i in 0..4 {
        let row = t.apply([columns[0][i], columns[1][i], columns[2][i], columns[3][i]]);
        for (j, value) in row.into_iter().enumerate() {
            out[j][i] = value;
        }
    }
    out
}

/// How the position of a run answers to an acceleration: the columns of effects that are linear in their magnitude.
#[derive(Debug)]
pub(super) struct Response {
    steps: Vec<Transition>,
}

impl Response {
    /// Of each of these runs, speed errors dying away at the rate `damping` in 1/s.
    pub fn all(runs: &[RunData], damping: f64) -> Vec<Self> {
        let of = |run: &RunData| Self {
            steps: (1..run.len())
                .map(|k| Transition::new(run.t_s[k] - run.t_s[k - 1], damping, run.moving[k]))
                .collect(),
        };
        runs.iter().map(of).collect()
    }

    /// Positions in counts under an acceleration in counts/s^2 that is in force from each sample to the next.
    pub fn to(&self, acceleration: &[f64]) -> Vec<f64> {
        let (mut p, mut v) = (0.0, 0.0);
        let mut out = Vec::with_capacity(acceleration.len());
        out.push(p);
        for (t, d) in self.steps.iter().zip(acceleration) {
            (p, v) = (p + t.pv * v + t.pd * d, t.vv * v + t.vd * d);
            out.push(p);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::Hypothesis;
    use super::super::samples::{motor_with, problem, ready, recording};
    use super::*;

    #[test]
    fn columns_whitened_together_are_those_whitened_one_by_one() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let motor = Hypothesis::new(&nominal, Vec::new(), &problem.setting);
        let level = problem.noise(&motor, &motor.start(), problem.levels[2]);
        let wave = |j: usize, k: usize| (k as f64 * (0.01 + 0.003 * j as f64)).sin();
        let mut carried = [[Carried::default(); 7]; 2];
        for (run, whitener) in runs.iter().zip(problem.whiteners(&level).iter()) {
            let mut together: Vec<Vec<f64>> = (0..7)
                .map(|j| (0..run.len()).map(|k| wave(j, k)).collect())
                .collect();
            let mut alone = together.clone();
            whitener.whiten_all_on(&mut carried[0], &mut together);
            for (column, carried) in alone.iter_mut().zip(&mut carried[1]) {
                whitener.whiten_on(carried, column);
            }
            assert_eq!(together, alone);
            assert!(together[5].iter().any(|x| x.abs() > 1e-3));
        }
    }
}
