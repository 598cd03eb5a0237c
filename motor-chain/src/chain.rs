//! The signal chain: command -> driver -> electrical -> mechanical -> transmission -> sensor -> timing.
//!
//! Every stage has the parameters of its equations; an effect changes its stage only.

use crate::CommandKind;
use crate::catalogue::{self, Effects, MAX_PARAMETERS};
use crate::scalar::Scalar;
use crate::stages::command::Command;
use crate::stages::driver::Driver;
use crate::stages::electrical::Electrical;
use crate::stages::mechanical::Mechanical;
use crate::stages::sensor::Sensor;
use crate::stages::timing::Timing;
use crate::stages::transmission::Transmission;
use crate::{Model, Parameters};

/// The stages with their parameters, in the order of the signal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chain<S> {
    /// Quantity that the command sets.
    pub kind: CommandKind,
    pub command: Command<S>,
    pub driver: Driver<S>,
    pub electrical: Electrical<S>,
    pub mechanical: Mechanical<S>,
    pub transmission: Transmission<S>,
    pub sensor: Sensor<S>,
    pub timing: Timing<S>,
    /// Counts per revolution in the run's header.
    pub stated_counts_per_rev: S,
}

impl<S: Scalar> Chain<S> {
    /// The chain of a motor with its effects; `number` converts value `k` to a scalar: first the nine parameters in
    /// the order of [`Parameters`], then each effect's in the order of the catalogue.
    pub(crate) fn new(
        parameters: &Parameters,
        effects: &Effects,
        model: Model,
        kind: CommandKind,
        mut number: impl FnMut(f64) -> S,
    ) -> Self {
        let p = parameters;
        let resistance_ohm = number(p.resistance_ohm);
        let back_emf_v_s_per_rad = number(p.back_emf_v_s_per_rad);
        let torque_constant_nm_per_a = number(p.torque_constant_nm_per_a);
        let viscous_nm_s_per_rad = number(p.viscous_friction_nm_s_per_rad);
        let inductance_h = number(p.inductance_h);
        let inertia_kg_m2 = number(p.inertia_kg_m2);
        let coulomb_nm = number(p.coulomb_friction_nm);
        let counts_per_rev = number(p.counts_per_rev);
        let supply_v = number(p.supply_v);
        let mut chain = Self {
            kind,
            command: Command::nominal(),
            driver: Driver::nominal(supply_v),
            electrical: Electrical {
                resistance_ohm,
                inductance_h: match model {
                    Model::FirstOrder => S::zero(),
                    Model::SecondOrder => inductance_h,
                },
                torque_constant_nm_per_a,
                back_emf_v_s_per_rad,
                ripple: None,
                heating: None,
                weakening_per_w: None,
            },
            mechanical: Mechanical {
                inertia_kg_m2,
                viscous_nm_s_per_rad,
                viscous_asymmetry: None,
                coulomb_nm,
                static_nm: None,
                stribeck: None,
                asymmetry: S::zero(),
                break_in_angle_rad: None,
                load_friction: None,
                drag: None,
                gravity: None,
                cogging: None,
                load_nm: None,
            },
            transmission: Transmission::rigid(),
            sensor: Sensor::nominal(counts_per_rev),
            timing: Timing::nominal(),
            stated_counts_per_rev: counts_per_rev,
        };
        for effect in effects.iter() {
            let mut values = [S::zero(); MAX_PARAMETERS];
            for (slot, (_, value)) in values.iter_mut().zip(effect.parameters()) {
                *slot = number(value);
            }
            catalogue::install(effect.index(), &values, &mut chain);
        }
        chain
    }

    /// Whether the current is a state, not an algebraic function of voltage and speed.
    #[inline(always)]
    pub(crate) fn current_is_state(&self) -> bool {
        self.kind == CommandKind::Voltage && self.electrical.inductance_h.value() > 0.0
    }
}
