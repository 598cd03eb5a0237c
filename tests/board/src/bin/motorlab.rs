//! The project's `motorlab` command, for tests of its recordings of the board.

use std::process::ExitCode;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::run_arguments()
}
