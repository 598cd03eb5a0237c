//! Limits of an encoder and a clock between two samples: the one set of limits that binary frames and text
//! lines are both compared with.

/// Fastest counting that is believed, in counts per second: a decoder in hardware takes some millions of
/// edges, the fastest gear motor with a fine encoder makes far fewer (convention).
pub const MOST_COUNTS_PER_S: f64 = 2_000_000.0;

/// Fastest shaft that is believed, in revolutions per second: 120,000 RPM, twice what brushed motors reach
/// without their gear (convention).
pub const MOST_REV_PER_S: f64 = 2_000.0;

/// Counts that any encoder may be off by, whatever its resolution: a few edges of chatter (convention).
const CHATTER_COUNTS: f64 = 16.0;

/// Most that a board's time may advance from one sample to the next, in microseconds: 300 s. A board that is
/// silent for so long is given up before.
pub const LONGEST_STEP_US: i64 = 300_000_000;

/// Most counts that can pass in `elapsed_us` with an encoder of `counts_per_rev` (infinite where it is not
/// known).
pub fn most_counts(counts_per_rev: f64, elapsed_us: u64) -> u64 {
    let per_s = MOST_COUNTS_PER_S.min(MOST_REV_PER_S * counts_per_rev);
    // `as` saturates, which is what an endless gap deserves.
    (CHATTER_COUNTS + per_s * elapsed_us as f64 * 1e-6) as u64
}

/// In what a sample does not follow from the one before it, though the one after it follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Leap {
    /// The board's time fell back, or continued by another span than the sample numbers say.
    pub time: bool,
    /// The counts moved faster than any motor can.
    pub counts: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_the_shafts_or_the_encoders_whichever_is_lower() {
        // 720 counts per revolution: 1,440,000 counts/s, 4320 in 3 ms.
        assert_eq!(most_counts(720.0, 3_000), 4_336);
        assert_eq!(most_counts(200_000.0, 3_000), 6_016);
        assert_eq!(most_counts(f64::INFINITY, 3_000), 6_016);
        assert_eq!(most_counts(720.0, 0), 16);
        assert!(most_counts(720.0, u64::MAX) > 1 << 60);
    }
}
