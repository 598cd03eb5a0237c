//! `motorlab export c`, `python`, `octave`, `isaac-lab`: the motor with its effects as a function that other programs call.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::export::{MotorFile, document};
use super::output_file::{Force, Form};
use super::{Failure, Output, Status};
use crate::export::actuator::{Target, check, divided};
use crate::motor::Motor;
use crate::plain::shown;

/// Shortest and longest step of the calling program in s: below, inner steps are shorter than any time constant of a
/// motor; above, a command is held longer than by any controller.
const STEPS_S: (f64, f64) = (1e-6, 1.0);

/// Which motor, for steps of which length, and where it goes.
#[derive(Debug, Args)]
pub(super) struct ActuatorFile {
    #[command(flatten)]
    motor: MotorFile,
    #[command(flatten)]
    step: Step,
    /// File to write; without it the file goes to standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// The step of the program that calls the motor.
#[derive(Debug, Args)]
struct Step {
    /// Step in s of the program that calls the motor: a voltage is held so long.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.001, value_parser = step)]
    step_time: f64,
}

fn step(text: &str) -> Result<f64, String> {
    let (least, most) = STEPS_S;
    match text.parse() {
        Ok(step_s) if (least..=most).contains(&step_s) => Ok(step_s),
        _ => Err(format!(
            "expected seconds from {least} to {most}\nhint: --step-time 0.001"
        )),
    }
}

fn form(target: Target) -> Form {
    match target {
        Target::C => Form::C,
        Target::Octave => Form::Matlab,
        Target::Python | Target::IsaacLab | Target::Mujoco => Form::Toml,
    }
}

impl ActuatorFile {
    pub(super) fn run(
        &self,
        format: &str,
        target: Target,
        output: &Output,
    ) -> Result<Status, Failure> {
        let outputs = self.force.outputs("export", self.motor.path());
        outputs.check(&self.output)?;
        let motor = self.motor.read(output)?;
        check(&motor, self.step.step_time).map_err(Failure::input)?;
        let text = target.file(&motor, self.step.step_time);
        if let Some(path) = &self.output {
            outputs.write_silently(path, &text, form(target))?;
        }
        let files: Vec<&PathBuf> = self.output.iter().collect();
        wrote_actuator(format, &files, Some(&text), &motor, output)
    }
}

/// Prints the written files, their effects, and those that are not part of an actuator. Without an output file the
/// text goes to standard output.
pub(super) fn wrote_actuator(
    format: &str,
    files: &[&PathBuf],
    text: Option<&str>,
    motor: &Motor,
    output: &Output,
) -> Result<Status, Failure> {
    let (effects, not_part) = divided(motor);
    for left in &not_part {
        output.message(&format!("not in the file: {}: {}", left.effect, left.why));
    }
    let text = text.filter(|_| files.is_empty());
    if output.json {
        let paths = files.iter().map(|file| file.as_path()).collect();
        let mut document = document(format, paths, Some(motor));
        document["effects"] = effects.into();
        document["not_part"] = json!(not_part);
        if let Some(text) = text {
            document["text"] = text.into();
        }
        output.document(&document)?;
    } else if let Some(text) = text {
        output.line(text.trim_end())?;
    } else {
        for file in files {
            output.line(&format!("wrote {}", shown(file)))?;
        }
    }
    Ok(Status::Done)
}
