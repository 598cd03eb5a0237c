//! How far the numbers of a motor file are plausibly off, stated or not.
//!
//! A stated tolerance is a normal distribution. One that nobody states is assumed to be 5 %, and that is not certain: a number that is
//! far off says that its tolerance is another. So what is assumed has Student's t with one degree of freedom (the normal with a
//! standard deviation that is not known; Lange, Little, Taylor, 1989), whose logarithm grows slowly: 15 % off costs 2.3 nats, half as much again 4.6,
//! where a normal of 5 % has 4.5 and 50.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::settings::solver::{PRIOR_CONVERGED, PRIOR_STEPS};

/// Effects that move base parameters: each number of the motor file by itself, independent of the others.
#[derive(Debug, Clone)]
pub(crate) struct Tolerances {
    /// By how much each base number (row) moves with each number of the file (column), in standard deviations of that.
    ways: DMatrix<f64>,
    /// Whether nobody states the column's.
    is_assumed: Vec<bool>,
}

/// The likeliest way to be off by so much.
struct Likeliest {
    /// Nats, 0 where nothing is off.
    cost: f64,
    /// Inverse of the covariance of the normal distribution that makes it as unlikely: back to nothing it gains the cost.
    as_unlikely: DMatrix<f64>,
}

impl Tolerances {
    /// Of columns: by how much each base number moves with a number of the file, its standard deviation included, and whether
    /// that is assumed.
    pub fn new(rows: usize, columns: Vec<(Vec<f64>, bool)>) -> Self {
        let ways = DMatrix::from_fn(rows, columns.len(), |i, k| columns[k].0[i]);
        let is_assumed = columns.into_iter().map(|column| column.1).collect();
        Self { ways, is_assumed }
    }

    /// Covariance of the base numbers, what is assumed as if it were stated.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.ways * self.ways.transpose()
    }

    /// Nats by which it is unlikely that the base numbers are off by these.
    pub fn cost(&self, off: &DVector<f64>) -> f64 {
        self.likeliest(off)
            .map_or(f64::INFINITY, |found| found.cost)
    }

    /// The precision of the normal distribution that makes it as unlikely to be off by these.
    pub fn as_unlikely(&self, off: &DVector<f64>) -> DMatrix<f64> {
        let rows = self.ways.nrows();
        self.likeliest(off)
            .map_or_else(|| DMatrix::identity(rows, rows), |found| found.as_unlikely)
    }

    /// By how many standard deviations of a normal distribution one base number alone is off, as likely.
    pub fn tolerances_off(&self, number: usize, off: f64) -> f64 {
        let alone = Self {
            ways: self.ways.rows(number, 1).into_owned(),
            is_assumed: self.is_assumed.clone(),
        };
        (2.0 * alone.cost(&DVector::from_element(1, off))).sqrt()
    }

    /// The ways with these variances in units of the tolerances'.
    fn scaled(&self, variances: &[f64]) -> DMatrix<f64> {
        &self.ways * DMatrix::from_diagonal(&DVector::from_column_slice(variances))
    }

    /// By steps that each lower the cost: a normal distribution that touches it at the last (Lange, Little, Taylor, 1989).
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

    /// Two numbers that move with a common one, and by themselves.
    fn two(is_assumed: bool) -> Tolerances {
        let column = |a: f64, b: f64| (vec![a, b], is_assumed);
        Tolerances::new(
            2,
            vec![column(0.05, 0.05), column(0.05, 0.0), column(0.0, 0.05)],
        )
    }

    /// Stated tolerances have the normal distribution of the covariance.
    #[test]
    fn what_is_stated_is_normal() {
        let off = DVector::from_vec(vec![0.2, -0.1]);
        let covariance = DMatrix::from_row_slice(2, 2, &[0.005, 0.0025, 0.0025, 0.005]);
        let precision = covariance.try_inverse().expect("two numbers");
        let square = (&precision * &off).dot(&off);
        assert!((two(false).cost(&off) - 0.5 * square).abs() < 1e-9);
        assert!((two(false).as_unlikely(&off) - precision).norm() < 1e-6);
        let one = two(false).tolerances_off(0, 0.2);
        assert!((one - 0.2 / 0.005_f64.sqrt()).abs() < 1e-9, "{one}");
    }

    /// One number with a tolerance of its own alone costs what Student's t says: ln(1 + z^2).
    #[test]
    fn what_is_assumed_has_long_tails() {
        let alone = Tolerances::new(1, vec![(vec![0.05], true)]);
        for z in [0.1, 1.0, 3.0, 10.0] {
            let cost = alone.cost(&DVector::from_element(1, 0.05 * z));
            assert!((cost - (z * z).ln_1p()).abs() < 1e-9, "{z} {cost}");
        }
        // Two that are off alike are off by what moves both: no dearer than one.
        let both = DVector::from_vec(vec![0.4, 0.4]);
        let (both, one) = (
            two(true).cost(&both),
            two(true).cost(&DVector::from_vec(vec![0.4, 0.0])),
        );
        assert!((both - 64.0_f64.ln_1p()).abs() < 0.1, "{both}");
        assert!((one - both).abs() < 0.5, "{one} {both}");
    }
}
