//! `motorlab firmware`: writes the built-in sketch for the board.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use firmware_protocol::sketch;
use serde_json::json;

use super::output_file::whole;
use super::{Failure, Output, Status};
use crate::hint::In;
use crate::plain::shown;

/// Write the Arduino sketch for the board into a folder; open it there in the Arduino IDE.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  motorlab firmware ~/Arduino\n  then open ~/Arduino/motorlab/motorlab.ino, or: motorlab flash /dev/ttyACM0"
)]
pub struct Firmware {
    /// The folder; the sketch's own folder `motorlab` is made in it.
    folder: PathBuf,
    /// Overwrite files of the sketch that somebody has changed.
    #[arg(long)]
    force: bool,
}

impl Firmware {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let folder = write_sketch(&self.folder, self.force)?;
        if output.json {
            let files: Vec<&str> = sketch::FILES.iter().map(|(name, _)| *name).collect();
            output.document(&json!({ "folder": folder, "files": files }))?;
        } else {
            output.line(&shown(folder.join("motorlab.ino")))?;
            output.message(
                "open it in the Arduino IDE, or: motorlab flash PORT; wiring is in README.md beside it",
            );
        }
        Ok(Status::Done)
    }
}

/// Writes the sketch's folder into `folder`. Changed files are kept unless `force`, as settings.h is meant to be
/// edited.
pub(super) fn write_sketch(folder: &Path, force: bool) -> Result<PathBuf, Failure> {
    let sketch = folder.join("motorlab");
    let failed = |path: &Path, error: io::Error| {
        Failure::device(In::new(format!("cannot write {}", shown(path)), error))
    };
    fs::create_dir_all(&sketch).map_err(|error| failed(&sketch, error))?;
    let changed: Vec<&str> = sketch::FILES
        .iter()
        .filter(|(name, text)| {
            fs::read(sketch.join(name)).is_ok_and(|found| found != text.as_bytes())
        })
        .map(|(name, _)| *name)
        .collect();
    if !changed.is_empty() && !force {
        return Err(Failure::wrong(
            format!(
                "{} holds a sketch with other contents in {}",
                shown(&sketch),
                changed.join(", ")
            ),
            "--force overwrites it, another folder keeps it",
        ));
    }
    for (name, text) in sketch::FILES {
        let path = sketch.join(name);
        whole(&path, text.as_bytes()).map_err(|error| failed(&path, error))?;
    }
    Ok(sketch)
}
