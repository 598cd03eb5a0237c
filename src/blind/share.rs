//! Proportions with their sampling error.

use serde::{Deserialize, Serialize};

/// A proportion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Share {
    /// Number of successes.
    pub hits: u64,
    /// Number of trials.
    pub of: u64,
}

impl Share {
    /// The proportion of the items with a property.
    pub fn count<T>(items: impl IntoIterator<Item = T>, holds: impl Fn(T) -> bool) -> Self {
        items.into_iter().fold(Self::default(), |share, item| Self {
            hits: share.hits + u64::from(holds(item)),
            of: share.of + 1,
        })
    }

    /// The value from 0 to 1; `None` without trials.
    pub fn value(self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }

    /// Wilson's 95 % score interval (Wilson 1927): `(p + z^2/2n +- z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n)`.
    pub fn interval95(self) -> Option<(f64, f64)> {
        const Z: f64 = 1.959_963_984_540_054;
        let p = self.value()?;
        let n = self.of as f64;
        let centre = p + Z * Z / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        let scale = 1.0 + Z * Z / n;
        Some((
            ((centre - half) / scale).max(0.0),
            ((centre + half) / scale).min(1.0),
        ))
    }

    /// p-value of this proportion or a lower one under the hypothesis that nothing is worse than when `published` was
    /// measured. The posterior of the true proportion after `published` is Beta(h + 1, n - h + 1), so that the
    /// successes of a new sample are beta-binomial; the sampling errors of both are included.
    ///
    /// `P(0) = B(a, b + n) / B(a, b)` is the product of `(b + i) / (a + b + i)` for `i < n`, and
    /// `P(k + 1) / P(k) = (n - k) (a + k) / ((k + 1) (b + n - k - 1))`; summed as logarithms, which do not underflow.
    pub fn chance_of_so_few(self, published: Self) -> f64 {
        let a = published.hits as f64 + 1.0;
        let b = (published.of - published.hits.min(published.of)) as f64 + 1.0;
        let n = self.of as f64;
        let none = (0..self.of).map(|i| ((b + i as f64) / (a + b + i as f64)).ln());
        let mut ln_probability: f64 = none.sum();
        let mut sum = 0.0;
        for k in 0..=self.hits.min(self.of) {
            sum += ln_probability.exp();
            let k = k as f64;
            ln_probability += ((n - k) * (a + k) / ((k + 1.0) * (b + n - k - 1.0))).ln();
        }
        sum.min(1.0)
    }

    /// As text: `47 of 54, 87 % (75 to 94)`.
    pub fn words(self) -> String {
        match (self.value(), self.interval95()) {
            (Some(value), Some((low, high))) => format!(
                "{} of {}, {:.0} % ({:.0} to {:.0})",
                self.hits,
                self.of,
                100.0 * value,
                100.0 * low,
                100.0 * high
            ),
            _ => "no case".to_owned(),
        }
    }

    /// In percent: `87 %`.
    pub fn percent(self) -> String {
        self.value()
            .map_or("–".to_owned(), |value| format!("{:.0} %", 100.0 * value))
    }
}

/// The `q` quantile by linear interpolation; `None` for no values.
pub(super) fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let place = q * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]))
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_agree_with_published_ones() {
        // Newcombe (1998), Statistics in Medicine 17, table I, method 3: 81 of 263, 15 of 148, 0 of 20,
        // 1 of 29.
        for (hits, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let (l, h) = Share { hits, of }.interval95().expect("there are cases");
            assert!(
                (l - low).abs() < 6e-5 && (h - high).abs() < 6e-5,
                "{hits}/{of}: {l} {h}"
            );
        }
        assert_eq!(Share::default().interval95(), None);
    }

    #[test]
    fn probabilities_follow_the_rule_of_succession() {
        // Laplace: after 8 of 10 one more case hits with (8 + 1)/(10 + 2).
        let published = Share { hits: 8, of: 10 };
        let missed = Share { hits: 0, of: 1 }.chance_of_so_few(published);
        assert!((missed - 0.25).abs() < 1e-12);
        let all = Share { hits: 7, of: 7 }.chance_of_so_few(published);
        assert!((all - 1.0).abs() < 1e-12);
        let impossible = Share {
            hits: 0,
            of: 20_000,
        }
        .chance_of_so_few(Share {
            hits: 20_000,
            of: 20_000,
        });
        assert!(impossible < 1e-300, "{impossible}");
        // Summed with Python's math.lgamma.
        let published = Share { hits: 291, of: 300 };
        for (hits, expected) in [(50, 2.173_689_289e-4), (55, 6.443_016_177e-2)] {
            let few = Share { hits, of: 60 }.chance_of_so_few(published);
            assert!((few / expected - 1.0).abs() < 1e-6, "{hits}: {few}");
        }
    }
}
