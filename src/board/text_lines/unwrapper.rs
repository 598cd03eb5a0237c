//! Unwrapping of counters to 64 bits.

/// Unwraps a counter: a jump by more than three quarters of its range is a wrap.
#[derive(Debug, Clone, Default)]
pub(super) struct Unwrapper {
    last_raw: Option<i64>,
    offset: i64,
}

impl Unwrapper {
    /// The unwrapped count for a reading of a counter with range `range`.
    pub(super) fn unwrap(&mut self, raw: i64, range: i64) -> i64 {
        if let Some(last) = self.last_raw {
            let jump = raw.saturating_sub(last);
            if jump < -(range / 4 * 3) {
                self.offset = self.offset.saturating_add(range);
            } else if jump > range / 4 * 3 {
                self.offset = self.offset.saturating_sub(range);
            }
        }
        self.last_raw = Some(raw);
        raw.saturating_add(self.offset)
    }

    /// Whether the counter wrapped more often in one direction than in the other.
    pub(super) fn has_wrapped(&self) -> bool {
        self.offset != 0
    }
}
