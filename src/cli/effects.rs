//! `motorlab effects`: the catalogue of effects, stage by stage.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::motor_file::motor_file;
use super::{Failure, Output, Status};
use crate::diagnose::is_parameter_change;
use crate::effects::{Entry, Number, entries, rounded};
use crate::motor::catalogue::{Stage, catalogue};
use crate::motor::plausible::Shown;
use crate::motor::{Parameters, nearest_name};

/// List the effects: equation, parameters, the experiment that shows each, and similar effects.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Effects {
    /// One effect, or one stage: command, driver, electrical, mechanical, transmission, sensor, timing.
    /// [default: all]
    #[arg(value_name = "ID")]
    id: Option<String>,
    /// Motor file: ranges and defaults are those of this motor. [default: the lab handout's motor]
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
}

const EXAMPLE: &str = "Examples:
  motorlab effects
  motorlab effects transmission
  motorlab effects backlash --motor motor.toml
  motorlab effects stribeck --json

In the profile that is named the effect shows at its default strength: no motor without it makes
the same run, whatever its gain, time constant and friction. docs/reference/effects.md is the same list.";

#[derive(Debug, Serialize)]
struct Document {
    shape: &'static str,
    parameters: Parameters,
    effects: Vec<Entry>,
}

impl Effects {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let motor = match &self.motor {
            Some(path) => motor_file(path, output)?,
            None => Default::default(),
        };
        let mut effects = entries(&motor.parameters);
        if let Some(id) = &self.id {
            effects.retain(|entry| entry.effect == id || entry.stage.id() == id);
            if effects.is_empty() {
                return Err(unknown(id));
            }
        }
        if output.json {
            output.document(&Document {
                shape: "motorlab-effects/1",
                parameters: motor.parameters,
                effects,
            })?;
            return Ok(Status::Done);
        }
        let alone = effects.len() == 1;
        let blocks = Stage::ALL.iter().filter_map(|stage| {
            let of_stage = effects.iter().filter(|entry| entry.stage == *stage);
            let blocks: Vec<String> = of_stage.map(|entry| block(entry, alone)).collect();
            (!blocks.is_empty()).then(|| format!("{stage}\n\n{}", blocks.join("\n")))
        });
        let text: Vec<String> = blocks.collect();
        output.line(text.join("\n").trim_end())?;
        Ok(Status::Done)
    }
}

fn unknown(id: &str) -> Failure {
    let ids = catalogue().iter().map(|kind| kind.id);
    let names = ids.chain(Stage::ALL.map(Stage::id));
    let meant =
        nearest_name(id, names).map_or_else(String::new, |name| format!("did you mean '{name}'? "));
    let stages = Stage::ALL.map(Stage::id).join(", ");
    Failure::wrong(
        format!("there is no effect and no stage '{id}'"),
        format!("{meant}`motorlab effects` lists the effects; the stages are {stages}"),
    )
}

fn block(entry: &Entry, with_example: bool) -> String {
    let mut text = format!("  {}: {}\n", entry.effect, entry.summary);
    let mut say = |what: &str, words: &str| {
        let _ = writeln!(text, "    {what:<14}{words}");
    };
    if is_parameter_change(entry.effect) {
        say("kind", "a parameter change beyond tolerance");
    }
    say("equation", entry.equation);
    let mut label = "parameters";
    for number in &entry.parameters {
        say(label, &words_of(number));
        label = "";
    }
    say("shows in", entry.excited_by);
    if !entry.confused_with.is_empty() {
        say("confused with", &entry.confused_with.join(", "));
    }
    let experiment = &entry.experiment;
    let flags = format!(
        "--profile {} --duration {} --ts {}",
        experiment.profile, experiment.duration_s, experiment.sample_time_s
    );
    say("shown by", &flags);
    if let Some(why) = entry.not_identifiable {
        say(
            "caution",
            &format!("not identifiable from voltage and counts: {why}"),
        );
    }
    if with_example {
        let id = entry.effect;
        say(
            "try it",
            &format!("motorlab capture 'virtual:?effect={id}&speed=max' {flags} -o {id}.csv"),
        );
    }
    text
}

fn words_of(number: &Number) -> String {
    let short = |value| Shown(rounded(value));
    let unit = if number.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", number.unit)
    };
    let range = match number.one_of {
        Some(values) => {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            values.join(", ")
        }
        None => format!("{} .. {}", short(number.lo), short(number.hi)),
    };
    format!(
        "{} = {}{unit} (plausible: {range}{unit})",
        number.key,
        short(number.default)
    )
}
