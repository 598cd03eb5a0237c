//! Parts of a model: effects with their values, and free parameters.

use crate::diagnose::settings::solver;
use crate::motor::Motor;
use crate::motor::catalogue::{EffectParameter, Prior, catalogue};
use crate::motor::fit::ParameterId;

/// An effect of a model with the values that are not fitted, or starting values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Member {
    pub index: usize,
    pub values: Vec<f64>,
}

impl Member {
    /// The effects of a motor that are in the catalogue, with their values.
    pub fn of(motor: &Motor) -> Vec<Self> {
        let of_catalogue = motor
            .effects
            .iter()
            .filter(|one| one.index() < catalogue().len());
        of_catalogue
            .map(|one| Self {
                index: one.index(),
                values: one.parameters().map(|(_, value)| value).collect(),
            })
            .collect()
    }

    pub fn id(&self) -> &'static str {
        catalogue()[self.index].id
    }
}

/// One free parameter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parameter {
    pub id: ParameterId,
    /// Whether the logarithm is fitted.
    pub log: bool,
    /// Value in SI of 1.
    pub unit: f64,
    pub lo: f64,
    pub hi: f64,
    pub smooth: bool,
    /// Whether it determines the variance of a random effect, which only the likelihood depends on.
    pub random: bool,
}

impl Parameter {
    /// Its value in SI.
    pub fn value(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { x }
    }

    /// Whether the fit ended at an end of its range.
    pub fn is_at_bound(&self, x: f64) -> bool {
        let near = solver::SAME * (self.hi - self.lo).abs();
        x <= self.lo + near || x >= self.hi - near
    }

    /// Step of its difference quotients.
    pub fn difference(&self) -> f64 {
        solver::DIFFERENCE * (self.hi - self.lo).min(solver::DIFFERENCE_RANGE)
    }

    /// Derivative of its value in SI.
    pub fn slope(&self, x: f64) -> f64 {
        self.unit * if self.log { x.exp() } else { 1.0 }
    }
}

/// Whether a parameter is fitted: discrete values and sides are separate starts.
pub(crate) fn is_free(parameter: &EffectParameter) -> bool {
    (!matches!(parameter.prior, Prior::OneOf(_)) || parameter.key == "max_rate_hz")
        && parameter.key != "encoder_side"
}
