//! Levenberg-Marquardt least squares of the multi-step prediction error (Marquardt 1963): the one fit that every figure comes from.
//!
//! In: segments, a model, starts. Out: [`Fit`], the minimum of a [`Metric`] plus the prior.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::model::{Model, dot, mean_square, predict, sensitivities};
use super::noise::Whitener;
use super::segments::Segments;
use super::settings::solver;
use crate::units::ROUNDING_VARIANCE;

/// A model fitted to segments.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub model: Model,
    pub x: Vec<f64>,
    /// Measured minus predicted, in counts.
    pub residual: Vec<f64>,
    /// The same after correction of the initial states.
    pub corrected: Vec<f64>,
    /// Derivatives of the prediction, a column for each parameter.
    pub columns: Vec<Vec<f64>>,
    /// `J'J` and `J'r` of corrected columns and residual.
    pub gram: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Negative log prior density, 0 at its mode.
    pub prior: f64,
    /// Profiles of the parameters that the prediction does not depend on smoothly.
    pub profiles: Vec<Profile>,
}

/// Change of the prediction with one parameter, in growing steps to either side.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    pub parameter: usize,
    pub sides: [Vec<Moved>; 2],
}

/// A step of a parameter.
#[derive(Debug, Clone)]
pub(crate) struct Moved {
    pub by: f64,
    /// Change of the prediction in counts.
    pub change: Vec<f64>,
    /// Its square sum and its products with the columns, after correction of the initial states.
    pub square: f64,
    pub along: DVector<f64>,
}

impl Fit {
    /// A model at these parameters, without fitting.
    pub fn at(segments: &Segments, model: &Model, x: Vec<f64>) -> Option<Self> {
        let linear = Linear::at(segments, model, &x)?;
        Some(Self::of(segments, model, x, linear))
    }

    fn of(segments: &Segments, model: &Model, x: Vec<f64>, linear: Linear) -> Self {
        let Linear { residual, columns } = linear;
        let corrected = segments.corrected(&residual);
        let own: Vec<Vec<f64>> = columns.iter().map(|c| segments.corrected(c)).collect();
        let mut fit = Self {
            gram: gram(&own),
            gradient: DVector::from_fn(own.len(), |i, _| dot(&own[i], &corrected)),
            prior: model.prior(&x),
            model: model.clone(),
            x,
            residual,
            corrected,
            columns,
            profiles: Vec::new(),
        };
        let parameters = model.parameters.iter().enumerate();
        let not_smooth = parameters.filter(|(_, parameter)| !parameter.smooth);
        fit.profiles = not_smooth
            .map(|(parameter, _)| Profile {
                parameter,
                sides: [-1.0, 1.0].map(|side| fit.moved(segments, &own, parameter, side)),
            })
            .collect();
        fit
    }

    /// Steps of a parameter, each twice the one before, until they change as much as the fit leaves or end at its bound.
    fn moved(&self, segments: &Segments, own: &[Vec<f64>], k: usize, side: f64) -> Vec<Moved> {
        let parameter = &self.model.parameters[k];
        let room = match side < 0.0 {
            true => self.x[k] - parameter.lo,
            false => parameter.hi - self.x[k],
        };
        let left = self.square_sum().max(ROUNDING_VARIANCE);
        let mut steps: Vec<Moved> = Vec::new();
        let mut by = parameter.difference();
        while steps
            .last()
            .is_none_or(|step| step.by < room && step.square < left)
        {
            let mut x = self.x.clone();
            x[k] += side * by.min(room);
            let Some(then) = predict(segments, &self.model.motor(&x)) else {
                break;
            };
            let then = segments.residual(&then);
            let change: Vec<f64> = self.residual.iter().zip(then).map(|(a, b)| a - b).collect();
            let corrected = segments.corrected(&change);
            steps.push(Moved {
                by: by.min(room),
                square: dot(&corrected, &corrected),
                along: DVector::from_fn(own.len(), |i, _| dot(&own[i], &corrected)),
                change,
            });
            by *= 2.0;
        }
        steps
    }

    /// Sum of the squares of the corrected residual in counts^2.
    pub fn square_sum(&self) -> f64 {
        dot(&self.corrected, &self.corrected)
    }

    /// Their mean.
    pub fn mean_square(&self) -> f64 {
        mean_square(&self.corrected)
    }

    /// Their root mean square in counts.
    pub fn rms(&self) -> f64 {
        self.mean_square().sqrt()
    }

    /// Ids of its effects, sorted.
    pub fn ids(&self) -> Vec<&'static str> {
        self.model.ids()
    }
}

/// Data term of a fit.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Metric<'a> {
    /// `N/2 ln MSE` of the corrected residual with an effective number of observations.
    ScaleFree(f64),
    /// The same with every sample an observation.
    LeastSquares,
    /// Half the squares of whitened innovations.
    Whitened(&'a Whitener),
}

impl Metric<'_> {
    fn prepared(&self, segments: &Segments, column: &[f64]) -> Vec<f64> {
        match self {
            Self::ScaleFree(_) | Self::LeastSquares => segments.corrected(column),
            Self::Whitened(whitener) => whitener.whiten(column),
        }
    }

    /// The number of observations of `n` samples, if their variance is unknown.
    fn observations(&self, n: usize) -> Option<f64> {
        match self {
            Self::ScaleFree(n_eff) => Some(*n_eff),
            Self::LeastSquares => Some(n as f64),
            Self::Whitened(_) => None,
        }
    }

    /// Cost of a sum of prepared squares. A mean square far below quantization's is no better than that.
    fn cost(&self, square_sum: f64, n: usize) -> f64 {
        let mean = square_sum / n.max(1) as f64;
        let logarithm = mean.max(solver::LEAST_SQUARE * ROUNDING_VARIANCE).ln();
        (self.observations(n)).map_or(0.5 * square_sum, |count| 0.5 * count * logarithm)
    }

    /// Weight of a prepared square.
    fn weight(&self, square_sum: f64, n: usize) -> f64 {
        let least = solver::LEAST_SQUARE * ROUNDING_VARIANCE * n.max(1) as f64;
        (self.observations(n)).map_or(1.0, |count| count / square_sum.max(least))
    }

    /// Whether the parameters of random effects are held: their variance, which is likeliest, is not in the squares.
    fn holds_random(&self) -> bool {
        !matches!(self, Self::ScaleFree(_))
    }
}

pub(crate) fn gram(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let n = columns.len();
    let mut gram = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            gram[(i, j)] = dot(&columns[i], &columns[j]);
            gram[(j, i)] = gram[(i, j)];
        }
    }
    gram
}

/// A residual and the columns of the prediction at some parameters.
#[derive(Debug)]
struct Linear {
    residual: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Linear {
    fn at(segments: &Segments, model: &Model, x: &[f64]) -> Option<Self> {
        let (predicted, columns) = sensitivities(segments, model, x)?;
        let residual = segments.residual(&predicted);
        Some(Self { residual, columns })
    }
}

/// Fits a model from the best of some starts, until a step decreases the cost by less than `least_gain` nats; `None` where none can be simulated, or where after some steps it costs more than a model that
/// it extends.
pub(crate) fn fit(
    segments: &Segments,
    model: &Model,
    starts: &[Vec<f64>],
    metric: Metric<'_>,
    least_gain: f64,
    extends: Option<&Fit>,
) -> Option<Fit> {
    let mut problem = Problem {
        segments,
        model,
        metric,
        least_gain,
        least: f64::INFINITY,
    };
    if let Some(fit) = extends {
        problem.least = problem.cost_of(&fit.residual) + fit.prior;
    }
    let mut begun: Vec<(f64, Vec<f64>)> = (starts.par_iter())
        .filter_map(|start| {
            let mut x = start.clone();
            model.clamp(&mut x);
            Some((problem.cost_at(&x)?, x))
        })
        .collect();
    begun.sort_by(|a, b| a.0.total_cmp(&b.0));
    begun.dedup_by(|a, b| a.1 == b.1);
    // The second best start where the best leads to no more than the model that is extended has.
    let mut best: Option<Minimum> = None;
    for (cost, x) in begun.into_iter().take(solver::STARTS_PER_SET) {
        let linear = None;
        let found = problem.lowest(Minimum { cost, x, linear });
        if let Some(found) = found
            && best.as_ref().is_none_or(|best| found.cost < best.cost)
        {
            best = Some(found);
        }
        if best.as_ref().is_some_and(|best| best.cost < problem.least) {
            break;
        }
    }
    best?.fit(segments, model)
}

/// Continues a fit in another metric.
pub(crate) fn refit(segments: &Segments, begun: Fit, metric: Metric<'_>) -> Option<Fit> {
    let Fit {
        model,
        x,
        residual,
        columns,
        prior,
        ..
    } = begun;
    let problem = Problem {
        segments,
        model: &model,
        metric,
        least_gain: solver::CONVERGED,
        least: f64::INFINITY,
    };
    let begun = Minimum {
        cost: problem.cost_of(&residual) + prior,
        x,
        linear: Some(Linear { residual, columns }),
    };
    problem.lowest(begun)?.fit(segments, &model)
}

/// The lowest cost found, where it is, and the linearization there if it is known.
struct Minimum {
    cost: f64,
    x: Vec<f64>,
    linear: Option<Linear>,
}

impl Minimum {
    fn fit(self, segments: &Segments, model: &Model) -> Option<Fit> {
        let Self { x, linear, .. } = self;
        match linear {
            Some(linear) => Some(Fit::of(segments, model, x, linear)),
            None => Fit::at(segments, model, x),
        }
    }
}

/// A model, what it is fitted to, and in which metric.
struct Problem<'a> {
    segments: &'a Segments,
    model: &'a Model,
    metric: Metric<'a>,
    /// Decrease of the cost in nats below which it has converged.
    least_gain: f64,
    /// Cost of the model that this one extends.
    least: f64,
}

impl Problem<'_> {
    fn cost_at(&self, x: &[f64]) -> Option<f64> {
        let predicted = predict(self.segments, &self.model.motor(x))?;
        let cost = self.cost_of(&self.segments.residual(&predicted)) + self.model.prior(x);
        cost.is_finite().then_some(cost)
    }

    /// Cost of the data, without the prior.
    fn cost_of(&self, residual: &[f64]) -> f64 {
        let residual = self.metric.prepared(self.segments, residual);
        (self.metric).cost(dot(&residual, &residual), residual.len())
    }

    /// The minimum from a start, also with a parameter elsewhere in its range.
    fn lowest(&self, begun: Minimum) -> Option<Minimum> {
        let found = self.minimised(begun)?;
        match self.elsewhere(found.cost, &found.x) {
            Some(other) => self.minimised(other),
            None => Some(found),
        }
    }

    /// Parameters that cost less with one of them elsewhere in its range, of those that the prediction does not depend on smoothly.
    fn elsewhere(&self, found: f64, x: &[f64]) -> Option<Minimum> {
        let parameters = self.model.parameters.iter().enumerate();
        let tried: Vec<Vec<f64>> = parameters
            .filter(|(_, parameter)| !parameter.smooth)
            .flat_map(|(k, parameter)| {
                (0..solver::PLACES).map(move |place| {
                    let share = (place as f64 + 0.5) / solver::PLACES as f64;
                    let mut x = x.to_vec();
                    x[k] = parameter.lo + share * (parameter.hi - parameter.lo);
                    x
                })
            })
            .collect();
        let costs = tried
            .into_par_iter()
            .filter_map(|x| Some((self.cost_at(&x)?, x)));
        let (cost, x) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let linear = None;
        (cost < found - solver::CONVERGED).then_some(Minimum { cost, x, linear })
    }

    /// Steps of Levenberg and Marquardt with bounds, until the Newton decrement is small (Boyd and Vandenberghe 2004, section 9.5); the prior is
    /// replaced at each step by the normal distribution that is as unlikely.
    fn minimised(&self, begun: Minimum) -> Option<Minimum> {
        let Self {
            segments,
            model,
            metric,
            least_gain,
            least,
        } = self;
        let mut damping = solver::DAMPING;
        let Minimum {
            cost: mut before,
            mut x,
            mut linear,
        } = begun;
        for step in 0..solver::FIT_STEPS {
            if step >= solver::PATIENCE && before > *least {
                return None;
            }
            let at = match linear.take() {
                Some(known) => known,
                None => Linear::at(segments, model, &x)?,
            };
            let residual = metric.prepared(segments, &at.residual);
            let columns: Vec<Vec<f64>> = (at.columns)
                .iter()
                .map(|c| metric.prepared(segments, c))
                .collect();
            let weight = metric.weight(dot(&residual, &residual), residual.len());
            let precision = model.precision_as_unlikely(&x);
            let distance = DVector::from_column_slice(&x) - &model.mean;
            let gradient = DVector::from_fn(x.len(), |i, _| weight * dot(&columns[i], &residual))
                - &precision * &distance;
            let hessian = gram(&columns) * weight + &precision;
            let mut held = held(model, &x, &gradient);
            if metric.holds_random() {
                model.random().for_each(|k| held[k] = true);
            }
            let decrement = solved(&hessian, &gradient, &held, 0.0);
            let is_lowest =
                decrement.is_some_and(|step| 0.5 * free(&gradient, &held).dot(&step) < *least_gain);
            let attempts = if is_lowest { 0 } else { solver::ATTEMPTS };
            let mut next = None;
            for _ in 0..attempts {
                let Some(step) = solved(&hessian, &gradient, &held, damping) else {
                    damping *= solver::DAMPING_MORE;
                    continue;
                };
                let mut moved: Vec<f64> = (x.iter().zip(step.iter()))
                    .map(|(x, s)| x + s.clamp(-solver::LONGEST_STEP, solver::LONGEST_STEP))
                    .collect();
                model.clamp(&mut moved);
                let cost = self.cost_at(&moved);
                if let Some(cost) = cost.filter(|cost| *cost < before) {
                    next = Some((cost, moved));
                    damping = (damping * solver::DAMPING_LESS).max(solver::LAST_DIGITS);
                    break;
                }
                damping *= solver::DAMPING_MORE;
            }
            let Some((cost, moved)) = next else {
                linear = Some(at);
                break;
            };
            let gained = before - cost;
            (before, x) = (cost, moved);
            if gained < *least_gain {
                break;
            }
        }
        Some(Minimum {
            cost: before,
            x,
            linear,
        })
    }
}

/// The gradient of the parameters that are not held.
fn free(gradient: &DVector<f64>, held: &[bool]) -> DVector<f64> {
    DVector::from_fn(held.len(), |k, _| if held[k] { 0.0 } else { gradient[k] })
}

/// Parameters at a bound that the gradient pushes beyond it.
fn held(model: &Model, x: &[f64], gradient: &DVector<f64>) -> Vec<bool> {
    (model.parameters.iter().enumerate())
        .map(|(k, p)| (x[k] <= p.lo && gradient[k] < 0.0) || (x[k] >= p.hi && gradient[k] > 0.0))
        .collect()
}

/// The damped step with some parameters held.
fn solved(
    hessian: &DMatrix<f64>,
    gradient: &DVector<f64>,
    held: &[bool],
    damping: f64,
) -> Option<DVector<f64>> {
    let mut damped = hessian.clone();
    let mut right = gradient.clone();
    for k in 0..held.len() {
        damped[(k, k)] += damping * hessian[(k, k)].max(solver::LAST_DIGITS);
        if held[k] {
            damped.row_mut(k).fill(0.0);
            damped.column_mut(k).fill(0.0);
            damped[(k, k)] = 1.0;
            right[k] = 0.0;
        }
    }
    damped.cholesky().map(|c| c.solve(&right))
}
