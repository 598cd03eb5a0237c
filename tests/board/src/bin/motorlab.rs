//! The `motorlab` command, as in the project, so that its recordings of the board can be tested here.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::parse().run().into()
}
