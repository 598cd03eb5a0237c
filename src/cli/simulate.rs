//! `motorlab simulate`: what the handout's motor does.

use clap::Args;

use super::{Failure, Output, Status};
use crate::motor::Parameters;

/// Simulate the motor and print or write the run.
#[derive(Debug, Args)]
pub struct Simulate {}

impl Simulate {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let parameters = Parameters::default();
        if output.json {
            println!(
                "{}",
                serde_json::to_string(&parameters).map_err(Failure::input)?
            );
        } else {
            println!("{parameters:#?}");
        }
        Ok(Status::Done)
    }
}
