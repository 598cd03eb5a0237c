//! Recordings in the document of a diagnosis: motor and time of each.

use serde::Serialize;

use crate::plain::shown;
use crate::recording::Run;

/// Use of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// It is diagnosed.
    Diagnosed,
    /// It is held out.
    HoldOut,
    /// It is a reference.
    Reference,
}

/// One recording.
#[derive(Debug, Clone, Serialize)]
pub struct RunFacts {
    path: Option<String>,
    role: Role,
    /// The header's `unit`, else the serial number of the board's USB device.
    unit: Option<String>,
    /// As in the header.
    started: Option<String>,
    samples: usize,
    sample_time_s: f64,
    duration_s: f64,
}

/// A document and its recordings.
#[derive(Serialize)]
pub struct WithRuns<'a, T> {
    #[serde(flatten)]
    document: &'a T,
    runs: &'a [RunFacts],
}

impl<'a, T> WithRuns<'a, T> {
    /// The document with these recordings.
    pub fn new(document: &'a T, runs: &'a [RunFacts]) -> Self {
        Self { document, runs }
    }
}

impl RunFacts {
    /// Facts of all runs, in their order.
    pub fn of<const N: usize>(runs: [(Role, &Vec<Run>); N]) -> Vec<Self> {
        let of_role = |(role, runs): (Role, &Vec<Run>)| -> Vec<Self> {
            runs.iter().map(|run| Self::of_run(role, run)).collect()
        };
        runs.into_iter().flat_map(of_role).collect()
    }

    fn of_run(role: Role, run: &Run) -> Self {
        let text = |value: &toml::Value| match value {
            toml::Value::String(text) => Some(text.clone()),
            toml::Value::Integer(number) => Some(number.to_string()),
            toml::Value::Datetime(time) => Some(time.to_string()),
            _ => None,
        };
        let of_header = |key: &str| run.header.get(key).and_then(text);
        let serial = || {
            let port = run.header.get("port")?.as_table()?;
            port.get("serial").and_then(text)
        };
        Self {
            path: run.path.as_ref().map(shown),
            role,
            unit: of_header("unit").or_else(serial),
            started: of_header("started"),
            samples: run.len(),
            sample_time_s: run.sample_time_s,
            duration_s: match (run.t_s.first(), run.t_s.last()) {
                (Some(first), Some(last)) => last - first,
                _ => 0.0,
            },
        }
    }
}
