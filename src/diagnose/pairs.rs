//! Which two effects explain the runs together, where neither need lead alone.
//!
//! On short horizons what effects take off the residual adds up: `r = B b + D a`, with the base's columns `B` and in `D`
//! what each effect does at its best starts, or the sine and cosine of an order. With the base projected out,
//! `S = D'D - D'B (B'B + P)^-1 B'D` and `t = D'r - D'B (B'B + P)^-1 (B'r - P p)`, and two effects with the columns `K`
//! together gain `t_K' S_KK^-1 t_K` in squares: all pairs are weighed without a simulation of any.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::anchor::Anchor;
use super::hypothesis::{BASE, Hypothesis, Member};
use super::periodic::{Waves, is_scanned, orders, repeats};
use super::problem::Problem;
use super::prospect::Prospect;
use super::rivals::catalogue;
use super::search::{Search, Start};
use super::sums::dot;

/// How many starts of an effect take part.
const STARTS: usize = 2;
/// Of what an effect does at a start, the least and the most share that means this effect.
const SHARES: std::ops::Range<f64> = 0.1..5.0;
/// How many places of a pair are fitted.
const PLACES: usize = 2;

/// Two effects with where their fit starts.
pub(super) struct Promise {
    /// Their indices in the catalogue.
    pub effects: [usize; 2],
    /// Starts, best first.
    pub starts: Vec<Start>,
}

/// Squares that two effects gain, with their indices and values.
type Weighed = (f64, [(usize, Vec<f64>); 2]);

/// What an effect may take off the residual: a column at a start, two for a wave of some order.
struct Block {
    index: usize,
    /// Values at the start; the order of a wave.
    place: Place,
    columns: Vec<Vec<f64>>,
    /// The columns' products with the base, in the coordinates in which it is orthonormal.
    on_base: Vec<DVector<f64>>,
    /// Products with the residual, the base projected out.
    on_residual: Vec<f64>,
}

enum Place {
    Values(Vec<f64>),
    Order(f64),
}

/// The base as it gives way.
struct Base<'a> {
    anchor: &'a Anchor,
    factor: Cholesky<f64, Dyn>,
    /// The residual's products with the base, in the same coordinates.
    residual: DVector<f64>,
}

impl<'a> Base<'a> {
    fn new(anchor: &'a Anchor) -> Option<Self> {
        let factor = anchor.factor.clone()?;
        let residual = factor.l_dirty().solve_lower_triangular(&anchor.right)?;
        Some(Self {
            anchor,
            factor,
            residual,
        })
    }

    fn block(&self, index: usize, place: Place, columns: Vec<Vec<f64>>) -> Option<Block> {
        let (mut on_base, mut on_residual) = (Vec::new(), Vec::new());
        for column in &columns {
            let base = &self.anchor.base;
            let products = DVector::from_iterator(base.len(), base.iter().map(|b| dot(b, column)));
            let products = self.factor.l_dirty().solve_lower_triangular(&products)?;
            on_residual.push(dot(column, &self.anchor.residual) - products.dot(&self.residual));
            on_base.push(products);
        }
        Some(Block {
            index,
            place,
            columns,
            on_base,
            on_residual,
        })
    }
}

/// Squares that two blocks gain together, and their coefficients.
fn together(a: &Block, b: &Block) -> Option<(f64, Vec<f64>)> {
    let n = a.columns.len() + b.columns.len();
    let of = |k: usize| match k.checked_sub(a.columns.len()) {
        None => (&a.columns[k], &a.on_base[k], a.on_residual[k]),
        Some(k) => (&b.columns[k], &b.on_base[k], b.on_residual[k]),
    };
    let mut s = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in i..n {
            let ((x, u, _), (y, v, _)) = (of(i), of(j));
            let sum = dot(x, y) - u.dot(v);
            (s[(i, j)], s[(j, i)]) = (sum, sum);
        }
        s[(i, i)] += 1e-9 * s[(i, i)] + 1e-9;
    }
    let t = DVector::from_fn(n, |k, _| of(k).2);
    let x = s.cholesky()?.solve(&t);
    let plausible = |block: &Block, first: usize| match block.place {
        Place::Values(_) => SHARES.contains(&x[first]),
        Place::Order(_) => true,
    };
    (plausible(a, 0) && plausible(b, a.columns.len()))
        .then(|| (x.dot(&t), x.iter().copied().collect()))
}

/// Those of these effects that do not repeat with the angle.
pub(super) fn not_repeating(indices: &[usize]) -> Vec<usize> {
    let indices = indices.iter().copied();
    indices
        .filter(|&index| !repeats(catalogue()[index].id))
        .collect()
}

/// The most promising pairs of these effects, at most `most`; `alone` is what those that do not repeat with the angle promise
/// beside nothing.
pub(super) fn promising(
    problem: &Problem<'_>,
    search: &Search<'_>,
    alone: &[Prospect],
    indices: &[usize],
    most: usize,
) -> Vec<Promise> {
    let Some((anchor, level)) = search.anchor() else {
        return Vec::new();
    };
    let Some(base) = Base::new(anchor) else {
        return Vec::new();
    };
    let waves = Waves::new(problem, level);
    let others: Vec<&Prospect> = alone
        .iter()
        .filter(|new| !repeats(catalogue()[new.index].id))
        .collect();
    let repeating = indices
        .iter()
        .copied()
        .filter(|&index| repeats(catalogue()[index].id));
    let at_starts: Vec<Block> = others
        .par_iter()
        .flat_map_iter(|new| {
            let starts = new.starts.iter().take(STARTS);
            starts.map(|start| (new.index, start))
        })
        .filter_map(|(index, start)| {
            let column = search.taken_off(start)?;
            let values = Place::Values(start.0.values(0, &start.1));
            base.block(index, values, vec![column])
        })
        .collect();
    let (often, once): (Vec<usize>, Vec<usize>) =
        repeating.partition(|&index| is_scanned(catalogue()[index].id));
    let wave = |index: usize, order: f64| {
        let columns = waves.columns(catalogue()[index].id, order).to_vec();
        base.block(index, Place::Order(order), columns)
    };
    let once: Vec<Block> = once
        .into_iter()
        .filter_map(|index| wave(index, 1.0))
        .collect();
    let scanned: Vec<(usize, f64)> = often
        .into_iter()
        .flat_map(|index| {
            let orders = orders(catalogue()[index].id).into_iter();
            orders.map(move |order| (index, order))
        })
        .collect();
    let partners: Vec<&Block> = at_starts.iter().chain(&once).collect();
    let mut found: Vec<Weighed> = Vec::new();
    for (k, a) in partners.iter().enumerate() {
        for b in &partners[k + 1..] {
            found.extend(weigh(&waves, a, b));
        }
    }
    found.par_extend(scanned.par_iter().flat_map_iter(|&(index, order)| {
        let pairs: Vec<_> = match wave(index, order) {
            Some(block) => partners
                .iter()
                .filter_map(|partner| weigh(&waves, partner, &block))
                .collect(),
            None => Vec::new(),
        };
        pairs
    }));
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut promises: Vec<Promise> = Vec::new();
    for (_, members) in found {
        let effects = [members[0].0, members[1].0];
        let known = promises.iter().position(|p| p.effects == effects);
        let members = members.map(|(index, values)| Member { index, values });
        match known {
            Some(k) if promises[k].starts.len() < PLACES => {
                promises[k].starts.push(start_of(problem, anchor, members));
            }
            None if promises.len() < most => promises.push(Promise {
                effects,
                starts: vec![start_of(problem, anchor, members)],
            }),
            _ => {}
        }
    }
    promises
}

/// What two blocks of different effects gain, with the values of both.
fn weigh(waves: &Waves<'_>, a: &Block, b: &Block) -> Option<Weighed> {
    if a.index == b.index {
        return None;
    }
    let (gain, x) = together(a, b)?;
    let values = |block: &Block, first: usize| match &block.place {
        Place::Values(values) => values.clone(),
        Place::Order(order) => waves.values(block.index, *order, [x[first], x[first + 1]]),
    };
    let members = [
        (a.index, values(a, 0)),
        (b.index, values(b, a.columns.len())),
    ];
    Some((gain, members))
}

fn start_of(problem: &Problem<'_>, anchor: &Anchor, members: [Member; 2]) -> Start {
    let hypothesis = Hypothesis::new(problem.nominal, members.into(), &problem.setting);
    let mut start = hypothesis.start();
    start[..BASE].copy_from_slice(&anchor.p[..BASE]);
    hypothesis.clamp(&mut start);
    (hypothesis, start)
}
