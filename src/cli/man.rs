//! `motorlab man`: manual pages.

use std::path::PathBuf;

use clap::{Args, CommandFactory};

use super::output_file::{Force, Form};
use super::{CommandLine, Failure, Output, Status};
use crate::hint::In;
use crate::plain::shown;

/// Write a manual page for motorlab and each of its subcommands into a folder.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  motorlab man ~/.local/share/man/man1")]
pub struct Man {
    /// The folder; it is made where it is missing.
    folder: PathBuf,
    #[command(flatten)]
    force: Force,
}

impl Man {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let failed = |error: std::io::Error| {
            Failure::device(In::new(
                format!("cannot write to {}", shown(&self.folder)),
                error,
            ))
        };
        std::fs::create_dir_all(&self.folder).map_err(failed)?;
        let outputs = self.force.outputs("man", []);
        let made = tempfile::tempdir().map_err(failed)?;
        clap_mangen::generate_to(CommandLine::command(), made.path()).map_err(failed)?;
        let mut pages = Vec::new();
        for entry in std::fs::read_dir(made.path()).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let target = self.folder.join(entry.file_name());
            outputs.may_replace(&target, None)?;
            let page = std::fs::read_to_string(entry.path()).map_err(failed)?;
            pages.push((target, page));
        }
        for (target, page) in &pages {
            outputs.write_silently(target, page, Form::Roff)?;
        }
        output.message(&format!("wrote manual pages to {}", shown(&self.folder)));
        Ok(Status::Done)
    }
}
