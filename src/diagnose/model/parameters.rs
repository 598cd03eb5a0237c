//! A motor with effects: free parameters and their priors.
//!
//! Voltage and counts identify `J R/Kt`, `Kb`, `Tf R/Kt`, `L/R` (and, when coasting, `b R/Kt`). J, Kb, Tf, b and L
//! are fitted relative to the motor file's, with fixed R and Kt; their prior is the covariance that follows from the
//! tolerances of all of them. Steady motion depends on sums of them, so that the valley between two parameters that
//! are not separated is straight.
//!
//! A known load or disc is a torque in N m: runs with one identify `R/Kt` as well. Kt is then fitted too, with fixed
//! R.

use crate::motor::catalogue::ids;
use nalgebra::{DMatrix, DVector};

use super::base::{
    BACK_EMF, BASE, Base, INDUCTANCE, INERTIA, TORQUE_CONSTANT, VISCOUS, freed_by, range_of,
};
use super::member::{Member, Parameter, is_free};
use super::prior::{scale_variance, since, tolerances};
use super::tolerances::Tolerances;
use crate::motor::catalogue::{EffectParameter, Prior, catalogue};
use crate::motor::fit::ParameterId;
use crate::motor::{ActiveEffect, CommandKind, Motor};

/// A model.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub members: Vec<Member>,
    pub parameters: Vec<Parameter>,
    /// Includes the values that are not fitted.
    motor: Motor,
    /// Prior as the fits use it: normal distributions, with assumed tolerances as if stated.
    pub precision: DMatrix<f64>,
    /// Tolerances of the base parameters, which are the first, from the motor file; `None` with a reference.
    tolerances: Option<Tolerances>,
    pub mean: DVector<f64>,
    start: Vec<f64>,
    /// Relative standard deviation of torques, inertias and currents that the runs do not reduce.
    pub scale: f64,
    /// Half the square of the deviation of an exact clock from the host's, if the model has no clock error.
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
                TORQUE_CONSTANT => base.torque_identifiable && base.kind != CommandKind::Torque,
                _ => true,
            })
            .collect();
        for &k in &used {
            numbers.push(Parameter {
                id: ParameterId::nominal(BASE[k]).expect("a key"),
                log: false,
                unit: p.get(BASE[k]).unwrap_or(1.0),
                lo: base.settings.largest_factor.recip(),
                hi: base.settings.largest_factor,
                smooth: true,
                random: false,
            });
            start.push(1.0);
        }
        let (tolerances, mut covariance) = match &base.reference {
            Some(then) => (None, since(base, then, &members, &used)),
            None => {
                let known = tolerances(base, &members, &used);
                let covariance = known.covariance();
                (Some(known), covariance)
            }
        };
        for (number, x) in base.reference.iter().flat_map(|then| &then.parameters) {
            numbers.push(*number);
            start.push(*x);
        }
        let mut mean = start.clone();
        let mut widths = Vec::new();
        for member in &members {
            if base.frees(member.id()).is_some() {
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
                let x = |value: f64| {
                    if log {
                        value.max(f64::MIN_POSITIVE).ln()
                    } else {
                        value
                    }
                };
                let (least, most) = limits_of(parameter, (lo, hi), base.settings.beyond_range);
                let (lo, hi) = (x(lo), x(hi));
                let id = ParameterId::Effect(member.index, k);
                // Parameters of the reference's effects are free around their values there.
                if let Some(place) = base.reference.as_ref().and_then(|then| then.place(id)) {
                    start[place] = x(member.values[k]);
                    covariance[(place, place)] += if phase {
                        std::f64::consts::PI.powi(2)
                    } else {
                        (0.5 * (hi - lo)).powi(2)
                    };
                    continue;
                }
                numbers.push(Parameter {
                    id,
                    log,
                    unit: 1.0,
                    lo: if phase { f64::NEG_INFINITY } else { x(least) },
                    hi: if phase { f64::INFINITY } else { x(most) },
                    smooth: parameter.smooth,
                    random: kind.random && parameter.key != "max_rate_hz",
                });
                start.push(x(member.values[k]));
                mean.push(0.5 * (lo + hi));
                let mut width = 0.5 * (hi - lo);
                if kind.id == ids::CLOCK_ERROR
                    && let Some((seen, sd)) = base.clock
                {
                    *mean.last_mut().expect("just pushed") = seen;
                    width = sd;
                }
                widths.push(if phase { f64::INFINITY } else { width });
            }
        }
        let clock = match base.clock {
            Some((seen, sd)) if !members.iter().any(|member| member.id() == ids::CLOCK_ERROR) => {
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
            parameters: numbers,
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

    /// The start with other base parameters: relative to the motor file's, in the order of [`BASE`].
    pub fn start_with(&self, shares: [f64; BASE.len()]) -> Vec<f64> {
        let mut start = self.start();
        for (number, x) in self.parameters.iter().zip(&mut start) {
            let place = BASE.iter().position(|key| number.id.key() == *key);
            if let Some(k) = place {
                *x = shares[k].clamp(number.lo, number.hi);
            }
        }
        start
    }

    /// The start with the values of shared parameters of another model.
    pub fn start_from(&self, other: &Self, x: &[f64]) -> Vec<f64> {
        let mut start = self.start();
        for (k, number) in self.parameters.iter().enumerate() {
            if let Some(j) = other.parameters.iter().position(|n| n.id == number.id) {
                start[k] = x[j];
            }
        }
        start
    }

    /// Parameters of a motor that is faster by this share at the same currents: inertia, viscous friction and back
    /// EMF are multiplied by it.
    pub fn faster(&self, x: &[f64], share: f64) -> Vec<f64> {
        let scaled = [INERTIA, BACK_EMF, VISCOUS].map(|k| BASE[k]);
        let numbers = self.parameters.iter().zip(x);
        numbers
            .map(|(number, x)| match scaled.contains(&number.id.key()) {
                true => x * share,
                false => *x,
            })
            .collect()
    }

    /// Indices of the parameters that determine the variance of a random effect.
    pub fn random(&self) -> impl Iterator<Item = usize> {
        let parameters = self.parameters.iter().enumerate();
        parameters.filter_map(|(k, parameter)| parameter.random.then_some(k))
    }

    /// Whether there is such a parameter.
    pub fn is_random(&self) -> bool {
        self.random().next().is_some()
    }

    /// Whether another model differs from this one in the fitted values only.
    pub fn is_like(&self, other: &Self) -> bool {
        self.free() == other.free() && {
            let zero = self.start();
            self.motor(&zero) == other.motor(&zero)
        }
    }

    /// Which numbers are free.
    pub fn free(&self) -> Vec<ParameterId> {
        self.parameters.iter().map(|number| number.id).collect()
    }

    pub fn motor(&self, x: &[f64]) -> Motor {
        let mut motor = self.motor.clone();
        for (number, x) in self.parameters.iter().zip(x) {
            number.id.set(&mut motor, number.value(*x));
        }
        motor
    }

    pub fn clamp(&self, x: &mut [f64]) {
        for (number, x) in self.parameters.iter().zip(x) {
            *x = x.clamp(number.lo, number.hi);
        }
    }

    /// Negative log prior density in nats; assumed tolerances of base parameters have heavy tails.
    pub fn prior(&self, x: &[f64]) -> f64 {
        let off = self.off_file(x);
        let (n, of_base) = match &self.tolerances {
            Some(known) => (off.len(), known.cost(&off)),
            None => (0, 0.0),
        };
        let rest = DVector::from_fn(x.len() - n, |k, _| x[n + k] - self.mean[n + k]);
        let of_rest = self.precision.view((n, n), (rest.len(), rest.len()));
        self.clock + of_base + 0.5 * (of_rest * &rest).dot(&rest)
    }

    /// Deviation of the base parameters from the motor file's.
    fn off_file(&self, x: &[f64]) -> DVector<f64> {
        let is_base = |number: &&Parameter| matches!(number.id, ParameterId::Nominal(_));
        let n = self.parameters.iter().take_while(is_base).count();
        DVector::from_fn(n, |k, _| x[k] - self.mean[k])
    }

    /// Precision of the normal distribution with the same density at these parameters.
    pub fn precision_as_unlikely(&self, x: &[f64]) -> DMatrix<f64> {
        let mut precision = self.precision.clone();
        if let Some(known) = &self.tolerances {
            let off = self.off_file(x);
            let n = off.len();
            (precision.view_mut((0, 0), (n, n))).copy_from(&known.as_unlikely(&off));
        }
        precision
    }

    /// Deviation of each base parameter from the motor file's in standard deviations of a normal distribution with
    /// the same density; 0 for the others.
    pub fn off(&self, x: &[f64]) -> Vec<f64> {
        let variance = self.precision.clone().pseudo_inverse(f64::MIN_POSITIVE);
        let off = |k: usize| {
            let off = (x[k] - self.mean[k]).abs();
            match &self.tolerances {
                Some(known) => known.tolerances_off(k, off),
                None => (variance.as_ref()).map_or(0.0, |known| off / known[(k, k)].sqrt()),
            }
        };
        let numbers = self.parameters.iter().enumerate();
        numbers
            .map(|(k, number)| match number.id {
                ParameterId::Nominal(_) => off(k),
                ParameterId::Effect(..) => 0.0,
            })
            .collect()
    }

    /// The base parameter whose prior a member widens.
    pub fn frees(&self, member: &Member) -> Option<usize> {
        let own = |number: &Parameter| matches!(number.id, ParameterId::Effect(of, _) if of == member.index);
        freed_by(member.id()).filter(|_| !self.parameters.iter().any(own))
    }

    /// Ids of its effects, sorted.
    pub fn ids(&self) -> Vec<&'static str> {
        let mut ids: Vec<&str> = self.members.iter().map(Member::id).collect();
        ids.sort_unstable();
        ids
    }
}

/// Limits of a fitted value in SI: a range is a prior, and may be exceeded.
fn limits_of(parameter: &EffectParameter, (lo, hi): (f64, f64), beyond_range: f64) -> (f64, f64) {
    let (least, most) = parameter.plausible();
    let beyond = |end: f64| (beyond_range * end).clamp(least, most.min(parameter.at_most));
    (beyond(lo).min(lo), beyond(hi).max(hi))
}
