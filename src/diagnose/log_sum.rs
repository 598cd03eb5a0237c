//! Sums of weighted logarithms, `sum w_k ln x_k`, with few logarithms.
//!
//! As long as the weight stays the same, `w ln x_1 + w ln x_2 + ... = w ln(x_1 x_2 ...)`.

/// Beyond this, and below its inverse, a product is too near the ends of what a number holds.
const LARGEST: f64 = 1e100;

/// Such a sum on its way.
#[derive(Debug)]
pub(super) struct LogSum {
    sum: f64,
    weight: f64,
    /// Of the factors with this weight that are not in the sum yet.
    product: f64,
}

impl LogSum {
    /// Of nothing.
    pub fn new() -> Self {
        Self {
            sum: 0.0,
            weight: 1.0,
            product: 1.0,
        }
    }

    /// Adds `weight ln x`.
    #[inline(always)]
    pub fn add(&mut self, weight: f64, x: f64) {
        let fits = 1.0 / LARGEST < self.product && self.product < LARGEST;
        if weight != self.weight || !fits {
            self.sum = self.total();
            (self.weight, self.product) = (weight, 1.0);
        }
        self.product *= x;
    }

    /// What has been added.
    pub fn total(&self) -> f64 {
        self.sum + self.weight * self.product.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that change and stay, and more factors than one product holds.
    #[test]
    fn logarithms_of_products_are_sums_of_logarithms() {
        let mut found = LogSum::new();
        let mut expected = 0.0;
        for k in 0..3000 {
            let weight = if k % 700 < 600 {
                1.0
            } else {
                0.01 * f64::from(k)
            };
            let x = 0.003 + f64::from(k * k % 1013);
            found.add(weight, x);
            expected += weight * x.ln();
        }
        assert!((found.total() / expected - 1.0).abs() < 1e-12);
    }
}
