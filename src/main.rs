//! The `motorlab` command: parse, run, exit status.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::parse().run()
}
