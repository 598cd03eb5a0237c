//! `motorlab diagnose`: where the gap lies, which effect causes it, how far it shrinks.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::diagnose_text::show;
use super::motor_choice::MotorChoice;
use super::picture::write_file;
use super::{Failure, Output, Status};
use crate::diagnose::diagnose;
use crate::recording::read_run;
use crate::report::diagnosis::page;

/// Say where the gap between recording and simulation lies, which effect causes it and how far it shrinks.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab diagnose step3.csv reversing.csv --motor motor.toml\n  motorlab diagnose run.csv --model-out diagnosed.toml --html why.html\n  motorlab diagnose run.csv --motor motor.toml --json"
)]
pub struct Diagnose {
    /// Run files of the same motor: other sample times and profiles tell more.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    #[command(flatten)]
    motor: MotorChoice,
    /// Write the motor with the diagnosed effects in it, for simulate and compare.
    #[arg(long, value_name = "FILE")]
    model_out: Option<PathBuf>,
    /// Write everything as one HTML file that needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

impl Diagnose {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let motor = self.motor.motor(output)?;
        let mut runs = Vec::new();
        for path in &self.runs {
            let (run, notes) = read_run(path).map_err(Failure::input)?;
            for note in notes {
                output.message(&format!("{}: {note}", path.display()));
            }
            runs.push(run);
        }
        let spinner = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            spinner.set_style(style);
        }
        spinner.enable_steady_tick(std::time::Duration::from_millis(100));
        let found = diagnose(&runs, &motor, &|what| spinner.set_message(what.to_owned()));
        spinner.finish_and_clear();
        let diagnosis = found.map_err(Failure::input)?;
        if let Some(path) = &self.model_out {
            write_file(path, &diagnosis.model.to_toml())?;
            output.message(&format!("wrote {}", path.display()));
        }
        if let Some(path) = &self.html {
            let title = format!("What makes the gap ({})", self.motor.words());
            let page = page(&diagnosis, &runs, &motor, &title).map_err(Failure::input)?;
            write_file(path, &page)?;
            output.message(&format!("wrote {}", path.display()));
        }
        if output.json {
            output.document(&diagnosis)?;
        } else {
            show(&diagnosis, output)?;
            if self.html.is_none() {
                output.message("a page with the pictures: add --html diagnosis.html");
            }
        }
        Ok(Status::Done)
    }
}
