//! `motorlab schema`: the JSON Schema of every document.

use clap::Args;
use serde::Serialize;
use serde_json::Value;

use super::{Failure, Output, Status};
use crate::motor::nearest_name;

/// Print the JSON Schema of a document, or list the documents.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab schema\n  motorlab schema diagnosis > diagnosis.schema.json\n\nUnits stand in the names of keys and in the descriptions. A reader ignores keys that it does not know: more may come."
)]
pub struct Schema {
    /// Name of a document. [default: they are listed]
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Every document of `--json` in alphabetical order; the files are those of `docs/json`.
const DOCUMENTS: [(&str, &str); 28] = [
    ("blind-run", include_str!("../../docs/json/blind-run.json")),
    (
        "blind-score",
        include_str!("../../docs/json/blind-score.json"),
    ),
    (
        "blind-sealed",
        include_str!("../../docs/json/blind-sealed.json"),
    ),
    ("capture", include_str!("../../docs/json/capture.json")),
    ("check", include_str!("../../docs/json/check.json")),
    ("class", include_str!("../../docs/json/class.json")),
    (
        "comparison",
        include_str!("../../docs/json/comparison.json"),
    ),
    ("demo", include_str!("../../docs/json/demo.json")),
    ("diagnosis", include_str!("../../docs/json/diagnosis.json")),
    ("effects", include_str!("../../docs/json/effects.json")),
    ("error", include_str!("../../docs/json/error.json")),
    (
        "explanation",
        include_str!("../../docs/json/explanation.json"),
    ),
    ("export", include_str!("../../docs/json/export.json")),
    (
        "export-json",
        include_str!("../../docs/json/export-json.json"),
    ),
    ("firmware", include_str!("../../docs/json/firmware.json")),
    ("flash", include_str!("../../docs/json/flash.json")),
    ("import", include_str!("../../docs/json/import.json")),
    (
        "isolability",
        include_str!("../../docs/json/isolability.json"),
    ),
    ("lab", include_str!("../../docs/json/lab.json")),
    ("motor", include_str!("../../docs/json/motor.json")),
    ("names", include_str!("../../docs/json/names.json")),
    (
        "next-experiment",
        include_str!("../../docs/json/next-experiment.json"),
    ),
    ("port", include_str!("../../docs/json/port.json")),
    ("ports", include_str!("../../docs/json/ports.json")),
    ("schemas", include_str!("../../docs/json/schemas.json")),
    (
        "simulation",
        include_str!("../../docs/json/simulation.json"),
    ),
    ("table", include_str!("../../docs/json/table.json")),
    (
        "until-known",
        include_str!("../../docs/json/until-known.json"),
    ),
];

pub(super) fn documents() -> impl Iterator<Item = &'static str> {
    DOCUMENTS.iter().map(|(name, _)| *name)
}

#[derive(Debug, Serialize)]
struct List {
    shape: &'static str,
    documents: Vec<Entry>,
}

#[derive(Debug, Serialize)]
struct Entry {
    name: &'static str,
    title: String,
    document_shape: Option<String>,
}

impl Entry {
    fn of(name: &'static str, schema: &Value) -> Self {
        let keys = ["shape", "format"].map(|key| &schema["properties"][key]["const"]);
        Self {
            name,
            title: schema["title"].as_str().unwrap_or_default().to_owned(),
            document_shape: keys.into_iter().find_map(Value::as_str).map(str::to_owned),
        }
    }
}

impl Schema {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        match &self.name {
            Some(name) => {
                let known = DOCUMENTS.iter().find(|(known, _)| known == name);
                let (_, text) = known.ok_or_else(|| unknown(name))?;
                output.line(text.trim_end())?;
            }
            None => list(output)?,
        }
        Ok(Status::Done)
    }
}

fn list(output: &Output) -> Result<(), Failure> {
    let entry = |(name, text): &(&'static str, &str)| {
        let schema = serde_json::from_str(text).map_err(Failure::input)?;
        Ok(Entry::of(name, &schema))
    };
    let documents = DOCUMENTS.iter().map(entry).collect::<Result<Vec<_>, _>>()?;
    if output.json {
        return output.document(&List {
            shape: "motorlab-schemas/1",
            documents,
        });
    }
    for Entry { name, title, .. } in documents {
        output.line(&format!("{name:<16} {title}"))?;
    }
    Ok(())
}

fn unknown(name: &str) -> Failure {
    let known = DOCUMENTS.iter().map(|(known, _)| *known);
    let meant = nearest_name(name, known)
        .map_or(String::new(), |known| format!("did you mean '{known}'? "));
    Failure::wrong(
        format!("there is no document '{name}'"),
        format!("{meant}`motorlab schema` lists them"),
    )
    .of_kind("wrong_use")
}
