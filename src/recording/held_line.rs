//! Plausibility of text lines: an implausible line is delayed until the next one confirms or refutes it.
//!
//! Text has no checksum: a number with a lost or doubled digit is still a number. A line whose time falls back or
//! jumps, or whose count jumps, is written only if the next line continues from it. If the next one continues from
//! the line before it, the odd one is skipped and counted.

use crate::board::leap::LONGEST_STEP_US;
use crate::board::text_lines::TextSample;

/// Largest usual step of time in sample times; a longer one is confirmed by the next line.
const OUTLYING_STEPS: f64 = 2.5;
/// Two lines with an earlier time agree within this many sample times: the board was reset.
const AGREE_STEPS: i64 = 20;
/// Largest usual step of counts as a multiple of the largest recent step, plus counts of chatter.
const OUTLYING_COUNTS: u64 = 5;
const CHATTER_COUNTS: u64 = 16;
/// Steps from which the motion is estimated, and the fewest.
const STEPS: usize = 16;
const FEWEST_STEPS: usize = 3;
/// Most consecutive skipped lines, after which the line before them is no reference: the time restarted, or runs
/// backward.
const MOST_SKIPPED: u64 = 8;

#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub sample: TextSample,
    pub host_us: u64,
    /// Its time in microseconds on the time base.
    pub at_us: i64,
}

/// Usual times of the lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpectedTiming {
    pub sample_time_us: i64,
    /// Resolution of the time in microseconds; 0 if it is fine.
    pub coarse_us: i64,
    /// The time is the board's, and may be implausible.
    pub is_boards: bool,
}

/// Result of a line together with the delayed one.
#[derive(Debug, Default)]
pub(super) struct LineResult {
    /// Lines to be written, in order.
    pub write: Vec<Line>,
    /// Number of skipped lines.
    pub passed_over: u64,
    /// Two lines agree that the board's time restarted, or none has continued for long.
    pub is_reset: bool,
}

/// The delayed line and its references.
#[derive(Debug, Default)]
pub(super) struct HeldLine {
    held: Option<Line>,
    /// Time and counts of the last written line.
    last: Option<(i64, i64)>,
    steps: [u64; STEPS],
    seen: usize,
    /// Skipped lines since the last written one.
    passed_over: u64,
}

/// Decision about a delayed line.
enum Decision {
    Kept,
    Skipped,
    Reset,
}

impl HeldLine {
    pub(super) fn take(&mut self, line: Line, usual: ExpectedTiming) -> LineResult {
        let mut taken = LineResult::default();
        let Some(last) = self.last else {
            self.accept(line, &mut taken);
            return taken;
        };
        if let Some(held) = self.held.take() {
            match self.judge(last, &held, &line, usual) {
                Decision::Kept => self.accept(held, &mut taken),
                Decision::Skipped => {
                    taken.passed_over += 1;
                    self.passed_over += 1;
                    if self.passed_over >= MOST_SKIPPED {
                        taken.is_reset = true;
                        return taken;
                    }
                }
                Decision::Reset => {
                    taken.is_reset = true;
                    return taken;
                }
            }
        }
        // After a skipped line the previous one may be repeated.
        let is_fine = usual.is_boards && usual.coarse_us == 0;
        if is_fine && self.last.is_some_and(|(last_us, _)| last_us == line.at_us) {
            taken.passed_over += 1;
        } else if self.is_outlying(&line, usual) {
            self.held = Some(line);
        } else {
            self.accept(line, &mut taken);
        }
        taken
    }

    /// The delayed line at the end, if its time continues.
    pub(super) fn end(&mut self) -> Option<Line> {
        let last = self.last?.0;
        let goes_on =
            |line: &Line| (last..=last.saturating_add(LONGEST_STEP_US)).contains(&line.at_us);
        self.held.take().filter(goes_on)
    }

    /// Time of the last written or delayed line.
    pub(super) fn latest_us(&self) -> Option<i64> {
        let held = self.held.map(|line| line.at_us);
        held.or(self.last.map(|last| last.0))
    }

    fn accept(&mut self, line: Line, taken: &mut LineResult) {
        if let Some((_, counts)) = self.last.replace((line.at_us, line.sample.counts)) {
            self.steps[self.seen % STEPS] = counts.abs_diff(line.sample.counts);
            self.seen += 1;
        }
        self.passed_over = 0;
        taken.write.push(line);
    }

    /// Largest usual step of counts.
    fn usual_counts(&self) -> u64 {
        if self.seen < FEWEST_STEPS {
            return u64::MAX;
        }
        let largest = self.steps.iter().copied().max().unwrap_or(0);
        largest
            .saturating_mul(OUTLYING_COUNTS)
            .saturating_add(CHATTER_COUNTS)
    }

    fn is_outlying(&self, line: &Line, usual: ExpectedTiming) -> bool {
        let Some((last_us, counts)) = self.last else {
            return false;
        };
        let longest_us = (OUTLYING_STEPS * usual.sample_time_us as f64) as i64 + usual.coarse_us;
        let step_us = line.at_us.saturating_sub(last_us);
        let is_odd_time = usual.is_boards && (step_us < 0 || step_us > longest_us);
        is_odd_time || counts.abs_diff(line.sample.counts) > self.usual_counts()
    }

    fn judge(&self, last: (i64, i64), held: &Line, next: &Line, usual: ExpectedTiming) -> Decision {
        let (last_us, last_counts) = last;
        if usual.is_boards {
            let near_us = AGREE_STEPS.saturating_mul(usual.sample_time_us) + usual.coarse_us;
            let after_us = next.at_us.saturating_sub(held.at_us);
            if held.at_us < last_us {
                let agree = next.at_us < last_us && (0..=near_us).contains(&after_us);
                return if agree {
                    Decision::Reset
                } else {
                    Decision::Skipped
                };
            }
            if held.at_us.saturating_sub(last_us) > LONGEST_STEP_US {
                let agree = after_us.unsigned_abs() <= LONGEST_STEP_US.unsigned_abs();
                return if agree {
                    Decision::Reset
                } else {
                    Decision::Skipped
                };
            }
            // With a coarse clock two lines may have the same time stamp.
            let falls =
                next.at_us < held.at_us || (next.at_us == held.at_us && usual.coarse_us == 0);
            if falls && next.at_us >= last_us {
                return Decision::Skipped;
            }
        }
        let usual_counts = self.usual_counts();
        let (held, next) = (held.sample.counts, next.sample.counts);
        let comes_back = held.abs_diff(last_counts) > usual_counts
            && held.abs_diff(next) > usual_counts
            && next.abs_diff(last_counts) <= usual_counts;
        if comes_back {
            Decision::Skipped
        } else {
            Decision::Kept
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: ExpectedTiming = ExpectedTiming {
        sample_time_us: 5000,
        coarse_us: 0,
        is_boards: true,
    };

    /// Times in ms and counts of the written lines, the number of ignored ones, and whether the board was reset.
    fn written(lines: &[(i64, i64)]) -> (Vec<(i64, i64)>, u64, bool) {
        written_by(lines, USUAL)
    }

    fn written_by(lines: &[(i64, i64)], usual: ExpectedTiming) -> (Vec<(i64, i64)>, u64, bool) {
        let mut held = HeldLine::default();
        let (mut rows, mut passed_over) = (Vec::new(), 0);
        let row = |line: Line| (line.at_us / 1000, line.sample.counts);
        for &(ms, counts) in lines {
            let line = Line {
                sample: TextSample {
                    counts,
                    ..TextSample::default()
                },
                host_us: 0,
                at_us: 1000 * ms,
            };
            let taken = held.take(line, usual);
            rows.extend(taken.write.into_iter().map(row));
            passed_over += taken.passed_over;
            if taken.is_reset {
                return (rows, passed_over, true);
            }
        }
        rows.extend(held.end().map(row));
        (rows, passed_over, false)
    }

    #[test]
    fn one_outlying_line_is_skipped_and_two_consistent_ones_are_kept() {
        let sound: Vec<(i64, i64)> = (0..10).map(|k| (5 * k, 6 * k)).collect();
        assert_eq!(written(&sound), (sound.clone(), 0, false));
        // A doubled, lost or changed digit in the time; an additional digit in the count; another program's line.
        for odd in [(220, 24), (2, 24), (35, 24), (20, 2400), (1, 2)] {
            let mut lines = sound.clone();
            lines[4] = odd;
            let mut expected = sound.clone();
            expected.remove(4);
            assert_eq!(written(&lines), (expected, 1, false), "{odd:?}");
        }
        // The line before the odd one is repeated: no two rows have the same time.
        let again = [&sound[..4], &[(1, 24), (15, 24)], &sound[4..]].concat();
        assert_eq!(written(&again), (sound.clone(), 2, false));
        // A pause, and missing lines, also at the end.
        let paused: Vec<(i64, i64)> = sound
            .iter()
            .map(|&(t, n)| (t + 400 * (t / 20), n))
            .collect();
        assert_eq!(written(&paused), (paused.clone(), 0, false));
        let ended = [&sound[..], &[(300, 60)]].concat();
        assert_eq!(written(&ended), (ended.clone(), 0, false));
        // The same for a clock with steps of 10 ms.
        let coarse = ExpectedTiming {
            coarse_us: 10_000,
            ..USUAL
        };
        let mut lines: Vec<(i64, i64)> = sound.iter().map(|&(t, n)| (t / 10 * 10, n)).collect();
        lines[4].0 = 520;
        let (rows, passed_over, is_reset) = written_by(&lines, coarse);
        assert_eq!((rows.len(), passed_over, is_reset), (9, 1, false));
        // A restarted board, and a reset counter.
        let anew = [&sound[..], &[(0, 0), (5, 0)]].concat();
        assert_eq!(written(&anew), (sound.clone(), 0, true));
        // A time that runs backward, and an erratic one.
        let ends = |odd: &dyn Fn(i64) -> i64| {
            let lines = [
                &sound[..],
                &(0..40).map(|k| (odd(k), 0)).collect::<Vec<_>>(),
            ]
            .concat();
            assert_eq!(written(&lines), (sound.clone(), MOST_SKIPPED, true));
        };
        ends(&|k| 40 - 5 * k);
        ends(&|k| 1_000_000 * (1 + 7 * k % 5));
        let set = [&sound[..], &[(50, 2000), (55, 2006), (60, 2012)]].concat();
        assert_eq!(written(&set), (set.clone(), 0, false));
    }
}
