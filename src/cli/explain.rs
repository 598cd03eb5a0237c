//! `motorlab explain`: the page of one effect, as docs/reference/effects has it.

use clap::Args;
use serde::Serialize;

use super::{Failure, Output, Status};
use crate::motor::catalogue::{Stage, catalogue, find};
use crate::motor::nearest_name;

/// Print the page of an effect: description, symptoms, causes, alternatives, model, references.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab explain backlash\n  motorlab explain supply_sag --json\n\nThe pages with pictures are in docs/reference/effects. `motorlab effects` lists all effects."
)]
pub struct Explain {
    /// Id of an effect, such as backlash.
    #[arg(value_name = "EFFECT")]
    effect: String,
}

macro_rules! pages {
    ($($id:literal),* $(,)?) => {
        &[$(($id, include_str!(concat!("../../docs/reference/effects/", $id, ".md")))),*]
    };
}

/// Pages by effect, in the order of the catalogue.
const PAGES: &[(&str, &str)] = pages![
    "transport_delay",
    "command_offset",
    "dead_zone",
    "asymmetric_dead_zone",
    "voltage_drop",
    "asymmetric_voltage_drop",
    "supply_sag",
    "supply_error",
    "asymmetric_gain",
    "current_limit",
    "coast_at_zero",
    "pwm_freewheel",
    "inductance",
    "winding_heating",
    "magnet_weakening",
    "torque_ripple",
    "coulomb_friction",
    "viscous_friction",
    "asymmetric_viscous",
    "inertia",
    "stribeck",
    "asymmetric_friction",
    "static_friction",
    "presliding",
    "load_friction",
    "quadratic_drag",
    "gravity_load",
    "constant_load",
    "cogging",
    "backlash",
    "compliance",
    "slipping_clutch",
    "resolution_error",
    "missed_counts",
    "edge_rate_loss",
    "encoder_eccentricity",
    "speed_filter",
    "sample_jitter",
    "clock_error",
];

#[derive(Debug, Serialize)]
struct Document {
    shape: &'static str,
    effect: &'static str,
    stage: Stage,
    sections: Vec<Section>,
}

#[derive(Debug, Serialize)]
struct Section {
    heading: String,
    text: String,
}

impl Explain {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let found = PAGES.iter().find(|(id, _)| *id == self.effect);
        let (Some((id, page)), Some((_, kind))) = (found, find(&self.effect)) else {
            return Err(unknown(&self.effect));
        };
        if output.json {
            output.document(&Document {
                shape: "motorlab-explanation/1",
                effect: id,
                stage: kind.stage,
                sections: sections(page),
            })?;
        } else {
            output.line(plain_text(page).trim_end())?;
        }
        Ok(Status::Done)
    }
}

fn unknown(name: &str) -> Failure {
    let hint = nearest_name(name, catalogue().iter().map(|kind| kind.id));
    let hint = hint.map_or_else(
        || "`motorlab effects` lists the effects".to_owned(),
        |id| format!("motorlab explain {id}"),
    );
    Failure::wrong(format!("there is no effect '{name}'"), hint)
}

/// Sections at headings of second level.
fn sections(page: &str) -> Vec<Section> {
    let parts = page.split("\n## ").skip(1);
    parts
        .filter_map(|part| part.split_once('\n'))
        .map(|(heading, text)| Section {
            heading: heading.to_owned(),
            text: plain_text(text).trim().to_owned(),
        })
        .collect()
}

/// Markdown for a terminal: without pictures and fences, code indented, links as text.
fn plain_text(markdown: &str) -> String {
    let mut in_code = false;
    let mut out = String::new();
    for line in markdown.lines() {
        if line.starts_with("```") {
            in_code = !in_code;
        } else if in_code {
            out.push_str("    ");
            out.push_str(line);
            out.push('\n');
        } else if !line.starts_with("![") {
            out.push_str(&without_targets(line));
            out.push('\n');
        }
    }
    while out.contains("\n\n\n") {
        out = out.replace("\n\n\n", "\n\n");
    }
    out
}

fn without_targets(line: &str) -> String {
    let mut parts = line.split("](");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        if let Some(open) = out.rfind('[') {
            out.remove(open);
        }
        out.push_str(part.split_once(')').map_or(part, |(_, rest)| rest));
    }
    out
}
