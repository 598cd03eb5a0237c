//! The effects of a model, with their values.

use crate::Parameters;
use crate::catalogue::{
    Absent, EffectKind, EffectParameter, MAX_PARAMETERS, again, catalogue, find, kind,
};
use crate::plausible::Shown;
use crate::synonyms::nearest_name;

/// A wrong name or value of an effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// Unknown effect.
    #[error("there is no effect '{id}'\nhint: {}`motorlab effects` lists the effects", did_you_mean(.nearest))]
    UnknownEffect {
        /// The given id.
        id: String,
        /// The most similar known id.
        nearest: Option<&'static str>,
    },
    /// Unknown parameter of the effect.
    #[error("effect '{id}' has no parameter '{key}'\nhint: {}`motorlab effects {id}` lists its parameters", did_you_mean(.nearest))]
    UnknownParameter {
        /// The effect.
        id: &'static str,
        /// The given key.
        key: String,
        /// The most similar known key.
        nearest: Option<&'static str>,
    },
    /// An impossible value.
    #[error("{key} = {} of effect '{id}' cannot be: expected {} .. {}\nhint: `motorlab effects {id}` lists its parameters with their units", Shown(*.value), Shown(*.lo), Shown(*.hi))]
    ImpossibleValue {
        /// The effect.
        id: &'static str,
        /// The key.
        key: &'static str,
        /// The given value.
        value: f64,
        /// Smallest possible value.
        lo: f64,
        /// Largest possible value.
        hi: f64,
    },
}

pub(crate) fn did_you_mean(nearest: &Option<&'static str>) -> String {
    nearest.map_or(String::new(), |name| format!("did you mean '{name}'? "))
}

/// Every id of an effect.
fn ids() -> impl Iterator<Item = &'static str> {
    catalogue().iter().chain(again()).map(|kind| kind.id)
}

/// One effect with its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveEffect {
    index: usize,
    /// Values in the order of the kind's parameters; unused ones are 0.
    pub values: [f64; MAX_PARAMETERS],
}

impl ActiveEffect {
    /// An effect by id with its values in the order of its parameters; trailing ones may be omitted if their default
    /// does not depend on the motor.
    pub fn new(id: &str, values: &[f64]) -> Result<Self, EffectError> {
        let (index, kind) = find(id).ok_or_else(|| EffectError::UnknownEffect {
            id: id.to_owned(),
            nearest: nearest_name(id, ids()),
        })?;
        let mut active = Self {
            index,
            values: [0.0; MAX_PARAMETERS],
        };
        for (k, parameter) in kind.parameters.iter().enumerate() {
            let left_out = match parameter.default {
                Absent::Value(value) => value,
                Absent::Scaled(_) | Absent::Middle => f64::NAN,
            };
            let value = values.get(k).copied().unwrap_or(left_out);
            let (lo, hi) = parameter.plausible();
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

    /// An effect by id with these keys, the others at their defaults for this motor.
    pub fn from_keys<'a>(
        id: &str,
        given: impl IntoIterator<Item = (&'a str, f64)>,
        parameters: &Parameters,
    ) -> Result<Self, EffectError> {
        let (_, kind) = find(id).ok_or_else(|| EffectError::UnknownEffect {
            id: id.to_owned(),
            nearest: nearest_name(id, ids()),
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
                nearest: nearest_name(key, kind.parameters.iter().map(|p| p.key)),
            })?;
            values[k] = value;
        }
        Self::new(id, &values[..kind.parameters.len()])
    }

    /// Description of the effect.
    pub fn kind(&self) -> &'static EffectKind {
        kind(self.index)
    }

    /// Its index in the catalogue, after the catalogue for a second instance.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Keys and values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static EffectParameter, f64)> + '_ {
        self.kind().parameters.iter().zip(self.values)
    }
}

/// Sample time for defaults relative to one, without a run.
const DEFAULT_SAMPLE_TIME_S: f64 = 0.003;

/// The effects of a model: each id at most once, in the catalogue's order, second instances last.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects {
    active: Vec<ActiveEffect>,
}

impl Effects {
    /// No effects: the nominal chain.
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds an effect, or replaces its values.
    pub fn set(&mut self, effect: ActiveEffect) {
        match self.active.binary_search_by_key(&effect.index, |e| e.index) {
            Ok(k) => self.active[k] = effect,
            Err(k) => self.active.insert(k, effect),
        }
    }

    /// Removes an effect; returns whether it was present.
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

    /// The effects with mutable values.
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
