//! What reference runs say of the motor whose later runs are diagnosed: its numbers there, and how well they are known.
//!
//! As the prior of the later runs this is the joint fit of both sets with every number shared, to second order (Laplace). A number
//! that an effect sets free differs by set.

use nalgebra::DMatrix;

use super::member::{Member, Number};
use crate::diagnose::settings::SAME_AXIS;
use crate::motor::fit::ParameterId;

/// A motor as reference runs have it.
#[derive(Debug, Clone)]
pub(crate) struct Then {
    /// Its effects with their values.
    pub effects: Vec<Member>,
    /// The free numbers of these effects, as they were fitted.
    pub numbers: Vec<(Number, f64)>,
    /// Covariance of the base numbers, as shares of what they were, and of those after them.
    pub covariance: DMatrix<f64>,
}

impl Then {
    /// Its effect with this number in the catalogue.
    pub fn effect(&self, index: usize) -> Option<&Member> {
        self.effects.iter().find(|member| member.index == index)
    }

    /// Whether the numbers of one of its effects are free in every model.
    pub fn is_fitted(&self, index: usize) -> bool {
        let own = |(number, _): &(Number, f64)| matches!(number.id, ParameterId::Effect(of, _) if of == index);
        self.numbers.iter().any(own)
    }

    /// Where a number of an effect stands among those of a model.
    pub fn place(&self, id: ParameterId) -> Option<usize> {
        let found = self.numbers.iter().position(|(number, _)| number.id == id);
        found.map(|k| self.n_base() + k)
    }

    /// How many base numbers are free.
    fn n_base(&self) -> usize {
        self.covariance.nrows() - self.numbers.len()
    }

    /// The covariance for another recording of the same axis.
    pub fn prior(&self) -> DMatrix<f64> {
        let mut prior = self.covariance.clone();
        for k in 0..self.n_base() {
            prior[(k, k)] += SAME_AXIS * SAME_AXIS;
        }
        prior
    }
}
