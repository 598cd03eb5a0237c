//! The command line: one file a subcommand, arguments and printing only.
//!
//! Every subcommand is a struct of arguments with `run(&self, &Output) -> Result<Status, Failure>`.
//! With `--json` one JSON document goes to standard output and nothing else; messages and progress
//! go to standard error.

mod failure;
mod simulate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use failure::{Failure, Status};

/// Record a DC motor over serial, simulate it, compare the two, and say which effect explains the gap.
#[derive(Debug, Parser)]
#[command(
    name = "motorlab",
    version,
    propagate_version = true,
    max_term_width = 100
)]
pub struct CommandLine {
    /// Print one JSON document on standard output, and nothing else there.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

/// The subcommands, in the order in which a lab uses them.
#[derive(Debug, Subcommand)]
enum Command {
    Simulate(simulate::Simulate),
}

/// How a subcommand is to print.
#[derive(Debug, Clone, Copy)]
pub struct Output {
    /// One JSON document instead of text.
    pub json: bool,
}

impl CommandLine {
    /// Runs the subcommand; a failure is said on standard error and becomes the exit status.
    pub fn run(self) -> ExitCode {
        let output = Output { json: self.json };
        let result = match self.command {
            Command::Simulate(command) => command.run(&output),
        };
        match result {
            Ok(status) => status.into(),
            Err(failure) => {
                eprintln!("{failure}");
                failure.status.into()
            }
        }
    }
}
