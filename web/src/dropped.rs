//! A dropped file: a run file, or a log of another program, which is imported.

use std::path::Path;

use motorlab::check::{Finding, check};
use motorlab::hint::Hinted;
use motorlab::import::{
    GivenFlags, Imported, Kind, Map, Missing, Ready, Source, Unclear, Understood, import, map_over,
};
use motorlab::platform::memory;
use motorlab::recording::{Run, read_run_from};
use motorlab::report::Size;
use motorlab::report::diagnosis::recorded;
use motorlab::report::svg;
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

use crate::failure::{Answer, document, failed, failed_in};

const PREVIEW: Size = Size {
    width: 720,
    height: 330,
};

/// Properties of a log from the page's form; empty fields are not given.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Form {
    time: String,
    command: String,
    direction: String,
    position: String,
    speed: String,
    current: String,
    supply: String,
    counts_per_rev: String,
    m_per_rev: String,
    pwm_full: String,
    wrap: String,
    command_limit: String,
    integrate: String,
    reverse: bool,
    increments: bool,
    unsigned: bool,
}

impl Form {
    fn given(&self) -> Result<GivenFlags, JsError> {
        let text = |text: &str| (!text.trim().is_empty()).then(|| text.trim().to_owned());
        let number = |name: &str, text: &str| match text.trim() {
            "" => Ok(None),
            number => match number.parse::<f64>() {
                Ok(value) if value > 0.0 && value.is_finite() => Ok(Some(value)),
                _ => Err(failed(Hinted::new(
                    format!("{name}: '{number}' is no number above 0"),
                    "a decimal point, no unit and no thousands separator, such as 0.75",
                ))),
            },
        };
        Ok(GivenFlags {
            time: text(&self.time),
            command: text(&self.command),
            direction: text(&self.direction),
            position: text(&self.position),
            speed: text(&self.speed),
            current: text(&self.current),
            supply: text(&self.supply),
            counts_per_rev: number("counts per revolution", &self.counts_per_rev)?,
            m_per_rev: number("travel of a revolution", &self.m_per_rev)?,
            pwm_full: number("full PWM", &self.pwm_full)?,
            wrap: number("range of the counter", &self.wrap)?,
            command_limit: number("limit of the command", &self.command_limit)?,
            integrate: text(&self.integrate)
                .map(|rule| rule.parse().map_err(failed))
                .transpose()?,
            reverse: self.reverse,
            increments: self.increments,
            unsigned: self.unsigned.then_some(true),
            ..GivenFlags::default()
        })
    }
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Dropped {
    /// A run file of motorlab.
    Run { runs: Vec<Seen>, notes: Vec<String> },
    /// A log of another program, imported.
    Log {
        runs: Vec<Seen>,
        understood: Vec<Understood>,
        notes: Vec<String>,
        /// The mapping file for further logs of this kind.
        mapping: String,
        imported: Imported,
        /// The rejected rows, as a file.
        rejected: Option<String>,
        findings: Vec<Finding>,
    },
    /// A log with missing properties.
    Question {
        understood: Vec<Understood>,
        notes: Vec<String>,
        missing: Vec<Asked>,
    },
}

/// A missing property.
#[derive(Debug, Serialize)]
struct Asked {
    /// Key of the form.
    key: String,
    /// An example.
    example: String,
    why: String,
}

impl From<&Missing> for Asked {
    fn from(missing: &Missing) -> Self {
        let flag = missing.flag.trim_start_matches("--");
        let (key, example) = flag.split_once([' ', '=']).unwrap_or((flag, ""));
        Self {
            key: key.replace('-', "_"),
            example: example.trim_matches('\'').to_owned(),
            why: missing.why.clone(),
        }
    }
}

/// A run with its preview.
#[derive(Debug, Serialize)]
pub(crate) struct Seen {
    name: String,
    /// The run file.
    text: String,
    samples: usize,
    duration_s: f64,
    sample_time_s: f64,
    /// A drawing.
    preview: String,
}

impl Seen {
    pub(crate) fn of(name: &str, text: Vec<u8>, run: &Run) -> Self {
        Self {
            name: name.to_owned(),
            text: String::from_utf8_lossy(&text).into_owned(),
            samples: run.len(),
            duration_s: match (run.t_s.first(), run.t_s.last()) {
                (Some(first), Some(last)) => last - first,
                _ => 0.0,
            },
            sample_time_s: run.sample_time_s,
            preview: svg::document(&recorded(run), PREVIEW),
        }
    }
}

/// Reads a dropped file: `form` has missing properties as JSON, `mapping` a mapping file or nothing.
#[wasm_bindgen]
pub fn look(name: &str, bytes: &[u8], form: &str, mapping: &str) -> Answer {
    let error = match read_run_from(bytes, name) {
        Ok((run, notes)) => {
            return document(&Dropped::Run {
                runs: vec![Seen::of(name, bytes.to_vec(), &run)],
                notes: notes.iter().map(ToString::to_string).collect(),
            });
        }
        Err(error) => error,
    };
    match Kind::of(bytes, name) {
        Kind::Run => Err(failed(error)),
        Kind::NoLog(what) => Err(failed(format!(
            "{name}: it is no run file of motorlab: {what}"
        ))),
        Kind::Log => log(name, bytes, form, mapping),
    }
}

fn log(name: &str, bytes: &[u8], form: &str, mapping: &str) -> Answer {
    let failed_here = failed_in(name);
    let form: Form = serde_json::from_str(form).map_err(failed)?;
    let given = form.given()?;
    let mut source = Source::new(Box::new(bytes), name).map_err(|error| failed_here(&error))?;
    let mut understood = Vec::new();
    let mut notes = Vec::new();
    let ready: Ready = if mapping.is_empty() {
        let command = format!("motorlab import {}", motorlab::plain::quoted(name));
        let reading = source.understand(name, &given, &command);
        let reading = reading.map_err(|error| failed_here(&error))?;
        understood = reading.understood;
        notes = reading.notes;
        match reading.map {
            Ok(ready) => ready,
            Err(Unclear::Missing { missing, .. }) => {
                return document(&Dropped::Question {
                    understood,
                    notes,
                    missing: missing.iter().map(Asked::from).collect(),
                });
            }
            Err(unclear) => return Err(failed_here(&unclear)),
        }
    } else if given == GivenFlags::default() {
        let map = Map::from_toml(mapping).map_err(failed)?;
        source.fitted(Ready {
            map,
            toml: mapping.to_owned(),
        })
    } else {
        source.fitted(map_over(mapping, &given).map_err(failed)?)
    };
    let target = run_name(name);
    let imported = import(source.read(), name, &ready.map, Path::new(&target)).map_err(failed)?;
    let rejected = imported.rejected.as_deref().and_then(memory::take);
    let mut seen = Vec::new();
    let mut runs = Vec::new();
    for one in &imported.runs {
        let text = memory::take(&one.path).unwrap_or_default();
        let name = one.path.display().to_string();
        let (mut run, _) = read_run_from(text.as_slice(), &name).map_err(failed)?;
        run.path = Some(one.path.clone());
        seen.push(Seen::of(&name, text, &run));
        runs.push(run);
    }
    document(&Dropped::Log {
        findings: check(&runs, None),
        runs: seen,
        understood,
        notes,
        mapping: ready.toml,
        imported,
        rejected: rejected.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()),
    })
}

/// `step.run.csv` for `step.txt` and `step.csv.gz`.
fn run_name(log: &str) -> String {
    let name = Path::new(log).file_name().unwrap_or_default();
    let name = Path::new(name);
    let name = match name.extension() {
        Some(extension) if extension == "gz" => Path::new(name.file_stem().unwrap_or_default()),
        _ => name,
    };
    name.with_extension("run.csv").display().to_string()
}
