//! `motorlab names`: names for arguments, also for shell completion.

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::completing::completing;
use super::virtual_spec::BOARD_KEYS;
use super::{Failure, Output, Status};
use crate::board::BUILT_IN;
use crate::board::text_lines::Column;
use crate::motor::Parameters;
use crate::motor::catalogue::{EffectKind, catalogue};

/// Shares of the supply proposed after a profile's name: those that `diagnose` requests.
pub(super) const SHARES: [&str; 6] = ["0.1", "0.15", "0.2", "0.3", "0.4", "0.5"];
/// Durations proposed after it.
pub(super) const TIMES: [&str; 4] = ["4s", "8s", "15s", "30s"];

/// List the names of profiles, columns, effects with their parameters, and keys of a virtual board.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab names\n  motorlab names profiles\n  motorlab names effects --json"
)]
pub struct Names {
    /// One kind of names. [default: all]
    #[arg(value_enum)]
    kind: Option<Kind>,

    /// Of a shell: print what can stand behind this word, a line each, beginning as TYPED does.
    #[arg(long, value_name = "WORD", hide = true, allow_hyphen_values = true, conflicts_with_all = ["kind", "json"])]
    completing: Option<String>,

    /// Typed part of the word.
    #[arg(last = true, hide = true, requires = "completing", default_value = "")]
    typed: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Values of `--profile`.
    Profiles,
    /// Values of `--columns`.
    Columns,
    /// Effects and their parameters, as after `virtual:?effect=` and in a motor file.
    Effects,
    /// Keys of a virtual board, as after `virtual:?`.
    Keys,
}

#[derive(Debug, Serialize)]
struct Document {
    shape: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    profiles: Vec<Named>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    columns: Vec<Named>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    effects: Vec<Named>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    keys: Vec<Named>,
}

#[derive(Debug, Serialize)]
struct Named {
    name: &'static str,
    what: String,
    /// For an effect.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parameters: Vec<&'static str>,
}

impl Named {
    fn of(name: &'static str, what: impl Into<String>) -> Self {
        Self {
            name,
            what: what.into(),
            parameters: Vec::new(),
        }
    }
}

pub(super) fn parameters_of(kind: &EffectKind) -> Vec<&'static str> {
    kind.parameters
        .iter()
        .map(|parameter| parameter.key)
        .collect()
}

impl Names {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        if let Some(before) = &self.completing {
            for word in completing(before, &self.typed) {
                output.line(&word)?;
            }
            return Ok(Status::Done);
        }
        let is = |kind| self.kind.is_none_or(|asked| asked == kind);
        let all = |kind, of: fn() -> Vec<Named>| if is(kind) { of() } else { Vec::new() };
        let document = Document {
            shape: "motorlab-names/1",
            profiles: all(Kind::Profiles, profiles),
            columns: all(Kind::Columns, columns),
            effects: all(Kind::Effects, effects),
            keys: all(Kind::Keys, keys),
        };
        if output.json {
            output.document(&document)?;
            return Ok(Status::Done);
        }
        let shares = format!(
            "profiles, for --profile NAME[@SHARE][,SECONDSs]: a share of the supply ({}, up to 1), a time ({})",
            SHARES.join(", "),
            TIMES.join(", ")
        );
        let mut blocks = Vec::new();
        for (title, names) in [
            (shares.as_str(), &document.profiles),
            ("columns, for --columns NAME,NAME,...", &document.columns),
            (
                "effects and their parameters, for virtual:?effect=NAME&PARAMETER=VALUE and motor files (motorlab effects tells more)",
                &document.effects,
            ),
            (
                "further keys of a virtual board, for virtual:?KEY=VALUE&KEY=VALUE",
                &document.keys,
            ),
        ] {
            if !names.is_empty() {
                blocks.push(format!("{title}\n{}", lines(names)));
            }
        }
        output.line(&blocks.join("\n\n"))?;
        Ok(Status::Done)
    }
}

fn lines(names: &[Named]) -> String {
    let widest = names
        .iter()
        .map(|named| named.name.len())
        .max()
        .unwrap_or(0);
    let line = |named: &Named| match named.parameters.as_slice() {
        [] => format!("  {:<widest$}  {}", named.name, named.what),
        keys => format!(
            "  {:<widest$}  {} ({})",
            named.name,
            named.what,
            keys.join(", ")
        ),
    };
    let lines: Vec<String> = names.iter().map(line).collect();
    lines.join("\n")
}

fn profiles() -> Vec<Named> {
    BUILT_IN.map(|(name, what)| Named::of(name, what)).into()
}

fn columns() -> Vec<Named> {
    let columns = Column::printed().into_iter();
    columns
        .map(|column| Named::of(column.name(), column.meaning()))
        .collect()
}

fn effects() -> Vec<Named> {
    let named = |kind: &'static EffectKind| Named {
        parameters: parameters_of(kind),
        ..Named::of(kind.id, kind.summary)
    };
    catalogue().iter().map(named).collect()
}

fn keys() -> Vec<Named> {
    let parameters = Parameters::KEYS.map(|key| Named::of(key, "number of the motor"));
    let board = BOARD_KEYS.map(|(key, what)| Named::of(key, what));
    board.into_iter().chain(parameters).collect()
}
