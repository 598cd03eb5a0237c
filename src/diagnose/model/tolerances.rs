//! Prior of the values of a motor file from stated and assumed tolerances.
//!
//! A stated tolerance is a normal distribution. One that is not stated is assumed to be 5 %, which is uncertain
//! itself. An assumed one is therefore Student's t with one degree of freedom (a normal distribution with unknown
//! standard deviation; Lange, Little, Taylor, 1989), whose negative logarithm grows slowly: a deviation of 15 % costs
//! 2.3 nats and one of 50 % 4.6, where a normal distribution of 5 % has 4.5 and 50.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::settings::solver::{PRIOR_CONVERGED, PRIOR_STEPS};

/// Prior of the base parameters: independent relative deviations of each value of the motor file.
#[derive(Debug, Clone)]
pub(crate) struct Tolerances {
    /// Change of each base parameter (row) per standard deviation of each value of the file (column).
    ways: DMatrix<f64>,
    /// Whether the tolerance of a column is assumed.
    is_assumed: Vec<bool>,
}

/// The most probable combination of deviations.
struct Likeliest {
    /// Negative log density in nats, 0 without a deviation.
    cost: f64,
    /// Precision of the normal distribution with the same cost: the quadratic form from 0 gives the cost.
    as_unlikely: DMatrix<f64>,
}

impl Tolerances {
    /// From columns: change of each base parameter per standard deviation of a value of the file, and whether that is
    /// assumed.
    pub fn new(rows: usize, columns: Vec<(Vec<f64>, bool)>) -> Self {
        let ways = DMatrix::from_fn(rows, columns.len(), |i, k| columns[k].0[i]);
        let is_assumed = columns.into_iter().map(|column| column.1).collect();
        Self { ways, is_assumed }
    }

    /// Covariance of the base parameters, with assumed tolerances as if stated.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.ways * self.ways.transpose()
    }

    /// Negative log density in nats of this deviation of the base parameters.
    pub fn cost(&self, off: &DVector<f64>) -> f64 {
        self.likeliest(off)
            .map_or(f64::INFINITY, |found| found.cost)
    }

    /// The precision of the normal distribution with the same density at this deviation.
    pub fn as_unlikely(&self, off: &DVector<f64>) -> DMatrix<f64> {
        let rows = self.ways.nrows();
        self.likeliest(off)
            .map_or_else(|| DMatrix::identity(rows, rows), |found| found.as_unlikely)
    }

    /// Deviation of one base parameter alone in standard deviations of a normal distribution with the same density.
    pub fn tolerances_off(&self, number: usize, off: f64) -> f64 {
        let alone = Self {
            ways: self.ways.rows(number, 1).into_owned(),
            is_assumed: self.is_assumed.clone(),
        };
        (2.0 * alone.cost(&DVector::from_element(1, off))).sqrt()
    }

    /// The columns scaled by these variances in units of the tolerances'.
    fn scaled(&self, variances: &[f64]) -> DMatrix<f64> {
        &self.ways * DMatrix::from_diagonal(&DVector::from_column_slice(variances))
    }

    /// Majorize-minimize iteration: each step minimizes a normal distribution that touches the density at the last
    /// (Lange, Little, Taylor, 1989).
    fn likeliest(&self, off: &DVector<f64>) -> Option<Likeliest> {
        let mut variances: Vec<f64> = vec![1.0; self.is_assumed.len()];
        let mut chords = variances.clone();
        let mut last = f64::INFINITY;
        for step in 0.. {
            let scaled = self.scaled(&variances);
            let precision = (&scaled * self.ways.transpose()).try_inverse()?;
            let moved = scaled.transpose() * (&precision * off);
            let mut cost = 0.0;
            for (k, is_assumed) in self.is_assumed.iter().enumerate() {
                let square = moved[k] * moved[k];
                if *is_assumed {
                    let own = square.ln_1p();
                    cost += own;
                    variances[k] = 0.5 * (1.0 + square);
                    chords[k] = if own > 0.0 {
                        0.5 * square / own
                    } else {
                        variances[k]
                    };
                } else {
                    cost += 0.5 * square;
                }
            }
            if last - cost < PRIOR_CONVERGED || step >= PRIOR_STEPS {
                let as_unlikely = (self.scaled(&chords) * self.ways.transpose()).try_inverse()?;
                return Some(Likeliest { cost, as_unlikely });
            }
            last = cost;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters that depend on a common value, and on one each.
    fn two(is_assumed: bool) -> Tolerances {
        let column = |a: f64, b: f64| (vec![a, b], is_assumed);
        Tolerances::new(
            2,
            vec![column(0.05, 0.05), column(0.05, 0.0), column(0.0, 0.05)],
        )
    }

    /// Stated tolerances have the normal distribution of the covariance.
    #[test]
    fn stated_values_have_normal_priors() {
        let off = DVector::from_vec(vec![0.2, -0.1]);
        let covariance = DMatrix::from_row_slice(2, 2, &[0.005, 0.0025, 0.0025, 0.005]);
        let precision = covariance.try_inverse().expect("two numbers");
        let square = (&precision * &off).dot(&off);
        assert!((two(false).cost(&off) - 0.5 * square).abs() < 1e-9);
        assert!((two(false).as_unlikely(&off) - precision).norm() < 1e-6);
        let one = two(false).tolerances_off(0, 0.2);
        assert!((one - 0.2 / 0.005_f64.sqrt()).abs() < 1e-9, "{one}");
    }

    /// One parameter with a separate tolerance has the cost of Student's t: ln(1 + z^2).
    #[test]
    fn assumed_values_have_heavy_tails() {
        let alone = Tolerances::new(1, vec![(vec![0.05], true)]);
        for z in [0.1, 1.0, 3.0, 10.0] {
            let cost = alone.cost(&DVector::from_element(1, 0.05 * z));
            assert!((cost - (z * z).ln_1p()).abs() < 1e-9, "{z} {cost}");
        }
        // Equal deviations of both are explained by the common value: no more expensive than one.
        let both = DVector::from_vec(vec![0.4, 0.4]);
        let (both, one) = (
            two(true).cost(&both),
            two(true).cost(&DVector::from_vec(vec![0.4, 0.0])),
        );
        assert!((both - 64.0_f64.ln_1p()).abs() < 0.1, "{both}");
        assert!((one - both).abs() < 0.5, "{one} {both}");
    }
}
