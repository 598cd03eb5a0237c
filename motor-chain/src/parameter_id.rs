//! Identifiers of a model's parameters: nominal, or of an effect.

use crate::catalogue::{self, EffectParameter};
use crate::{Motor, Parameters};

/// One number of a model: a nominal parameter, or one of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ParameterId {
    /// Index in [`Parameters::KEYS`].
    Nominal(usize),
    /// Index of the effect in the catalogue, and of the parameter in the effect.
    Effect(usize, usize),
}

impl ParameterId {
    /// The nominal parameter under this key of a motor file.
    pub fn nominal(key: &str) -> Option<Self> {
        Parameters::KEYS
            .iter()
            .position(|k| *k == key)
            .map(Self::Nominal)
    }

    /// The parameter of an effect.
    pub fn effect(id: &str, key: &str) -> Option<Self> {
        let (index, kind) = catalogue::find(id)?;
        let k = kind.parameters.iter().position(|p| p.key == key)?;
        Some(Self::Effect(index, k))
    }

    /// Its key in a motor file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Nominal(k) => Parameters::KEYS[k],
            Self::Effect(index, k) => catalogue::kind(index).parameters[k].key,
        }
    }

    /// Its description, if it belongs to an effect.
    pub fn effect_parameter(self) -> Option<&'static EffectParameter> {
        match self {
            Self::Nominal(_) => None,
            Self::Effect(index, k) => Some(&catalogue::kind(index).parameters[k]),
        }
    }

    /// Its value in a motor; `None` if the motor does not have the effect.
    pub fn get(self, motor: &Motor) -> Option<f64> {
        match self {
            Self::Nominal(k) => motor.parameters.get(Parameters::KEYS[k]),
            Self::Effect(index, k) => motor
                .effects
                .iter()
                .find(|effect| effect.index() == index)
                .map(|effect| effect.values[k]),
        }
    }

    /// Sets its value in a motor; `false` if the motor does not have the effect.
    pub fn set(self, motor: &mut Motor, value: f64) -> bool {
        let slot = match self {
            Self::Nominal(k) => motor.parameters.get_mut(Parameters::KEYS[k]),
            Self::Effect(index, k) => motor
                .effects
                .iter_mut()
                .find(|effect| effect.index() == index)
                .map(|effect| &mut effect.values[k]),
        };
        slot.map(|slot| *slot = value).is_some()
    }
}
