//! Consistency of a frame with the previous sample: number, device time, counts and command.

use firmware_protocol::Sequence;

use super::super::leap::{Leap, most_counts};
use super::Intake;

/// Largest time error in sample times of a board that reports an overrun.
const LATE_SAMPLES: u64 = 16;

/// A doubt that only the next sample resolves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Doubt {
    /// After a gap of this many microseconds, in which a 16-bit counter may have wrapped.
    Gap(f64),
    /// The counter moved by this many counts to 0.
    Reset(f64),
}

/// Consistency of a sample with another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    /// It follows.
    Follows,
    /// It may follow, if the next sample agrees.
    Leaps(Leap),
    /// It cannot follow.
    Never,
}

impl Intake {
    pub(super) fn moved(
        &self,
        from: &firmware_protocol::Sample,
        to: &firmware_protocol::Sample,
    ) -> f64 {
        let moved = to.counts.wrapping_sub(from.counts);
        match self.fields.counts_16_bit {
            true => f64::from(moved as i16),
            false => f64::from(moved),
        }
    }

    /// Doubts about a sample that follows from the last one.
    pub(super) fn doubt(&self, sample: &firmware_protocol::Sample) -> Option<Doubt> {
        let last = self.wire.as_ref()?;
        let steps = u64::from(sample.sequence.wrapping_sub(last.sequence));
        let elapsed_us = steps * u64::from(self.expectations.sample_time_us);
        let counts = self.moved(last, sample);
        let most = most_counts(self.counts_per_rev, elapsed_us);
        if self.fields.counts_16_bit && steps > 1 && most > u64::from(u16::MAX / 2) {
            return Some(Doubt::Gap(elapsed_us as f64));
        }
        let is_reset = self.motion.is_reset(counts, i64::from(sample.counts));
        (steps == 1 && is_reset).then_some(Doubt::Reset(counts))
    }

    pub(super) fn is_ahead(&self, sample: &firmware_protocol::Sample) -> bool {
        let mut sequence = self.sequence;
        sequence.push(sample.sequence) != Sequence::Stale
    }

    /// Consistency of `sample` with `last`; without one, whether it can be the first.
    pub(super) fn fit(
        &self,
        last: Option<&firmware_protocol::Sample>,
        sample: &firmware_protocol::Sample,
    ) -> Fit {
        let sample_time_us = u64::from(self.expectations.sample_time_us);
        let mut sequence = self.sequence;
        let number = match sequence.push(sample.sequence) {
            Sequence::Next { number, .. } => number,
            Sequence::Stale => return Fit::Never,
        };
        if self
            .expected_command(number)
            .is_some_and(|command_mv| command_mv != sample.command_mv)
        {
            return Fit::Never;
        }
        let Some(last) = last else {
            // The first sample is checked by its number only.
            return if number == 0 || sample_time_us == 0 {
                Fit::Follows
            } else {
                Fit::Leaps(Leap::default())
            };
        };
        let steps = u64::from(sample.sequence.wrapping_sub(last.sequence));
        if steps == 0 || steps > u64::from(u16::MAX / 2) {
            return Fit::Never;
        }
        if sample_time_us == 0 {
            return Fit::Follows;
        }
        let elapsed_us = u64::from(sample.time_us.wrapping_sub(last.time_us));
        let expected_us = steps * sample_time_us;
        let late = sample.flags.overrun || last.flags.overrun;
        let slack_us = expected_us / 100
            + if late {
                LATE_SAMPLES * sample_time_us
            } else {
                sample_time_us / 2
            };
        // Gaps beyond 71 minutes are aliased to shorter ones.
        let off_us = (elapsed_us as i64 - (expected_us % (1 << 32)) as i64).unsigned_abs();
        let moved = if self.fields.counts_16_bit {
            u64::from(
                (sample.counts as i16)
                    .wrapping_sub(last.counts as i16)
                    .unsigned_abs(),
            )
        } else {
            u64::from(sample.counts.wrapping_sub(last.counts).unsigned_abs())
        };
        let leap = Leap {
            time: off_us > slack_us,
            counts: moved > most_counts(self.counts_per_rev, expected_us),
        };
        if leap == Leap::default() {
            Fit::Follows
        } else {
            Fit::Leaps(leap)
        }
    }

    /// The profile's command for sample `number`, which is after the last one.
    pub(super) fn expected_command(&self, number: u64) -> Option<i16> {
        let (mut index, mut first) = self.segment;
        loop {
            let (length, command_mv) = *self.expectations.commands.get(index)?;
            let is_last = index + 1 == self.expectations.commands.len();
            if is_last || number < first + length {
                return Some(command_mv);
            }
            first += length;
            index += 1;
        }
    }
}
