//! The `motorlab` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::run_arguments()
}
