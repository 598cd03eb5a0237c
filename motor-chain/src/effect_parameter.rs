//! Description of one parameter of an effect: unit, plausible range, prior, default.

use crate::Parameters;
use crate::plausible;

/// Scale of a parameter's plausible range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The unit.
    Absolute,
    /// The run's sample time.
    SampleTime,
    /// The angle of one encoder count.
    Count,
    /// Stall current: supply over resistance.
    StallCurrent,
    /// Resistance.
    Resistance,
    /// 1 / (stall current^2 resistance): the rise per watt that adds 100 % at stall.
    PerStallPower,
    /// Nominal Coulomb torque (at least 3 % of the stall torque).
    CoulombTorque,
    /// Nominal viscous coefficient (at least 0.1 % of Kt Kb / R).
    ViscousCoefficient,
    /// Nominal inertia.
    Inertia,
    /// Speed whose back EMF is the supply.
    NoLoadSpeed,
    /// Torque at stall.
    StallTorque,
    /// Mechanical time constant.
    TimeConstant,
    /// 1 / (2 pi time constant), in Hz.
    TimeConstantAsFrequency,
    /// Resistance times time constant: converts a relative electrical time constant to an inductance.
    ResistanceTimesTimeConstant,
    /// Edge rate in 1/s at the no-load speed.
    TopRate,
    /// Supply voltage.
    Supply,
    /// Viscous coefficient over no-load speed: the drag that equals the viscous torque there.
    DragAtTopSpeed,
}

impl Scale {
    /// The scale in the parameter's own unit.
    pub fn of(self, p: &Parameters, sample_time_s: f64) -> f64 {
        let stall_a = p.supply_v / p.resistance_ohm;
        // Without back EMF and viscous friction no scale may be 0.
        let back_emf = p
            .back_emf_v_s_per_rad
            .max(1e-3 * p.torque_constant_nm_per_a);
        let coupling = p.torque_constant_nm_per_a * back_emf / p.resistance_ohm;
        let viscous = p.viscous_friction_nm_s_per_rad.max(1e-3 * coupling);
        let time_constant_s = p.inertia_kg_m2 / (coupling + viscous);
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
            Self::NoLoadSpeed => p.supply_v / back_emf,
            Self::StallTorque => p.torque_constant_nm_per_a * stall_a,
            Self::TimeConstant => time_constant_s,
            Self::TimeConstantAsFrequency => 1.0 / (std::f64::consts::TAU * time_constant_s),
            Self::ResistanceTimesTimeConstant => p.resistance_ohm * time_constant_s,
            Self::TopRate => p.supply_v / back_emf * p.counts_per_rev / std::f64::consts::TAU,
            Self::Supply => p.supply_v,
            Self::DragAtTopSpeed => viscous * back_emf / p.supply_v,
        }
    }
}

/// Least ratio of the ends of a range whose upper end is capped.
const NARROWEST: f64 = 0.1;

/// Prior distribution over the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Uniform.
    Uniform,
    /// Uniform in the logarithm; the range is positive.
    LogUniform,
    /// Uniform on the circle, 0 .. 2 pi.
    Phase,
    /// One of these, equally probable.
    OneOf(&'static [f64]),
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct EffectParameter {
    /// Key in a motor file, with its unit.
    pub key: &'static str,
    /// Unit for output; empty for a dimensionless value.
    pub unit: &'static str,
    /// Smallest plausible value, in multiples of `scale`.
    pub lo: f64,
    /// Largest plausible value, in multiples of `scale`.
    pub hi: f64,
    /// The value without an effect (in multiples of `scale`) and the least plausible distance from it (of the
    /// logarithm for a log-uniform prior); less is the tolerance of motors, no effect.
    pub neutral: Option<(f64, f64)>,
    /// Scale of `lo` and `hi`.
    pub scale: Scale,
    /// An alternative upper end in multiples of another scale, used if it is larger.
    pub or_up_to: Option<(f64, Scale)>,
    /// Largest upper end, in the parameter's unit.
    pub at_most: f64,
    /// Prior distribution over the range.
    pub prior: Prior,
    /// Value if the file omits the key.
    pub default: Absent,
    /// Possible values (a resistance is not negative).
    pub possible: (f64, f64),
    /// Whether the encoder's angle is a smooth function of it.
    pub smooth: bool,
}

/// Default of an omitted key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Absent {
    /// This value.
    Value(f64),
    /// This multiple of `scale`.
    Scaled(f64),
    /// The middle of the plausible range (geometric for a log-uniform prior).
    Middle,
}

impl EffectParameter {
    /// Sets the value without an effect and the least plausible distance from it.
    pub(crate) const fn away_from(mut self, neutral: f64, least: f64) -> Self {
        self.neutral = Some((neutral, least));
        self
    }

    /// The value without an effect, in SI, and the least plausible distance from it (of the logarithm for a
    /// log-uniform prior).
    pub fn neutral(&self, parameters: &Parameters) -> Option<(f64, f64)> {
        let (neutral, least) = self.neutral?;
        let scale = self.scale.of(parameters, 1.0);
        Some(match self.prior {
            Prior::LogUniform => (neutral * scale, least),
            _ => (neutral * scale, least * scale),
        })
    }

    /// A smooth parameter with a plausible range from `lo` to `hi` (in `scale`), possible if positive.
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
            or_up_to: None,
            at_most: f64::MAX,
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

    /// Sets an alternative upper end in multiples of another scale.
    pub(crate) const fn or_up_to(mut self, multiple: f64, scale: Scale) -> Self {
        self.or_up_to = Some((multiple, scale));
        self
    }

    /// Sets the largest upper end, in the parameter's unit.
    pub(crate) const fn at_most(mut self, value: f64) -> Self {
        self.at_most = value;
        self
    }

    /// Sets the possible values.
    pub(crate) const fn possible(mut self, lo: f64, hi: f64) -> Self {
        self.possible = (lo, hi);
        self
    }

    /// Sets the default.
    pub(crate) const fn defaulting_to(mut self, value: f64) -> Self {
        self.default = Absent::Value(value);
        self
    }

    /// Sets the default in multiples of the scale.
    pub(crate) const fn defaulting_to_scaled(mut self, multiple: f64) -> Self {
        self.default = Absent::Scaled(multiple);
        self
    }

    /// Marks the angle as a non-smooth function of it.
    pub(crate) const fn not_smooth(mut self) -> Self {
        self.smooth = false;
        self
    }

    /// Possible values, restricted to the plausible range of its unit.
    pub fn plausible(&self) -> (f64, f64) {
        let most = plausible::largest_of_effect(self.key, self.unit);
        let (lo, hi) = self.possible;
        (lo.max(-most), hi.min(most))
    }

    /// Plausible range `(lo, hi)` in the parameter's unit for this motor and sample time.
    pub fn range(&self, parameters: &Parameters, sample_time_s: f64) -> (f64, f64) {
        let scale = self.scale.of(parameters, sample_time_s);
        let mut range = (self.lo * scale, self.hi * scale);
        if let Some((multiple, other)) = self.or_up_to {
            range.1 = range.1.max(multiple * other.of(parameters, sample_time_s));
        }
        if range.1 > self.at_most {
            range = (range.0.min(NARROWEST * self.at_most), self.at_most);
        }
        range
    }

    /// Default of an omitted key.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;

    /// Times that do not scale with the motor's: of heat and of a filter in firmware; and the frequency of a spring.
    const NOT_THE_MOTORS: [&str; 2] = ["time_constant_s", "frequency_hz"];

    /// The handout's motor in other units of volt, ampere, newton metre and second.
    fn in_other_units(volt: f64, ampere: f64, nm: f64, second: f64) -> Parameters {
        let mut p = Parameters::default();
        p.resistance_ohm *= volt / ampere;
        p.back_emf_v_s_per_rad *= volt * second;
        p.torque_constant_nm_per_a *= nm / ampere;
        p.viscous_friction_nm_s_per_rad *= nm * second;
        p.inductance_h *= volt * second / ampere;
        p.inertia_kg_m2 *= nm * second * second;
        p.coulomb_friction_nm *= nm;
        p.supply_v *= volt;
        p
    }

    #[test]
    fn ranges_scale_with_the_motor() {
        let (volt, ampere, nm, second) = (5.3, 0.4, 0.07, 0.25);
        let other = in_other_units(volt, ampere, nm, second);
        for kind in catalogue() {
            for p in kind.parameters {
                if NOT_THE_MOTORS.contains(&p.key) || matches!(p.prior, Prior::OneOf(_)) {
                    continue;
                }
                let unit = match p.unit {
                    "" | "rad" => 1.0,
                    "V" => volt,
                    "A" => ampere,
                    "ohm" => volt / ampere,
                    "H" => volt * second / ampere,
                    "N m" => nm,
                    "N m s/rad" => nm * second,
                    "N m s^2/rad^2" | "kg m^2" => nm * second * second,
                    "s" => second,
                    "rad/s" | "1/s" => 1.0 / second,
                    "1/W" => 1.0 / (volt * ampere),
                    unit => panic!("{}: {unit}", p.key),
                };
                let (lo, hi) = p.range(&Parameters::default(), 0.003);
                let (other_lo, other_hi) = p.range(&other, 0.003 * second);
                for (a, b) in [(lo, other_lo), (hi, other_hi)] {
                    let off = (b - a * unit).abs();
                    assert!(
                        off <= 1e-9 * b.abs(),
                        "{} {}: {a} {b}, {unit}",
                        kind.id,
                        p.key
                    );
                }
            }
        }
    }

    /// Motors of a watch, a drone, a servo, a scooter and a winch; the second has 600 rad/s at 24 V.
    const MOTORS: [Parameters; 5] = [
        parameters([60.0, 3e-4, 3e-4, 1e-10, 1e-4, 1e-10, 1e-6, 12.0, 1.5]),
        parameters([1.1, 0.04, 0.04, 2e-6, 4e-4, 6e-6, 2e-3, 2000.0, 24.0]),
        parameters([5.0, 0.9, 0.6, 0.02, 0.002, 0.004, 0.08, 4096.0, 7.4]),
        parameters([0.2, 1.1, 1.1, 0.0, 3e-4, 0.08, 0.0, 90.0, 36.0]),
        parameters([0.05, 4.0, 4.0, 1.0, 1e-3, 20.0, 30.0, 1024.0, 400.0]),
    ];

    const fn parameters(p: [f64; 9]) -> Parameters {
        Parameters {
            resistance_ohm: p[0],
            back_emf_v_s_per_rad: p[1],
            torque_constant_nm_per_a: p[2],
            viscous_friction_nm_s_per_rad: p[3],
            inductance_h: p[4],
            inertia_kg_m2: p[5],
            coulomb_friction_nm: p[6],
            counts_per_rev: p[7],
            supply_v: p[8],
        }
    }

    #[test]
    fn ranges_of_another_motor_scale_with_its_parameters() {
        for motor in MOTORS {
            let w0 = motor.supply_v / motor.back_emf_v_s_per_rad;
            let stall_nm = motor.torque_constant_nm_per_a * motor.supply_v / motor.resistance_ohm;
            for kind in catalogue() {
                for p in kind.parameters {
                    for sample_time_s in [1e-4, 0.003, 0.1, 20.0] {
                        let (lo, hi) = p.range(&motor, sample_time_s);
                        let fixed = matches!(p.prior, Prior::OneOf(_));
                        assert!(lo < hi || fixed, "{} {}: {lo} .. {hi}", kind.id, p.key);
                        let positive = p.prior != Prior::LogUniform || lo > 0.0;
                        assert!(positive, "{} {}: {lo}", kind.id, p.key);
                        let most = match p.unit {
                            "V" => 0.4 * motor.supply_v,
                            "rad/s" => 0.5 * w0,
                            // For high nominal friction its multiples may exceed the stall torque.
                            "N m" => stall_nm.max(5.0 * motor.coulomb_friction_nm),
                            _ if p.key == "delay_s" => LONGEST_DELAY_S,
                            _ => continue,
                        };
                        assert!(
                            hi <= most * (1.0 + 1e-9),
                            "{} {}: {hi} of {most}",
                            kind.id,
                            p.key
                        );
                    }
                }
            }
        }
        // A delay may be five time constants for short samples: 32 and 42 ms at 5 ms are delays.
        let delay = catalogue()[0].parameters[0];
        assert!(delay.range(&Parameters::default(), 0.005).1 > 0.15);
    }

    const LONGEST_DELAY_S: f64 = 0.3;
}
