//! Bound of `--until-known`: total seconds of recording, or number of recordings.

/// Longest bound in s, and most recordings: a day at the bench.
const LONGEST_S: f64 = 86_400.0;
const MOST_ROUNDS: u32 = 1000;

/// Limit after which no further recording begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::cli) enum Bound {
    /// Total recorded seconds.
    Recorded(f64),
    /// Number of recordings.
    Rounds(u32),
}

impl Bound {
    /// Reads `60s`, or `4`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "'{text}' is neither seconds nor a number of recordings\nhint: 60s are seconds of recording in all, 4 is a number of recordings"
            )
        };
        if let Some(seconds) = text.strip_suffix('s') {
            let seconds: f64 = seconds.trim_end().parse().map_err(|_| wrong())?;
            return match (0.0..=LONGEST_S).contains(&seconds) && seconds > 0.0 {
                true => Ok(Self::Recorded(seconds)),
                false => Err(format!(
                    "expected more than 0 s and at most {LONGEST_S} s\nhint: --until-known 60s"
                )),
            };
        }
        match text.parse() {
            Ok(rounds @ 1..=MOST_ROUNDS) => Ok(Self::Rounds(rounds)),
            Ok(_) => Err(format!(
                "expected 1 to {MOST_ROUNDS} recordings\nhint: --until-known 8; seconds have an s, as in 60s"
            )),
            Err(_) => Err(wrong()),
        }
    }

    /// Whether another recording of `next_s` may begin after `rounds` recordings of `recorded_s` in all.
    pub(super) fn allows(self, rounds: usize, recorded_s: f64, next_s: f64) -> bool {
        match self {
            // Durations are sums of decimals: an excess of a microsecond is rounding.
            Self::Recorded(most_s) => recorded_s + next_s <= most_s + 1e-6,
            Self::Rounds(most) => rounds < most as usize,
        }
    }

    pub(super) fn words(self) -> String {
        match self {
            Self::Recorded(most_s) => format!("{most_s} s of recording"),
            Self::Rounds(1) => "one recording".to_owned(),
            Self::Rounds(most) => format!("{most} recordings"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bounds_in_seconds_or_recordings_are_parsed() {
        assert_eq!(Bound::parse("60s"), Ok(Bound::Recorded(60.0)));
        assert_eq!(Bound::parse("7.5s"), Ok(Bound::Recorded(7.5)));
        assert_eq!(Bound::parse("4"), Ok(Bound::Rounds(4)));
        for wrong in [
            "", "s", "0", "0s", "-3s", "NaNs", "infs", "1m", "4.5", "1e9s", "1001",
        ] {
            assert!(Bound::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_recording_starts_only_if_it_ends_within_the_bound() {
        assert!(Bound::Recorded(45.0).allows(2, 30.0, 15.0));
        assert!(!Bound::Recorded(44.0).allows(2, 30.0, 15.0));
        assert!(Bound::Rounds(3).allows(2, 1e6, 15.0));
        assert!(!Bound::Rounds(3).allows(3, 0.0, 15.0));
    }
}
