//! Plausibility limits of encoder and clock between two samples, for binary frames and text lines.

/// Largest plausible counting rate in counts per second: a hardware decoder takes some millions of edges, the fastest
/// gear motor with a fine encoder makes far fewer (convention).
pub const MOST_COUNTS_PER_S: f64 = 2_000_000.0;

/// Largest plausible speed in revolutions per second: 120,000 RPM, twice that of brushed motors without a gear
/// (convention).
pub const MOST_REV_PER_S: f64 = 2_000.0;

/// Tolerance for any encoder in counts: a few edges of chatter (convention).
const CHATTER_COUNTS: f64 = 16.0;

/// Largest plausible step of a board's time in microseconds: 300 s. A silent board is given up earlier.
pub const LONGEST_STEP_US: i64 = 300_000_000;

/// Largest plausible number of counts in `elapsed_us` with an encoder of `counts_per_rev` (infinite if unknown).
pub fn most_counts(counts_per_rev: f64, elapsed_us: u64) -> u64 {
    let per_s = MOST_COUNTS_PER_S.min(MOST_REV_PER_S * counts_per_rev);
    // `as` saturates, which is right for an unbounded gap.
    (CHATTER_COUNTS + per_s * elapsed_us as f64 * 1e-6) as u64
}

/// Discontinuities of a sample relative to the previous one, confirmed by the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Leap {
    /// The board's time fell back, or disagrees with the sample numbers.
    pub time: bool,
    /// The counts changed faster than any motor can.
    pub counts: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_limit_is_the_lower_of_shaft_and_encoder() {
        // 720 counts per revolution: 1,440,000 counts/s, 4320 in 3 ms.
        assert_eq!(most_counts(720.0, 3_000), 4_336);
        assert_eq!(most_counts(200_000.0, 3_000), 6_016);
        assert_eq!(most_counts(f64::INFINITY, 3_000), 6_016);
        assert_eq!(most_counts(720.0, 0), 16);
        assert!(most_counts(720.0, u64::MAX) > 1 << 60);
    }
}
