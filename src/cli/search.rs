//! `motorlab search`: what the rebuilt diagnosis finds, step by step.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Output, Status};
use crate::diagnosis::{Found, Step, search};
use crate::motor::{Motor, read_motor};
use crate::recording::read_run;

/// Search for what a motor lacks, step by step. `diagnose` does not use this search yet.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  motorlab search run.csv --motor motor.toml")]
pub struct Search {
    /// Run files of one motor.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Motor file; without it the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
}

/// For `--json`; the shape is not settled.
#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    found: Found,
    sets: &'a [Vec<&'static str>],
    probability: f64,
    left_counts: f64,
    wander: f64,
    steps: &'a [Step],
}

impl Search {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let motor = match &self.motor {
            Some(path) => read_motor(path).map_err(Failure::input)?,
            None => Motor::default(),
        };
        let mut runs = Vec::new();
        for path in &self.runs {
            let (run, notes) = read_run(path).map_err(Failure::input)?;
            for note in notes {
                output.message(&format!("{}: {note}", path.display()));
            }
            runs.push(run);
        }
        let found = search(&runs, &motor).map_err(Failure::input)?;
        if output.json {
            output.document(&Document {
                shape: "motorlab-search/0",
                found: found.found,
                sets: &found.sets,
                probability: found.probability,
                left_counts: found.left_counts,
                wander: found.wander,
                steps: &found.steps,
            })?;
        } else {
            output.line(found.to_string().trim_end())?;
        }
        Ok(Status::Done)
    }
}
