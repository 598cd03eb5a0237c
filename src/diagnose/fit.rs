//! Fits a hypothesis: damped least squares on whitened innovations, and its evidence.
//!
//! Minimised is `1/2 |W (r(p) - J dp)|^2 + 1/2 (p - c)' P (p - c)` (Levenberg-Marquardt), where `W` is the
//! filter of `noise`. The evidence is Laplace's: `ln Z = ln L + ln prior + d/2 ln 2 pi - 1/2 ln|H|`
//! with `H = J'W'WJ + P`; `P` keeps a number that the runs do not tell from looking surer than its range.
//! The wander's level is fitted too, on a grid, from strong (short horizons, a smooth objective) to weak.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::RunData;
use super::hypothesis::{BASE, Hypothesis};
use super::noise::{Carried, Whitener};
use super::noise_numbers;
use super::predict::{predict, predict_with_derivatives};
use super::problem::{Columns, Problem};
use super::sums::{dot, gram};

/// How many times what a linear step promises a fit may gain.
const OPTIMISM: f64 = 3.0;

/// A step that gains fewer nats is the last.
const SETTLED: f64 = 0.05;

/// A fit of fewer steps is a look: its curvature is that of its last step.
const FEW_STEPS: usize = 4;

/// A fitted hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// What was fitted.
    pub hypothesis: Hypothesis,
    /// Its numbers.
    pub p: Vec<f64>,
    /// Level of the wander.
    pub wander: f64,
    /// Logarithm of the evidence.
    pub log_evidence: f64,
    /// Covariance of the numbers.
    pub covariance: DMatrix<f64>,
    /// Whether the last step changed nothing that matters.
    pub converged: bool,
    /// The prediction of each run in counts.
    pub predictions: Vec<Vec<f64>>,
}

impl Problem<'_> {
    fn predictions(&self, hypothesis: &Hypothesis, p: &[f64]) -> Option<Vec<Vec<f64>>> {
        let motor = hypothesis.motor(self.nominal, p);
        let runs = self.runs.par_iter().with_max_len(1);
        runs.map(|run| predict(&motor, run, &self.effort)).collect()
    }

    /// What a fit would predict without its member `m`, all else equal.
    pub fn predictions_without(&self, fit: &Fit, m: usize) -> Option<Vec<Vec<f64>>> {
        let motor = fit.hypothesis.motor_without(self.nominal, &fit.p, m);
        let runs = self.runs.par_iter().with_max_len(1);
        runs.map(|run| predict(&motor, run, &self.effort)).collect()
    }

    /// Residuals of all runs end to end, whitened.
    pub fn whitened(&self, predictions: &[Vec<f64>], whiteners: &[Whitener]) -> Vec<f64> {
        let mut all = Vec::new();
        let mut carried = Carried::default();
        for ((run, x), whitener) in self.runs.iter().zip(predictions).zip(whiteners) {
            // The middle of the prior of the start inside a count is half a count.
            let mut r: Vec<f64> = run.counts.iter().zip(x).map(|(n, x)| n - x - 0.5).collect();
            whitener.whiten_on(&mut carried, &mut r);
            all.extend(r);
        }
        all
    }

    /// The same of several predictions: many at a time are whitened as fast as one.
    pub fn whitened_together(&self, predictions: &[Columns], whiteners: &[Whitener]) -> Columns {
        let of_run = |(k, run): (usize, &RunData)| {
            let residual = |x: &Columns| {
                let samples = run.counts.iter().zip(&x[k]);
                samples.map(|(n, x)| n - x - 0.5).collect()
            };
            predictions.iter().map(residual).collect()
        };
        self.whitened_columns(
            self.runs.iter().enumerate().map(of_run).collect(),
            whiteners,
        )
    }

    /// Fits from a start on one level of the wander.
    pub fn fit_at(
        &self,
        hypothesis: &Hypothesis,
        start: &[f64],
        wander: f64,
        most_steps: usize,
    ) -> Option<Fit> {
        self.fit_towards(f64::NEG_INFINITY, hypothesis, start, wander, most_steps)
    }

    /// The same; `None` too where the start is so far below this evidence that no step promises to reach it.
    pub fn fit_towards(
        &self,
        least: f64,
        hypothesis: &Hypothesis,
        start: &[f64],
        wander: f64,
        most_steps: usize,
    ) -> Option<Fit> {
        let d = hypothesis.len();
        let mut p = start.to_vec();
        hypothesis.clamp(&mut p);
        let mut whiteners = self.whiteners(&self.noise(hypothesis, &p, wander));
        // The first derivatives bring the first predictions with them.
        let (mut predictions, first) = self.predictions_and_jacobian(hypothesis, &p, &whiteners)?;
        let mut first = Some(first);
        let mut r = self.whitened(&predictions, &whiteners);
        let mut cost = self.cost(hypothesis, &p, &r, &whiteners);
        let mut lambda = 1e-3;
        let mut converged = false;
        let mut jtj = DMatrix::zeros(d, d);
        let mut of_noise = Vec::new();
        // The curvature of the last step serves the evidence too, unless there was none or it was far off.
        let steps = if most_steps < FEW_STEPS {
            most_steps.max(1)
        } else {
            most_steps + 1
        };
        for step in 0..steps {
            let jacobian = match first.take() {
                Some(first) => first,
                None => self.jacobian(hypothesis, &p, &whiteners)?,
            };
            let mut gradient: DVector<f64>;
            (jtj, gradient) = normal_equations(hypothesis, &jacobian, &r, &p);
            of_noise = self.noise_curvature(hypothesis, &p, wander, &predictions, &r, &whiteners);
            for (k, slope, curvature) in &of_noise {
                gradient[*k] += slope;
                jtj[(*k, *k)] += curvature;
            }
            if step == 0 && least > f64::NEG_INFINITY {
                let cholesky = jtj.clone().cholesky()?;
                let promised = 0.5 * cholesky.solve(&gradient).dot(&gradient);
                let here =
                    self.evidence(hypothesis, &p, wander, log_likelihood(&r, &whiteners), &jtj)?;
                if here + OPTIMISM * promised < least {
                    return None;
                }
            }
            if step == most_steps {
                break;
            }
            let mut improved = false;
            let mut promised = f64::INFINITY;
            for _ in 0..6 {
                let mut damped = jtj.clone();
                for k in 0..d {
                    damped[(k, k)] += lambda * jtj[(k, k)].max(1e-12);
                    // The edge of a range bends the objective, not the posterior's width inside.
                    let (outside, edge) = hypothesis.outside(k, &p);
                    if outside != 0.0 {
                        damped[(k, k)] += 1.0 / (edge * edge);
                    }
                }
                let Some(delta) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                    lambda *= 10.0;
                    continue;
                };
                promised = promised.min(0.5 * delta.dot(&gradient));
                let mut tried: Vec<f64> = p.iter().zip(delta.iter()).map(|(a, b)| a + b).collect();
                hypothesis.clamp(&mut tried);
                let Some(x) = self.predictions(hypothesis, &tried) else {
                    lambda *= 10.0;
                    continue;
                };
                let w = self.whiteners(&self.noise(hypothesis, &tried, wander));
                let r_tried = self.whitened(&x, &w);
                let cost_tried = self.cost(hypothesis, &tried, &r_tried, &w);
                if cost_tried < cost {
                    converged = cost - cost_tried < SETTLED;
                    (p, predictions, whiteners, r, cost) = (tried, x, w, r_tried, cost_tried);
                    lambda = (lambda * 0.2).max(1e-9);
                    improved = true;
                    break;
                }
                lambda *= 10.0;
            }
            if !improved {
                converged = true;
                break;
            }
            if converged && (step > 0 || promised < SETTLED) {
                break;
            }
        }
        let log_likelihood = log_likelihood(&r, &whiteners);
        let log_evidence = self.evidence(hypothesis, &p, wander, log_likelihood, &jtj)?;
        for (k, _, curvature) in &of_noise {
            jtj[(*k, *k)] -= (1.0 - noise_numbers::INFORMATION) * curvature;
        }
        let covariance = jtj.cholesky()?.inverse();
        Some(Fit {
            hypothesis: hypothesis.clone(),
            p,
            wander,
            log_evidence,
            covariance,
            converged,
            predictions,
        })
    }

    /// Logarithm of the evidence by Laplace's approximation, with this curvature.
    fn evidence(
        &self,
        hypothesis: &Hypothesis,
        p: &[f64],
        wander: f64,
        log_likelihood: f64,
        curvature: &DMatrix<f64>,
    ) -> Option<f64> {
        let cholesky = curvature.clone().cholesky()?;
        let diagonal = cholesky.l_dirty().diagonal();
        let log_determinant = 2.0 * diagonal.iter().map(|x| x.ln()).sum::<f64>();
        let d = hypothesis.len() as f64;
        // Numbers of the base that mean nothing have a prior of their own and no data: they cancel.
        Some(
            log_likelihood + hypothesis.log_prior(p) + 0.5 * d * std::f64::consts::TAU.ln()
                - 0.5 * log_determinant
                - wander_penalty(wander, &self.levels),
        )
    }

    fn cost(&self, hypothesis: &Hypothesis, p: &[f64], r: &[f64], whiteners: &[Whitener]) -> f64 {
        let d = hypothesis.len();
        let mut quadratic = 0.0;
        for i in 0..d {
            for j in 0..d {
                let precision = hypothesis.precision(i, j);
                if precision != 0.0 {
                    quadratic +=
                        (p[i] - hypothesis.centre(i)) * precision * (p[j] - hypothesis.centre(j));
                }
            }
        }
        let edges = (0..d).map(|k| hypothesis.outside(k, p).0.powi(2));
        0.5 * (quadratic + edges.sum::<f64>()) - log_likelihood(r, whiteners)
    }

    /// Whitened derivatives of the prediction, a column a number.
    pub fn jacobian(
        &self,
        hypothesis: &Hypothesis,
        p: &[f64],
        whiteners: &[Whitener],
    ) -> Option<Vec<Vec<f64>>> {
        let (_, columns) = self.predictions_and_jacobian(hypothesis, p, whiteners)?;
        Some(columns)
    }

    /// The same, and the prediction of each run that they belong to, in counts.
    fn predictions_and_jacobian(
        &self,
        hypothesis: &Hypothesis,
        p: &[f64],
        whiteners: &[Whitener],
    ) -> Option<(Columns, Columns)> {
        let (predictions, derivatives) = self.derivatives(hypothesis, p, hypothesis.len())?;
        Some((predictions, self.whitened_columns(derivatives, whiteners)))
    }

    /// The prediction of each run, and its derivatives by the first numbers of the hypothesis.
    fn derivatives(
        &self,
        hypothesis: &Hypothesis,
        p: &[f64],
        numbers: usize,
    ) -> Option<(Columns, Vec<Columns>)> {
        let of_run =
            |run| predict_with_derivatives(hypothesis, self.nominal, p, numbers, run, &self.effort);
        let by_run: Option<Vec<_>> = (self.runs.par_iter().with_max_len(1)).map(of_run).collect();
        Some(by_run?.into_iter().unzip())
    }

    /// Columns of each run, whitened, all runs end to end.
    fn whitened_columns(&self, by_run: Vec<Columns>, whiteners: &[Whitener]) -> Columns {
        let samples: usize = self.runs.iter().map(RunData::len).sum();
        let count = by_run.first().map_or(0, Vec::len);
        let mut columns = vec![Vec::with_capacity(samples); count];
        let mut carried = vec![Carried::default(); count];
        for (mut of_run, whitener) in by_run.into_iter().zip(whiteners) {
            whitener.whiten_all_on(&mut carried, &mut of_run);
            for (all, column) in columns.iter_mut().zip(of_run) {
                all.extend(column);
            }
        }
        columns
    }

    /// Derivatives by the numbers of the base alone, run by run, at a fit: the linear part of searches.
    pub fn base_derivatives(&self, fit: &Fit) -> Option<Vec<Columns>> {
        let (_, derivatives) = self.derivatives(&fit.hypothesis, &fit.p, BASE)?;
        Some(derivatives)
    }

    /// The same whitened on the fit's level of the noise.
    pub fn whitened_base(&self, fit: &Fit, derivatives: Vec<Columns>) -> Columns {
        let level = self.noise(&fit.hypothesis, &fit.p, fit.wander);
        self.whitened_columns(derivatives, &self.whiteners(&level))
    }

    /// The same for each run.
    pub fn innovations_by_run(&self, fit: &Fit) -> Vec<Vec<f64>> {
        let mut all = self.innovations(fit).into_iter();
        let lengths = self.runs.iter().map(RunData::len);
        lengths.map(|n| all.by_ref().take(n).collect()).collect()
    }

    /// Whitened residuals at a fit.
    pub fn innovations(&self, fit: &Fit) -> Vec<f64> {
        let level = self.noise(&fit.hypothesis, &fit.p, fit.wander);
        self.whitened(&fit.predictions, &self.whiteners(&level))
    }
}

/// A wander is plausible up to a few per cent of what the motor can do, and the less the likelier.
pub(super) fn wander_penalty(wander: f64, levels: &[f64]) -> f64 {
    let weakest = levels.last().copied().unwrap_or(1.0);
    (wander / weakest).max(1.0).ln()
}

pub(super) fn log_likelihood(r: &[f64], whiteners: &[Whitener]) -> f64 {
    let squares: f64 = r.iter().map(|x| x * x).sum();
    let determinants: f64 = whiteners.iter().map(|w| w.log_determinant).sum();
    -0.5 * (squares + determinants)
}

pub(super) fn normal_equations(
    hypothesis: &Hypothesis,
    jacobian: &[Vec<f64>],
    r: &[f64],
    p: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let d = jacobian.len();
    let jtj = gram(jacobian, |i, j| hypothesis.precision(i, j));
    let gradient = DVector::from_fn(d, |i, _| {
        let prior: f64 = (0..d)
            .map(|j| hypothesis.precision(i, j) * (hypothesis.centre(j) - p[j]))
            .sum();
        let (outside, edge) = hypothesis.outside(i, p);
        dot(&jacobian[i], r) + prior - outside / edge
    });
    (jtj, gradient)
}
