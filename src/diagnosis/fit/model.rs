//! A motor with effects, which of its numbers are free, and what is plausible of them.
//!
//! Voltage in and counts out identify `J R/Kt`, `Kb` and `Tf R/Kt` (and, coasting, `b R/Kt`). Moved are the logarithms of J, Kb, Tf and
//! b, with R and Kt held: their prior is the covariance that the tolerances of all of them give.

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::settings::{DEFAULT_TOLERANCE, FREED_WIDTH};
use crate::motor::catalogue::{EffectParameter, Prior, Scale, catalogue};
use crate::motor::fit::ParameterId;
use crate::motor::{ActiveEffect, CommandKind, Motor};

/// Keys of the base numbers.
pub(crate) const BASE: [&str; 4] = [
    "inertia_kg_m2",
    "back_emf_v_s_per_rad",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_per_rad",
];
/// Effects that set a base number free, and which.
const FREEING: [(&str, usize); 3] = [
    ("inertia", 0),
    ("coulomb_friction", 2),
    ("viscous_friction", 3),
];

/// Lowest rate above which edges are lost, as a share of the top rate: lower is a decoder that nobody would use.
const LEAST_RATE: f64 = 0.2;

/// What is the same for all models of a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub motor: Motor,
    pub kind: CommandKind,
    pub sample_time_s: f64,
    /// Error of the clock as the host saw it, with its standard deviation.
    pub clock: Option<(f64, f64)>,
}

/// An effect of a model with the values that are not fitted, or to start from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Member {
    pub index: usize,
    pub values: Vec<f64>,
}

impl Member {
    pub fn id(&self) -> &'static str {
        catalogue()[self.index].id
    }

    /// The base number that it sets free.
    pub fn frees(&self) -> Option<usize> {
        frees(self.id())
    }
}

/// The base number that an effect sets free.
pub(crate) fn frees(id: &str) -> Option<usize> {
    FREEING
        .iter()
        .find(|(freeing, _)| *freeing == id)
        .map(|f| f.1)
}

/// One free number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    pub id: ParameterId,
    pub log: bool,
    pub lo: f64,
    pub hi: f64,
    pub smooth: bool,
}

/// A model.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub members: Vec<Member>,
    pub numbers: Vec<Number>,
    /// With the values that are not fitted.
    motor: Motor,
    pub precision: DMatrix<f64>,
    pub mean: DVector<f64>,
    start: Vec<f64>,
    /// Half the square by which the host contradicts a clock that is right, where the model has no other.
    clock: f64,
}

impl Model {
    pub fn new(base: &Base, members: Vec<Member>) -> Self {
        let mut motor = base.motor.clone();
        let mut numbers = Vec::new();
        let mut start = Vec::new();
        let p = &base.motor.parameters;
        let used: Vec<usize> = (0..BASE.len())
            .filter(|&k| p.get(BASE[k]).is_some_and(|value| value > 0.0))
            .filter(|&k| !(k == 1 && base.kind != CommandKind::Voltage))
            .collect();
        for &k in &used {
            let value = p.get(BASE[k]).unwrap_or(1.0).ln();
            numbers.push(Number {
                id: ParameterId::nominal(BASE[k]).expect("a key"),
                log: true,
                lo: value - 8.0,
                hi: value + 8.0,
                smooth: true,
            });
            start.push(value);
        }
        let covariance = base_covariance(base, &members);
        let n_base = used.len();
        let picked = DMatrix::from_fn(n_base, n_base, |i, j| covariance[(used[i], used[j])]);
        let base_precision = picked
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(n_base, n_base));
        let mut mean = start.clone();
        let mut widths = Vec::new();
        for member in &members {
            if member.frees().is_some() {
                continue;
            }
            let kind = &catalogue()[member.index];
            if let Ok(effect) = ActiveEffect::new(kind.id, &member.values) {
                motor.effects.set(effect);
            }
            for (k, parameter) in kind.parameters.iter().enumerate() {
                if !is_free(parameter)
                    || (member.values[k] == 0.0 && parameter.key == "max_rate_hz")
                {
                    continue;
                }
                if parameter.key == "probability" && member.values[k] == 0.0 {
                    continue;
                }
                let (lo, hi) = range_of(parameter, base);
                let log = matches!(parameter.prior, Prior::LogUniform);
                let phase = matches!(parameter.prior, Prior::Phase);
                let x = |value: f64| if log { value.max(1e-300).ln() } else { value };
                let (lo, hi) = (x(lo), x(hi));
                numbers.push(Number {
                    id: ParameterId::Effect(member.index, k),
                    log,
                    lo: if phase { f64::NEG_INFINITY } else { lo },
                    hi: if phase { f64::INFINITY } else { hi },
                    smooth: parameter.smooth,
                });
                start.push(x(member.values[k]));
                mean.push(0.5 * (lo + hi));
                let mut width = 0.5 * (hi - lo);
                if kind.id == "clock_error"
                    && let Some((seen, sd)) = base.clock
                {
                    *mean.last_mut().expect("just pushed") = seen;
                    width = sd;
                }
                widths.push(if phase { f64::INFINITY } else { width });
            }
        }
        let clock = match base.clock {
            Some((seen, sd)) if !members.iter().any(|member| member.id() == "clock_error") => {
                0.5 * (seen / sd).powi(2)
            }
            _ => 0.0,
        };
        let n = numbers.len();
        let mut precision = DMatrix::zeros(n, n);
        precision
            .view_mut((0, 0), (n_base, n_base))
            .copy_from(&base_precision);
        for (k, width) in widths.iter().enumerate() {
            precision[(n_base + k, n_base + k)] = 1.0 / (width * width);
        }
        Self {
            members,
            numbers,
            motor,
            precision,
            mean: DVector::from_vec(mean),
            start,
            clock,
        }
    }

    pub fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    /// The start with the numbers that another model has too taken from there.
    pub fn start_from(&self, other: &Self, x: &[f64]) -> Vec<f64> {
        let mut start = self.start();
        for (k, number) in self.numbers.iter().enumerate() {
            if let Some(j) = other.numbers.iter().position(|n| n.id == number.id) {
                start[k] = x[j];
            }
        }
        start
    }

    /// Which numbers are free.
    pub fn free(&self) -> Vec<ParameterId> {
        self.numbers.iter().map(|number| number.id).collect()
    }

    pub fn motor(&self, x: &[f64]) -> Motor {
        let mut motor = self.motor.clone();
        for (number, x) in self.numbers.iter().zip(x) {
            number
                .id
                .set(&mut motor, if number.log { x.exp() } else { *x });
        }
        motor
    }

    pub fn clamp(&self, x: &mut [f64]) {
        for (number, x) in self.numbers.iter().zip(x) {
            *x = x.clamp(number.lo, number.hi);
        }
    }

    /// Half the squared distance from what is plausible, whitened.
    pub fn prior(&self, x: &[f64]) -> f64 {
        let d = DVector::from_column_slice(x) - &self.mean;
        self.clock + 0.5 * (&self.precision * &d).dot(&d)
    }

    /// Ids of its effects, sorted.
    pub fn ids(&self) -> Vec<&'static str> {
        let mut ids: Vec<&str> = self.members.iter().map(Member::id).collect();
        ids.sort_unstable();
        ids
    }
}

/// Whether a parameter is fitted: what is one of a few values, or a side, is a start of its own.
pub(crate) fn is_free(parameter: &EffectParameter) -> bool {
    (!matches!(parameter.prior, Prior::OneOf(_)) || parameter.key == "max_rate_hz")
        && parameter.key != "encoder_side"
}

/// Range in SI, for the run's own sample time.
pub(crate) fn range_of(parameter: &EffectParameter, base: &Base) -> (f64, f64) {
    if parameter.key == "max_rate_hz" {
        let top = Scale::TopRate.of(&base.motor.parameters, base.sample_time_s);
        return (LEAST_RATE * top, top);
    }
    let (lo, hi) = parameter.range(&base.motor.parameters, base.sample_time_s);
    (lo.min(hi), lo.max(hi))
}

fn base_covariance(base: &Base, members: &[Member]) -> DMatrix<f64> {
    let tolerance = |key: &str| {
        let stated = base.motor.tolerance.get(key).copied();
        stated.unwrap_or(DEFAULT_TOLERANCE)
    };
    let common = match base.kind {
        CommandKind::Voltage => {
            tolerance("resistance_ohm").powi(2) + tolerance("torque_constant_nm_per_a").powi(2)
        }
        CommandKind::Current => tolerance("torque_constant_nm_per_a").powi(2),
        CommandKind::Torque => 0.0,
    };
    let mut covariance = DMatrix::zeros(BASE.len(), BASE.len());
    for i in 0..BASE.len() {
        for j in 0..BASE.len() {
            if i != 1 && j != 1 {
                covariance[(i, j)] = common;
            }
        }
        let own = if members.iter().any(|member| member.frees() == Some(i)) {
            FREED_WIDTH
        } else {
            tolerance(BASE[i])
        };
        covariance[(i, i)] += own * own;
    }
    covariance
}
