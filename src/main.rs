//! The `motorlab` command: parse, run, exit status.

use std::process::ExitCode;

fn main() -> ExitCode {
    motorlab::cli::CommandLine::run_arguments()
}
