//! Unwrapping of counters: sample numbers, microseconds, counts.
//!
//! Each takes the smallest difference from the last value: right as long as the counter changes by less than half its
//! range between two received samples.

/// Sample numbers: 16 bits on the wire, 64 bits unwrapped, and the number of lost samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct SequenceUnwrapper {
    last: Option<u64>,
}

/// An unwrapped sample number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sequence {
    /// A later sample; `lost` are missing in between.
    Next {
        /// The number.
        number: u64,
        /// Samples missing before it.
        lost: u64,
    },
    /// The last sample again, or an earlier one: not to be recorded.
    Stale,
}

impl SequenceUnwrapper {
    /// Initial state; the first sample may be any, those before it (from 0) count as lost.
    pub const fn new() -> Self {
        Self { last: None }
    }

    /// Unwraps a number. Losses of up to 32,767 consecutive samples are counted correctly.
    pub fn push(&mut self, wrapped: u16) -> Sequence {
        let (number, lost) = match self.last {
            None => (u64::from(wrapped), u64::from(wrapped)),
            Some(last) => {
                let step = wrapped.wrapping_sub(last as u16);
                if step == 0 || step > u16::MAX / 2 {
                    return Sequence::Stale;
                }
                (last + u64::from(step), u64::from(step) - 1)
            }
        };
        self.last = Some(number);
        Sequence::Next { number, lost }
    }
}

/// Microseconds: 32 bits on the wire (wrapping after 71.58 min), 64 bits here.
#[derive(Debug, Clone, Copy, Default)]
pub struct MicrosUnwrapper {
    last: Option<u64>,
}

impl MicrosUnwrapper {
    /// Nothing seen yet.
    pub const fn new() -> Self {
        Self { last: None }
    }

    /// Unwraps a time. Gaps of up to 71.58 min are right; time never decreases.
    pub fn push(&mut self, wrapped: u32) -> u64 {
        let micros = match self.last {
            None => u64::from(wrapped),
            Some(last) => last + u64::from(wrapped.wrapping_sub(last as u32)),
        };
        self.last = Some(micros);
        micros
    }
}

/// Encoder counts: 32 bits, or the low 16 of them, on the wire, 64 bits here.
#[derive(Debug, Clone, Copy)]
pub struct CountsUnwrapper {
    last: Option<i64>,
    sixteen_bit: bool,
}

impl CountsUnwrapper {
    /// Initial state for a counter of 16 or 32 bits.
    pub const fn new(sixteen_bit: bool) -> Self {
        Self {
            last: None,
            sixteen_bit,
        }
    }

    /// Unwraps counts by the smallest difference.
    pub fn push(&mut self, wrapped: i32) -> i64 {
        let counts = match self.last {
            None if self.sixteen_bit => i64::from(wrapped as i16),
            None => i64::from(wrapped),
            Some(last) if self.sixteen_bit => {
                last + i64::from((wrapped as i16).wrapping_sub(last as i16))
            }
            Some(last) => last + i64::from(wrapped.wrapping_sub(last as i32)),
        };
        self.last = Some(counts);
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn micros_wrap_after_seventy_one_and_a_half_minutes() {
        let mut unwrap = MicrosUnwrapper::new();
        assert_eq!(unwrap.push(u32::MAX - 1000), u64::from(u32::MAX) - 1000);
        assert_eq!(unwrap.push(1999), (1 << 32) + 1999);
    }

    #[test]
    fn a_sample_twice_is_stale() {
        let mut unwrap = SequenceUnwrapper::new();
        assert_eq!(unwrap.push(0), Sequence::Next { number: 0, lost: 0 });
        assert_eq!(unwrap.push(3), Sequence::Next { number: 3, lost: 2 });
        assert_eq!(unwrap.push(3), Sequence::Stale);
        assert_eq!(unwrap.push(2), Sequence::Stale);
        assert_eq!(unwrap.push(4), Sequence::Next { number: 4, lost: 0 });
    }

    proptest! {
        #[test]
        fn sequences_with_losses_are_unwrapped(steps in proptest::collection::vec(1u64..=32_767, 1..200)) {
            let mut unwrap = SequenceUnwrapper::new();
            unwrap.push(0);
            let mut truth = 0;
            for step in steps {
                truth += step;
                prop_assert_eq!(
                    unwrap.push(truth as u16),
                    Sequence::Next { number: truth, lost: step - 1 }
                );
            }
        }

        #[test]
        fn microseconds_are_unwrapped(steps in proptest::collection::vec(any::<u32>(), 1..200)) {
            let mut unwrap = MicrosUnwrapper::new();
            let mut truth = unwrap.push(77);
            for step in steps {
                truth += u64::from(step);
                prop_assert_eq!(unwrap.push(truth as u32), truth);
            }
        }

        #[test]
        fn counts_of_both_widths_are_unwrapped(steps in proptest::collection::vec(-32_768i64..32_768, 1..200)) {
            let (mut narrow, mut wide) = (CountsUnwrapper::new(true), CountsUnwrapper::new(false));
            let mut truth = 0i64;
            narrow.push(0);
            wide.push(0);
            for step in steps {
                truth += step;
                prop_assert_eq!(narrow.push(i32::from(truth as i16)), truth);
                prop_assert_eq!(wide.push(truth as i32), truth);
            }
        }
    }
}
