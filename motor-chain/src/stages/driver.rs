//! Stage 2, the driver: the bridge and its supply.
//!
//! With `e = gain u - Kb w` the winding has `e - drop sgn(i)`, through `R + d^2 Rs` with `d = |u| / supply`, and at
//! most `limit`. `u = 0` short-circuits the motor, unless the bridge opens the circuit. A freewheeling bridge drives
//! the mean current over its pulses.

use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// The bridge and its supply.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Driver<S> {
    /// Reference voltage of the duty cycle, in V.
    pub supply_v: S,
    /// Voltage at the bridge per commanded volt.
    pub gain: S,
    /// Relative difference of the gain forward; the opposite applies back.
    pub gain_asymmetry: Option<S>,
    /// Voltage drops of bridge and brushes forward and back, in V.
    pub drops_v: Option<[S; 2]>,
    /// The supply's resistance, in ohm.
    pub source_resistance_ohm: Option<S>,
    /// Largest current, in A.
    pub limit_a: Option<S>,
    /// Whether a command of 0 opens the circuit.
    pub coast: bool,
    /// Freewheeling between pulses, unless through a short circuit.
    pub freewheel: Option<Freewheel<S>>,
}

/// A bridge whose current decays through diodes between the pulses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Freewheel<S> {
    /// Period of the pulses over the electrical time constant L/R.
    pub period_ratio: S,
    /// Whether the diodes lead back into the supply; else they short-circuit the motor in one direction.
    pub into_supply: bool,
}

impl<S: Scalar> Driver<S> {
    pub(crate) fn nominal(supply_v: S) -> Self {
        Self {
            supply_v,
            gain: S::from(1.0),
            gain_asymmetry: None,
            drops_v: None,
            source_resistance_ohm: None,
            limit_a: None,
            coast: false,
            freewheel: None,
        }
    }

    /// Voltage equivalent of the mean current of a freewheeling bridge at this back EMF, in V: the resistance times
    /// that current.
    ///
    /// In the pulse, `d` of a period `p` (in units of L/R), the current approaches `a = v - e`, between pulses `b =
    /// -e` or `b = -v - e` (all times 1/R), with `v` and `e` in the command's direction. For continuous current the
    /// mean is `d a + (1 - d) b`. A current that reaches 0 after `t0` has risen from 0 to `a (1 - exp(-d p))`, so
    /// that `t0 = ln(1 - a (1 - exp(-d p)) / b)` and the mean is `d a + b t0 / p`: until the next pulse the terminals
    /// have the back EMF. A motor that is driven faster than `v` supplies current through the diodes all the time.
    #[inline(never)]
    pub(crate) fn pulsed(&self, freewheel: &Freewheel<S>, command: f64, emf: S) -> S {
        let volts = self.voltage(command);
        if command == 0.0 {
            return volts - emf;
        }
        let s = command.signum();
        let duty = S::from(command.abs()) / self.supply_v;
        if duty.value() >= 1.0 {
            return volts - emf;
        }
        let (on_v, against_v) = (volts * s / duty, emf * s);
        let rises = on_v - against_v;
        if rises.value() <= 0.0 {
            return rises * s;
        }
        let falls = if freewheel.into_supply {
            -on_v - against_v
        } else {
            -against_v
        };
        let off = -duty + 1.0;
        let period = freewheel.period_ratio;
        if falls.value() < 0.0 {
            let most = rises * (-(-(duty * period)).exp() + 1.0);
            let lasts = (-(most / falls) + 1.0).ln();
            if lasts.value() < (off * period).value() {
                return (duty * rises + falls * lasts / period) * s;
            }
        }
        (duty * rises + off * falls) * s
    }

    /// Resistance added by the supply at this command, in ohm.
    pub(crate) fn added_resistance(&self, command: f64) -> S {
        match self.source_resistance_ohm {
            Some(source) => {
                let duty = S::from(command.abs()) / self.supply_v;
                duty * duty * source
            }
            None => S::zero(),
        }
    }

    /// Volts at the bridge at this command.
    pub(crate) fn voltage(&self, command: f64) -> S {
        let volts = self.gain * command;
        match self.gain_asymmetry {
            Some(ratio) if command != 0.0 => volts * (ratio * command.signum() + 1.0),
            _ => volts,
        }
    }

    /// Bridge and brush drop in V against a current in this direction, 0 without the effect.
    #[inline(always)]
    pub(crate) fn drop(&self, direction: f64) -> S {
        match &self.drops_v {
            Some(drops) => drops[usize::from(direction < 0.0)],
            None => S::zero(),
        }
    }

    /// Adds voltage drops forward and back.
    fn lose(&mut self, forward: S, back: S) {
        let [a, b] = self.drops_v.unwrap_or_else(|| [S::zero(); 2]);
        self.drops_v = Some([a + forward, b + back]);
    }
}

/// A voltage drop of bridge and brushes that is independent of the current.
pub(crate) struct VoltageDrop;

impl Effect for VoltageDrop {
    const KIND: EffectKind = EffectKind {
        id: ids::VOLTAGE_DROP,
        stage: Stage::Driver,
        summary: "bridge and brushes drop a constant voltage",
        equation: "v = u - drop_v sgn(i); i stays 0 while |u - Kb w| <= drop_v",
        source: "brush drop (Fitzgerald, Electric Machinery); saturation voltage of bipolar bridges",
        excited_by: "several levels, braking and reversing",
        confounded_with: &[ids::COULOMB_FRICTION],
        parameters: &[EffectParameter::new(
            "drop_v",
            "V",
            (0.02, 0.3),
            Scale::Supply,
            Prior::LogUniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.lose(values[0], values[0]);
    }
}

/// The voltage drop of bridge and brushes differs by direction.
pub(crate) struct AsymmetricVoltageDrop;

impl Effect for AsymmetricVoltageDrop {
    const KIND: EffectKind = EffectKind {
        id: ids::ASYMMETRIC_VOLTAGE_DROP,
        stage: Stage::Driver,
        summary: "the voltage drop of bridge and brushes differs by direction",
        equation: "v = u - positive_v for i > 0, u + negative_v for i < 0; i stays 0 while -negative_v <= u - Kb w <= positive_v",
        source: "saturation voltages of a bipolar bridge's upper and lower transistors (ST L298 data sheet), which differ by half bridge",
        excited_by: "several levels, both directions",
        confounded_with: &[ids::VOLTAGE_DROP, ids::ASYMMETRIC_FRICTION],
        parameters: &[
            EffectParameter::new(
                "positive_v",
                "V",
                (0.02, 0.3),
                Scale::Supply,
                Prior::LogUniform,
            )
            .defaulting_to_scaled(0.05),
            EffectParameter::new(
                "negative_v",
                "V",
                (0.02, 0.3),
                Scale::Supply,
                Prior::LogUniform,
            )
            .defaulting_to_scaled(0.15),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.lose(values[0], values[1]);
    }
}

/// The supply sags under load.
pub(crate) struct SupplySag;

impl Effect for SupplySag {
    const KIND: EffectKind = EffectKind {
        id: ids::SUPPLY_SAG,
        stage: Stage::Driver,
        summary: "the supply sags under load",
        equation: "R -> R + d^2 source_resistance_ohm, d = |u| / supply_v",
        source: "averaged bridge: the supply carries d i, which drops d Rs i, of which d reaches the motor",
        excited_by: "several levels",
        confounded_with: &["resistance_ohm"],
        parameters: &[EffectParameter::new(
            "source_resistance_ohm",
            "ohm",
            (0.05, 1.0),
            Scale::Resistance,
            Prior::LogUniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.source_resistance_ohm = Some(values[0]);
    }
}

/// The supply voltage differs from the reference of the duty cycle.
pub(crate) struct SupplyError;

impl Effect for SupplyError {
    const KIND: EffectKind = EffectKind {
        id: ids::SUPPLY_ERROR,
        stage: Stage::Driver,
        summary: "the supply voltage differs from the assumed one",
        equation: "v = gain u",
        source: "duty = u / assumed supply",
        excited_by: "any command",
        confounded_with: &["torque_constant_nm_per_a", "back_emf_v_s_per_rad"],
        parameters: &[EffectParameter::new(
            "gain",
            "",
            (0.7, 1.3),
            Scale::Absolute,
            Prior::Uniform,
        )
        .away_from(1.0, 0.05)
        .defaulting_to(0.9)
        .possible(-f64::MAX, f64::MAX)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.gain = values[0];
    }
}

/// The driver has a larger gain in one direction.
pub(crate) struct AsymmetricGain;

impl Effect for AsymmetricGain {
    const KIND: EffectKind = EffectKind {
        id: ids::ASYMMETRIC_GAIN,
        stage: Stage::Driver,
        summary: "the gain of the driver differs by direction",
        equation: "v = u (1 + ratio sgn(u))",
        source: "half bridges or pulse-width channels that differ",
        excited_by: "both directions",
        confounded_with: &[ids::ASYMMETRIC_FRICTION, ids::SUPPLY_ERROR],
        parameters: &[EffectParameter::new(
            "ratio",
            "",
            (-0.3, 0.3),
            Scale::Absolute,
            Prior::Uniform,
        )
        .away_from(0.0, 0.01)
        .possible(-0.99, 0.99)
        .defaulting_to(0.1)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.gain_asymmetry = Some(values[0]);
    }
}

/// The driver limits the current.
pub(crate) struct CurrentLimit;

impl Effect for CurrentLimit {
    const KIND: EffectKind = EffectKind {
        id: ids::CURRENT_LIMIT,
        stage: Stage::Driver,
        summary: "the driver limits the current",
        equation: "|i| <= limit_a",
        source: "current-chopping drivers",
        excited_by: "steps from rest, reversals",
        confounded_with: &[],
        parameters: &[EffectParameter::new(
            "limit_a",
            "A",
            (0.2, 0.8),
            Scale::StallCurrent,
            Prior::Uniform,
        )
        .possible(1e-6, f64::MAX)],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.limit_a = Some(values[0]);
    }
}

/// A command of 0 opens the circuit instead of braking.
pub(crate) struct CoastAtZero;

impl Effect for CoastAtZero {
    const KIND: EffectKind = EffectKind {
        id: ids::COAST_AT_ZERO,
        stage: Stage::Driver,
        summary: "a command of 0 opens the circuit instead of braking",
        equation: "u = 0 -> i = 0",
        source: "bridges with both inputs low in high impedance",
        excited_by: "switching off while turning",
        confounded_with: &[ids::VISCOUS_FRICTION],
        parameters: &[],
        random: false,
    };

    fn install<S: Scalar>(_values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.coast = true;
    }
}

/// Current decays through diodes between the pulses.
pub(crate) struct PwmFreewheel;

impl Effect for PwmFreewheel {
    const KIND: EffectKind = EffectKind {
        id: ids::PWM_FREEWHEEL,
        stage: Stage::Driver,
        summary: "between pulses the current decays through diodes, at low duty to zero, so that the curve of speed against duty is concave",
        equation: "mean current of a period: d a + (1 - d) b where it lasts, else d a + b t0 / p; d = |u| / supply_v, p = period_ratio, a = (V - Kb w) / R, b = (-V - Kb w) / R, or -Kb w / R with into_supply = 0, t0 = ln(1 - a (1 - exp(-d p)) / b); u = 0 -> i = 0",
        source: "discontinuous conduction of a chopper (Mohan, Undeland, Robbins, Power Electronics, 1995); decay modes of bridges (TI DRV8833 data sheet)",
        excited_by: "duty from low to high",
        confounded_with: &[ids::DEAD_ZONE, ids::QUADRATIC_DRAG, ids::COAST_AT_ZERO],
        parameters: &[
            EffectParameter::new(
                "period_ratio",
                "",
                (0.1, 20.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(1e-3, 1e3),
            EffectParameter::new(
                "into_supply",
                "",
                (0.0, 1.0),
                Scale::Absolute,
                Prior::OneOf(&[0.0, 1.0]),
            )
            .possible(0.0, 1.0)
            .defaulting_to(1.0)
            .not_smooth(),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.driver.freewheel = Some(Freewheel {
            period_ratio: values[0],
            into_supply: values[1].value() >= 0.5,
        });
        chain.driver.coast = true;
    }
}
