//! Stage 3, the winding: current from voltage, torque from current.
//!
//! `L di/dt = v - R (1 + k P) i - Kb f(theta) w`, `tau_m = Kt f(theta) i`, with the ripple `f = 1 + A sin(n theta +
//! phi)` (or two waves) in both so that power is conserved, and the filtered copper loss `P` of winding heating.

use crate::CommandKind;
use crate::catalogue::ids;
use crate::catalogue::{Effect, EffectKind, EffectParameter, MAX_PARAMETERS, Prior, Scale, Stage};
use crate::chain::Chain;
use crate::scalar::Scalar;

/// The winding.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Electrical<S> {
    /// Cold resistance R in ohm.
    pub resistance_ohm: S,
    /// Inductance L in H; 0 if the current is algebraic.
    pub inductance_h: S,
    /// Torque constant Kt in N m/A.
    pub torque_constant_nm_per_a: S,
    /// Back-EMF constant Kb in V s/rad.
    pub back_emf_v_s_per_rad: S,
    /// Ripple of both constants with the angle.
    pub ripple: Option<Waves<S>>,
    /// Resistance that rises with the copper loss.
    pub heating: Option<Heating<S>>,
    /// Share of both motor constants that is lost per watt of copper loss.
    pub weakening_per_w: Option<S>,
}

/// `amplitude sin(cycles theta + phase)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wave<S> {
    /// Amplitude.
    pub amplitude: S,
    /// Periods a revolution.
    pub cycles_per_rev: S,
    /// Phase in rad.
    pub phase_rad: S,
}

impl<S: Scalar> Wave<S> {
    /// The wave at this angle.
    #[inline(always)]
    pub(crate) fn at(&self, angle_rad: S) -> S {
        self.amplitude * (self.cycles_per_rev * angle_rad + self.phase_rad).sin()
    }
}

/// Effects periodic in the angle: one wave, or two of different orders.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Waves<S> {
    first: Wave<S>,
    second: Option<Wave<S>>,
}

impl<S: Scalar> Waves<S> {
    /// Adds a wave.
    pub(crate) fn with(waves: Option<Self>, wave: Wave<S>) -> Self {
        match waves {
            None => Self {
                first: wave,
                second: None,
            },
            Some(waves) => Self {
                second: Some(wave),
                ..waves
            },
        }
    }

    /// The sum at this angle.
    #[inline(always)]
    pub(crate) fn at(&self, angle_rad: S) -> S {
        let first = self.first.at(angle_rad);
        match &self.second {
            None => first,
            Some(second) => first + second.at(angle_rad),
        }
    }
}

/// First-order thermal lag: `P' = (i^2 R - P) / tau`, `R (1 + k P)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heating<S> {
    /// Relative rise of R per watt.
    pub rise_per_w: S,
    /// Thermal time constant in s.
    pub time_constant_s: S,
}

impl<S: Scalar> Electrical<S> {
    /// `f(theta)`: the ripple of both motor constants.
    #[inline(always)]
    pub(crate) fn factor(&self, angle_rad: S) -> S {
        match &self.ripple {
            Some(ripple) => ripple.at(angle_rad) + 1.0,
            None => S::from(1.0),
        }
    }

    /// Factor of a warm magnet on both motor constants.
    #[inline(always)]
    pub(crate) fn hot_magnet_factor(&self, per_w: S, loss_w: S) -> S {
        -(per_w * loss_w) + 1.0
    }

    /// Mean filtered copper loss in W over an interval with these means of the squared command, of the command times
    /// the speed and of the squared speed, with a filtered loss before it.
    pub(crate) fn mean_loss(&self, kind: CommandKind, means: [f64; 3], before_w: S) -> S {
        let [command, both, speed] = means;
        let weak = match self.weakening_per_w {
            Some(per_w) => self.hot_magnet_factor(per_w, before_w),
            None => S::from(1.0),
        };
        let squared_current = match kind {
            CommandKind::Voltage => {
                let back_emf = self.back_emf_v_s_per_rad * weak;
                let resistance = self.resistance(before_w);
                (back_emf * back_emf * speed - back_emf * (2.0 * both) + command)
                    / (resistance * resistance)
            }
            CommandKind::Current => S::from(command),
            CommandKind::Torque => {
                let constant = self.torque_constant_nm_per_a * weak;
                S::from(command) / (constant * constant)
            }
        };
        squared_current * self.resistance_ohm
    }

    /// Resistance of the winding at this filtered copper loss.
    #[inline(always)]
    pub(crate) fn resistance(&self, loss_w: S) -> S {
        match &self.heating {
            Some(heating) => self.resistance_ohm * (heating.rise_per_w * loss_w + 1.0),
            None => self.resistance_ohm,
        }
    }
}

/// The winding's inductance differs from the nominal motor's.
pub(crate) struct Inductance;

impl Effect for Inductance {
    const KIND: EffectKind = EffectKind {
        id: ids::INDUCTANCE,
        stage: Stage::Electrical,
        summary: "the winding's inductance differs from the nominal motor's",
        equation: "L di/dt = v - R i - Kb w",
        source: "lab handout, second-order model",
        excited_by: "steps, at a short sample time",
        confounded_with: &[ids::TRANSPORT_DELAY],
        parameters: &[EffectParameter::new(
            "inductance_h",
            "H",
            // L/R of the handout's motor is then 1 to 30 ms.
            (0.03, 0.9),
            Scale::ResistanceTimesTimeConstant,
            Prior::LogUniform,
        )],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.electrical.inductance_h = values[0];
    }
}

/// The winding warms up and its resistance rises.
pub(crate) struct WindingHeating;

impl Effect for WindingHeating {
    const KIND: EffectKind = EffectKind {
        id: ids::WINDING_HEATING,
        stage: Stage::Electrical,
        summary: "the winding warms up and its resistance rises",
        equation: "R (1 + k P), dP/dt = (i^2 R - P) / time_constant_s, k = resistance_rise_per_w",
        source: "copper's temperature coefficient through one thermal lag",
        excited_by: "long hot runs",
        confounded_with: &[ids::SUPPLY_SAG],
        parameters: &[
            EffectParameter::new(
                "resistance_rise_per_w",
                "1/W",
                // A freely turning motor has some 5 % of its stall power: 8 there is +40 %.
                (0.05, 8.0),
                Scale::PerStallPower,
                Prior::LogUniform,
            ),
            EffectParameter::new(
                "time_constant_s",
                "s",
                (1.0, 120.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(1e-3, f64::MAX),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        chain.electrical.heating = Some(Heating {
            rise_per_w: values[0],
            time_constant_s: values[1],
        });
    }
}

/// The magnets warm up and weaken.
pub(crate) struct MagnetWeakening;

impl Effect for MagnetWeakening {
    const KIND: EffectKind = EffectKind {
        id: ids::MAGNET_WEAKENING,
        stage: Stage::Electrical,
        summary: "the magnets warm up and weaken",
        equation: "Kt, Kb times (1 - drop P / Ps), dP/dt = (i^2 R - P) / time_constant_s, Ps = supply_v^2 / R; with winding_heating its time constant",
        source: "reversible temperature coefficient of remanence (IEC 60404-8-1: some -0.2 %/K of ferrite, -0.1 %/K of NdFeB) through one thermal lag",
        excited_by: "long hot runs: the speed rises",
        confounded_with: &[ids::WINDING_HEATING],
        parameters: &[
            // Ps is reached at stall only; a freely turning motor has some 5 % of it, one that reverses often a
            // third.
            EffectParameter::new("drop", "", (0.02, 0.6), Scale::Absolute, Prior::LogUniform)
                .possible(0.0, 0.9),
            EffectParameter::new(
                "time_constant_s",
                "s",
                (1.0, 120.0),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(1e-3, f64::MAX),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let supply_v = chain.driver.supply_v;
        let electrical = &mut chain.electrical;
        let per_w = values[0] * electrical.resistance_ohm / (supply_v * supply_v);
        electrical.weakening_per_w = Some(per_w);
        electrical.heating.get_or_insert(Heating {
            rise_per_w: S::zero(),
            time_constant_s: values[1],
        });
    }
}

/// Torque constant and back EMF ripple with the angle.
pub(crate) struct TorqueRipple;

impl Effect for TorqueRipple {
    const KIND: EffectKind = EffectKind {
        id: ids::TORQUE_RIPPLE,
        stage: Stage::Electrical,
        summary: "torque constant and back EMF ripple with the angle",
        equation: "Kt, Kb times (1 + amplitude sin(cycles_per_rev theta + phase_rad))",
        source: "commutation ripple; both constants alike keep the energy balance",
        excited_by: "several levels",
        confounded_with: &[ids::COGGING],
        parameters: &[
            EffectParameter::new(
                "amplitude",
                "",
                (0.01, 0.25),
                Scale::Absolute,
                Prior::LogUniform,
            )
            .possible(0.0, 0.99),
            EffectParameter::new(
                "cycles_per_rev",
                "",
                (2.0, 30.0),
                Scale::Absolute,
                Prior::Uniform,
            )
            .defaulting_to(12.0),
            EffectParameter::phase("phase_rad"),
        ],
        random: false,
    };

    fn install<S: Scalar>(values: &[S; MAX_PARAMETERS], chain: &mut Chain<S>) {
        let wave = Wave {
            amplitude: values[0],
            cycles_per_rev: values[1],
            phase_rad: values[2],
        };
        chain.electrical.ripple = Some(Waves::with(chain.electrical.ripple, wave));
    }
}
