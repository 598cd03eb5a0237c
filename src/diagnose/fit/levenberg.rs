//! Levenberg and Marquardt's fit of whitened residuals with prior rows (Marquardt, 1963).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fitted::{Fit, dot, mean_square, residual, surroundings};
use super::folds::finished;
use super::{Left, Model, Starts, less_start, response, sensitivities};
use crate::diagnose::noise::{Noise, Whitener, likeliest};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{CLOSES, ROUNDING};
use crate::motor::CommandKind;

/// Most steps of a fit under one noise: a fit that settles takes six.
const MOST_STEPS: usize = 20;
/// A fit ends with a step that gains less than so many nats: a fortieth of what decides.
const ENOUGH: f64 = 0.1;
/// Most times that the noise is found anew: it stands still after two.
const ROUNDS: usize = 4;
/// Places in its range at which a number is tried that nothing depends on smoothly: a threshold between two levels of the command is
/// not left by steps, and two levels apart by less are told by none of the catalogue's starts.
const PLACES: usize = 24;

/// Fits a model from the likeliest of some starts, with the noise that is found on the way, and to leave no more than `most` of what is
/// shown; none where no start leads there. A fit that starts far off takes what it leaves for a load that wanders, and is content
/// there: so least squares are tried as a start as well. Pieces are simulated from their measured starts until that stands still, and
/// then from those that the model has: far off, numbers and starts would stand in for each other.
pub(crate) fn fit(
    pieces: &Pieces,
    model: &Model,
    kind: CommandKind,
    starts: &[Vec<f64>],
    most: Most,
) -> Option<Fit> {
    let asked = Asked {
        pieces,
        model,
        kind,
        most,
    };
    let begun = (starts.par_iter()).filter_map(|start| {
        let mut x = start.clone();
        model.clamp(&mut x);
        Some(Likeliest::new(&asked, At::measured(pieces, model, x)?))
    });
    let begun: Vec<Likeliest> = begun.collect();
    let first = (begun.into_iter()).min_by(|a, b| {
        let is_beyond = |one: &Likeliest| !asked.allows(&one.at);
        (is_beyond(a).cmp(&is_beyond(b))).then(a.cost.total_cmp(&b.cost))
    })?;
    let mut best = first.settled(&asked)?;
    if best.noise.strength > 0.0 {
        let around = surroundings(pieces, model, &best.at.x, kind);
        let squares = dot(&best.at.residual, &best.at.residual) / pieces.len.max(1) as f64;
        let evenly = Whitener::even(pieces, &around, squares.max(ROUNDING));
        let plain = minimise(pieces, model, &evenly, best.at.clone(), &|_| 0.0)
            .map(|at| Likeliest::new(&asked, at))
            .filter(|plain| plain.cost < best.cost || !asked.allows(&best.at));
        let settled = plain.and_then(|plain| plain.settled(&asked));
        if let Some(settled) = settled.filter(|at| asked.allows(&at.at) || !asked.allows(&best.at))
        {
            best = settled;
        }
    }
    let about_its_own = |x: &[f64]| {
        let mut x = x.to_vec();
        model.clamp(&mut x);
        let at = At::about_its_own(pieces, model, kind, x)?;
        let settled = Likeliest::new(&asked, at).settled(&asked);
        settled.filter(|own| asked.allows(&own.at))
    };
    // Measured starts may have led away from numbers that leave no more than they may.
    let own = about_its_own(&best.at.x).or_else(|| {
        let others = starts.par_iter().filter_map(|x| about_its_own(x));
        others.min_by(|a, b| a.cost.total_cmp(&b.cost))
    });
    let is_better = |own: &Likeliest| own.cost < best.cost || !asked.allows(&best.at);
    if let Some(own) = own.filter(is_better) {
        best = own;
    }
    if !asked.allows(&best.at) {
        return None;
    }
    finished(pieces, model, kind, best.at.x, best.noise, best.at.starts)
}

/// The most that a fit may leave of what is shown: a mean square in counts^2. Under a load that is taken to wander widely the likeliest
/// numbers may follow the recording from sample to sample and leave its course: those explain nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Most(f64);

impl Most {
    /// No more than numbers that leave this mean square, but for what does not matter.
    pub fn beside(mean_square: f64) -> Self {
        Self(mean_square + CLOSES * (mean_square - ROUNDING).max(ROUNDING))
    }

    /// Whatever it leaves.
    pub fn anything() -> Self {
        Self(f64::INFINITY)
    }

    /// Whether a fit may leave this mean square.
    pub fn allows(self, mean_square: f64) -> bool {
        mean_square <= self.0
    }

    /// No more than a model leaves with the numbers that it starts from; none where it cannot be simulated.
    pub fn of_start(pieces: &Pieces, model: &Model, kind: CommandKind) -> Option<Self> {
        let left = Left::new(pieces, model, kind, &model.start())?;
        Some(Self::beside(mean_square(&left.shown)))
    }
}

/// What is fitted to what.
struct Asked<'a> {
    pieces: &'a Pieces,
    model: &'a Model,
    kind: CommandKind,
    most: Most,
}

impl Asked<'_> {
    /// By how much in counts^2 numbers leave more than they may.
    fn beyond(&self, at: &At) -> f64 {
        let around = surroundings(self.pieces, self.model, &at.x, self.kind);
        let shown = less_start(self.pieces, around.time_constant_s, &at.residual);
        (mean_square(&shown) - self.most.0).max(0.0)
    }

    fn allows(&self, at: &At) -> bool {
        self.beyond(at) <= 0.0
    }
}

/// Numbers with the noise under which what they leave is likeliest.
#[derive(Debug, Clone)]
struct Likeliest {
    at: At,
    noise: Noise,
    /// Negative logarithm of likelihood and prior, in nats.
    cost: f64,
}

impl Likeliest {
    fn new(asked: &Asked<'_>, at: At) -> Self {
        let Asked {
            pieces,
            model,
            kind,
            ..
        } = *asked;
        let around = surroundings(pieces, model, &at.x, kind);
        let noise = likeliest(pieces, &around, &at.residual);
        let whitener = Whitener::new(pieces, &around, noise);
        let determinants = whitener.log_det.iter().sum::<f64>();
        Self {
            cost: cost_of(model, &whitener, &at) + 0.5 * determinants + noise.prior(),
            at,
            noise,
        }
    }

    /// The fit from here on, with the noise found anew until it stands still.
    fn settled(self, asked: &Asked<'_>) -> Option<Self> {
        let Asked {
            pieces,
            model,
            kind,
            ..
        } = *asked;
        let beyond = |at: &At| asked.beyond(at);
        let mut now = self;
        for round in 0..ROUNDS {
            let around = surroundings(pieces, model, &now.at.x, kind);
            let whitener = Whitener::new(pieces, &around, now.noise);
            let mut at = minimise(pieces, model, &whitener, now.at, &beyond)?;
            if let Some(other) = elsewhere(pieces, model, &whitener, &at, &beyond) {
                at = minimise(pieces, model, &whitener, other, &beyond)?;
            }
            let next = Self::new(asked, at);
            let stands_still = next.noise == now.noise && round > 0;
            now = next;
            if stands_still {
                break;
            }
        }
        Some(now)
    }
}

/// Numbers, and what they leave.
#[derive(Debug, Clone)]
pub(super) struct At {
    pub x: Vec<f64>,
    /// What the simulation is expanded about.
    starts: Starts,
    /// Whether that is found anew on the way.
    is_about_its_own: bool,
    /// Recorded less predicted, in counts.
    pub residual: Vec<f64>,
}

impl At {
    /// From the starts that are measured.
    pub fn measured(pieces: &Pieces, model: &Model, x: Vec<f64>) -> Option<Self> {
        let starts = Starts::measured(pieces);
        let residual = residual(pieces, &response(pieces, &model.motor(&x), &starts)?);
        Some(Self {
            x,
            starts,
            is_about_its_own: false,
            residual,
        })
    }

    /// From the starts that the model has.
    pub fn about_its_own(
        pieces: &Pieces,
        model: &Model,
        kind: CommandKind,
        x: Vec<f64>,
    ) -> Option<Self> {
        let time_constant_s = surroundings(pieces, model, &x, kind).time_constant_s;
        let (starts, residual) = Starts::of(pieces, &model.motor(&x), time_constant_s)?;
        Some(Self {
            x,
            starts,
            is_about_its_own: true,
            residual,
        })
    }

    /// Other numbers about the same starts.
    fn moved(&self, pieces: &Pieces, model: &Model, x: Vec<f64>) -> Option<Self> {
        let predicted = response(pieces, &model.motor(&x), &self.starts)?;
        Some(Self {
            x,
            residual: residual(pieces, &predicted),
            ..self.clone()
        })
    }

    /// The same numbers about other starts, with the derivatives by the numbers, a column each.
    fn with_columns(
        &self,
        pieces: &Pieces,
        model: &Model,
        starts: Starts,
    ) -> Option<(Self, Vec<Vec<f64>>)> {
        let (predicted, columns) = sensitivities(pieces, model, &self.x, &starts)?;
        let at = Self {
            residual: residual(pieces, &predicted),
            starts,
            ..self.clone()
        };
        Some((at, columns))
    }
}

/// Negative logarithm of likelihood and prior under a noise, but for what does not depend on the numbers.
fn cost_of(model: &Model, whitener: &Whitener, at: &At) -> f64 {
    let white = whitener.whiten(&at.residual);
    0.5 * dot(&white, &white) + model.normal_prior(&at.x)
}

/// The same numbers but for one that nothing depends on smoothly, at the place in its range that costs least; none where no place costs
/// less.
fn elsewhere(
    pieces: &Pieces,
    model: &Model,
    whitener: &Whitener,
    at: &At,
    beyond: &(dyn Fn(&At) -> f64 + Sync),
) -> Option<At> {
    let numbers = model.numbers.iter().enumerate();
    let tried: Vec<(usize, f64)> = numbers
        .filter(|(_, number)| !number.smooth)
        .flat_map(|(k, number)| {
            let at = |place: usize| (place as f64 + 0.5) / PLACES as f64;
            (0..PLACES).map(move |place| (k, number.lo + at(place) * (number.hi - number.lo)))
        })
        .collect();
    let tried = tried.into_par_iter().filter_map(|(k, value)| {
        let mut x = at.x.clone();
        x[k] = value;
        let other = at.moved(pieces, model, x)?;
        Some((cost_of(model, whitener, &other), other))
    });
    let allowed = beyond(at);
    let tried = tried.filter(|(_, other)| beyond(other) <= allowed);
    let (cost, other) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (cost < cost_of(model, whitener, at) - ENOUGH).then_some(other)
}

/// The numbers that cost least under a noise, from some on, by steps that leave no more `beyond` what is allowed.
pub(super) fn minimise(
    pieces: &Pieces,
    model: &Model,
    whitener: &Whitener,
    mut at: At,
    beyond: &dyn Fn(&At) -> f64,
) -> Option<At> {
    let n = at.x.len();
    let mut damping = 1e-3;
    let mut allowed = beyond(&at);
    let cost_of = |at: &At| cost_of(model, whitener, at);
    if !cost_of(&at).is_finite() {
        return None;
    }
    for _ in 0..MOST_STEPS {
        // About starts that have been found anew, unless these do worse.
        let does_no_worse =
            |next: &At| cost_of(next) < cost_of(&at) + ENOUGH && beyond(next) <= allowed;
        let anew = (at.is_about_its_own)
            .then(|| Starts::seen(pieces, whitener.time_constant_s, &at.residual))
            .and_then(|starts| at.with_columns(pieces, model, starts))
            .filter(|(next, _)| does_no_worse(next));
        let as_it_is = || at.with_columns(pieces, model, at.starts.clone());
        let Some((now, columns)) = anew.or_else(as_it_is) else {
            break;
        };
        at = now;
        let mut cost = cost_of(&at);
        let white = whitener.whiten(&at.residual);
        let columns = whitener.whiten_all(&columns);
        let d = DVector::from_column_slice(&at.x) - &model.mean;
        let hessian =
            DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j])) + &model.precision;
        let gradient = DVector::from_fn(n, |i, _| dot(&columns[i], &white)) - &model.precision * d;
        let mut gained = 0.0;
        let mut done = false;
        for _ in 0..8 {
            let mut damped = hessian.clone();
            for k in 0..n {
                damped[(k, k)] += damping * hessian[(k, k)].max(1e-9);
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                damping *= 10.0;
                continue;
            };
            let mut next: Vec<f64> = (at.x.iter())
                .zip(step.iter())
                .map(|(x, s)| x + s.clamp(-1.5, 1.5))
                .collect();
            model.clamp(&mut next);
            let next = at.moved(pieces, model, next);
            let then = next.as_ref().map_or(f64::INFINITY, cost_of);
            if let Some(next) = next.filter(|next| then < cost && beyond(next) <= allowed) {
                gained = cost - then;
                allowed = beyond(&next);
                (at, cost) = (next, then);
                damping = (damping * 0.2).max(1e-9);
                done = true;
                break;
            }
            damping *= 6.0;
        }
        if !done || gained < ENOUGH {
            break;
        }
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::{base_of, fitted, member, motor_with, recording};
    use crate::motor::Motor;

    /// A threshold between two levels of the command is found wherever its fit begins.
    #[test]
    fn a_threshold_is_found_from_any_start() {
        let run = recording(&motor_with(&[("dead_zone", &[1.3])]), 1000);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let base = base_of(&pieces);
        for begun_v in [0.3, 0.9, 1.7] {
            let fit = fitted(&pieces, &base, &[member("dead_zone", begun_v)]);
            let motor = fit.model.motor(&fit.x);
            let mut found = motor
                .effects
                .get("dead_zone")
                .expect("it is there")
                .parameters();
            let (_, threshold_v) = found.next().expect("a threshold");
            // The levels about it are 1.1 and 1.5 V.
            assert!(
                (1.1..1.5).contains(&threshold_v),
                "{begun_v}: {threshold_v}"
            );
        }
    }
}
