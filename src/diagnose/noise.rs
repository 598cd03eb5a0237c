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

use super::covariance::Covariance;
use super::data::RunData;
use super::disturbance::Disturbance;
use super::log_sum::LogSum;
use super::response::Response;
use super::tones::Projection;

/// Standard deviation in counts of the position each time the shaft starts, stops or turns back: contacts give
/// way before they slide, by a law of their own.
const SLIP_COUNTS: f64 = 0.5;

/// By how much the position walks at random in counts^2 for each count of travel: uneven slots and teeth, and
/// what a wander with one correlation time leaves out. Without it lost edges would be the name for all that.
const DIFFUSION: f64 = 0.0005;

/// Correlation time of the wandering load in s.
pub(super) const WANDER_S: f64 = 1.0;

/// Levels of the noise for one candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoiseLevel {
    /// Standard deviation of the wandering acceleration in counts/s^2.
    pub wander: f64,
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
    /// What the run's supply has to do with them; none where it is surely known.
    supplied: Vec<Supplied>,
    response: Response,
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
    /// Gains of p, v and d.
    gain: [f64; 3],
    /// Square root of the sample's weight over the innovation's variance.
    scale: f64,
}

/// The same for the run's supply.
#[derive(Debug, Clone, Copy)]
struct Supplied {
    /// Gain of g.
    gain: f64,
    /// Acceleration for each unit of g up to this sample.
    input: f64,
}

impl Whitener {
    /// The filters of runs, or of pieces of runs, from which to which what wanders may go on.
    pub fn all(runs: &[RunData], responses: &[Response], level: &NoiseLevel) -> Vec<Self> {
        let mut filters: Vec<Self> = Vec::with_capacity(runs.len());
        for (k, (run, response)) in runs.iter().zip(responses).enumerate() {
            let before = k.checked_sub(1).filter(|_| level.goes_on);
            let before = before.map(|k| (&runs[k], &filters[k]));
            filters.push(Self::after(before, run, response, level));
        }
        filters
    }

    /// Runs the filter's covariances through a run.
    pub fn new(run: &RunData, response: &Response, level: &NoiseLevel) -> Self {
        Self::after(None, run, response, level)
    }

    fn after(
        before: Option<(&RunData, &Self)>,
        run: &RunData,
        response: &Response,
        level: &NoiseLevel,
    ) -> Self {
        let variance = level.wander * level.wander;
        let mut start = Covariance {
            // Where inside a count the shaft started: evenly in one count.
            pp: 1.0 / 12.0,
            vv: run.start_variance,
            dd: variance,
            gg: f64::from(u8::from(level.supply > 0.0)),
            ..Covariance::default()
        };
        let before = before.and_then(|(last, filter)| Some((run.gap_s(last)?, filter)));
        let left = before.map(|(gap_s, _)| (-gap_s / WANDER_S).exp());
        if let (Some(left), Some((_, filter))) = (left, before) {
            start.dd += left * left * (filter.end.dd - variance);
            start.gg = filter.end.gg;
            start.dg = left * filter.end.dg;
        }
        let mut filter = Self {
            steps: Vec::with_capacity(run.len()),
            supplied: Vec::new(),
            response: response.clone(),
            tones: Projection::new(Vec::new()),
            left,
            end: start,
            log_determinant: 0.0,
        };
        if level.supply > 0.0 {
            filter.supplied.reserve_exact(run.len());
            filter.run_through::<true>(run, level);
        } else {
            filter.run_through::<false>(run, level);
        }
        // Without tones yet: they are whitened by what the filter alone does.
        let mut tones = run.tones.clone();
        filter.whiten_all_on(&mut vec![Carried::default(); tones.len()], &mut tones);
        filter.tones = Projection::new(tones);
        filter.log_determinant += filter.tones.log_determinant;
        filter
    }

    /// Takes the covariance from the start of a run to its end.
    fn run_through<const SUPPLIED: bool>(&mut self, run: &RunData, level: &NoiseLevel) {
        let variance = level.wander * level.wander;
        let supply = level.supply * run.counts_per_rev / std::f64::consts::TAU;
        let diffusion = DIFFUSION + level.lost_share * (1.0 - level.lost_share);
        let late_s = level.late_s.hypot(run.arrivals_scatter_s.unwrap_or(0.0));
        let mut c = self.end;
        let mut log_determinant = LogSum::new();
        for (k, t) in self.response.transitions().iter().enumerate() {
            let speed = run.speed_counts_s[k];
            let mut input = 0.0;
            if k > 0 {
                input = supply * run.command[k - 1];
                c = c.propagated::<SUPPLIED>(t, input);
                c.dd += variance * (1.0 - t.dd * t.dd);
                let dt_s = run.t_s[k] - run.t_s[k - 1];
                c.pp += diffusion * (speed.abs() * dt_s);
                if run.moving[k] {
                    let walk = level.rough.speed_walk(run.is_slow(k)) * dt_s;
                    c.pp += walk * dt_s * dt_s / 3.0;
                    c.pv += walk * dt_s / 2.0;
                    c.vv += walk;
                }
                if run.slips(k) {
                    c.pp += SLIP_COUNTS * SLIP_COUNTS;
                }
            }
            let late = speed * late_s;
            let own = (level.rounding + late * late) / 12.0 + level.rough.scatter;
            let weight = run.weight[k];
            let spread = c.pp + own;
            let gain = c.learn::<SUPPLIED>(c.pp + own / weight);
            log_determinant.add(weight, std::f64::consts::TAU * spread);
            self.steps.push(Step {
                gain: [gain[0], gain[1], gain[2]],
                scale: (weight / spread).sqrt(),
            });
            if SUPPLIED {
                self.supplied.push(Supplied {
                    gain: gain[3],
                    input,
                });
            }
        }
        self.end = c;
        self.log_determinant = log_determinant.total();
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
        self.whiten_together([carried], [column]);
    }

    /// The same for many columns, several at a time: what one waits for, another computes.
    pub fn whiten_all_on(&self, carried: &mut [Carried], columns: &mut [Vec<f64>]) {
        let (columns, carried) = self.whiten_by::<8>(carried, columns);
        let (columns, carried) = self.whiten_by::<4>(carried, columns);
        let (columns, carried) = self.whiten_by::<2>(carried, columns);
        for (column, carried) in columns.iter_mut().zip(carried) {
            self.whiten_on(carried, column);
        }
    }

    /// So many at a time, as long as there are; the others.
    fn whiten_by<'a, const TOGETHER: usize>(
        &self,
        carried: &'a mut [Carried],
        columns: &'a mut [Vec<f64>],
    ) -> (&'a mut [Vec<f64>], &'a mut [Carried]) {
        let (columns, other_columns) = columns.as_chunks_mut::<TOGETHER>();
        let (carried, others_carried) = carried.as_chunks_mut::<TOGETHER>();
        for (columns, carried) in columns.iter_mut().zip(carried) {
            self.whiten_together(
                carried.each_mut(),
                columns.each_mut().map(Vec::as_mut_slice),
            );
        }
        (other_columns, others_carried)
    }

    fn whiten_together<const TOGETHER: usize>(
        &self,
        carried: [&mut Carried; TOGETHER],
        mut columns: [&mut [f64]; TOGETHER],
    ) {
        let mut start = [[0.0; TOGETHER]; 4];
        if let Some(left) = self.left {
            for (j, carried) in carried.iter().enumerate() {
                (start[2][j], start[3][j]) = (left * carried.wander, carried.supply);
            }
        }
        let columns_of = columns.each_mut().map(|column| &mut **column);
        let end = self.filter_all(start, columns_of);
        for (j, carried) in carried.into_iter().enumerate() {
            (carried.wander, carried.supply) = (end[2][j], end[3][j]);
        }
        for column in columns {
            self.tones.apply(column);
        }
    }
    /// Turns columns into their innovations, tones still in them; from and to this state of the filter.
    fn filter_all<const TOGETHER: usize>(
        &self,
        start: [[f64; TOGETHER]; 4],
        columns: [&mut [f64]; TOGETHER],
    ) -> [[f64; TOGETHER]; 4] {
        if self.supplied.is_empty() {
            self.filter::<false, TOGETHER>(start, columns)
        } else {
            self.filter::<true, TOGETHER>(start, columns)
        }
    }

    fn filter<const SUPPLIED: bool, const TOGETHER: usize>(
        &self,
        start: [[f64; TOGETHER]; 4],
        columns: [&mut [f64]; TOGETHER],
    ) -> [[f64; TOGETHER]; 4] {
        let [mut p, mut v, mut d, mut g] = start;
        let columns = columns.map(|column| &mut column[..self.steps.len()]);
        let steps = self.steps.iter().zip(self.response.transitions());
        for (k, (step, t)) in steps.enumerate() {
            for j in 0..TOGETHER {
                let mut x = d[j];
                if SUPPLIED {
                    x += self.supplied[k].input * g[j];
                }
                p[j] += t.pv * v[j] + t.pd * x;
                v[j] = t.vv * v[j] + t.pv * x;
                d[j] *= t.dd;
                let innovation = columns[j][k] - p[j];
                p[j] += step.gain[0] * innovation;
                v[j] += step.gain[1] * innovation;
                d[j] += step.gain[2] * innovation;
                if SUPPLIED {
                    g[j] += self.supplied[k].gain * innovation;
                }
                columns[j][k] = innovation * step.scale;
            }
        }
        [p, v, d, g]
    }
}

/// What a filter has learnt of a column, as far as it goes on in the next piece of the run.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Carried {
    wander: f64,
    supply: f64,
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
