//! Runs that replace others with `--force`: written completely, then moved into place.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output_file::{Force, Outputs};

/// Runs in a temporary folder beside the runs that they replace.
pub(super) struct Staged {
    /// Removed with its remaining content on drop.
    directory: tempfile::TempDir,
    run: PathBuf,
    beside: PathBuf,
}

impl Staged {
    /// `None` without `--force`, or without an existing run.
    ///
    /// # Errors
    /// The existing file is an input or a link, or the folder cannot be written.
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

    /// Temporary path of the run.
    pub(super) fn run(&self) -> &PathBuf {
        &self.run
    }

    /// Moves files into place and updates their paths.
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
