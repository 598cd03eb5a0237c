//! Profiles of held commands over time, for the board, the simulator and the design of experiments.
//!
//! A profile is a list of segments (duration, command); the last command is held. With sample time `TS`, the command
//! of sample `k` is that of the segment in force at `k TS`.
//!
//! A built-in profile is written `NAME[@SHARE][,SECONDSs]`: `crawl@0.25,8s` is `crawl` with a quarter of the supply,
//! 8 s long.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::profile_levels::{chirp, probing_levels};
use super::profile_words::hint;
use crate::motor::plausible;
use crate::plain::shown;

/// Initial rest of the `step` profile in s: a whole number of samples at 3 and at 30 ms.
pub const STEP_REST_S: f64 = 0.3;

/// Half a period of the `square` profile in s, after which a gear motor is at steady speed.
const HALF_SQUARE_S: f64 = 0.5;

/// The built-in profiles and their purpose.
pub const BUILT_IN: [(&str, &str); 12] = [
    ("step", "0 V for 0.3 s, then the supply (the lab's step)"),
    (
        "staircase",
        "quarter steps of the supply up, and down again",
    ),
    (
        "reversing",
        "steps of both signs and several sizes, with rests between",
    ),
    ("square", "plus and minus the supply, half a second each"),
    (
        "ramp",
        "slowly from 0 to the supply and back, then the same in reverse",
    ),
    ("rest", "0 V all the time"),
    (
        "threshold",
        "fine steps up and down, then in reverse (with a small share of the supply)",
    ),
    (
        "crawl",
        "long holds of both signs with rests (with a small share of the supply)",
    ),
    ("coasts", "bursts of both signs, each followed by 0 V"),
    ("jog", "quick reversals in three sizes"),
    ("chirp", "plus and minus, faster and faster"),
    (
        "brakes",
        "from high to low levels and back without a rest, both signs",
    ),
];

/// Longest duration in a profile's name in s.
const LONGEST_S: f64 = plausible::DURATION_S.hi;

/// Longest profile file in bytes.
pub(super) const MOST_BYTES: u64 = 1 << 24;

/// One held command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// Duration in s.
    pub duration_s: f64,
    /// The command: V, or A or N m of a current- or torque-driven axis.
    pub command: f64,
}

/// A profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Name, or the path of its file; written into the run's header.
    pub name: String,
    /// Held commands, first to last.
    pub segments: Vec<Segment>,
}

/// Errors of a profile.
#[derive(Debug, thiserror::Error)]
pub enum ProfileError {
    /// Neither a built-in name nor a file.
    #[error(
        "there is no profile '{name}'\nhint: {hint}the built-in ones are {list}; a file of rows `t_s,command_v` is named by its path", list = built_in_names()
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// The most similar name, as a phrase.
        hint: String,
    },
    /// The file cannot be read.
    #[error("cannot read the profile {path}", path = shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// An invalid row.
    #[error(
        "{path}, row {row}, column {column}: '{found}' {problem}\nhint: a profile has rows `t_s,command_v` with rising times", path = shown(path))]
    Row {
        /// The file.
        path: PathBuf,
        /// Line of the file, from 1.
        row: u64,
        /// Column name.
        column: &'static str,
        /// Text found.
        found: String,
        /// Error in it.
        problem: String,
    },
    /// The file is too long.
    #[error(
        "{path} is longer than {MOST_BYTES} bytes\nhint: a profile has a row for each change of the command, not for each sample", path = shown(path))]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// There are no rows.
    #[error("{path} has no row `t_s,command_v`\nhint: such as `0,0`, `0.5,3` and `2,0` on lines of their own: 3 V from 0.5 s to 2 s", path = shown(path))]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

fn built_in_names() -> String {
    BUILT_IN.map(|(name, _)| name).join(", ")
}

impl Profile {
    /// A built-in profile by its name (`NAME[@SHARE][,SECONDSs]`), or one from a file `t_s,command_v`.
    ///
    /// `supply_v` scales the built-in ones and `duration_s` their time; share and duration in the name take
    /// precedence.
    pub fn named(name: &str, supply_v: f64, duration_s: f64) -> Result<Self, ProfileError> {
        let (plain, share, stated_s) = spelt(name);
        let duration_s = stated_s.unwrap_or(duration_s);
        if let Some(profile) = Self::built_in(plain, share * supply_v, duration_s) {
            return Ok(Self {
                name: name.to_owned(),
                ..profile
            });
        }
        let path = Path::new(name);
        // Share and time of a built-in profile may contain a point; its name does not.
        let before = name.split(['@', ',']).next().unwrap_or_default();
        if path.exists() || before.contains(['/', '\\', '.']) {
            return Self::read(path);
        }
        Err(ProfileError::Unknown {
            name: name.to_owned(),
            hint: hint(name, &BUILT_IN.map(|(known, _)| known)),
        })
    }

    /// One of [`BUILT_IN`].
    pub fn built_in(name: &str, supply_v: f64, duration_s: f64) -> Option<Self> {
        let equal = |levels: &[f64]| -> Vec<Segment> {
            let each_s = duration_s / levels.len() as f64;
            levels
                .iter()
                .map(|level| held(each_s, level * supply_v))
                .collect()
        };
        let segments = match name {
            "step" => {
                let rest_s = STEP_REST_S.min(duration_s / 2.0);
                vec![held(rest_s, 0.0), held(duration_s - rest_s, supply_v)]
            }
            "staircase" => equal(&[0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0]),
            "reversing" => equal(&[
                0.0, 1.0, -1.0, 0.0, 0.6, -0.6, 0.0, 0.35, -0.35, 0.0, 0.8, -0.45, 0.5, -1.0, 0.0,
            ]),
            "square" => {
                let halves = (duration_s / HALF_SQUARE_S).ceil().max(1.0) as usize;
                (0..halves)
                    .map(|k| {
                        // The last one ends with the profile.
                        let left_s = duration_s - k as f64 * HALF_SQUARE_S;
                        let level = if k % 2 == 0 { supply_v } else { -supply_v };
                        held(left_s.min(HALF_SQUARE_S), level)
                    })
                    .collect()
            }
            "ramp" => {
                let levels: Vec<f64> = (0..64)
                    .map(|k| {
                        let phase = (f64::from(k) + 0.5) / 16.0;
                        match phase {
                            p if p < 1.0 => p,
                            p if p < 3.0 => 2.0 - p,
                            p => p - 4.0,
                        }
                    })
                    .collect();
                equal(&levels)
            }
            "rest" => vec![held(duration_s, 0.0)],
            "chirp" => chirp(supply_v, duration_s),
            _ => equal(&probing_levels(name)?),
        };
        Some(Self {
            name: name.to_owned(),
            segments,
        })
    }

    /// Total duration in s, rounded to the nanosecond because it is a sum of decimals.
    pub fn duration_s(&self) -> f64 {
        let sum_s: f64 = self.segments.iter().map(|segment| segment.duration_s).sum();
        (sum_s * 1e9).round() / 1e9
    }

    /// Largest absolute command.
    pub fn largest_command(&self) -> f64 {
        self.segments
            .iter()
            .fold(0.0, |largest, segment| segment.command.abs().max(largest))
    }

    /// The command at `t_s`; 0 before the profile begins, the last one after its end.
    pub fn command_at(&self, t_s: f64) -> f64 {
        if t_s < 0.0 {
            return 0.0;
        }
        let mut ends_s = 0.0;
        for segment in &self.segments {
            ends_s += segment.duration_s;
            // Segment ends are sums of decimals: tolerance of a nanosecond.
            if t_s + 1e-9 < ends_s {
                return segment.command;
            }
        }
        self.segments.last().map_or(0.0, |segment| segment.command)
    }

    /// Commands of samples 0 to `samples - 1` at `sample_time_s`.
    pub fn commands(&self, sample_time_s: f64, samples: usize) -> Vec<f64> {
        self.in_samples(sample_time_s)
            .into_iter()
            .flat_map(|(length, command)| std::iter::repeat_n(command, length))
            .chain(std::iter::repeat(
                self.segments.last().map_or(0.0, |segment| segment.command),
            ))
            .take(samples)
            .collect()
    }

    /// The segments in whole samples: a segment starts with the first sample at or after its start. Segments without
    /// a sample are dropped, except the last, whose command is held.
    pub fn in_samples(&self, sample_time_s: f64) -> Vec<(usize, f64)> {
        let mut samples: Vec<(usize, f64)> = Vec::new();
        let (mut ends_s, mut before) = (0.0, 0_usize);
        for segment in &self.segments {
            ends_s += segment.duration_s;
            let end = ((ends_s - 1e-9) / sample_time_s).ceil().max(0.0) as usize;
            if end > before {
                samples.push((end - before, segment.command));
                before = end;
            }
        }
        // The last command is held, however short its segment is.
        if let Some(last) = self.segments.last()
            && samples
                .last()
                .is_none_or(|(_, command)| *command != last.command)
        {
            samples.push((1, last.command));
        }
        samples
    }
}

/// Parts of `NAME[@SHARE][,SECONDSs]`; any other text is all name.
fn spelt(name: &str) -> (&str, f64, Option<f64>) {
    let number = |text: &str, most: f64| {
        let value = text.parse::<f64>().ok();
        value.filter(|value| *value > 0.0 && *value <= most)
    };
    let (mut rest, mut stated_s) = (name, None);
    if let Some((before, seconds)) = name.rsplit_once(',')
        && let Some(seconds) = seconds.strip_suffix('s').and_then(|s| number(s, LONGEST_S))
    {
        (rest, stated_s) = (before, Some(seconds));
    }
    match rest.split_once('@') {
        Some((plain, share)) => match number(share, 1.0) {
            Some(share) => (plain, share, stated_s),
            None => (name, 1.0, None),
        },
        None => (rest, 1.0, stated_s),
    }
}

pub(super) fn held(duration_s: f64, command: f64) -> Segment {
    Segment {
        duration_s,
        command,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_profile_is_that_of_the_lab() {
        let step = Profile::named("step", 4.5, 4.0).expect("built in");
        for (sample_time_s, rest) in [(0.003, 100), (0.03, 10)] {
            let commands = step.commands(sample_time_s, rest + 5);
            assert!(commands[..rest].iter().all(|&command| command == 0.0));
            assert!(commands[rest..].iter().all(|&command| command == 4.5));
        }
        assert!((step.duration_s() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_built_in_profile_has_the_requested_duration() {
        for (name, _) in BUILT_IN {
            for duration_s in [0.2, 1.2, 4.0, 15.0] {
                let profile = Profile::built_in(name, 4.5, duration_s).expect("built in");
                assert_eq!(profile.duration_s(), duration_s, "{name}");
            }
        }
    }

    #[test]
    fn sampled_profiles_agree_with_the_command_in_force() {
        for (name, _) in BUILT_IN {
            let profile = Profile::built_in(name, 4.5, 6.0).expect("built in");
            assert!(profile.largest_command() <= 4.5);
            for sample_time_s in [0.003, 0.03, 0.0047] {
                let commands = profile.commands(sample_time_s, 2000);
                for (k, command) in commands.iter().enumerate() {
                    assert_eq!(*command, profile.command_at(k as f64 * sample_time_s));
                }
            }
        }
    }

    #[test]
    fn a_profile_name_states_share_and_duration() {
        let crawl = Profile::named("crawl@0.25,8s", 4.0, 2.0).expect("built in");
        assert_eq!(crawl.largest_command(), 1.0);
        assert!((crawl.duration_s() - 8.0).abs() < 1e-9);
        assert_eq!(crawl.name, "crawl@0.25,8s");
        for wrong in ["crawl@2", "crawl@x", "crawl,s", "crawl,-1s", "step@"] {
            assert!(Profile::named(wrong, 4.0, 2.0).is_err(), "{wrong}");
        }
    }
}
