//! Command over time: a profile of held commands, for the board, the simulator and the design of
//! experiments alike.
//!
//! A profile is a list of segments (duration, command); after the last one its command holds. Sampled
//! with sample time `TS`, the command of sample `k` is that of the segment in force at `k TS`.
//!
//! A built-in profile is written `NAME[@SHARE][,SECONDSs]`: `crawl@0.25,8s` is `crawl` with a quarter of the
//! supply, 8 s long, so that one word says all that there is to play.

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::profile_levels::{chirp, probing_levels};
use super::profile_words::hint;
use crate::motor::plausible;
use crate::plain::shown;

/// How long the `step` profile rests before it steps, in s: a whole number of samples at 3 and at 30 ms.
pub const STEP_REST_S: f64 = 0.3;

/// Names of the built-in profiles with what they are for.
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
/// Times of a profile's rows in s, from its beginning.
const TIMES_S: plausible::Range = plausible::Range {
    lo: 0.0,
    ..plausible::DURATION_S
};

/// Longest profile file in bytes.
const MOST_BYTES: u64 = 1 << 24;

/// One held command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// How long it holds in s.
    pub duration_s: f64,
    /// The command: V, or A or N m of a current- or torque-driven axis.
    pub command: f64,
}

/// Command over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Name, or the path of the file that it came from; goes into the run's header.
    pub name: String,
    /// Held commands, first to last.
    pub segments: Vec<Segment>,
}

/// Why there is no such profile.
#[derive(Debug, thiserror::Error)]
pub enum ProfileError {
    /// Neither a built-in name nor a file.
    #[error(
        "there is no profile '{name}'{hint}: the built-in ones are {list}; a file of rows `t_s,command_v` is named by its path", list = built_in_names()
    )]
    Unknown {
        /// Requested value.
        name: String,
        /// The nearest name, as a phrase.
        hint: String,
    },
    /// The file cannot be read.
    #[error("cannot read the profile {path}", path = shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A row is wrong.
    #[error(
        "{path}, row {row}, column {column}: '{found}' {problem}; a profile has rows `t_s,command_v` with rising times", path = shown(path))]
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
    /// It is longer than any profile.
    #[error(
        "{path} is longer than {MOST_BYTES} bytes: a profile has a row for each change of the command", path = shown(path))]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// There is no row at all.
    #[error("{path} has no row `t_s,command_v`", path = shown(path))]
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
    /// `supply_v` scales the built-in ones and `duration_s` scales their time; a share and a duration that
    /// stand in the name go before.
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
        // The share and the time of a built-in one may have a point; its name has none.
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
                let halves = (duration_s / 0.5).ceil().max(1.0) as usize;
                (0..halves)
                    .map(|k| held(0.5, if k % 2 == 0 { supply_v } else { -supply_v }))
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

    /// Reads rows `t_s,command_v`: from each time on, that command; the last row ends the profile.
    pub fn read(path: &Path) -> Result<Self, ProfileError> {
        let file = std::fs::File::open(path).map_err(|source| ProfileError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::read_from(file, path)
    }

    fn read_from(input: impl Read, path: &Path) -> Result<Self, ProfileError> {
        let mut input = input.take(MOST_BYTES);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(&mut input);
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut columns = (0, 1);
        for (index, record) in reader.records().enumerate() {
            let record = record.map_err(|error| ProfileError::Read {
                path: path.to_owned(),
                source: std::io::Error::other(error),
            })?;
            let row = record.position().map_or(0, csv::Position::line);
            if index == 0 && record.iter().all(|cell| cell.parse::<f64>().is_err()) {
                let names: Vec<&str> = record.iter().collect();
                columns = named_columns(&names).map_err(|(column, problem)| ProfileError::Row {
                    path: path.to_owned(),
                    row,
                    column,
                    found: names.join(",").chars().take(40).collect(),
                    problem,
                })?;
                continue;
            }
            let cell = |column: usize, name: &'static str, range: plausible::Range| {
                let text = record.get(column).unwrap_or("");
                let problem = match text.parse::<f64>() {
                    Ok(value) if range.holds(value) => return Ok(value),
                    Ok(value) if value.is_finite() => format!("lies outside {range}"),
                    _ => "is no finite number".to_owned(),
                };
                Err(ProfileError::Row {
                    path: path.to_owned(),
                    row,
                    column: name,
                    found: text.chars().take(40).collect(),
                    problem,
                })
            };
            let t_s = cell(columns.0, "t_s", TIMES_S)?;
            let command = cell(columns.1, "command_v", plausible::COMMAND)?;
            if points.last().is_some_and(|last| last.0 >= t_s) {
                return Err(ProfileError::Row {
                    path: path.to_owned(),
                    row,
                    column: "t_s",
                    found: t_s.to_string(),
                    problem: "is not later than the row before".to_owned(),
                });
            }
            points.push((t_s, command));
        }
        drop(reader);
        if input.limit() == 0 {
            return Err(ProfileError::TooLong {
                path: path.to_owned(),
            });
        }
        let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) else {
            return Err(ProfileError::Empty {
                path: path.to_owned(),
            });
        };
        let mut segments = Vec::new();
        if first.0 > 0.0 {
            segments.push(held(first.0, 0.0));
        }
        // A recording has a row a sample: those with the same command are one segment.
        let mut from = first;
        for &point in &points[1..] {
            if point.1 != from.1 {
                segments.push(held(point.0 - from.0, from.1));
                from = point;
            }
        }
        segments.push(held(last.0 - from.0, last.1));
        Ok(Self {
            name: path.display().to_string(),
            segments,
        })
    }

    /// Time at which the last command begins to hold for good, plus its own duration, in s.
    pub fn duration_s(&self) -> f64 {
        self.segments.iter().map(|segment| segment.duration_s).sum()
    }

    /// Largest command by size.
    pub fn largest_command(&self) -> f64 {
        self.segments
            .iter()
            .fold(0.0, |largest, segment| segment.command.abs().max(largest))
    }

    /// The command in force at `t_s`; 0 before the profile begins, the last one after its end.
    pub fn command_at(&self, t_s: f64) -> f64 {
        if t_s < 0.0 {
            return 0.0;
        }
        let mut ends_s = 0.0;
        for segment in &self.segments {
            ends_s += segment.duration_s;
            // Segment ends are sums of decimals: a nanosecond short is on time.
            if t_s + 1e-9 < ends_s {
                return segment.command;
            }
        }
        self.segments.last().map_or(0.0, |segment| segment.command)
    }

    /// Commands of samples 0 to `samples - 1`, taken every `sample_time_s`.
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

    /// The segments in whole samples: a segment starts with the first sample at or after its start.
    /// Segments too short to have a sample vanish, but for the last, whose command holds on.
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
        // The last command holds on, however short its own segment is.
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

/// Names of the time and of the command in the first line of a profile's file; a run file has the first of each.
const TIME_NAMES: &[&str] = &["t_s", "time_s", "t", "time"];
const COMMAND_NAMES: &[&str] = &[
    "command_v",
    "command_a",
    "command_nm",
    "command",
    "voltage_v",
    "voltage",
    "volts",
    "u",
    "v",
];

/// Where time and command are by these names. Two columns under other names are time and command, in this order.
fn named_columns(names: &[&str]) -> Result<(usize, usize), (&'static str, String)> {
    let lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let of = |known: &[&str]| {
        let mut places = known
            .iter()
            .filter_map(|known| lower.iter().position(|name| name == known));
        places.next()
    };
    match (of(TIME_NAMES), of(COMMAND_NAMES)) {
        (Some(time), Some(command)) => Ok((time, command)),
        (None | Some(0), None | Some(1)) if names.len() == 2 => Ok((0, 1)),
        (None, _) => Err(("t_s", "names no column t_s".to_owned())),
        (_, None) => Err(("command_v", "names no column command_v".to_owned())),
    }
}

/// `NAME[@SHARE][,SECONDSs]` in its parts; what is spelt otherwise is all name.
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
    fn the_step_is_the_labs() {
        let step = Profile::named("step", 4.5, 4.0).expect("built in");
        for (sample_time_s, rest) in [(0.003, 100), (0.03, 10)] {
            let commands = step.commands(sample_time_s, rest + 5);
            assert!(commands[..rest].iter().all(|&command| command == 0.0));
            assert!(commands[rest..].iter().all(|&command| command == 4.5));
        }
        assert!((step.duration_s() - 4.0).abs() < 1e-12);
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
    fn a_name_says_share_and_duration() {
        let crawl = Profile::named("crawl@0.25,8s", 4.0, 2.0).expect("built in");
        assert_eq!(crawl.largest_command(), 1.0);
        assert!((crawl.duration_s() - 8.0).abs() < 1e-9);
        assert_eq!(crawl.name, "crawl@0.25,8s");
        for wrong in ["crawl@2", "crawl@x", "crawl,s", "crawl,-1s", "step@"] {
            assert!(Profile::named(wrong, 4.0, 2.0).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_file_holds_each_command_until_the_next_row() {
        let rows = "t_s,command_v\n0.1,1.5\n0.2,-3\n0.5,0\n";
        let profile = Profile::read_from(rows.as_bytes(), Path::new("p.csv")).expect("good rows");
        assert_eq!(profile.command_at(0.05), 0.0);
        assert_eq!(profile.command_at(0.1), 1.5);
        assert_eq!(profile.command_at(0.2), -3.0);
        assert_eq!(profile.command_at(9.0), 0.0);
    }

    #[test]
    fn a_recording_is_read_by_the_names_of_its_columns() {
        let read = |rows: &str| Profile::read_from(rows.as_bytes(), Path::new("p.csv"));
        let rows = "# format = \"motorlab-run/1\"\nseq,t_s,host_t_s,command_v,counts\n0,0.0,9,0,0\n1,0.03,9,0,0\n2,0.06,9,4.5,0\n3,0.09,9,4.5,7\n";
        let profile = read(rows).expect("a recording");
        assert_eq!(profile.segments, [held(0.06, 0.0), held(0.09 - 0.06, 4.5)]);
        assert!(
            read("zeit,spannung\n0,1\n").is_ok(),
            "two columns need no names"
        );
        for wrong in [
            "seq,t_s,counts\n0,0,1\n",
            "seq,t_s\n0,1\n",
            "t_s,counts,x\n0,1,2\n",
        ] {
            let error = read(wrong).expect_err(wrong).to_string();
            assert!(
                error.contains("row 1") && error.contains("names no column"),
                "{error}"
            );
        }
    }

    #[test]
    fn bad_rows_are_named() {
        let message = |rows: &str| {
            Profile::read_from(rows.as_bytes(), Path::new("p.csv"))
                .expect_err("bad rows")
                .to_string()
        };
        assert!(message("0,1\n0.1,x\n").contains("p.csv, row 2, column command_v: 'x'"));
        assert!(message("0,1\n0,2\n").contains("row 2, column t_s: '0' is not later"));
        assert!(message("0,1\n0.5,inf\n").contains("'inf' is no finite number"));
        assert!(message("# nothing\n").contains("no row"));
        let unknown = Profile::named("stpe", 4.5, 1.0).expect_err("no such profile");
        assert!(unknown.to_string().contains("did you mean 'step'?"));
    }
}
