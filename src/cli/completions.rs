//! `motorlab completions`: completion scripts for shells.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{CommandLine, Failure, Output, Status};

/// Print the completion script of a shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  motorlab completions bash > ~/.local/share/bash-completion/completions/motorlab"
)]
pub struct Completions {
    /// Which shell.
    shell: Shell,
}

impl Completions {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(
            self.shell,
            &mut CommandLine::command(),
            "motorlab",
            &mut script,
        );
        output.line(String::from_utf8_lossy(&script).trim_end())?;
        Ok(Status::Done)
    }
}
