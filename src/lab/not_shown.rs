//! Part 3: effects that the diagnosis of these recordings may miss, because they change them little.

use serde::Serialize;

use crate::diagnose::{Diagnosis, beyond_parameters};
use crate::motor::Motor;
use crate::recording::Run;
use crate::report::number::figure;

/// Counts RMS beyond re-identified parameters above which a diagnosis reliably names an effect or its class: below,
/// most are not named in the breadth table (docs/decisions).
const RELIED_ON_FROM: f64 = 2.0;
/// Most samples used for it: each of the catalogue's effects is simulated and fitted on them.
const MOST_SAMPLES: usize = 20_000;

/// An effect that the diagnosis may miss.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NotShown {
    /// Its id.
    pub effect: &'static str,
    /// RMS change of the recordings in counts beyond re-identified parameters, at its default magnitude.
    pub beyond_parameters_counts: f64,
}

/// Effects that are hardly visible in these recordings together, in the order of the catalogue, without those that
/// the diagnosis names; empty if it is not computed.
pub fn not_shown(
    motor: &Motor,
    runs: &[Run],
    diagnosis: &Diagnosis,
    done: &(dyn Fn(f64) + Sync),
) -> Vec<NotShown> {
    if runs.iter().any(|run| run.len() > MOST_SAMPLES) {
        return Vec::new();
    }
    let of_classes = diagnosis
        .classes
        .iter()
        .flat_map(|class| class.members.iter());
    let named: Vec<&str> = diagnosis
        .effects
        .iter()
        .chain(of_classes)
        .copied()
        .collect();
    (beyond_parameters(motor, runs, &diagnosis.settings, done).into_iter())
        .filter(|one| one.rms_counts < RELIED_ON_FROM && !named.contains(&one.effect))
        .map(|one| NotShown {
            effect: one.effect,
            beyond_parameters_counts: one.rms_counts,
        })
        .collect()
}

/// Text for the answer; empty if all effects are visible. `reverses`: one of the recordings has commands in both
/// directions.
pub fn words(effects: &[NotShown], reverses: bool) -> String {
    let name = |one: &NotShown| one.effect.replace('_', " ");
    let with_figure = |one: &NotShown| {
        let counts = figure(one.beyond_parameters_counts, 2);
        format!("{} ({counts})", name(one))
    };
    let (imitated, little): (Vec<&NotShown>, Vec<&NotShown>) =
        (effects.iter()).partition(|one| one.beyond_parameters_counts == 0.0);
    let imitated: Vec<String> = imitated.into_iter().map(name).collect();
    let little: Vec<String> = little.into_iter().map(with_figure).collect();
    let mut words = String::new();
    if !imitated.is_empty() {
        words += &format!(
            " At their default magnitudes these recordings do not show, because re-identified parameters leave no more than the noise floor: {}.",
            imitated.join(", ")
        );
    }
    if !little.is_empty() {
        words += &format!(
            " The diagnosis may miss these, which change the recordings by less than {RELIED_ON_FROM} counts RMS beyond re-identified parameters: {}.",
            little.join(", ")
        );
    }
    if !effects.is_empty() && !reverses {
        words += " hint: record with --profile reversing too, for more of them.";
    }
    words
}
