//! The posterior of reference runs as the prior of later runs of the same motor.
//!
//! To second order (Laplace) this is the joint fit of both with all parameters shared; parameters that an effect
//! widens differ between the two.

use nalgebra::DMatrix;

use super::member::{Member, Parameter};
use crate::motor::fit::ParameterId;

/// The motor of the reference runs.
#[derive(Debug, Clone)]
pub(crate) struct ReferencePosterior {
    /// Its effects with their values.
    pub effects: Vec<Member>,
    /// The free parameters of these effects with their fitted values.
    pub parameters: Vec<(Parameter, f64)>,
    /// Covariance of the relative base parameters, and of those after them.
    pub covariance: DMatrix<f64>,
    /// Mean square residual of its fit to the reference runs in counts^2.
    pub mean_square: f64,
}

impl ReferencePosterior {
    /// Its effect with this index in the catalogue.
    pub fn effect(&self, index: usize) -> Option<&Member> {
        self.effects.iter().find(|member| member.index == index)
    }

    /// Index of a parameter of an effect among those of a model.
    pub fn place(&self, id: ParameterId) -> Option<usize> {
        let found = self
            .parameters
            .iter()
            .position(|(parameter, _)| parameter.id == id);
        found.map(|k| self.n_base() + k)
    }

    fn n_base(&self) -> usize {
        self.covariance.nrows() - self.parameters.len()
    }

    /// The covariance for another recording of the same axis.
    pub fn prior(&self, same_axis: f64) -> DMatrix<f64> {
        let mut prior = self.covariance.clone();
        for k in 0..self.n_base() {
            prior[(k, k)] += same_axis * same_axis;
        }
        prior
    }
}
