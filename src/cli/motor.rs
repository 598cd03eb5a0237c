//! `motorlab motor`: a motor file as a template, or a motor file with all defaults.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::motor_file::motor_file;
use super::motor_template::template;
use super::output_file::{Force, Form};
use super::resistance::Resistance;
use super::{Failure, Output, Status};
use crate::motor::{Motor, Parameters};

/// Write a commented motor file, or print one with all defaults.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab motor --template -o motor.toml\n  motorlab motor motor.toml\n  motorlab motor motor.toml --json\n  motorlab motor diagnosed.toml --resistance 3.1 -o measured.toml"
)]
pub struct MotorFile {
    /// Motor file: it is printed whole, with what it leaves out. [default: the lab handout's motor]
    #[arg(value_name = "FILE", conflicts_with = "template")]
    file: Option<PathBuf>,
    /// Every key with its unit and the lab handout's number, tolerances and all effects commented out.
    #[arg(long)]
    template: bool,
    #[command(flatten)]
    resistance: Resistance,
    /// File to write; without it the motor file goes to standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    parameters: Parameters,
    tolerance: &'a BTreeMap<String, f64>,
    effects: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    /// The motor file.
    text: &'a str,
}

impl MotorFile {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self.force.outputs("motor", &self.file);
        outputs.check(&self.output)?;
        let motor = match &self.file {
            Some(path) => motor_file(path, output)?,
            None => Motor::default(),
        };
        let motor = self.resistance.of(motor);
        let text = if self.template {
            template()
        } else {
            motor.to_toml()
        };
        if let Some(path) = &self.output {
            outputs.write(path, &text, Form::Toml, output)?;
        }
        if output.json {
            let effects = motor.effects.iter().map(|effect| {
                let numbers = effect.parameters().map(|(p, value)| (p.key, value));
                (effect.kind().id, numbers.collect())
            });
            output.document(&Document {
                shape: "motorlab-motor-facts/1",
                parameters: motor.parameters,
                tolerance: &motor.tolerance,
                effects: effects.collect(),
                text: &text,
            })?;
        } else if self.output.is_none() {
            output.line(text.trim_end())?;
        }
        Ok(Status::Done)
    }
}
