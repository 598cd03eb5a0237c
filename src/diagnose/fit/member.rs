//! What a model is made of: effects, and numbers that are free.

use crate::motor::catalogue::{EffectParameter, Prior, catalogue};
use crate::motor::fit::ParameterId;

/// An effect of a model with the values that are not fitted, or to start from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Member {
    pub index: usize,
    pub values: Vec<f64>,
}

impl Member {
    pub fn id(&self) -> &'static str {
        catalogue()[self.index].id
    }

    /// Whether its numbers are each one of a few: less of it is another of them, which is looked at by itself.
    pub fn is_whole(&self) -> bool {
        let parameters = catalogue()[self.index].parameters;
        !parameters.is_empty() && !parameters.iter().any(is_free)
    }
}

/// One free number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Number {
    pub id: ParameterId,
    /// Whether what is fitted is the logarithm.
    pub log: bool,
    /// Value in SI of a number of 1.
    pub unit: f64,
    pub lo: f64,
    pub hi: f64,
    pub smooth: bool,
}

impl Number {
    /// Its value in SI.
    pub fn value(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { x }
    }

    /// Derivative of its value in SI.
    pub fn slope(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { 1.0 }
    }
}

/// Whether a parameter is fitted: what is one of a few values, or a side, is a start of its own.
pub(crate) fn is_free(parameter: &EffectParameter) -> bool {
    (!matches!(parameter.prior, Prior::OneOf(_)) || parameter.key == "max_rate_hz")
        && parameter.key != "encoder_side"
}
