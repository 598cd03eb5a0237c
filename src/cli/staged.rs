//! Runs that replace others by `--force`: written whole beside them, then moved into their places.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output_file::{Force, Outputs};

/// Runs that are written in a folder of their own beside the runs that they replace.
pub(super) struct Staged {
    /// Goes with what is left in it.
    directory: tempfile::TempDir,
    run: PathBuf,
    beside: PathBuf,
}

impl Staged {
    /// `None` without `--force`, and where there is no such run.
    ///
    /// # Errors
    /// An input or a link, and a folder that cannot be written.
    pub(super) fn of(
        force: Force,
        outputs: &Outputs,
        target: &Path,
    ) -> Result<Option<Self>, Failure> {
        if !force.is_given() || !target.exists() {
            return Ok(None);
        }
        outputs.may_replace(target, None)?;
        let beside = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let directory = tempfile::tempdir_in(beside).map_err(Failure::device)?;
        let run = directory
            .path()
            .join(target.file_name().unwrap_or_default());
        Ok(Some(Self {
            directory,
            run,
            beside: beside.to_owned(),
        }))
    }

    /// Where the run is written first.
    pub(super) fn run(&self) -> &PathBuf {
        &self.run
    }

    /// Moves files into their places, which their paths then say.
    pub(super) fn take_place<'a>(
        &self,
        outputs: &Outputs,
        paths: impl IntoIterator<Item = &'a mut PathBuf>,
    ) -> Result<(), Failure> {
        for path in paths {
            let Ok(name) = path.strip_prefix(self.directory.path()) else {
                continue;
            };
            let place = match self.beside.as_path() == Path::new(".") {
                true => name.to_owned(),
                false => self.beside.join(name),
            };
            outputs.may_replace(&place, None)?;
            std::fs::rename(&*path, &place).map_err(Failure::device)?;
            *path = place;
        }
        Ok(())
    }
}
