//! A motor with effects, which of its numbers are free, and what is plausible of them.
//!
//! Voltage in and counts out identify `J R/Kt`, `Kb`, `Tf R/Kt`, `L/R` (and, coasting, `b R/Kt`). Moved are J, Kb, Tf, b and L as shares
//! of the motor file's, with R and Kt held: their prior is the covariance that the tolerances of all of them give. What is steady
//! depends on sums of them, so that where two are not told apart the valley between them is straight.
//!
//! A load or a disc that is known is a torque in N m: runs with one identify `R/Kt` as well. There Kt is moved too, with R held.

use nalgebra::{DMatrix, DVector};

use super::Then;
use super::tolerances::Tolerances;
use crate::diagnose::settings::{BEYOND_RANGE, DEFAULT_TOLERANCE, LEAST_RATE, MOST_CHANGED};
use crate::motor::catalogue::{EffectParameter, Prior, Scale, catalogue};
use crate::motor::fit::ParameterId;
use crate::motor::{ActiveEffect, CommandKind, Motor};

/// Keys of the base numbers.
pub(crate) const BASE: [&str; 6] = [
    "inertia_kg_m2",
    "back_emf_v_s_per_rad",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_per_rad",
    "inductance_h",
    "torque_constant_nm_per_a",
];
/// Those of them that a command in volts alone depends on.
const BACK_EMF: usize = 1;
const INDUCTANCE: usize = 4;
/// That of them that only known torques tell.
const TORQUE_CONSTANT: usize = 5;
/// Effects that set a base number free, and which.
const FREEING: [(&str, usize); 3] = [
    ("inertia", 0),
    ("coulomb_friction", 2),
    ("viscous_friction", 3),
];

/// What is the same for all models of a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    pub motor: Motor,
    pub kind: CommandKind,
    pub sample_time_s: f64,
    /// Error of the clock as the host saw it, with its standard deviation.
    pub clock: Option<(f64, f64)>,
    /// Whether the times are those of arrivals at the host.
    pub is_host_timed: bool,
    /// Whether a load or a disc is known in one of the runs: a torque in N m.
    pub knows_torque: bool,
    /// What reference runs say of the motor, which is theirs then.
    pub then: Option<Then>,
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

    /// Whether its numbers are each one of a few: less of it is another of them, which is looked at by itself.
    pub fn is_whole(&self) -> bool {
        let parameters = catalogue()[self.index].parameters;
        !parameters.is_empty() && !parameters.iter().any(is_free)
    }

    /// The base number that it sets free.
    pub fn frees(&self, base: &Base) -> Option<usize> {
        base.frees(self.id())
    }
}

impl Base {
    /// Keys of the base numbers that such runs may tell.
    pub fn told(&self) -> &'static [&'static str] {
        match self.knows_torque {
            true => &BASE,
            false => &BASE[..TORQUE_CONSTANT],
        }
    }

    /// The base number that an effect sets free; none where the motor has none of it, so that the effect brings its own.
    pub fn frees(&self, id: &str) -> Option<usize> {
        let k = freed_by(id)?;
        let value = self.motor.parameters.get(BASE[k])?;
        (value > 0.0).then_some(k)
    }
}

fn freed_by(id: &str) -> Option<usize> {
    let found = FREEING.iter().find(|(freeing, _)| *freeing == id);
    found.map(|(_, number)| *number)
}

/// One free number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    pub id: ParameterId,
    /// Whether what is fitted is the logarithm.
    pub log: bool,
    /// Value in SI of a number of 1.
    pub unit: f64,
    pub lo: f64,
    pub hi: f64,
    pub smooth: bool,
}

impl Number {
    /// Its value in SI.
    pub fn value(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { x }
    }

    /// Derivative of its value in SI.
    pub fn slope(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { 1.0 }
    }
}

/// A model.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub members: Vec<Member>,
    pub numbers: Vec<Number>,
    /// With the values that are not fitted.
    motor: Motor,
    /// As fits have it: normal distributions, a tolerance that nobody states as if it were stated.
    pub precision: DMatrix<f64>,
    /// Of the base numbers, which are the first: what the motor file says; none against a reference.
    tolerances: Option<Tolerances>,
    pub mean: DVector<f64>,
    start: Vec<f64>,
    /// Relative standard deviation of torques, inertias and currents beside what the runs tell.
    pub scale: f64,
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
            .filter(|k| match *k {
                BACK_EMF | INDUCTANCE => base.kind == CommandKind::Voltage,
                TORQUE_CONSTANT => base.knows_torque && base.kind != CommandKind::Torque,
                _ => true,
            })
            .collect();
        for &k in &used {
            numbers.push(Number {
                id: ParameterId::nominal(BASE[k]).expect("a key"),
                log: false,
                unit: p.get(BASE[k]).unwrap_or(1.0),
                lo: MOST_CHANGED.recip(),
                hi: MOST_CHANGED,
                smooth: true,
            });
            start.push(1.0);
        }
        let (tolerances, mut covariance) = match &base.then {
            Some(then) => (None, since(base, then, &members, &used)),
            None => {
                let known = tolerances(base, &members, &used);
                let covariance = known.covariance();
                (Some(known), covariance)
            }
        };
        for (number, x) in base.then.iter().flat_map(|then| &then.numbers) {
            numbers.push(*number);
            start.push(*x);
        }
        let mut mean = start.clone();
        let mut widths = Vec::new();
        for member in &members {
            if member.frees(base).is_some() {
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
                let (least, most) = limits_of(parameter, (lo, hi));
                let (lo, hi) = (x(lo), x(hi));
                let id = ParameterId::Effect(member.index, k);
                // What the reference had is free about what it was there.
                if let Some(place) = base.then.as_ref().and_then(|then| then.place(id)) {
                    start[place] = x(member.values[k]);
                    covariance[(place, place)] += if phase {
                        std::f64::consts::PI.powi(2)
                    } else {
                        (0.5 * (hi - lo)).powi(2)
                    };
                    continue;
                }
                numbers.push(Number {
                    id,
                    log,
                    unit: 1.0,
                    lo: if phase { f64::NEG_INFINITY } else { x(least) },
                    hi: if phase { f64::INFINITY } else { x(most) },
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
        let n_known = covariance.nrows();
        let known_precision =
            (covariance.try_inverse()).unwrap_or_else(|| DMatrix::identity(n_known, n_known));
        let mut precision = DMatrix::zeros(n, n);
        precision
            .view_mut((0, 0), (n_known, n_known))
            .copy_from(&known_precision);
        for (k, width) in widths.iter().enumerate() {
            precision[(n_known + k, n_known + k)] = 1.0 / (width * width);
        }
        Self {
            members,
            numbers,
            motor,
            precision,
            tolerances,
            mean: DVector::from_vec(mean),
            start,
            scale: scale_variance(base).sqrt(),
            clock,
        }
    }

    pub fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    /// The start with other base numbers: shares of the motor file's, in the order of [`BASE`].
    pub fn start_with(&self, shares: [f64; BASE.len()]) -> Vec<f64> {
        let mut start = self.start();
        for (number, x) in self.numbers.iter().zip(&mut start) {
            let place = BASE.iter().position(|key| number.id.key() == *key);
            if let Some(k) = place {
                *x = shares[k].clamp(number.lo, number.hi);
            }
        }
        start
    }

    /// The start with the numbers that another model has too taken from there.
    pub fn start_from(&self, other: &Self, x: &[f64]) -> Vec<f64> {
        self.taken_from(self.start(), other, x)
    }

    /// A start with the numbers that another model has too taken from there.
    pub fn taken_from(&self, mut start: Vec<f64>, other: &Self, x: &[f64]) -> Vec<f64> {
        for (k, number) in self.numbers.iter().enumerate() {
            if let Some(j) = other.numbers.iter().position(|n| n.id == number.id) {
                start[k] = x[j];
            }
        }
        start
    }

    /// Whether another model differs from this one in nothing but the numbers that are fitted.
    pub fn is_like(&self, other: &Self) -> bool {
        let neutral = self.start();
        self.ids() == other.ids()
            && self.free() == other.free()
            && self.motor(&neutral) == other.motor(&neutral)
    }

    /// Which numbers are free.
    pub fn free(&self) -> Vec<ParameterId> {
        self.numbers.iter().map(|number| number.id).collect()
    }

    pub fn motor(&self, x: &[f64]) -> Motor {
        let mut motor = self.motor.clone();
        for (number, x) in self.numbers.iter().zip(x) {
            number.id.set(&mut motor, number.value(*x));
        }
        motor
    }

    pub fn clamp(&self, x: &mut [f64]) {
        for (number, x) in self.numbers.iter().zip(x) {
            *x = x.clamp(number.lo, number.hi);
        }
    }

    /// Nats by which the numbers are off what is plausible, as fits have it.
    pub fn normal_prior(&self, x: &[f64]) -> f64 {
        let d = DVector::from_column_slice(x) - &self.mean;
        self.clock + 0.5 * (&self.precision * &d).dot(&d)
    }

    /// The same as it counts: what is assumed of the base numbers has long tails.
    pub fn prior(&self, x: &[f64]) -> f64 {
        let Some(known) = &self.tolerances else {
            return self.normal_prior(x);
        };
        let off = self.off_file(x);
        let n = off.len();
        let rest = DVector::from_fn(x.len() - n, |k, _| x[n + k] - self.mean[n + k]);
        let of_rest = self.precision.view((n, n), (rest.len(), rest.len()));
        self.clock + known.cost(&off) + 0.5 * (of_rest * &rest).dot(&rest)
    }

    /// By how much the base numbers are off the motor file's.
    fn off_file(&self, x: &[f64]) -> DVector<f64> {
        let is_base = |number: &&Number| matches!(number.id, ParameterId::Nominal(_));
        let n = self.numbers.iter().take_while(is_base).count();
        DVector::from_fn(n, |k, _| x[k] - self.mean[k])
    }

    /// Inverse of the covariance of the normal distribution under which these numbers are as unlikely as they are.
    pub fn precision_as_unlikely(&self, x: &[f64]) -> DMatrix<f64> {
        let mut precision = self.precision.clone();
        if let Some(known) = &self.tolerances {
            let off = self.off_file(x);
            let n = off.len();
            (precision.view_mut((0, 0), (n, n))).copy_from(&known.as_unlikely(&off));
        }
        precision
    }

    /// By how many of its tolerances each base number lies off the motor file's, as unlikely under a normal distribution; 0 of the others.
    pub fn off(&self, x: &[f64]) -> Vec<f64> {
        let variance = self.precision.clone().pseudo_inverse(f64::MIN_POSITIVE);
        let off = |k: usize| {
            let off = (x[k] - self.mean[k]).abs();
            match &self.tolerances {
                Some(known) => known.tolerances_off(k, off),
                None => (variance.as_ref()).map_or(0.0, |known| off / known[(k, k)].sqrt()),
            }
        };
        let numbers = self.numbers.iter().enumerate();
        numbers
            .map(|(k, number)| match number.id {
                ParameterId::Nominal(_) => off(k),
                ParameterId::Effect(..) => 0.0,
            })
            .collect()
    }

    /// By how many of its tolerances the base number that is farthest from the motor file's lies off, those left out that an effect
    /// sets free.
    pub fn bent(&self, x: &[f64]) -> f64 {
        let freed: Vec<usize> = self.members.iter().filter_map(|m| self.frees(m)).collect();
        let is_freed = |key: &str| freed.iter().any(|number| BASE[*number] == key);
        let off = self.numbers.iter().zip(self.off(x));
        off.filter(|(number, _)| !is_freed(number.id.key()))
            .fold(0.0, |most, (_, off)| f64::max(most, off))
    }

    /// The base number that a member sets free.
    pub fn frees(&self, member: &Member) -> Option<usize> {
        let own =
            |number: &Number| matches!(number.id, ParameterId::Effect(of, _) if of == member.index);
        freed_by(member.id()).filter(|_| !self.numbers.iter().any(own))
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

/// Values in SI that a fit may reach. What a range is a multiple of is the motor file's number, which is off as well; shares and angles
/// have no such scale.
fn limits_of(parameter: &EffectParameter, (lo, hi): (f64, f64)) -> (f64, f64) {
    if matches!(parameter.scale, Scale::Absolute | Scale::TopRate) {
        return (lo, hi);
    }
    let (least, most) = parameter.plausible();
    let beyond = |end: f64| (BEYOND_RANGE * end).clamp(least, most.min(parameter.at_most));
    (beyond(lo).min(lo), beyond(hi).max(hi))
}

/// Relative tolerance (one sigma) of a number of the motor file, and whether nobody states it.
fn tolerance(base: &Base, key: &str) -> (f64, bool) {
    let stated = base.motor.tolerance.get(key).copied();
    (stated.unwrap_or(DEFAULT_TOLERANCE), stated.is_none())
}

/// Relative variances of what is held, R and Kt, by the motor file's tolerances: every torque, inertia and current is seen only relative
/// to them.
fn held_variances(base: &Base) -> (f64, f64) {
    let variance = |key: &str| tolerance(base, key).0.powi(2);
    match base.kind {
        CommandKind::Voltage => (
            variance("resistance_ohm"),
            variance("torque_constant_nm_per_a"),
        ),
        CommandKind::Current => (0.0, variance("torque_constant_nm_per_a")),
        CommandKind::Torque => (0.0, 0.0),
    }
}

/// Relative variance of what is seen relative to R and Kt: none where a torque is known.
fn scale_variance(base: &Base) -> f64 {
    if base.knows_torque {
        return 0.0;
    }
    let (resistance, torque_constant) = held_variances(base);
    resistance + torque_constant
}

/// Width (one sigma) of a base number that an effect sets free, as a share of the motor file's: half the effect's range.
fn freed_width(base: &Base, member: &Member, number: usize) -> f64 {
    let parameter = &catalogue()[member.index].parameters[0];
    let (lo, hi) = range_of(parameter, base);
    let own = base.motor.parameters.get(BASE[number]).unwrap_or(1.0);
    0.5 * (hi - lo) / own
}

/// By how much the base number that an effect sets free is off.
fn freed(base: &Base, members: &[Member], number: usize) -> Option<f64> {
    let freeing = members
        .iter()
        .find(|member| member.frees(base) == Some(number));
    freeing.map(|member| freed_width(base, member, number))
}

/// Covariance of the base numbers that are used, and of the reference's effects after them, by what reference runs say; wider where an
/// effect sets a number free.
fn since(base: &Base, then: &Then, members: &[Member], used: &[usize]) -> DMatrix<f64> {
    let mut covariance = then.prior();
    for (k, &number) in used.iter().enumerate() {
        covariance[(k, k)] += freed(base, members, number).unwrap_or(0.0).powi(2);
    }
    covariance
}

/// What moves the base numbers that are used: R and Kt, which are held, and each by itself; further where an effect sets one free.
fn tolerances(base: &Base, members: &[Member], used: &[usize]) -> Tolerances {
    let (resistance, torque_constant) = held_variances(base);
    // By how much each moves with R and with Kt: `J R/Kt`, `Kb`, `L/R`; where a torque is known, `J` and `Kt/R`.
    let moves = |number: usize| match number {
        BACK_EMF => (0.0, 0.0),
        INDUCTANCE | TORQUE_CONSTANT => (-1.0, 0.0),
        _ if base.knows_torque => (0.0, 0.0),
        _ => (1.0, -1.0),
    };
    let held = |variance: f64, by: &dyn Fn(usize) -> f64, key: &str| {
        let column = used.iter().map(|&k| variance.sqrt() * by(k)).collect();
        (column, tolerance(base, key).1)
    };
    let mut columns: Vec<(Vec<f64>, bool)> = vec![
        held(resistance, &|k| moves(k).0, "resistance_ohm"),
        held(torque_constant, &|k| moves(k).1, "torque_constant_nm_per_a"),
    ];
    for (k, &number) in used.iter().enumerate() {
        let (own, is_assumed) = match freed(base, members, number) {
            Some(width) => (width, false),
            None => tolerance(base, BASE[number]),
        };
        let mut column = vec![0.0; used.len()];
        column[k] = own;
        columns.push((column, is_assumed));
    }
    Tolerances::new(used.len(), columns)
}
