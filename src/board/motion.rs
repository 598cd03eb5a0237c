//! Motion of the counts so far: possible wraps of a 16-bit counter in a gap, and counter resets.

/// Half the range of a 16-bit counter, beyond which a move is ambiguous.
const HALF_RANGE: f64 = 32_768.0;

/// Largest speed in a gap, as a multiple of the largest one observed before or after it.
const FASTER: f64 = 2.0;

/// Steps from which the motion is estimated, and the fewest.
const STEPS: usize = 8;
const FEWEST_STEPS: usize = 3;

/// Least move of a counter reset: as a multiple of the largest of these steps, and in counts.
const LEAPS: f64 = 5.0;
const LEAST_COUNTS: f64 = 10.0;

/// The moves of a counter.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Motion {
    /// The last steps in counts, absolute.
    steps: [f64; STEPS],
    seen: usize,
    /// Largest rate so far in counts/us.
    top: f64,
}

impl Motion {
    /// Adds a move of this many counts in this many microseconds.
    pub(crate) fn push(&mut self, counts: f64, elapsed_us: f64) {
        self.steps[self.seen % STEPS] = counts.abs();
        self.seen += 1;
        if elapsed_us > 0.0 {
            self.top = self.top.max(counts.abs() / elapsed_us);
        }
    }

    /// Whether a 16-bit counter may have passed half its range in a gap, after which it moves by `after` counts/us.
    pub(crate) fn may_have_wrapped(&self, gap_us: f64, after: f64) -> bool {
        FASTER * self.top.max(after.abs()) * gap_us > HALF_RANGE
    }

    /// Whether a move of `counts` that ends at `at` is a counter reset.
    pub(crate) fn is_reset(&self, counts: f64, at: i64) -> bool {
        let largest = self.steps.iter().copied().fold(1.0, f64::max);
        self.seen >= FEWEST_STEPS
            && counts.abs() >= LEAST_COUNTS
            && counts.abs() > LEAPS * largest
            && at.unsigned_abs() as f64 <= largest
    }

    /// Whether a move is far smaller than that of a preceding reset: a shaft that starts to turn keeps accelerating.
    pub(crate) fn continues_after(reset: f64, counts: f64) -> bool {
        LEAPS * counts.abs() < reset.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_may_hide_a_wrap_where_the_speed_allows_it() {
        let mut motion = Motion::default();
        // 100 counts/ms: half of 65,536 takes 328 ms.
        (0..10).for_each(|_| motion.push(300.0, 3000.0));
        assert!(motion.may_have_wrapped(660_000.0, 0.1));
        assert!(!motion.may_have_wrapped(100_000.0, 0.1));
        assert!(Motion::default().may_have_wrapped(660_000.0, 0.1));
        assert!(!Motion::default().may_have_wrapped(660_000.0, 0.0));
    }

    #[test]
    fn a_single_change_to_0_is_a_reset() {
        let mut motion = Motion::default();
        assert!(!motion.is_reset(-540.0, 0), "nothing says how it moves");
        (0..5).for_each(|_| motion.push(1.0, 3000.0));
        assert!(motion.is_reset(-540.0, 1));
        assert!(!motion.is_reset(-540.0, 300), "it does not end at 0");
        assert!(!motion.is_reset(-5.0, 0), "dither");
        assert!(Motion::continues_after(-540.0, 2.0) && !Motion::continues_after(-40.0, -60.0));
    }
}
