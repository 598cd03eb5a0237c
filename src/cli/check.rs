//! `motorlab check`: findings about recordings.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::findings::listed;
use super::foreign::{read_runs, refuse_unused};
use super::import_flags::Flags;
use super::motor_file::motor_file;
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::check::{Finding, check, is_fatal};
use crate::plain::shown;

/// Find errors of the recordings themselves, before a comparison or a diagnosis.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Check {
    /// Run files; several are taken to be of one motor and judged together too. A log of another program is imported on the way.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Motor file: some errors only show against it, such as counts that are off by 4.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    /// Print the figures too, and every finding of a kind that several runs have.
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    log: Flags,
}

const EXAMPLE: &str = "Examples:
  motorlab check run.csv
  motorlab check a.csv b.csv --motor motor.toml --json

The exit status is 1 with a fatal finding: no diagnosis is valid before it is corrected.
Warnings and notes leave it at 0. A kind that several runs have is told once; --verbose tells all. Every kind of finding: docs/reference/check.md.";

#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    findings: &'a [Finding],
}

impl Check {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let motor = match &self.motor {
            Some(path) => Some(motor_file(path, output)?),
            None => None,
        };
        let mut runs = Vec::new();
        for path in &self.runs {
            for (run, notes) in read_runs(path, &self.log, output)? {
                for note in notes {
                    output.message(&format!("{}: {note}", shown(path)));
                }
                runs.push(run);
            }
        }
        refuse_unused(&self.log, &runs, output)?;
        let findings = check(&runs, motor.as_ref());
        if output.json {
            output.document(&Document {
                shape: "motorlab-check/1",
                findings: &findings,
            })?;
        } else if findings.is_empty() {
            let samples: usize = runs.iter().map(|run| run.counts.len()).sum();
            output.line(&format!("no findings in {samples} samples"))?;
        }
        if !output.json {
            for text in listed(&findings, self.verbose) {
                output.line(&text)?;
            }
        }
        Ok(if is_fatal(&findings) {
            Status::FellShort
        } else {
            Status::Done
        })
    }
}
