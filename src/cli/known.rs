//! `--with RUN:KEY=VALUE`: known differences of a run, on the command line.

use std::path::Path;

use clap::Args;

use super::Failure;
use crate::hint::In;
use crate::plain::{one_line, shown};
use crate::recording::Run;

/// Known differences of single runs from the motor file.
#[derive(Debug, Clone, Args)]
pub(super) struct With {
    /// Known difference of a run, in SI: `inertia_added_kg_m2`, `gravity_torque_nm` (of an arm, its angle counted from count 0), or
    /// a key of the motor file, such as `supply_v`. RUN is the file as it is named here. May be given again.
    #[arg(long = "with", value_name = "RUN:KEY=VALUE", value_parser = difference)]
    with: Vec<Difference>,
}

#[derive(Debug, Clone)]
struct Difference {
    run: String,
    key: String,
    value: f64,
}

fn difference(text: &str) -> Result<Difference, String> {
    let expected =
        "expected RUN:KEY=VALUE\nhint: such as --with disc.csv:inertia_added_kg_m2=0.001";
    let (name, value) = text.rsplit_once('=').ok_or(expected)?;
    // The last colon: the path may contain another.
    let (run, key) = name.rsplit_once(':').ok_or(expected)?;
    let value = value
        .parse()
        .map_err(|_| format!("`{value}` is not a number; {expected}"))?;
    Ok(Difference {
        run: run.to_owned(),
        key: key.to_owned(),
        value,
    })
}

impl With {
    /// Applies the known differences of the file at this path to its run.
    pub(super) fn apply(&self, path: &Path, run: &mut Run) -> Result<(), Failure> {
        for difference in self
            .with
            .iter()
            .filter(|difference| path == Path::new(&difference.run))
        {
            run.known
                .set(&difference.key, difference.value)
                .map_err(|error| {
                    Failure::input(In::new(format!("--with {}", difference.run), error))
                })?;
        }
        Ok(())
    }

    /// Refuses differences for a file that is not among these.
    pub(super) fn refuse_others<'a>(
        &self,
        mut paths: impl Iterator<Item = &'a Path> + Clone,
    ) -> Result<(), Failure> {
        match self
            .with
            .iter()
            .find(|difference| !paths.clone().any(|path| path == Path::new(&difference.run)))
        {
            None => Ok(()),
            Some(difference) => {
                let first = paths.next().map_or(String::new(), shown);
                Err(Failure::wrong(
                    format!(
                        "--with {}: no run of that name is given",
                        one_line(&difference.run)
                    ),
                    format!(
                        "name it as the run itself, such as --with {first}:{}={}",
                        difference.key, difference.value
                    ),
                ))
            }
        }
    }
}
