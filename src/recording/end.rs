//! Comparison of the board's END with the received samples.

use firmware_protocol::EndReason;

use super::Ending;

/// A board's END.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct End {
    /// Samples taken, as stated.
    pub taken: u32,
    /// Samples that could not be sent, as stated.
    pub dropped: u32,
    /// Reason.
    pub reason: EndReason,
}

/// How a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ended {
    /// Reason.
    pub ending: Ending,
    /// The board's END, if it came.
    pub end: Option<End>,
    /// The board was told to stop.
    pub host_stopped: bool,
}

impl From<Ending> for Ended {
    fn from(ending: Ending) -> Self {
        Self {
            ending,
            end: None,
            host_stopped: false,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ReceivedSamples {
    /// Requested samples; 0 is unlimited.
    pub asked: u32,
    /// Losses according to sample numbers.
    pub lost: u64,
    /// Rows before which the board reports dropped frames.
    pub dropped_rows: u64,
    /// Number of the last received sample, plus one.
    pub up_to: u64,
    /// Samples received beyond the requested ones.
    pub beyond: u64,
    /// Most samples that can be missing after the last one.
    pub most_missing_at_the_end: u64,
}

/// Result of the comparison.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Verdict {
    /// Samples lost at the end, without an effect on sample numbers.
    pub lost_at_the_end: u64,
    /// Contradictions.
    pub contradictions: Vec<String>,
}

impl ReceivedSamples {
    /// Compares an END with the received samples.
    pub(super) fn judge(&self, ended: &Ended) -> Verdict {
        let mut verdict = Verdict::default();
        let mut says = |what: String| verdict.contradictions.push(what);
        let asked = u64::from(self.asked);
        if self.beyond > 0 {
            says(format!(
                "it continued after the {asked} samples asked for; {} more came and are not in the file",
                self.beyond
            ));
        }
        let Some(end) = ended.end else {
            // The loss of the last samples and the END of a complete recording causes no longer silence than the
            // limit.
            let missing = asked.saturating_sub(self.up_to);
            if ended.ending == Ending::Silent && missing <= self.most_missing_at_the_end {
                verdict.lost_at_the_end = missing;
            }
            return verdict;
        };
        let taken = u64::from(end.taken);
        let complete = end.reason == EndReason::Complete;
        if taken < self.up_to {
            says(format!(
                "its END says that it took {taken} samples, and number {} came",
                self.up_to - 1
            ));
        }
        if complete && asked == 0 && !ended.host_stopped {
            says("its END says that it is complete, and nobody asked for a number".to_owned());
        }
        if complete && asked > 0 && taken < asked {
            says(format!(
                "its END says that it is complete after {taken} of the {asked} samples asked for"
            ));
        }
        if complete && asked > 0 && taken > asked {
            says(format!(
                "its END says that it took {taken} samples, and {asked} were asked for"
            ));
        }
        if end.reason == EndReason::Stopped && !ended.host_stopped {
            says("its END says that it was told to stop, and nobody told it".to_owned());
        }
        // With a requested number the board took no more; without one, a longer loss would have been silence.
        let most = if asked > 0 {
            asked
        } else {
            self.up_to + self.most_missing_at_the_end
        };
        if asked == 0 && taken > most {
            says(format!(
                "its END says that it took {taken} samples, and they ended with number {}",
                self.up_to.saturating_sub(1)
            ));
        }
        let last = self.up_to.min(most);
        verdict.lost_at_the_end = if taken > most && asked == 0 {
            0
        } else {
            taken.min(most).saturating_sub(last)
        };
        let missing = self.lost + verdict.lost_at_the_end;
        let dropped = u64::from(end.dropped);
        if dropped > missing {
            verdict.contradictions.push(format!(
                "its END says that {dropped} samples were dropped, and {missing} are missing"
            ));
        }
        if dropped < self.dropped_rows {
            verdict.contradictions.push(format!(
                "its END says that {dropped} samples were dropped, and {} samples say that frames before them were",
                self.dropped_rows
            ));
        }
        verdict
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: ReceivedSamples = ReceivedSamples {
        asked: 333,
        lost: 0,
        dropped_rows: 0,
        up_to: 333,
        beyond: 0,
        most_missing_at_the_end: 500,
    };

    fn judged(came: ReceivedSamples, taken: u32, dropped: u32, reason: EndReason) -> Verdict {
        came.judge(&Ended {
            ending: reason.into(),
            end: Some(End {
                taken,
                dropped,
                reason,
            }),
            host_stopped: came.asked == 0,
        })
    }

    #[test]
    fn a_consistent_end_is_accepted() {
        let complete = EndReason::Complete;
        assert_eq!(judged(WHOLE, 333, 0, complete), Verdict::default());
        let hurt = ReceivedSamples {
            lost: 8,
            dropped_rows: 2,
            up_to: 328,
            ..WHOLE
        };
        let verdict = judged(hurt, 333, 9, complete);
        assert_eq!(verdict.lost_at_the_end, 5);
        assert_eq!(verdict.contradictions, [""; 0]);
        let stopped = ReceivedSamples { asked: 0, ..WHOLE };
        let verdict = judged(stopped, 340, 0, EndReason::Stopped);
        assert_eq!(
            (verdict.lost_at_the_end, verdict.contradictions.len()),
            (7, 0)
        );
    }

    #[test]
    fn samples_lost_before_the_end_are_counted() {
        let lost = |up_to: u64, ending: Ending| {
            let came = ReceivedSamples { up_to, ..WHOLE };
            came.judge(&ending.into()).lost_at_the_end
        };
        assert_eq!(lost(320, Ending::Silent), 13);
        assert_eq!(lost(333, Ending::Silent), 0);
        assert_eq!(lost(320, Ending::Unplugged), 0);
        // For a board that fell silent long before, no further samples are known.
        let early = ReceivedSamples {
            asked: 4000,
            up_to: 333,
            ..WHOLE
        };
        assert_eq!(early.judge(&Ending::Silent.into()).lost_at_the_end, 0);
    }

    #[test]
    fn each_inconsistent_end_is_named_and_counts_no_losses() {
        let complete = EndReason::Complete;
        for (came, taken, dropped, said) in [
            (WHOLE, 50, 0, "took 50 samples, and number 332 came"),
            (WHOLE, u32::MAX, 0, "333 were asked for"),
            (WHOLE, 333, u32::MAX, "and 0 are missing"),
            (
                ReceivedSamples {
                    up_to: 100,
                    ..WHOLE
                },
                100,
                0,
                "complete after 100 of the 333",
            ),
            (
                ReceivedSamples {
                    beyond: 20,
                    up_to: 353,
                    ..WHOLE
                },
                353,
                0,
                "20 more came",
            ),
            (
                ReceivedSamples {
                    dropped_rows: 3,
                    ..WHOLE
                },
                333,
                0,
                "3 samples say",
            ),
            (
                ReceivedSamples { asked: 0, ..WHOLE },
                4_000_000,
                0,
                "ended with number 332",
            ),
        ] {
            let verdict = judged(came, taken, dropped, complete);
            assert_eq!(verdict.lost_at_the_end, 0, "{said}");
            let all = verdict.contradictions.join("; ");
            assert!(all.contains(said), "{said}: {all}");
        }
    }
}
