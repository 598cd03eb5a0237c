//! `motorlab design`: which effects a planned profile separates, and the next experiment of a diagnosis.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;

use super::motor_choice::MotorChoice;
use super::numbers::{duration_s, sample_time_s, supply_v};
use super::output_file::{Force, Form};
use super::progress::{set_share, spinner};
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::board::Profile;
use crate::diagnose::{Isolability, NextExperiment, Pair, Plan, SHAPE, Settings, isolability};
use crate::plain::{quoted, shown};
use crate::report::diagnosis::hypotheses;
use crate::report::isolability::{CLEAR, page};

/// List the effects that a profile cannot show and the pairs that it cannot separate, before it is recorded.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab design --profile step --ts 0.03 --duration 4\n  motorlab design --motor motor.toml --profile reversing --duration 15 --json\n  motorlab design --profile reversing --html design.html\n  motorlab diagnose run.csv --json > why.json && motorlab design --diagnosis why.json"
)]
pub struct Design {
    #[command(flatten)]
    motor: MotorChoice,
    /// Command profile: a built-in profile (`crawl@0.25,8s`: a quarter of the supply, 8 s), or a
    /// file of rows `t_s,command_v`.
    #[arg(long, default_value = "step")]
    profile: String,
    /// Sample time in s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.003, value_parser = sample_time_s)]
    ts: f64,
    /// Duration in s. [default: the profile's own, else 4]
    #[arg(long, value_name = "SECONDS", value_parser = duration_s)]
    duration: Option<f64>,
    /// Driver supply in V, if not the motor file's.
    #[arg(long, value_name = "VOLTS", value_parser = supply_v)]
    supply: Option<f64>,
    /// Print the next experiment of this diagnosis (the JSON of `diagnose`) instead.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["profile", "ts", "duration", "supply"])]
    diagnosis: Option<PathBuf>,
    /// Write the separations as one HTML page with a heatmap.
    #[arg(long, value_name = "FILE", conflicts_with = "diagnosis")]
    html: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    threads: Threads,
}

const DURATION_S: f64 = 4.0;
/// Most samples of a plan.
const MOST_SAMPLES: f64 = 200_000.0;
/// Longest diagnosis read, in bytes.
const MOST_BYTES: u64 = 1 << 26;
/// Earlier versions of the document in which the next experiment has the same keys.
const EARLIER_SHAPES: [&str; 2] = ["motorlab-diagnosis/1", "motorlab-diagnosis/2"];

#[derive(Debug, Deserialize)]
struct Diagnosed {
    shape: String,
    #[serde(default)]
    verdict: String,
    #[serde(default)]
    sentence: String,
    next_experiment: Option<NextExperiment>,
}

impl Design {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        if let Some(path) = &self.diagnosis {
            return next_of(path, output);
        }
        let inputs = self.motor.file().into_iter();
        let outputs = self.force.outputs("design", inputs);
        outputs.check(&self.html)?;
        let mut motor = self.motor.motor(output)?;
        if let Some(supply_v) = self.supply {
            motor.parameters.supply_v = supply_v;
        }
        let built_in_s = self.duration.unwrap_or(DURATION_S);
        let supply_v = motor.parameters.supply_v;
        let profile =
            Profile::named(&self.profile, supply_v, built_in_s).map_err(Failure::input)?;
        let duration_s = self.duration.unwrap_or_else(|| profile.duration_s());
        let samples = duration_s / self.ts;
        if !(2.0..=MOST_SAMPLES).contains(&samples) {
            return Err(Failure::wrong(
                format!("{samples:.0} samples: a plan has 2 to {MOST_SAMPLES}"),
                "change --duration or --ts",
            ));
        }
        let plan = Plan {
            profile,
            sample_time_s: self.ts,
            duration_s,
        };
        let spinner = spinner();
        spinner.set_message("simulating every effect on the profile");
        let found = isolability(&motor, &plan, &Settings::default(), &|share| {
            set_share(&spinner, share);
        });
        spinner.finish_and_clear();
        let found = found.ok_or_else(|| {
            Failure::wrong(
                "the motor cannot be simulated on this profile",
                "`motorlab motor FILE` lists its parameters with their units",
            )
        })?;
        if let Some(path) = &self.html {
            outputs.write(path, &page(&found, &self.capture()), Form::Markup, output)?;
        }
        if output.json {
            output.document(&found)?;
        } else {
            show(&found, output)?;
        }
        Ok(Status::Done)
    }

    /// The command line that records the plan.
    fn capture(&self) -> String {
        let duration = self.duration.map(|s| format!(" --duration {s}"));
        format!(
            "motorlab capture PORT --profile {} --ts {}{} -o run.csv",
            quoted(&self.profile),
            self.ts,
            duration.unwrap_or_default()
        )
    }
}

fn show(found: &Isolability, output: &Output) -> Result<(), Failure> {
    output.line(&format!(
        "{} at {} V, {} samples every {} s\n",
        found.profile, found.supply_v, found.samples, found.sample_time_s
    ))?;
    let n = found.effects.len();
    let tens: String = (0..n).map(|j| mark_of(j, 10)).collect();
    let ones: String = (0..n).map(|j| mark_of(j, 1)).collect();
    output.line(&format!("{:>26} {tens}\n{:>26} {ones}", "", ""))?;
    for (i, effect) in found.effects.iter().enumerate() {
        let cells: String = (0..n)
            .map(|j| match found.between(i, j) {
                _ if i == j => '\\',
                d if d < found.tie_below => '#',
                d if d < CLEAR => '+',
                _ => '.',
            })
            .collect();
        output.line(&format!("{i:>2} {effect:<23} {cells}"))?;
    }
    output.line(&format!(
        "\n#  not separable (separation D below {})   +  just (D below {CLEAR})   .  clearly",
        found.tie_below
    ))?;
    let hidden = |pair: &Pair| format!("{} (D {:.1})", pair.a, pair.separation);
    list(
        output,
        "not visible",
        found.cannot_see.iter().map(hidden).collect(),
    )?;
    let alike = |pair: &Pair| format!("{} from {} (D {:.1})", pair.a, pair.b, pair.separation);
    let pairs = found.cannot_tell_apart.iter().map(alike).collect();
    list(output, "not separable", pairs)
}

/// A digit of a column's number, without leading zeros.
fn mark_of(column: usize, place: usize) -> char {
    match (column / place % 10, column < place && place > 1) {
        (_, true) => ' ',
        (digit, _) => char::from(b'0' + digit as u8),
    }
}

fn list(output: &Output, what: &str, items: Vec<String>) -> Result<(), Failure> {
    if items.is_empty() {
        return output.line(&format!("{what}: none"));
    }
    output.line(&format!("{what}:"))?;
    for item in items {
        output.line(&format!("  {item}"))?;
    }
    Ok(())
}

/// The next experiment as text.
fn next_line(next: &NextExperiment) -> String {
    let what = match next.tells_apart.as_slice() {
        [one] => format!("shows whether {one} is present"),
        several => format!("separates these hypotheses: {}", hypotheses(several)),
    };
    let bench = next.change.as_ref();
    let bench = bench.map_or(String::new(), |change| format!(" with {}", change.words()));
    let then = next
        .change
        .as_ref()
        .and_then(|change| change.flag("next.csv"));
    let then = then.map_or(String::new(), |flag| {
        format!("\n  then: motorlab diagnose RUN... next.csv {flag}")
    });
    format!(
        "record next{bench}: {}\n  it {what} (expected separation D {:.1}){then}",
        next.command, next.expected_separation
    )
}

fn next_of(path: &Path, output: &Output) -> Result<Status, Failure> {
    let wrong = |why: &dyn std::fmt::Display| {
        Failure::wrong(
            format!("{}: {why}", shown(path)),
            "`motorlab diagnose RUN --json` writes a diagnosis",
        )
    };
    let mut text = String::new();
    let file = File::open(path).map_err(|error| wrong(&error))?;
    file.take(MOST_BYTES)
        .read_to_string(&mut text)
        .map_err(|error| wrong(&error))?;
    let diagnosed: Diagnosed = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    if diagnosed.verdict == "bad_recording" {
        return Err(wrong(&format!(
            "a diagnosis of a bad recording proposes no experiment: {}",
            diagnosed.sentence
        )));
    }
    let shape = diagnosed.shape.as_str();
    if shape != SHAPE && !EARLIER_SHAPES.contains(&shape) {
        return Err(wrong(&format!("its shape is '{shape}'")));
    }
    if output.json {
        output.document(&diagnosed.next_experiment)?;
    } else {
        output.line(&match &diagnosed.next_experiment {
            Some(next) => next_line(next),
            None => {
                "no next experiment: no further recording would separate the sets that are left"
                    .to_owned()
            }
        })?;
    }
    Ok(Status::Done)
}
