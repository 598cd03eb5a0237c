//! `motorlab tabulate`: many diagnoses as tables, and as one page.

use std::path::{Path, PathBuf};
use std::{fs, io};

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use super::output_file::{Force, Form, Outputs};
use super::progress::bar;
use super::threads::Threads;
use super::{Failure, Output, Status, missing_file};
use crate::fleet::{Damaged, Document, Population, Table, tables};
use crate::hint::{Hinted, In, parted};
use crate::plain::shown;
use crate::report::fleet::{Names, page};

/// Lay many diagnoses out as flat tables (CSV or Parquet), and hold each unit against the population on one page.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Tabulate {
    /// Documents of `motorlab diagnose --json`, or folders of them (every *.json in it, in the order of names).
    #[arg(required = true, value_name = "DOCUMENT")]
    documents: Vec<PathBuf>,
    /// Table with a row a diagnosis; .csv or .parquet.
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["html", "causes", "numbers"])]
    output: Option<PathBuf>,
    /// Table with a row a cause.
    #[arg(long, value_name = "FILE")]
    causes: Option<PathBuf>,
    /// Table with a row an identified number.
    #[arg(long, value_name = "FILE")]
    numbers: Option<PathBuf>,
    /// The fleet page: one HTML file that needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Hint for a document that is not a diagnosis.
const WRITE_AGAIN: &str = "`motorlab diagnose RUN --json > DOCUMENT` writes a diagnosis";

const EXAMPLE: &str = "Examples:
  motorlab tabulate diagnoses/*.json -o fleet.csv
  motorlab tabulate diagnoses -o fleet.parquet --causes causes.parquet --numbers numbers.parquet --html fleet.html

A unit is what the run's header calls it (`unit`, else the serial number of the board), else the document's
name without the date in it. Documents that are no diagnosis are named and ignored, with exit status 1.
Columns: docs/many-recordings.md.";

#[derive(Debug, Serialize)]
struct Summary<'a> {
    shape: &'static str,
    diagnoses: usize,
    causes: usize,
    numbers: usize,
    units: usize,
    files: Vec<&'a Path>,
    /// Documents that were skipped.
    skipped: &'a [Damaged],
}

impl Tabulate {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let inputs = self.all()?;
        let outputs = self.force.outputs("tabulate", &inputs);
        let tables_of = [&self.output, &self.causes, &self.numbers];
        for path in tables_of.into_iter().flatten() {
            Kind::of(path)?;
        }
        self.refuse_twice()?;
        for path in tables_of.into_iter().flatten().chain(&self.html) {
            outputs.may_replace(path, self.witness(path))?;
        }
        self.threads.set()?;
        let bar = bar(inputs.len(), "documents read");
        let read: Vec<_> = (inputs.par_iter().map(|path| Document::read(path)))
            .inspect(|_| bar.inc(1))
            .collect();
        bar.finish_and_clear();
        let (mut documents, mut damaged) = (Vec::new(), Vec::new());
        for one in read {
            match one {
                Ok(document) => documents.push(document),
                Err(why) => damaged.push(why),
            }
        }
        for Damaged { document, why } in &damaged {
            let (what, hint) = parted(why);
            let missing = missing_file::hint(what, Some(document));
            let what = format!("{}: {what}; it is ignored", shown(document));
            let hint = missing.as_deref().or(hint).unwrap_or(WRITE_AGAIN);
            output.message(&Hinted::new(what, hint).to_string());
        }
        if documents.is_empty() {
            return Err(Failure::wrong(
                format!("none of the {} documents is a diagnosis", inputs.len()),
                WRITE_AGAIN,
            ));
        }
        let made = tables(&documents);
        let of = [&made.diagnoses, &made.causes, &made.numbers];
        for (path, table) in tables_of.into_iter().zip(of) {
            if let Some(path) = path {
                let content = Kind::of(path)?.content(table, path)?;
                outputs.write_bytes(path, &content, self.witness(path))?;
            }
        }
        let population = Population::of(&documents);
        if let Some(path) = &self.html {
            for document in &mut documents {
                document.page = page_of(&document.document, path);
            }
            self.write_page(path, &documents, &damaged, &population, &outputs)?;
        }
        self.say(of, &population, &damaged, output)?;
        Ok(match damaged.is_empty() {
            true => Status::Done,
            false => Status::FellShort,
        })
    }

    /// The documents; those of folders in the order of their names.
    fn all(&self) -> Result<Vec<PathBuf>, Failure> {
        let mut all = Vec::new();
        for path in &self.documents {
            if !path.is_dir() {
                all.push(path.clone());
                continue;
            }
            let failed = |error: io::Error| Failure::input(In::new(shown(path), error));
            let mut inside = Vec::new();
            for entry in fs::read_dir(path).map_err(failed)? {
                let file = entry.map_err(failed)?.path();
                if file.extension().is_some_and(|end| end == "json") {
                    inside.push(file);
                }
            }
            if inside.is_empty() {
                return Err(Failure::wrong(
                    format!("{} holds no *.json", shown(path)),
                    "name the folder that the diagnoses were written to",
                ));
            }
            inside.sort();
            all.append(&mut inside);
        }
        Ok(all)
    }

    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let tables = [&self.output, &self.causes, &self.numbers];
        tables.into_iter().flatten().chain(&self.html)
    }

    fn refuse_twice(&self) -> Result<(), Failure> {
        let files: Vec<&PathBuf> = self.files().collect();
        let twice = (1..files.len()).find(|k| files[..*k].contains(&files[*k]));
        match twice {
            Some(k) => Err(Failure::wrong(
                format!("{} is named for two outputs", shown(files[k])),
                "name two files",
            )),
            None => Ok(()),
        }
    }

    /// The first table has the mark in every row; the others may have no rows.
    fn witness<'a>(&'a self, path: &Path) -> Option<&'a Path> {
        self.output.as_deref().filter(|output| *output != path)
    }

    fn write_page(
        &self,
        path: &Path,
        documents: &[Document],
        damaged: &[Damaged],
        population: &Population,
        outputs: &Outputs,
    ) -> Result<(), Failure> {
        let name = |path: &Option<PathBuf>, default: &str| {
            path.as_ref()
                .map_or(default.to_owned(), |path| path.display().to_string())
        };
        let names = Names {
            diagnoses: name(&self.output, "fleet.parquet"),
            causes: name(&self.causes, "causes.parquet"),
            numbers: name(&self.numbers, "numbers.parquet"),
        };
        outputs.write_silently(
            path,
            &page(documents, damaged, population, &names),
            Form::Markup,
        )
    }

    fn say(
        &self,
        [diagnoses, causes, numbers]: [&Table; 3],
        population: &Population,
        damaged: &[Damaged],
        output: &Output,
    ) -> Result<(), Failure> {
        if output.json {
            return output.document(&Summary {
                shape: "motorlab-table/1",
                diagnoses: diagnoses.rows,
                causes: causes.rows,
                numbers: numbers.rows,
                units: population.units.len(),
                files: self.files().map(PathBuf::as_path).collect(),
                skipped: damaged,
            });
        }
        output.line(&format!(
            "{} diagnoses of {} units, {} causes, {} numbers",
            diagnoses.rows,
            population.units.len(),
            causes.rows,
            numbers.rows
        ))?;
        for (verdict, count) in &population.verdicts {
            output.line(&format!("  {count:>6}  {verdict}"))?;
        }
        for path in self.files() {
            output.line(&format!("wrote {}", shown(path)))?;
        }
        Ok(())
    }
}

/// The page of a document, `NAME.html` beside `NAME.json`, relative to the fleet page.
fn page_of(document: &str, fleet: &Path) -> Option<String> {
    let page = Path::new(document)
        .with_extension("html")
        .canonicalize()
        .ok()?;
    let here = match fleet.parent() {
        Some(folder) if folder != Path::new("") => folder.canonicalize().ok()?,
        _ => Path::new(".").canonicalize().ok()?,
    };
    if page == here.join(fleet.file_name()?) {
        return None;
    }
    let shared = page.components().zip(here.components());
    let shared = shared.take_while(|(one, other)| one == other).count();
    let up = here.components().skip(shared).map(|_| "..".to_owned());
    let down = page.components().skip(shared);
    let down = down.map(|part| part.as_os_str().to_string_lossy().into_owned());
    Some(up.chain(down).collect::<Vec<_>>().join("/"))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Csv,
    #[cfg(feature = "parquet")]
    Parquet,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|end| end.to_str()) {
            Some("csv") => Ok(Self::Csv),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(Self::Parquet),
            #[cfg(not(feature = "parquet"))]
            Some("parquet") => Err(super::export_run::not_built("parquet")),
            _ => Err(Failure::wrong(
                format!("{}: a table is written as .csv or .parquet", shown(path)),
                "end its name with one of them",
            )),
        }
    }

    fn content(self, table: &Table, path: &Path) -> Result<Vec<u8>, Failure> {
        let failed = |error: String| {
            Failure::device(In::new(
                format!("cannot write {}", shown(path)),
                io::Error::other(error),
            ))
        };
        match self {
            Self::Csv => table.to_csv().map_err(|error| failed(error.to_string())),
            #[cfg(feature = "parquet")]
            Self::Parquet => {
                let mut content = Vec::new();
                crate::fleet::write_table(table, &mut content)
                    .map_err(|error| failed(error.to_string()))?;
                Ok(content)
            }
        }
    }
}
