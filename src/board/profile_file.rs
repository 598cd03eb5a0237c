//! Profiles from files of rows `t_s,command_v`, or from recordings.

use std::io::Read;
use std::path::Path;

use super::profile::{MOST_BYTES, Profile, ProfileError, held};
use crate::motor::plausible;

/// Range of a profile's times in s.
const TIMES_S: plausible::Range = plausible::Range {
    lo: 0.0,
    ..plausible::DURATION_S
};
/// Column names of time and command; a run file has the first of each.
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

impl Profile {
    /// Reads rows `t_s,command_v`: each command is in force from its time on; the last row ends the profile.
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
        // Rows of a recording with the same command are one segment.
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
}

/// Columns of time and command by these names. Two columns of other names are time and command, in this order.
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

#[cfg(test)]
mod tests {
    use super::*;

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
