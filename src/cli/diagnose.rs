//! `motorlab diagnose`: where the gap lies, which effect causes it, how far it shrinks.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::motor_choice::MotorChoice;
use super::picture::write_file;
use super::{Failure, Output, Status};
use crate::diagnose::{Cause, Diagnosis, diagnose};
use crate::recording::read_run;

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
}

/// How many causes are listed on the terminal.
const LISTED: usize = 6;

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
        if output.json {
            output.document(&diagnosis)?;
        } else {
            show(&diagnosis, output)?;
        }
        Ok(Status::Done)
    }
}

fn show(diagnosis: &Diagnosis, output: &Output) -> Result<(), Failure> {
    output.line(&diagnosis.sentence)?;
    for problem in &diagnosis.data {
        output.line(&format!(
            "  recording {}: {} ({})",
            problem.run, problem.detail, problem.problem
        ))?;
    }
    output.line("\ncauses")?;
    for cause in diagnosis.causes.iter().take(LISTED) {
        output.line(&cause_line(cause))?;
    }
    let gap = &diagnosis.gap;
    output.line("\nposition error, counts RMS, on data kept from the fit")?;
    for (name, value) in [
        ("nominal model", gap.before),
        ("refitted", gap.after_parameters),
        ("with the effects", gap.after_effect),
        ("the encoder's floor", gap.floor),
    ] {
        output.line(&format!("  {name:<22} {value:>10.3}"))?;
    }
    output.line(&format!(
        "  closed {:.1} % (95 %: {:.1} to {:.1})",
        100.0 * gap.closed,
        100.0 * gap.closed_lo95,
        100.0 * gap.closed_hi95
    ))?;
    if !diagnosis.place.regions.is_empty() {
        output.line("\nwhere")?;
    }
    for region in diagnosis.place.regions.iter().take(LISTED) {
        output.line(&format!(
            "  {:>4.0} %  {} from {:.2} s to {:.2} s, {}",
            100.0 * region.share,
            region.regime.words(),
            region.from_s,
            region.to_s,
            region.run
        ))?;
    }
    Ok(())
}

fn cause_line(cause: &Cause) -> String {
    let numbers: Vec<String> = cause
        .parameters
        .iter()
        .map(|(name, n)| format!("{name} {:.4} [{:.4}, {:.4}]", n.value, n.lo95, n.hi95))
        .collect();
    let mut line = format!(
        "  {:>6.1} %  {:<22} {}",
        100.0 * cause.probability,
        cause.effect,
        numbers.join("  ")
    );
    if !cause.indistinguishable_from.is_empty() {
        line.push_str(&format!(
            "  not told from {}",
            cause.indistinguishable_from.join(", ")
        ));
    }
    if !cause.converged {
        line.push_str("  (its fit has not settled)");
    }
    line
}
