//! The catalogue: every effect of the signal chain that motorlab knows.
//!
//! An effect is one small type in the file of its stage. Here is its one registry line; the motor
//! file's `[effects.<id>]`, the virtual board, the documentation's table and the diagnosis read it from
//! [`catalogue`].

use std::fmt;

use serde::Serialize;

use super::chain::Chain;
use super::scalar::Scalar;
use super::{Parameters, command, driver, electrical, mechanical, sensor, timing, transmission};

/// The most parameters that one effect has.
pub const MAX_PARAMETERS: usize = 4;

/// A stage of the signal chain, in the order in which a signal passes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// What is asked for, and when it arrives.
    Command,
    /// The bridge and its supply.
    Driver,
    /// Winding and torque constant.
    Electrical,
    /// Inertia, friction, load.
    Mechanical,
    /// What lies between the motor and the load.
    Transmission,
    /// The encoder.
    Sensor,
    /// When the encoder is read.
    Timing,
}

impl Stage {
    /// Every stage, in the chain's order.
    pub const ALL: [Self; 7] = [
        Self::Command,
        Self::Driver,
        Self::Electrical,
        Self::Mechanical,
        Self::Transmission,
        Self::Sensor,
        Self::Timing,
    ];

    /// The stage's name in files and in JSON.
    pub fn id(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Driver => "driver",
            Self::Electrical => "electrical",
            Self::Mechanical => "mechanical",
            Self::Transmission => "transmission",
            Self::Sensor => "sensor",
            Self::Timing => "timing",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// What a parameter's plausible range is a multiple of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The unit itself.
    Absolute,
    /// The run's sample time.
    SampleTime,
    /// The angle of one encoder count.
    Count,
    /// Stall current: supply over resistance.
    StallCurrent,
    /// Resistance: turns an electrical time constant in s into an inductance.
    Resistance,
    /// 1 / (stall current^2 resistance): the rise per watt that adds 100 % at stall.
    PerStallPower,
    /// Nominal Coulomb torque (3 % of the stall torque where the nominal is less).
    CoulombTorque,
    /// Nominal viscous coefficient (0.1 % of Kt Kb / R where the nominal is less).
    ViscousCoefficient,
    /// Nominal inertia.
    Inertia,
    /// Viscous coefficient over top speed: the drag that equals the viscous torque at top speed.
    DragAtTopSpeed,
}

impl Scale {
    /// The scale in the parameter's own unit.
    pub fn of(self, p: &Parameters, sample_time_s: f64) -> f64 {
        let stall_a = p.supply_v / p.resistance_ohm;
        // A motor file may have neither back EMF nor viscous friction; no scale may be 0.
        let back_emf = p
            .back_emf_v_s_per_rad
            .max(1e-3 * p.torque_constant_nm_per_a);
        let coupling = p.torque_constant_nm_per_a * back_emf / p.resistance_ohm;
        let viscous = p.viscous_friction_nm_s_per_rad.max(1e-3 * coupling);
        match self {
            Self::Absolute => 1.0,
            Self::SampleTime => sample_time_s,
            Self::Count => std::f64::consts::TAU / p.counts_per_rev,
            Self::StallCurrent => stall_a,
            Self::Resistance => p.resistance_ohm,
            Self::PerStallPower => 1.0 / (stall_a * stall_a * p.resistance_ohm),
            Self::CoulombTorque => p
                .coulomb_friction_nm
                .max(0.03 * p.torque_constant_nm_per_a * stall_a),
            Self::ViscousCoefficient => viscous,
            Self::Inertia => p.inertia_kg_m2,
            Self::DragAtTopSpeed => viscous * back_emf / p.supply_v,
        }
    }
}

/// How plausible values spread over the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Evenly.
    Uniform,
    /// Evenly in the logarithm; the range is positive.
    LogUniform,
    /// Evenly around the circle, 0 .. 2 pi.
    Phase,
    /// One of these, all alike.
    OneOf(&'static [f64]),
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct EffectParameter {
    /// Key in a motor file, with its unit.
    pub key: &'static str,
    /// Unit as it is printed; empty for a pure number.
    pub unit: &'static str,
    /// Smallest plausible value, in multiples of `scale`.
    pub lo: f64,
    /// Largest plausible value, in multiples of `scale`.
    pub hi: f64,
    /// The value that changes nothing (in multiples of `scale`) and the least plausible distance from it (of the
    /// logarithm where the prior is in the logarithm); less is scatter between motors of a kind, no effect.
    pub neutral: Option<(f64, f64)>,
    /// What `lo` and `hi` are multiples of.
    pub scale: Scale,
    /// How plausible values spread between them.
    pub prior: Prior,
    /// The value where the file leaves the key out.
    pub default: Absent,
    /// Values that are possible at all (a smaller resistance than nought is not).
    pub possible: (f64, f64),
    /// Whether the encoder's angle depends smoothly on it.
    pub smooth: bool,
}

/// What a motor file that leaves a key out means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Absent {
    /// This value.
    Value(f64),
    /// The middle of the plausible range (geometric where the prior is in the logarithm).
    Middle,
}

impl EffectParameter {
    /// With a value that changes nothing and the least plausible distance from it.
    pub(super) const fn away_from(mut self, neutral: f64, least: f64) -> Self {
        self.neutral = Some((neutral, least));
        self
    }

    /// The value that changes nothing, in SI, and the least plausible distance from it (of the logarithm where the
    /// prior is in the logarithm).
    pub fn neutral(&self, parameters: &Parameters) -> Option<(f64, f64)> {
        let (neutral, least) = self.neutral?;
        let scale = self.scale.of(parameters, 1.0);
        Some(match self.prior {
            Prior::LogUniform => (neutral * scale, least),
            _ => (neutral * scale, least * scale),
        })
    }

    /// A smooth parameter, plausible from `lo` to `hi` (in `scale`), possible wherever it is positive.
    pub(super) const fn new(
        key: &'static str,
        unit: &'static str,
        (lo, hi): (f64, f64),
        scale: Scale,
        prior: Prior,
    ) -> Self {
        Self {
            key,
            unit,
            lo,
            hi,
            neutral: None,
            scale,
            prior,
            default: Absent::Middle,
            possible: (0.0, f64::MAX),
            smooth: true,
        }
    }

    /// An angle anywhere on the circle.
    pub(super) const fn phase(key: &'static str) -> Self {
        let circle = (0.0, std::f64::consts::TAU);
        Self::new(key, "rad", circle, Scale::Absolute, Prior::Phase)
            .possible(-f64::MAX, f64::MAX)
            .defaulting_to(0.0)
    }

    /// The same with other possible values.
    pub(super) const fn possible(mut self, lo: f64, hi: f64) -> Self {
        self.possible = (lo, hi);
        self
    }

    /// The same with another default.
    pub(super) const fn defaulting_to(mut self, value: f64) -> Self {
        self.default = Absent::Value(value);
        self
    }

    /// The same, but the angle does not depend smoothly on it.
    pub(super) const fn not_smooth(mut self) -> Self {
        self.smooth = false;
        self
    }

    /// Plausible range `(lo, hi)` in the parameter's unit for this motor and sample time.
    pub fn range(&self, parameters: &Parameters, sample_time_s: f64) -> (f64, f64) {
        let scale = self.scale.of(parameters, sample_time_s);
        (self.lo * scale, self.hi * scale)
    }

    /// What the key means when a file leaves it out.
    pub fn default(&self, parameters: &Parameters, sample_time_s: f64) -> f64 {
        let (lo, hi) = self.range(parameters, sample_time_s);
        match (self.default, self.prior) {
            (Absent::Value(value), _) => value,
            (Absent::Middle, Prior::LogUniform) => (lo * hi).sqrt(),
            (Absent::Middle, Prior::OneOf(values)) => values[values.len() / 2],
            (Absent::Middle, _) => 0.5 * (lo + hi),
        }
    }
}

/// What there is to know about an effect.
#[derive(Debug, Clone, Copy)]
pub struct EffectKind {
    /// Its name in files and in JSON.
    pub id: &'static str,
    /// The stage it belongs to.
    pub stage: Stage,
    /// One line of what it is.
    pub summary: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Where the equation is from.
    pub source: &'static str,
    /// What it costs to leave it out shows up in.
    pub excited_by: &'static str,
    /// Ids and names of what looks much the same in a run.
    pub confounded_with: &'static [&'static str],
    /// Its parameters, in order.
    pub parameters: &'static [EffectParameter],
    /// Whether two runs with the same command differ by it.
    pub random: bool,
}

/// An effect as its stage defines it.
pub(super) trait Effect {
    /// What there is to know about it.
    const KIND: EffectKind;

    /// Puts the effect with these values into the chain.
    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>);
}

macro_rules! registry {
    ($($stage:ident :: $effect:ident),* $(,)?) => {
        static CATALOGUE: &[EffectKind] = &[$(<$stage::$effect as Effect>::KIND),*];

        /// Puts effect number `index` of the catalogue with these values into the chain.
        pub(super) fn install<S: Scalar>(index: usize, values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
            let installers = [$(<$stage::$effect as Effect>::install::<S>),*];
            installers[index](values, chain);
        }
    };
}

registry! {
    command::TransportDelay,
    command::DeadZone,
    driver::VoltageDrop,
    driver::SupplySag,
    driver::SupplyError,
    driver::CurrentLimit,
    driver::CoastAtZero,
    electrical::Inductance,
    electrical::WindingHeating,
    electrical::TorqueRipple,
    mechanical::CoulombFriction,
    mechanical::ViscousFriction,
    mechanical::Inertia,
    mechanical::Stribeck,
    mechanical::AsymmetricFriction,
    mechanical::Presliding,
    mechanical::LoadFriction,
    mechanical::QuadraticDrag,
    mechanical::GravityLoad,
    mechanical::Cogging,
    transmission::Backlash,
    transmission::Compliance,
    sensor::ResolutionError,
    sensor::MissedCounts,
    sensor::EncoderEccentricity,
    timing::SampleJitter,
    timing::ClockError,
}

/// Every effect, in the order in which a signal meets it.
pub fn catalogue() -> &'static [EffectKind] {
    CATALOGUE
}

/// The effect with this id, and its number in the catalogue.
pub fn find(id: &str) -> Option<(usize, &'static EffectKind)> {
    CATALOGUE.iter().enumerate().find(|(_, kind)| kind.id == id)
}

/// A wrong name or value of an effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// No such effect.
    #[error("there is no effect '{id}'{}; `motorlab simulate --help` says where they are listed", did_you_mean(.nearest))]
    UnknownEffect {
        /// What was asked for.
        id: String,
        /// The nearest id there is.
        nearest: Option<&'static str>,
    },
    /// No such parameter of the effect.
    #[error("effect '{id}' has no parameter '{key}'{}", did_you_mean(.nearest))]
    UnknownParameter {
        /// The effect.
        id: &'static str,
        /// What was asked for.
        key: String,
        /// The nearest key there is.
        nearest: Option<&'static str>,
    },
    /// A value that cannot be.
    #[error("{key} = {value} of effect '{id}' cannot be: expected {lo} .. {hi}")]
    ImpossibleValue {
        /// The effect.
        id: &'static str,
        /// The key.
        key: &'static str,
        /// What was asked for.
        value: f64,
        /// Smallest possible value.
        lo: f64,
        /// Largest possible value.
        hi: f64,
    },
}

pub(super) fn did_you_mean(nearest: &Option<&'static str>) -> String {
    nearest.map_or(String::new(), |name| format!(", did you mean '{name}'?"))
}

/// The nearest of `names` to `asked`, if any is near.
pub(super) fn nearest(
    asked: &str,
    names: impl Iterator<Item = &'static str>,
) -> Option<&'static str> {
    names
        .map(|name| (strsim::jaro_winkler(asked, name), name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(likeness, _)| *likeness > 0.7)
        .map(|(_, name)| name)
}

/// One effect with its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveEffect {
    index: usize,
    /// Values in the order of the kind's parameters; the rest is 0.
    pub values: [f64; MAX_PARAMETERS],
}

impl ActiveEffect {
    /// An effect by id, its values in the order of its parameters.
    pub fn new(id: &str, values: &[f64]) -> Result<Self, EffectError> {
        let (index, kind) = find(id).ok_or_else(|| EffectError::UnknownEffect {
            id: id.to_owned(),
            nearest: nearest(id, CATALOGUE.iter().map(|kind| kind.id)),
        })?;
        let mut active = Self {
            index,
            values: [0.0; MAX_PARAMETERS],
        };
        for (k, parameter) in kind.parameters.iter().enumerate() {
            let value = values.get(k).copied().unwrap_or(f64::NAN);
            let (lo, hi) = parameter.possible;
            if !(lo..=hi).contains(&value) {
                let (id, key) = (kind.id, parameter.key);
                return Err(EffectError::ImpossibleValue {
                    id,
                    key,
                    value,
                    lo,
                    hi,
                });
            }
            active.values[k] = value;
        }
        Ok(active)
    }

    /// An effect by id with some keys given and the others at their defaults for this motor.
    pub fn from_keys<'a>(
        id: &str,
        given: impl IntoIterator<Item = (&'a str, f64)>,
        parameters: &Parameters,
    ) -> Result<Self, EffectError> {
        let (_, kind) = find(id).ok_or_else(|| EffectError::UnknownEffect {
            id: id.to_owned(),
            nearest: nearest(id, CATALOGUE.iter().map(|kind| kind.id)),
        })?;
        let mut values = [0.0; MAX_PARAMETERS];
        for (value, parameter) in values.iter_mut().zip(kind.parameters) {
            *value = parameter.default(parameters, DEFAULT_SAMPLE_TIME_S);
        }
        for (key, value) in given {
            let known = kind.parameters.iter().position(|p| p.key == key);
            let k = known.ok_or_else(|| EffectError::UnknownParameter {
                id: kind.id,
                key: key.to_owned(),
                nearest: nearest(key, kind.parameters.iter().map(|p| p.key)),
            })?;
            values[k] = value;
        }
        Self::new(id, &values[..kind.parameters.len()])
    }

    /// What there is to know about the effect.
    pub fn kind(&self) -> &'static EffectKind {
        &CATALOGUE[self.index]
    }

    /// Its number in the catalogue.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Keys and values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static EffectParameter, f64)> + '_ {
        self.kind().parameters.iter().zip(self.values)
    }
}

/// Sample time for defaults that are multiples of one, where no run says which.
const DEFAULT_SAMPLE_TIME_S: f64 = 0.003;

/// The effects that are part of a model: each at most once, in the catalogue's order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects {
    active: Vec<ActiveEffect>,
}

impl Effects {
    /// No effect at all: the nominal chain.
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds an effect, or replaces the values of one that is there.
    pub fn set(&mut self, effect: ActiveEffect) {
        match self.active.binary_search_by_key(&effect.index, |e| e.index) {
            Ok(k) => self.active[k] = effect,
            Err(k) => self.active.insert(k, effect),
        }
    }

    /// Takes an effect out; whether it was there.
    pub fn remove(&mut self, id: &str) -> bool {
        let before = self.active.len();
        self.active.retain(|effect| effect.kind().id != id);
        self.active.len() != before
    }

    /// The effect with this id, if it is part of the model.
    pub fn get(&self, id: &str) -> Option<&ActiveEffect> {
        self.active.iter().find(|effect| effect.kind().id == id)
    }

    /// The effects, in the catalogue's order.
    pub fn iter(&self) -> impl Iterator<Item = &ActiveEffect> {
        self.active.iter()
    }

    /// The effects with their values open to change.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut ActiveEffect> {
        self.active.iter_mut()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.active.is_empty()
    }

    /// Number of effects.
    pub fn len(&self) -> usize {
        self.active.len()
    }
}
