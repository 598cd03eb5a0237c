//! Counters of a few bits unwrapped to 64.

/// Undoes the wrap of a counter: a jump back or forth by more than three quarters of its range is a wrap.
#[derive(Debug, Clone, Default)]
pub(super) struct Unwrapper {
    last_raw: Option<i64>,
    offset: i64,
}

impl Unwrapper {
    /// The count of the whole counter for a reading of one whose range is `range`.
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

    /// Whether the counter wrapped more often one way than the other.
    pub(super) fn has_wrapped(&self) -> bool {
        self.offset != 0
    }
}
