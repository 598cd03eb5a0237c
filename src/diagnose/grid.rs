//! Values of an effect that a search sets out from: a grid over its plausible range, for some effects the values that matter.

use super::hypothesis::{Member, is_limited};
use super::problem::Problem;
use crate::motor::catalogue::{EffectKind, EffectParameter, Prior};

/// Limits of the edge rate to try, as shares of the fastest that was counted (smoothed, so that it may be higher).
const RATES: [f64; 12] = [
    0.80, 0.86, 0.92, 0.97, 1.0, 1.03, 1.06, 1.1, 1.15, 1.2, 1.3, 1.4,
];

/// Most thresholds of a dead zone to try, and how far from that of a fit to try all.
const MOST_THRESHOLDS: usize = 40;
const NEARBY: f64 = 1.25;

/// Frequencies to try, as shares of the logarithm of their range: a resonance is some damping ratios wide.
const RESONANCES: [f64; 8] = [0.04, 0.16, 0.28, 0.4, 0.52, 0.64, 0.76, 0.9];
/// Shares of the range to try of a number that is the only one, of the first of several, and of the others.
const OF_ONE: [f64; 6] = [0.03, 0.15, 0.3, 0.5, 0.7, 0.9];
const OF_FIRST: [f64; 4] = [0.1, 0.35, 0.6, 0.9];
const OF_OTHERS: [f64; 2] = [0.2, 0.7];

/// By how much less than the least of its range an effect does next to nothing.
const NEXT_TO_NOTHING: f64 = 5.0;

/// Values of an effect, in the order of its parameters.
pub(super) type Values = Vec<f64>;

/// The grid of an effect in a problem.
pub(super) struct Grid<'a> {
    problem: &'a Problem<'a>,
    kind: &'static EffectKind,
}

impl<'a> Grid<'a> {
    /// Of this effect.
    pub fn new(problem: &'a Problem<'a>, kind: &'static EffectKind) -> Self {
        Self { problem, kind }
    }

    /// What to try beside these members; `known` are the effect's values in a fit, near which to look more closely.
    pub fn beside(&self, members: &[Member], known: Option<&[f64]>) -> Vec<Values> {
        if self.kind.id == "dead_zone" {
            let mut values = self.thresholds(None);
            if let Some(known) = known {
                values.extend(self.thresholds(known.first().copied()));
            }
            return values;
        }
        let mut values = combined(&self.lists());
        if self.kind.id == "missed_counts" {
            values.extend(self.fastest_rates());
        } else if members.iter().any(is_limited) {
            values.push(self.next_to_nothing());
        }
        values
    }

    /// Values to try of each number: four of the first one, eight of a frequency, two of the others.
    fn lists(&self) -> Vec<Values> {
        let parameters = self.kind.parameters;
        let list = |(k, parameter)| self.list(k, parameter);
        parameters.iter().enumerate().map(list).collect()
    }

    fn list(&self, k: usize, parameter: &EffectParameter) -> Values {
        let problem = self.problem;
        let (setting, motor) = (&problem.setting, &problem.nominal.parameters);
        let (lo, hi) = setting.range(parameter, motor);
        let shares: &[f64] = match (k, self.kind.parameters.len()) {
            (0, 1) => &OF_ONE,
            (0, _) if parameter.unit == "Hz" => &RESONANCES,
            (0, _) => &OF_FIRST,
            _ => &OF_OTHERS,
        };
        match parameter.prior {
            Prior::OneOf(values) => {
                let stated = motor.get(parameter.key);
                let others = values.iter().copied().filter(|v| Some(*v) != stated);
                others.collect()
            }
            Prior::Phase => [0.0, 0.5, 1.0, 1.5]
                .map(|x| x * std::f64::consts::PI)
                .to_vec(),
            _ if hi <= lo => vec![setting.default(parameter, motor)],
            Prior::LogUniform => shares.iter().map(|s| lo * (hi / lo).powf(*s)).collect(),
            Prior::Uniform => shares.iter().map(|s| lo + (hi - lo) * s).collect(),
        }
    }

    /// Values at which an effect does next to nothing. Beside edges that are lost above a rate a larger one moves the speed
    /// across that rate, and what is left is no longer what the fit before had found.
    fn next_to_nothing(&self) -> Values {
        let problem = self.problem;
        let (setting, motor) = (&problem.setting, &problem.nominal.parameters);
        let value = |(k, parameter): (usize, &EffectParameter)| {
            let (lo, hi) = setting.range(parameter, motor);
            match parameter.neutral(&setting.measures(motor)) {
                Some((neutral, _)) => neutral,
                None if k == 0 && hi > lo && parameter.prior == Prior::LogUniform => {
                    lo / NEXT_TO_NOTHING
                }
                None if k == 0 => lo,
                None => setting.default(parameter, motor),
            }
        };
        let parameters = self.kind.parameters.iter().enumerate();
        parameters.map(value).collect()
    }

    /// A dead zone swallows whole levels of the command: only which ones matters. Tried are the gaps between
    /// levels, in a ramp of many levels every so many; all of them near the value of a fit.
    fn thresholds(&self, near: Option<f64>) -> Vec<Values> {
        let (lo, hi) = match near {
            Some(value) => (value / NEARBY, value * NEARBY),
            None => (0.05, 3.0),
        };
        let commands = self.problem.runs.iter().flat_map(|run| &run.command);
        let mut levels: Vec<f64> = commands.map(|u| u.abs()).filter(|u| *u > 0.0).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let between = levels.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let last = levels.last().map(|level| level * 1.05);
        let gaps: Vec<f64> = between
            .chain(last)
            .filter(|v| (lo..=hi).contains(v))
            .collect();
        let every = gaps.len().div_ceil(MOST_THRESHOLDS).max(1);
        gaps.into_iter().step_by(every).map(|v| vec![v]).collect()
    }

    /// Edges that come too fast are lost: then the fastest that were counted tell the limit.
    fn fastest_rates(&self) -> Vec<Values> {
        let top = self.problem.runs.iter().map(|run| run.top_speed_counts_s);
        let top = top.fold(0.0, f64::max);
        RATES.iter().map(|share| vec![0.0, share * top]).collect()
    }
}

/// Every value of each number with every value of the others.
fn combined(lists: &[Values]) -> Vec<Values> {
    lists.iter().fold(vec![Vec::new()], |points, list| {
        let with_each = |point: Values| {
            let point_with = move |value: &f64| {
                let mut point = point.clone();
                point.push(*value);
                point
            };
            list.iter().map(point_with)
        };
        points.into_iter().flat_map(with_each).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::super::rivals::catalogue;
    use super::super::samples::{index, motor_with, problem, ready, recording};
    use super::*;

    /// Every value of each number with every value of the others; beside edges that are lost above a rate one more.
    #[test]
    fn a_grid_holds_all_combinations_and_beside_lost_edges_next_to_nothing() {
        let nominal = motor_with(&[]);
        let runs = ready(&recording(&nominal));
        let problem = problem(&nominal, &runs);
        let limited = Member {
            index: index("missed_counts"),
            values: vec![0.0, 500.0],
        };
        for (id, points) in [("compliance", 64), ("stribeck", 8), ("quadratic_drag", 6)] {
            let kind = &catalogue()[index(id)];
            let grid = Grid::new(&problem, kind);
            let mut tried = grid.beside(&[], None);
            tried.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
            tried.dedup();
            assert_eq!(tried.len(), points, "{id}");
            let more = grid.beside(std::slice::from_ref(&limited), None);
            assert_eq!(more.len(), points + 1, "{id}");
            let least = more[points][0];
            let is_least = |point: &Values| kind.id == "compliance" || point[0] > least;
            assert!(tried.iter().all(is_least), "{id}: {least}");
        }
    }
}
