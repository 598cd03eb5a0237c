//! The `motorlab` command, as in the project, so that its recordings of the board can be tested here.

use std::process::ExitCode;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::run_arguments()
}
