//! A hypothesis: which effects are there, which of their numbers are free, and what is plausible.
//!
//! Voltage in and position out identify three numbers of the base model only: the inertia, the back EMF
//! and the friction as seen from the terminals (`J R/Kt`, `Kb + b R/Kt`, `Tf R/Kt`); a motor that coasts
//! shows `b` apart. Moved are the logarithms of `J`, `Kb`, `Tf` and `b`, with `R` and `Kt` held: their prior
//! is the tolerance of everything that they stand for, and keeps what the runs do not tell.

use super::rivals::catalogue;
use crate::motor::catalogue::{EffectParameter, Prior};
use crate::motor::fit::ParameterId;
use crate::motor::{ActiveEffect, Motor, Parameters};
use crate::recording::CommandKind;

use super::setting::{MAX_RATE, Setting};

/// Relative tolerance of a key that the motor file gives none for.
pub(super) const DEFAULT_TOLERANCE: f64 = 0.05;
/// Widest tolerance that means anything for a logarithm.
const WIDEST: f64 = 3.0;
/// How fast plausibility falls off outside a range: as a share of its width, of a logarithm in any case this.
const EDGE: f64 = 0.04;
const EDGE_OF_LOGARITHM: f64 = 0.05;
/// Standard deviations by which a value that changes nothing is implausible as an effect.
const HOLE: f64 = 12.0;
/// Key of the order of an angle-periodic effect, and how far outside its range it may be: the first order is
/// another effect's.
const ORDER: &str = "cycles_per_rev";
const ORDER_ROOM: f64 = 0.25;
/// Keys of the numbers of noises: the share of edges lost by chance, the spread of samples taken late.
const LOSS: &str = "probability";
const LATENESS: &str = "spread_s";
/// Half width of the range of a number that is held.
const HELD: f64 = 1e-6;
/// How many numbers of the base model are free.
pub(super) const BASE: usize = 4;
/// Their keys in a motor file.
pub(super) const BASE_KEYS: [&str; BASE] = [
    "inertia_kg_m2",
    "back_emf_v_s_per_rad",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_per_rad",
];

/// An effect of a hypothesis with the values that are not fitted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    /// Index in the catalogue.
    pub index: usize,
    /// Values of all its parameters; the free ones are overwritten by the fit.
    pub values: Vec<f64>,
}

/// One free number and its prior.
#[derive(Debug, Clone, Copy)]
struct Free {
    member: usize,
    parameter: usize,
    logarithmic: bool,
    /// Plausible range of the number as it is fitted (its logarithm where that is so).
    range: (f64, f64),
    phase: bool,
    order: bool,
    possible: (f64, f64),
    /// Value that changes nothing, and the least plausible distance from it.
    neutral: Option<(f64, f64)>,
}

/// A set of effects on top of the nominal motor, with its free numbers.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis {
    /// Its effects.
    pub members: Vec<Member>,
    free: Vec<Free>,
    base_precision: [[f64; BASE]; BASE],
    base_free: [bool; BASE],
    kind: CommandKind,
    /// Logarithm of the prior density that does not depend on the numbers (choices among fixed values).
    log_choice: f64,
}

impl Hypothesis {
    /// The nominal motor with these effects added, for runs that command `kind`.
    pub fn new(motor: &Motor, members: Vec<Member>, setting: &Setting) -> Self {
        let kind = setting.kind;
        let mut free = Vec::new();
        let mut log_choice = 0.0;
        for (m, member) in members.iter().enumerate() {
            let parameters = catalogue()[member.index].parameters;
            for (k, parameter) in parameters.iter().enumerate() {
                let limited = is_limited(member);
                match parameter.prior {
                    // Edges are lost by chance or above a rate: one of the two.
                    _ if parameter.key == MAX_RATE => {
                        log_choice -= 2f64.ln();
                        if limited {
                            free.push(Free::new(m, k, parameter, motor, setting));
                        }
                    }
                    _ if limited => {}
                    Prior::OneOf(values) => log_choice -= (values.len() as f64).ln(),
                    _ if !is_free(parameter) => {}
                    _ => free.push(Free::new(m, k, parameter, motor, setting)),
                }
            }
        }
        Self {
            members,
            free,
            base_precision: base_precision(motor, kind),
            base_free: base_free(motor, setting),
            kind,
            log_choice,
        }
    }

    /// The hypothesis without the effect at `index` of the catalogue, and its numbers as they are in `p`.
    pub fn without(
        &self,
        index: usize,
        motor: &Motor,
        setting: &Setting,
        p: &[f64],
    ) -> (Self, Vec<f64>) {
        let members = self.members.iter().enumerate();
        let kept = members
            .filter(|(_, member)| member.index != index)
            .map(|(m, member)| Member {
                index: member.index,
                values: self.values(m, p),
            });
        let hypothesis = Self::new(motor, kept.collect(), setting);
        let mut start = hypothesis.start();
        start[..BASE].copy_from_slice(&p[..BASE]);
        (hypothesis, start)
    }

    /// The same with the orders of angle-periodic effects held where they are in `p`.
    pub fn with_orders_held(&self, p: &[f64]) -> Self {
        let mut held = self.clone();
        for (value, free) in p[BASE..].iter().zip(&mut held.free) {
            let kind = &catalogue()[self.members[free.member].index];
            if kind.parameters[free.parameter].key == ORDER {
                free.range = (value - HELD, value + HELD);
            }
        }
        held
    }

    /// Number of free numbers, those of the base first.
    pub fn len(&self) -> usize {
        BASE + self.free.len()
    }

    /// Where the fit starts: the nominal base and the members' own values.
    pub fn start(&self) -> Vec<f64> {
        let mut p = vec![0.0; BASE];
        p.extend(self.free.iter().map(|free| {
            let value = self.members[free.member].values[free.parameter];
            if free.logarithmic {
                value.max(1e-300).ln()
            } else {
                value
            }
        }));
        p
    }

    /// Brings numbers back to what is possible at all and not wildly implausible.
    pub fn clamp(&self, p: &mut [f64]) {
        for (k, value) in p.iter_mut().take(BASE).enumerate() {
            let widest = if self.base_free[k] { 1.5 } else { 0.0 };
            *value = value.clamp(-widest, widest);
        }
        for (value, free) in p[BASE..].iter_mut().zip(&self.free) {
            if free.phase {
                *value = value.rem_euclid(std::f64::consts::TAU);
                continue;
            }
            let (lo, hi) = free.range;
            let room = if free.order {
                ORDER_ROOM
            } else {
                0.5 * (hi - lo)
            };
            *value = value.clamp(lo - room, hi + room);
            if !free.logarithmic {
                *value = value.clamp(free.possible.0, free.possible.1);
            }
        }
    }

    /// Whether number `k` is the logarithm of a parameter.
    pub fn is_logarithmic(&self, k: usize) -> bool {
        k.checked_sub(BASE).is_none_or(|k| self.free[k].logarithmic)
    }

    /// Which numbers are those of a noise (edges lost by chance, samples taken late): the likelihood depends on them
    /// through the filter too.
    pub fn noise_numbers(&self) -> impl Iterator<Item = usize> {
        let kind =
            |free: &Free| &catalogue()[self.members[free.member].index].parameters[free.parameter];
        let of_noise = move |free: &Free| matches!(kind(free).key, LOSS | LATENESS);
        (self.free.iter().enumerate())
            .filter(move |(_, free)| of_noise(free))
            .map(|(k, _)| BASE + k)
    }

    /// The order of a member; none of one that has no order of its own.
    pub fn order(&self, m: usize, p: &[f64]) -> Option<f64> {
        let mut parameters = catalogue()[self.members[m].index].parameters.iter();
        let place = parameters.position(|parameter| parameter.key == ORDER)?;
        self.values(m, p).get(place).copied()
    }

    /// Whether it has edges lost by chance.
    pub fn loses_by_chance(&self) -> bool {
        let parameters = |free: &Free| catalogue()[self.members[free.member].index].parameters;
        let key = |free: &Free| parameters(free)[free.parameter].key;
        self.free.iter().any(|free| key(free) == LOSS)
    }

    /// The simulator's name of each number.
    pub fn parameter_ids(&self) -> Vec<ParameterId> {
        let nominal = |key: &str| {
            let place = Parameters::KEYS.iter().position(|known| *known == key);
            ParameterId::Nominal(place.unwrap_or(0))
        };
        let base = BASE_KEYS.map(nominal);
        let free = self
            .free
            .iter()
            .map(|free| ParameterId::Effect(self.members[free.member].index, free.parameter));
        base.into_iter().chain(free).collect()
    }

    /// Whether number `k` can be moved at all.
    pub fn movable(&self, k: usize) -> bool {
        k >= BASE || self.base_free[k]
    }

    /// Precision of the prior: the tolerances of the base, and for the effects' numbers the width of
    /// their range (so that no fit is surer than the range allows).
    pub fn precision(&self, i: usize, j: usize) -> f64 {
        if i < BASE && j < BASE {
            return self.base_precision[i][j];
        }
        if i != j || i < BASE {
            return 0.0;
        }
        let free = &self.free[i - BASE];
        let width = free.range.1 - free.range.0;
        if free.phase {
            1e-6
        } else {
            1.0 / (width * width)
        }
    }

    /// Middle of the prior of number `k`.
    pub fn centre(&self, k: usize) -> f64 {
        match k.checked_sub(BASE) {
            None => 0.0,
            Some(k) => 0.5 * (self.free[k].range.0 + self.free[k].range.1),
        }
    }

    /// How far the base is from the nominal motor, in squares of the prior's standard deviations.
    pub fn strain(&self, p: &[f64]) -> f64 {
        let mut quadratic = 0.0;
        for i in 0..BASE {
            for j in 0..BASE {
                quadratic += p[i] * self.base_precision[i][j] * p[j];
            }
        }
        quadratic
    }

    /// Logarithm of the prior density of the numbers: Gaussian for the base, even over its range for each
    /// number of an effect, falling off steeply outside.
    pub fn log_prior(&self, p: &[f64]) -> f64 {
        let quadratic = self.strain(p);
        let determinant =
            nalgebra::Matrix4::from_fn(|i, j| self.base_precision[i][j]).determinant();
        let mut log = -0.5 * quadratic + 0.5 * determinant.max(1e-300).ln()
            - 0.5 * BASE as f64 * std::f64::consts::TAU.ln()
            + self.log_choice;
        for (value, free) in p[BASE..].iter().zip(&self.free) {
            let (lo, hi) = free.range;
            log -= (hi - lo).ln();
            if !free.phase {
                let outside = free.outside(*value);
                let inside = free.neutral.map_or(0.0, |(neutral, least)| {
                    (1.0 - (value - neutral).abs() / least).max(0.0) * HOLE
                });
                log -= 0.5 * (outside * outside + inside * inside);
            }
        }
        log
    }

    /// How far number `k` is outside its range, in standard deviations of the fall beyond the edge, and that fall;
    /// negative below the range.
    pub fn outside(&self, k: usize, p: &[f64]) -> (f64, f64) {
        match k.checked_sub(BASE) {
            Some(k) if !self.free[k].phase => {
                (self.free[k].outside(p[BASE + k]), self.free[k].edge())
            }
            _ => (0.0, 1.0),
        }
    }

    /// The motor with these numbers in it.
    pub fn motor(&self, nominal: &Motor, p: &[f64]) -> Motor {
        let mut motor = nominal.clone();
        for (key, ln_ratio) in BASE_KEYS.iter().zip(p) {
            if let Some(value) = motor.parameters.get_mut(key) {
                *value *= ln_ratio.exp();
            }
        }
        for (m, member) in self.members.iter().enumerate() {
            let values = self.values(m, p);
            let kind = &catalogue()[member.index];
            if let Ok(effect) = ActiveEffect::new(kind.id, &values) {
                motor.effects.set(effect);
            }
        }
        motor
    }

    /// The motor with these numbers in it but without member `m`.
    pub fn motor_without(&self, nominal: &Motor, p: &[f64], m: usize) -> Motor {
        let mut motor = self.motor(nominal, p);
        motor.effects.remove(catalogue()[self.members[m].index].id);
        motor
    }

    /// All values of member `m` with the free ones from `p`.
    pub fn values(&self, m: usize, p: &[f64]) -> Vec<f64> {
        let mut values = self.members[m].values.clone();
        for (value, free) in p[BASE..].iter().zip(&self.free) {
            if free.member == m {
                let value = if free.logarithmic {
                    value.exp()
                } else {
                    *value
                };
                values[free.parameter] = value.clamp(free.possible.0, free.possible.1);
            }
        }
        values
    }

    /// Relative standard deviation of what a number in this unit is known through: a torque through `R/Kt`, a
    /// current or a resistance through `R`. Both are held in the fit, so that no interval of it has them.
    pub fn scale_deviation(&self, motor: &Motor, unit: &str) -> f64 {
        let resistance = tolerance(motor, "resistance_ohm");
        let constant = tolerance(motor, "torque_constant_nm_per_a");
        match self.kind {
            CommandKind::Torque => 0.0,
            CommandKind::Current if unit.contains("N m") || unit == "kg m^2" => constant,
            CommandKind::Current => 0.0,
            CommandKind::Voltage => match unit {
                "A" | "H" | "ohm" | "1/W" => resistance,
                _ if unit.contains("N m") || unit == "kg m^2" => resistance.hypot(constant),
                _ => 0.0,
            },
        }
    }

    /// For each parameter of member `m`: its number's place in `p` and whether that is a logarithm.
    pub fn place(&self, m: usize, parameter: usize) -> Option<(usize, bool)> {
        let found = self
            .free
            .iter()
            .position(|free| free.member == m && free.parameter == parameter);
        found.map(|k| (BASE + k, self.free[k].logarithmic))
    }
}

/// Whether edges are lost above a rate.
pub(super) fn is_limited(member: &Member) -> bool {
    let parameters = catalogue()[member.index].parameters.iter();
    let mut values = parameters.zip(&member.values);
    values.any(|(parameter, value)| parameter.key == MAX_RATE && *value > 0.0)
}

/// Fitted are smooth numbers with a range; sides, switches and lists of values are tried one by one.
fn is_free(parameter: &EffectParameter) -> bool {
    parameter.hi > parameter.lo && parameter.smooth
}

impl Free {
    /// Standard deviation of the fall outside the range.
    fn edge(&self) -> f64 {
        let share = EDGE * (self.range.1 - self.range.0);
        if self.logarithmic {
            share.min(EDGE_OF_LOGARITHM)
        } else {
            share
        }
    }

    /// How far outside the range a value is in these; negative below.
    fn outside(&self, value: f64) -> f64 {
        let (lo, hi) = self.range;
        ((value - hi).max(0.0) - (lo - value).max(0.0)) / self.edge()
    }

    fn new(
        member: usize,
        parameter: usize,
        kind: &EffectParameter,
        motor: &Motor,
        setting: &Setting,
    ) -> Self {
        let (lo, hi) = setting.range(kind, &motor.parameters);
        let logarithmic = kind.prior == Prior::LogUniform || kind.key == MAX_RATE;
        Self {
            member,
            parameter,
            logarithmic,
            range: if logarithmic {
                (lo.ln(), hi.ln())
            } else {
                (lo, hi)
            },
            phase: kind.prior == Prior::Phase,
            order: kind.key == ORDER,
            possible: kind.plausible(),
            neutral: kind
                .neutral(&setting.measures(&motor.parameters))
                .map(|(neutral, least)| match logarithmic {
                    true => (neutral.ln(), least),
                    false => (neutral, least),
                }),
        }
    }
}

/// Which numbers of the base mean anything: none that is nought in the nominal motor can be scaled, and no
/// back EMF is felt where the current or the torque is commanded.
fn base_free(motor: &Motor, setting: &Setting) -> [bool; BASE] {
    BASE_KEYS.map(|key| {
        let felt = match key {
            "back_emf_v_s_per_rad" => setting.kind == CommandKind::Voltage,
            "inertia_kg_m2" => !setting.is_held,
            _ => true,
        };
        felt && motor.parameters.get(key).is_some_and(|value| value > 0.0)
    })
}

/// Relative standard deviation of a nominal value.
pub(super) fn tolerance(motor: &Motor, key: &str) -> f64 {
    let given = motor.tolerance.get(key).copied();
    given.unwrap_or(DEFAULT_TOLERANCE).clamp(1e-4, WIDEST)
}

/// Inverse of the prior covariance of the base's logarithms.
fn base_precision(motor: &Motor, kind: CommandKind) -> [[f64; BASE]; BASE] {
    let variance = |key: &str| tolerance(motor, key).powi(2);
    // What stands between torque and terminal: R/Kt for a voltage, Kt for a current, nothing for a torque.
    // It scales inertia and friction together as seen from there.
    let shared = match kind {
        CommandKind::Voltage => variance("resistance_ohm") + variance("torque_constant_nm_per_a"),
        CommandKind::Current => variance("torque_constant_nm_per_a"),
        CommandKind::Torque => 0.0,
    };
    let alone = |k: usize| BASE_KEYS[k] == "back_emf_v_s_per_rad";
    let covariance = nalgebra::Matrix4::from_fn(|i, j| {
        let own = if i == j { variance(BASE_KEYS[i]) } else { 0.0 };
        let common = if alone(i) || alone(j) { 0.0 } else { shared };
        own + common
    });
    let precision = covariance
        .try_inverse()
        .unwrap_or_else(nalgebra::Matrix4::identity);
    std::array::from_fn(|i| std::array::from_fn(|k| precision[(i, k)]))
}
