//! Runs with the residual torque of the nested models: nominal, re-identified, with the identified effects.

use super::words;
use crate::compare::{Overlay, compare, missing_torque};
use crate::diagnose::Diagnosis;
use crate::motor::{Model, SimulationError};
use crate::recording::Run;

pub(super) struct OverlaidRun<'a> {
    pub run: &'a Run,
    /// Its name on the page.
    pub name: String,
    /// Its name in the diagnosis.
    pub id: String,
    /// The models in order; without the last if no effect is identified.
    pub models: Vec<OverlaidModel>,
}

pub(super) struct OverlaidModel {
    pub name: String,
    pub colour: usize,
    pub overlay: Overlay,
    /// Residual torque in N m, or in the unit of the command where no torque is known.
    pub residual: Vec<Option<f64>>,
}

/// Colours of the models, from the nominal on.
const COLOURS: [usize; 3] = [6, 4, 1];

/// Simulates every run with the models of a diagnosis.
pub(super) fn lay<'a>(
    diagnosis: &Diagnosis,
    runs: &'a [Run],
) -> Result<Vec<OverlaidRun<'a>>, SimulationError> {
    let nominal = &diagnosis.nominal;
    let models = [nominal, &diagnosis.refitted, &diagnosis.model];
    let motors: Vec<_> = words::models(diagnosis).into_iter().zip(models).collect();
    let names = names(runs);
    let unit = match diagnosis.has_torque() {
        true => 1.0,
        false => diagnosis.command_kind.per_nm(&nominal.parameters),
    };
    runs.iter()
        .zip(names)
        .enumerate()
        .map(|(k, (run, name))| {
            let models = motors.iter().zip(COLOURS).map(|((name, motor), colour)| {
                let overlay = compare(run, motor, Model::SecondOrder)?;
                let residual_nm =
                    missing_torque(run, &overlay.residual_counts, &nominal.parameters);
                let in_unit = |torque: Option<f64>| torque.map(|torque| unit * torque);
                Ok(OverlaidModel {
                    name: name.clone(),
                    colour,
                    residual: residual_nm.into_iter().map(in_unit).collect(),
                    overlay,
                })
            });
            Ok(OverlaidRun {
                run,
                name,
                id: path(run).unwrap_or_else(|| (k + 1).to_string()),
                models: models.collect::<Result<_, SimulationError>>()?,
            })
        })
        .collect()
}

fn path(run: &Run) -> Option<String> {
    run.path.as_ref().map(|path| path.display().to_string())
}

/// File names if they are unique, else whole paths.
pub(super) fn names(runs: &[Run]) -> Vec<String> {
    let short: Vec<String> = runs
        .iter()
        .enumerate()
        .map(|(k, run)| {
            let name = run.path.as_ref().and_then(|path| path.file_name());
            name.map_or_else(
                || format!("run {}", k + 1),
                |name| name.to_string_lossy().into_owned(),
            )
        })
        .collect();
    let twice = |name: &String| short.iter().filter(|other| *other == name).count() > 1;
    if !short.iter().any(twice) {
        return short;
    }
    let whole = runs.iter().zip(&short);
    whole
        .map(|(run, short)| path(run).unwrap_or_else(|| short.clone()))
        .collect()
}
