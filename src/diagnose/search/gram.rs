//! Scores of all single effects, pairs and triples to second order, from one Gram matrix (score test; Rao 1948).
//!
//! Columns of all candidates are corrected (or whitened), base parameters projected out with their priors. The gain of a set of columns
//! `C` is `1/2 t' S^-1 t` with `S = C'C - C'J H^-1 J'C` and `t` the projection of the residual, with coefficients that an effect can have.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidates::{Candidate, Shape};
use crate::diagnose::fit::{Fit, gram};
use crate::diagnose::model::dot;

use crate::diagnose::settings::solver::{EXTENDED, LARGEST_COEFFICIENT, LAST_DIGITS, SAME};

/// A set of candidates with the coefficients of their columns.
#[derive(Debug, Clone)]
pub(crate) struct Screened {
    /// Numbers of the candidates.
    pub of: Vec<usize>,
    pub coefficients: Vec<(f64, f64)>,
    /// Gain in nats less the price of complexity.
    pub worth: f64,
}

/// The Gram matrix of all candidates against a fit.
pub(crate) struct Screen {
    /// First column of each candidate, how many it has, and whether their coefficient has a sign.
    blocks: Vec<(usize, usize, bool)>,
    s: DMatrix<f64>,
    t: DVector<f64>,
    price: Vec<f64>,
    /// Effective number of observations, where gains are those of a scale-free score.
    n_eff: Option<f64>,
}

impl Screen {
    /// `prepared` turns a column in counts into one of uncorrelated unit noise (`weight` times that of the residual's units). `None` where the
    /// base parameters are not determined.
    pub fn new(
        fit: &Fit,
        candidates: &[Candidate],
        prices: Vec<f64>,
        prepared: &(dyn Fn(&[f64]) -> Vec<f64> + Sync),
        weight: f64,
        n_eff: Option<f64>,
    ) -> Option<Self> {
        let residual = prepared(&fit.residual);
        let base: Vec<Vec<f64>> = fit.columns.par_iter().map(|c| prepared(c)).collect();
        let precision = fit.model.precision_as_unlikely(&fit.x);
        let distance = DVector::from_column_slice(&fit.x) - &fit.model.mean;
        let mut blocks = Vec::new();
        let mut raw: Vec<(&[f64], f64)> = Vec::new();
        for Candidate { shape, .. } in candidates {
            let own = match shape {
                Shape::One(column) => vec![(&column[..], 0.0)],
                Shape::Pair([sine, cosine], _) => vec![(&sine[..], 0.0), (&cosine[..], 0.0)],
                Shape::Widens(place, known) => vec![(&fit.columns[*place][..], *known)],
            };
            blocks.push((raw.len(), own.len(), matches!(shape, Shape::One(_))));
            raw.extend(own);
        }
        let columns: Vec<Vec<f64>> = raw.par_iter().map(|(c, _)| prepared(c)).collect();
        let m = columns.len();
        let hessian = gram(&base) * weight + &precision;
        let right = DVector::from_fn(base.len(), |i, _| weight * dot(&base[i], &residual))
            - &precision * &distance;
        let cross = DMatrix::from_fn(base.len(), m, |i, k| weight * dot(&base[i], &columns[k]));
        let solved = hessian.cholesky()?.solve(&cross);
        let rows: Vec<Vec<f64>> = (0..m)
            .into_par_iter()
            .map(|i| {
                (0..=i)
                    .map(|j| weight * dot(&columns[i], &columns[j]))
                    .collect()
            })
            .collect();
        let mut s = DMatrix::from_fn(m, m, |i, j| rows[i.max(j)][i.min(j)]);
        let own = s.diagonal();
        s -= cross.transpose() * &solved;
        let mut t = DVector::from_fn(m, |k, _| weight * dot(&columns[k], &residual))
            - solved.transpose() * &right;
        for k in 0..m {
            s[(k, k)] += raw[k].1;
            if s[(k, k)] < LAST_DIGITS * own[k].max(f64::MIN_POSITIVE) {
                s.row_mut(k).fill(0.0);
                s.column_mut(k).fill(0.0);
                t[k] = 0.0;
            }
        }
        Some(Self {
            blocks,
            s,
            t,
            price: prices,
            n_eff,
        })
    }

    /// Singles, pairs and triples by worth, best first.
    pub fn sets(&self, candidates: &[Candidate], deepest: usize) -> Vec<Screened> {
        let n = self.blocks.len();
        let singles: Vec<Screened> = (0..n).filter_map(|i| self.of(vec![i])).collect();
        let mut all = singles.clone();
        if deepest >= 2 {
            let pairs = (0..n).into_par_iter().flat_map_iter(|i| {
                (0..i).filter_map(move |j| {
                    let differ = candidates[i].member.index != candidates[j].member.index;
                    differ.then(|| self.of(vec![j, i])).flatten()
                })
            });
            let mut pairs: Vec<Screened> = pairs.collect();
            pairs.sort_by(|a, b| b.worth.total_cmp(&a.worth));
            let pairs = distinct(pairs, candidates, 1);
            if deepest >= 3 {
                for pair in pairs.iter().take(EXTENDED) {
                    all.extend((0..n).filter_map(|k| {
                        let index = candidates[k].member.index;
                        let is_new = pair.of.iter().all(|i| candidates[*i].member.index != index);
                        let set = || [&pair.of[..], &[k]].concat();
                        is_new.then(|| self.of(set())).flatten()
                    }));
                }
            }
            all.extend(pairs);
        }
        all.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        all
    }

    /// One set, where each of its members contributes.
    fn of(&self, of: Vec<usize>) -> Option<Screened> {
        let places: Vec<usize> = (of.iter())
            .flat_map(|k| self.blocks[*k].0..self.blocks[*k].0 + self.blocks[*k].1)
            .collect();
        let n = places.len();
        if places.iter().any(|k| self.s[(*k, *k)] <= 0.0) {
            return None;
        }
        let mut s = DMatrix::from_fn(n, n, |i, j| self.s[(places[i], places[j])]);
        for k in 0..n {
            s[(k, k)] *= 1.0 + LAST_DIGITS;
        }
        let t = DVector::from_fn(n, |i, _| self.t[places[i]]);
        let mut a = s.clone().cholesky()?.solve(&t);
        let mut at = 0;
        for k in &of {
            if self.blocks[*k].2 {
                if a[at] <= 0.0 {
                    return None;
                }
                if a[at] > LARGEST_COEFFICIENT {
                    a[at] = LARGEST_COEFFICIENT;
                }
            }
            at += self.blocks[*k].1;
        }
        let gain = a.dot(&t) - 0.5 * (&s * &a).dot(&a);
        if gain <= 0.0 {
            return None;
        }
        let gain = match self.n_eff {
            Some(n_eff) => -0.5 * n_eff * (1.0 - 2.0 * gain / n_eff).max(LAST_DIGITS).ln(),
            None => gain,
        };
        let mut coefficients = Vec::new();
        let (mut at, mut price) = (0, 0.0);
        for k in &of {
            let columns = self.blocks[*k].1;
            coefficients.push((a[at], if columns > 1 { a[at + 1] } else { 0.0 }));
            let information =
                (at..at + columns).map(|i| 0.5 * (1.0 + s[(i, i)] * a[i] * a[i]).ln());
            price += self.price[*k] + information.sum::<f64>();
            at += columns;
        }
        Some(Screened {
            of,
            coefficients,
            worth: ((gain - price) / SAME).round() * SAME,
        })
    }
}

/// Of each set of effects the best, up to so many starts of each.
pub(crate) fn distinct(
    sets: Vec<Screened>,
    candidates: &[Candidate],
    starts: usize,
) -> Vec<Screened> {
    let mut seen: std::collections::BTreeMap<Vec<usize>, usize> = Default::default();
    (sets.into_iter())
        .filter(|set| {
            let mut ids: Vec<usize> = set.of.iter().map(|k| candidates[*k].member.index).collect();
            ids.sort_unstable();
            let count = seen.entry(ids).or_default();
            *count += 1;
            *count <= starts
        })
        .collect()
}
