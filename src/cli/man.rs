//! `motorlab man`: manual pages.

use std::path::PathBuf;

use clap::{Args, CommandFactory};

use super::{CommandLine, Failure, Output, Status};

/// Write a manual page for motorlab and each of its subcommands into a folder.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  motorlab man ~/.local/share/man/man1")]
pub struct Man {
    /// The folder; it is made where it is missing.
    folder: PathBuf,
}

impl Man {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let failed = |error: std::io::Error| {
            Failure::device(format!(
                "cannot write to {}: {error}",
                self.folder.display()
            ))
        };
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        clap_mangen::generate_to(CommandLine::command(), &self.folder).map_err(failed)?;
        output.message(&format!("wrote manual pages to {}", self.folder.display()));
        Ok(Status::Done)
    }
}
