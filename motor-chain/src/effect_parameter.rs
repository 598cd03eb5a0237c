//! What there is to know about one parameter of an effect: unit, plausible range, prior, default.

use crate::Parameters;
use crate::plausible;

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
    /// Edge rate in 1/s at the speed whose back EMF is the supply.
    TopRate,
    /// Supply voltage.
    Supply,
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
            Self::TopRate => p.supply_v / back_emf * p.counts_per_rev / std::f64::consts::TAU,
            Self::Supply => p.supply_v,
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
    /// So many times `scale`.
    Scaled(f64),
    /// The middle of the plausible range (geometric where the prior is in the logarithm).
    Middle,
}

impl EffectParameter {
    /// With a value that changes nothing and the least plausible distance from it.
    pub(crate) const fn away_from(mut self, neutral: f64, least: f64) -> Self {
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
    pub(crate) const fn new(
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
    pub(crate) const fn phase(key: &'static str) -> Self {
        let circle = (0.0, std::f64::consts::TAU);
        Self::new(key, "rad", circle, Scale::Absolute, Prior::Phase)
            .possible(-f64::MAX, f64::MAX)
            .defaulting_to(0.0)
    }

    /// The same with other possible values.
    pub(crate) const fn possible(mut self, lo: f64, hi: f64) -> Self {
        self.possible = (lo, hi);
        self
    }

    /// The same with another default.
    pub(crate) const fn defaulting_to(mut self, value: f64) -> Self {
        self.default = Absent::Value(value);
        self
    }

    /// The same with another default, in multiples of the scale.
    pub(crate) const fn defaulting_to_scaled(mut self, multiple: f64) -> Self {
        self.default = Absent::Scaled(multiple);
        self
    }

    /// The same, but the angle does not depend smoothly on it.
    pub(crate) const fn not_smooth(mut self) -> Self {
        self.smooth = false;
        self
    }

    /// Values that are possible, within what is plausible of any quantity of this unit.
    pub fn plausible(&self) -> (f64, f64) {
        let most = plausible::largest_of_effect(self.key, self.unit);
        let (lo, hi) = self.possible;
        (lo.max(-most), hi.min(most))
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
            (Absent::Scaled(multiple), _) => multiple * self.scale.of(parameters, sample_time_s),
            (Absent::Middle, Prior::LogUniform) => (lo * hi).sqrt(),
            (Absent::Middle, Prior::OneOf(values)) => values[values.len() / 2],
            (Absent::Middle, _) => 0.5 * (lo + hi),
        }
    }
}
