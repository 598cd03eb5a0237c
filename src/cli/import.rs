//! `motorlab import`: converts a log of another program to a run file.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::capture::capture_failure;
use super::findings::check_written;
use super::import_flags::Flags;
use super::import_words::{print_understood, say};
use super::output_file::{Force, Form, Outputs};
use super::progress::FileProgress;
use super::staged::Staged;
use super::{Failure, Output, Status};
use crate::check::Finding;
use crate::hint::In;
use crate::import::{
    ImportProblem, Imported, Map, Reading, Ready, Source, SourceError, Understood, import, map_over,
};
use crate::plain::{quoted, shown};
use crate::recording::{next_free_name, refuse_no_file};

/// Convert a log of another program into a run file: by the names of its columns, by flags, or by a mapping file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Import {
    /// The log: text in columns, plain or gzipped; Parquet, MCAP, a ROS 2 bag (.db3), WPILOG, SysId JSON or MAT; - is
    /// standard input.
    log: PathBuf,
    /// Mapping file: columns and their units. A flag takes precedence over it.
    #[arg(long, value_name = "MAP.toml")]
    map: Option<PathBuf>,
    #[command(flatten)]
    flags: Flags,
    /// Write the mapping file that does the same for the next log of this kind.
    #[arg(long, value_name = "FILE")]
    save_map: Option<PathBuf>,
    /// Where the run goes. An existing file is not overwritten, unless with --force: the next free name is taken.
    /// [default: the log's name with .run.csv, in the working directory]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

const EXAMPLE: &str = "Examples:
  motorlab import log.csv                               # names and units are recognised, and shown
  motorlab import log.csv --supply 12 --counts-per-rev 720
  motorlab import log.csv --speed rpm_left --supply 12  # which of two motors
  motorlab import step_12V.csv --speed 2:rpm --command 12V@0.5s   # no names; 12 V from 0.5 s on
  motorlab import bag_0.mcap --position '/joint_states.position[0]' --command /motor_voltage.data:V
  motorlab import log.csv --supply 12 --save-map map.toml
  motorlab import next.csv.gz --map map.toml -o run.csv

What the log does not say is asked for in one message, with the finished command line. Every key of a
mapping file: docs/reference/import.md. Rows that cannot be used are named by their line and kept in
run.rejected.csv; the exit status is then 1, and where the run contradicts itself (motorlab check).";

#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    #[serde(flatten)]
    imported: &'a Imported,
    /// Empty with a mapping file.
    understood: &'a [Understood],
    notes: &'a [String],
    findings: &'a [Finding],
}

impl Import {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self
            .force
            .outputs("import", [&self.log].into_iter().chain(&self.map));
        outputs.check(&self.save_map)?;
        let standard_input = self.log.as_os_str() == "-";
        let name = match self.log.file_name() {
            Some(name) if !standard_input => name.to_string_lossy().into_owned(),
            _ => "standard input".to_owned(),
        };
        let mapped = match &self.map {
            Some(map) => Some(self.mapping_file(map)?),
            None => None,
        };
        let bytes: Box<dyn Read> = if standard_input {
            Box::new(io::stdin().lock())
        } else {
            Box::new(FileProgress::new(open(&self.log)?, &name))
        };
        let at = |failure: Failure| match standard_input {
            true => failure,
            false => failure.at(&self.log),
        };
        let unread = |error: SourceError| Failure::input(In::new(&*name, error));
        let mut source = Source::new(bytes, &name).map_err(|error| at(unread(error)))?;
        let mut reading = None;
        let map = match mapped {
            Some(map) => source.fitted(map),
            None => {
                let found = source.understand(&name, &self.flags.given(), &self.line());
                let found = found.map_err(|error| unread(error.into()))?;
                let Reading {
                    understood,
                    notes,
                    map,
                } = found;
                print_understood(output, &name, &understood, &notes);
                let ready = map.map_err(|unclear| at(Failure::input(In::new(&*name, unclear))))?;
                reading = Some((understood, notes));
                ready
            }
        };
        let target = self.target();
        refuse_no_file(&target).map_err(capture_failure)?;
        let staged = Staged::of(self.force, &outputs, &target)?;
        let free = next_free_name(&target);
        if staged.is_none() && free != target && self.output.is_some() {
            output.message(&format!(
                "{} exists, and the run goes to {}\nhint: --force replaces it",
                shown(&target),
                shown(&free)
            ));
        }
        let written = staged.as_ref().map_or(&target, |staged| staged.run());
        let mut imported = import(source.read(), &name, &map.map, written).map_err(|error| {
            match error.problem {
                ImportProblem::Write(_) | ImportProblem::Rejected { .. } => Failure::device(error),
                _ if standard_input => Failure::input(error),
                _ => Failure::input(error).at(&self.log),
            }
        })?;
        if let Some(staged) = &staged {
            let runs = imported.runs.iter_mut().map(|run| &mut run.path);
            staged.take_place(&outputs, runs.chain(&mut imported.rejected))?;
        }
        say(output, &name, &imported);
        self.save(&outputs, &map.toml, output)?;
        let paths: Vec<&Path> = imported.runs.iter().map(|run| run.path.as_path()).collect();
        let (findings, contradicts) = check_written(&paths, output);
        if output.json {
            let (understood, notes) = reading.unwrap_or_default();
            output.document(&Document {
                shape: "motorlab-import/1",
                imported: &imported,
                understood: &understood,
                notes: &notes,
                findings: &findings,
            })?;
        } else {
            for run in &imported.runs {
                output.line(&shown(&run.path))?;
            }
        }
        Ok(if imported.bad_rows > 0 || contradicts {
            Status::FellShort
        } else {
            Status::Done
        })
    }

    /// The mapping file with the flags that replace its entries.
    fn mapping_file(&self, path: &Path) -> Result<Ready, Failure> {
        let text = Map::text(path).map_err(Failure::input)?;
        let in_file = |error| Failure::input(Map::in_file(path, error));
        if self.flags.is_given() || self.save_map.is_some() {
            let failed = |unclear| match unclear {
                crate::import::Unclear::Map(error) => in_file(error),
                unclear => Failure::input(unclear),
            };
            return map_over(&text, &self.flags.given()).map_err(failed);
        }
        let map = Map::from_toml(&text).map_err(in_file)?;
        Ok(Ready { map, toml: text })
    }

    /// The command line so far, for the message about missing facts.
    fn line(&self) -> String {
        // A path with a leading dash would be parsed as a flag.
        let path = |path: &Path| match path.display().to_string() {
            text if text.starts_with('-') && text != "-" => quoted(&format!("./{text}")),
            text => quoted(&text),
        };
        let mut line = format!("motorlab import {}", path(&self.log));
        for (flag, value) in [("-o", &self.output), ("--save-map", &self.save_map)] {
            if let Some(value) = value {
                line.push_str(&format!(" {flag} {}", path(value)));
            }
        }
        if self.force.is_given() {
            line.push_str(" --force");
        }
        line
    }

    fn save(&self, outputs: &Outputs, toml: &str, output: &Output) -> Result<(), Failure> {
        match &self.save_map {
            Some(path) => outputs.write(path, toml, Form::Toml, output),
            None => Ok(()),
        }
    }

    fn target(&self) -> PathBuf {
        if let Some(output) = &self.output {
            return output.clone();
        }
        run_name(&self.log)
    }
}

/// Default name of a log's run.
pub(super) fn run_name(log: &Path) -> PathBuf {
    let name = match log.file_name() {
        Some(name) if log.as_os_str() != "-" => Path::new(name),
        _ => Path::new("log"),
    };
    let name = match name.extension() {
        Some(extension) if extension == "gz" => Path::new(name.file_stem().unwrap_or_default()),
        _ => name,
    };
    name.with_extension("run.csv")
}

/// Opens a log. For a folder of a ROS 2 bag the error names the file in it.
pub(super) fn open(path: &Path) -> Result<File, Failure> {
    let failed = |error: io::Error| Failure::input(In::new(shown(path), error));
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        let is_bag = |path: &PathBuf| {
            path.extension()
                .is_some_and(|end| end == "db3" || end == "mcap")
        };
        let mut inside = std::fs::read_dir(path).map_err(failed)?;
        let bag = inside.find_map(|entry| entry.ok().map(|entry| entry.path()).filter(is_bag));
        return Err(match bag {
            Some(bag) => Failure::wrong(
                format!("{} is a folder", shown(path)),
                format!("of this ROS 2 bag import {}", shown(bag)),
            ),
            None => failed(io::ErrorKind::IsADirectory.into()),
        });
    }
    Ok(file)
}
