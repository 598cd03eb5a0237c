//! `motorlab import`: turn a log that another program wrote into a run file.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::capture::capture_failure;
use super::findings::check_written;
use super::{Failure, Output, Status};
use crate::check::Finding;
use crate::import::{ImportProblem, Imported, Map, import};
use crate::plain::shown;
use crate::recording::{next_free_name, refuse_no_file};

/// Turn a log that another program wrote into a run file, by a small mapping file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Import {
    /// The log: text in columns, plain or gzipped; - is standard input.
    log: PathBuf,
    /// Mapping file: which column is what, and in which unit.
    #[arg(long, value_name = "MAP.toml")]
    map: PathBuf,
    /// Where the run goes. An existing file is not overwritten: the next free name is taken.
    /// [default: the log's name with .run.csv, in the working directory]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

const EXAMPLE: &str = r#"Example: a log with the line of names `millis;pwm;angle_deg`, and map.toml:

  counts_per_rev = 720            # of the run: the encoder's, x4 decoded
  supply_v = 7.4

  [time]
  column = "millis"
  unit = "ms"                     # s, ms, us, ns, min, h; 12:34:56.789 and dates: stamp

  [command]
  column = "pwm"
  unit = "pwm"                    # or V, mV, A, mA, N m, percent, share
  full = 255                      # this number is full drive, supply_v

  [position]                      # or [speed]: integrated, and marked so
  column = "angle_deg"            # or its number, the first is 1
  unit = "deg"                    # counts, rev, rad, deg; m, mm with m_per_rev
  wrap = 360                      # the angle starts again at 0 there

  motorlab import log.csv.gz --map map.toml -o run.csv

Delimiter, decimal commas, header lines, scales, currents, measured supplies, linear axes, signals of
different rates and logs of many runs: docs/import.md. Rows that cannot be used are named by their line and kept in
run.rejected.csv; the exit status is then 1, and where the run contradicts itself (motorlab check)."#;

/// For `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    shape: &'static str,
    #[serde(flatten)]
    imported: &'a Imported,
    findings: &'a [Finding],
}

impl Import {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let map = Map::read(&self.map).map_err(Failure::input)?;
        let standard_input = self.log.as_os_str() == "-";
        let name = match self.log.file_name() {
            Some(name) if !standard_input => name.to_string_lossy().into_owned(),
            _ => "standard input".to_owned(),
        };
        let target = self.target();
        refuse_no_file(&target).map_err(capture_failure)?;
        let free = next_free_name(&target);
        if free != target && self.output.is_some() {
            output.message(&format!(
                "{} exists; the run goes to {}",
                shown(&target),
                shown(&free)
            ));
        }
        let source: Box<dyn Read> = if standard_input {
            Box::new(io::stdin().lock())
        } else {
            Box::new(open(&self.log)?)
        };
        let imported =
            import(source, &name, &map, &target).map_err(|error| match error.problem {
                ImportProblem::Write(_) | ImportProblem::Rejected { .. } => Failure::device(error),
                _ if standard_input => Failure::input(error),
                _ => Failure::input(error).at(&self.log),
            })?;
        say(output, &name, &imported);
        let paths: Vec<&Path> = imported.runs.iter().map(|run| run.path.as_path()).collect();
        let (findings, contradicts) = check_written(&paths, output);
        if output.json {
            output.document(&Document {
                shape: "motorlab-import/1",
                imported: &imported,
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

    fn target(&self) -> PathBuf {
        if let Some(output) = &self.output {
            return output.clone();
        }
        let name = match self.log.file_name() {
            Some(name) if self.log.as_os_str() != "-" => Path::new(name),
            _ => Path::new("log"),
        };
        let name = match name.extension() {
            Some(extension) if extension == "gz" => Path::new(name.file_stem().unwrap_or_default()),
            _ => name,
        };
        name.with_extension("run.csv")
    }
}

fn open(path: &Path) -> Result<File, Failure> {
    let failed = |error: io::Error| Failure::input(format!("{}: {error}", shown(path)));
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    Ok(file)
}

/// What became of the log, for people.
fn say(output: &Output, name: &str, imported: &Imported) {
    for run in &imported.runs {
        let (shortest_s, longest_s) = run.steps_s;
        output.message(&format!(
            "wrote {}: {} samples in {:.3} s, sample time {} s (steps {shortest_s} to {longest_s} s)",
            shown(&run.path),
            run.samples,
            run.duration_s,
            run.sample_time_s,
        ));
    }
    if imported.rows_without_position > 0 {
        output.message(&format!(
            "{name}: {} of {} rows have no position and only set what is held",
            imported.rows_without_position, imported.rows
        ));
    }
    if imported.unended {
        output.message(&format!(
            "{name}: the last line has no line end; if the log was cut off there, its last number may be short"
        ));
    }
    let Some(rejected) = &imported.rejected else {
        return;
    };
    output.message(&format!(
        "{name}: {} of {} rows cannot be used and count as lost; all of them are in {}:",
        imported.bad_rows,
        imported.rows,
        shown(rejected)
    ));
    for row in &imported.first_bad {
        output.message(&format!("  {row}"));
    }
    let listed = imported.first_bad.len() as u64;
    if imported.bad_rows > listed {
        output.message(&format!("  and {} more", imported.bad_rows - listed));
    }
}
