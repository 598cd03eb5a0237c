//! Cases from the generator, in parallel.

use case_generator::breadth::{generate_bench, plan_breadth};
use case_generator::{Kind, Options, UnknownKind, generate_with, plan};
use rand::TryRng;
use rand::rngs::SysRng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{BlindError, NewCase};

/// Parameters of a generated set; kept with the labels, because the seed determines every label.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Number of cases.
    pub cases: usize,
    /// Seed of the set.
    pub seed: u64,
    /// [`BREADTH`], `mixed`, `singles`, `pairs`, `none`, `outside`, an effect's id, or two joined by `+`.
    pub kind: String,
    /// Motors unlike the handout's.
    pub other_motors: bool,
    /// Factor on the random torque of load and friction.
    #[serde(rename = "wander_scale")]
    pub random_torque_scale: f64,
}

/// The kind of a set with several motor families, protocols and sample times.
pub const BREADTH: &str = "breadth";

/// Seeds below are for tuning: their cases may be examined, and their figures are not published.
pub const FIRST_UNTOUCHED_SEED: u64 = 1_000_000;

impl Recipe {
    /// Whether the cases may have been examined while the diagnosis was tuned.
    pub fn is_for_tuning(&self) -> bool {
        self.seed < FIRST_UNTOUCHED_SEED
    }
}

/// A random seed outside the tuning range.
///
/// # Errors
/// The system provides no randomness.
pub fn drawn_seed() -> Result<u64, BlindError> {
    let drawn = SysRng.try_next_u64().map_err(|error| {
        BlindError::refused(
            format!("no randomness to draw a seed from: {error}"),
            "give a seed of your own with --seed",
        )
    })?;
    // 53 bits: JSON numbers are exact up to there in every language.
    Ok((drawn >> 11).max(FIRST_UNTOUCHED_SEED))
}

/// Generates the cases of a recipe; `made` is called after each.
///
/// # Errors
/// The kind is unknown.
pub fn make(recipe: &Recipe, made: &(dyn Fn() + Sync)) -> Result<Vec<NewCase>, UnknownKind> {
    if recipe.kind == BREADTH {
        let planned = plan_breadth(recipe.cases, recipe.seed);
        let cases = planned.par_iter().map(|(seed, hidden, protocol)| {
            let bench = generate_bench(*seed, *hidden, *protocol);
            made();
            NewCase {
                runs: bench.case.runs.iter().map(|run| run.to_csv()).collect(),
                motor: bench.motor_file,
                unseen: Some(bench.case.unseen_run.to_csv()),
                truth: bench.case.into(),
            }
        });
        return Ok(cases.collect());
    }
    let planned: Vec<(u64, Kind)> = match recipe.kind.parse() {
        Ok(mix) => plan(recipe.cases, recipe.seed, mix),
        Err(_) => {
            let kind: Kind = recipe.kind.parse()?;
            let cases = plan(recipe.cases, recipe.seed, case_generator::Mix::None);
            cases
                .into_iter()
                .map(|(seed, _)| (seed, kind.clone()))
                .collect()
        }
    };
    let options = Options {
        other_motors: recipe.other_motors,
        random_torque_scale: recipe.random_torque_scale,
        ..Options::default()
    };
    let cases = planned.par_iter().map(|(seed, kind)| {
        let case = generate_with(*seed, kind, &options);
        made();
        NewCase {
            runs: case.runs.iter().map(|run| run.to_csv()).collect(),
            motor: case.nominal.to_toml(),
            unseen: Some(case.unseen_run.to_csv()),
            truth: case.into(),
        }
    });
    Ok(cases.collect())
}
