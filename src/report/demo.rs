//! The page of `motorlab demo`: a motor that agrees with its simulation, then one with a sim-to-real gap, and its
//! diagnosis.

use super::number::figure;
use super::{Page, comparison, diagnosis};
use crate::compare::Overlay;
use crate::diagnose::Diagnosis;
use crate::motor::SimulationError;
use crate::recording::Run;

/// Runs with their simulations, and the diagnosed one.
#[derive(Debug)]
pub struct Shown<'a> {
    /// Runs of the motor that agrees.
    pub met: &'a [(&'a Run, &'a Overlay)],
    /// The run with a gap, its simulation and its diagnosis.
    pub gap: (&'a Run, &'a Overlay, &'a Diagnosis),
    /// Keys of that run's virtual board, as after `virtual:?`.
    pub board: &'a str,
}

/// Keys of a virtual board for readers. The playback rate has no effect on the run.
pub fn keys_words(keys: &str) -> String {
    let telling = keys.split('&').filter(|key| !key.starts_with("speed="));
    telling.collect::<Vec<_>>().join(", ")
}

/// Why the figures of comparison and diagnosis differ.
pub fn two_measures(found: &Diagnosis) -> String {
    format!(
        "The comparison simulates a whole run from rest, where errors accumulate. The diagnosis predicts segments of {}\u{a0}s from their measured initial states, so that its errors are smaller.",
        figure(found.gap.horizon_s, 2)
    )
}

/// The whole demo as one offline page.
///
/// # Errors
/// The diagnosed run cannot be simulated with one of the motors.
pub fn page(shown: &Shown<'_>) -> Result<String, SimulationError> {
    let (run, overlay, found) = shown.gap;
    let mut page = Page::new("A recorded motor, its simulation, and the sim-to-real gap");
    page.lead(
        "First a motor that agrees with its simulation. Then one that differs in one effect, and its diagnosis.",
    );
    page.section("Recorded and simulated");
    comparison::lay_out(&mut page, shown.met, &[]);
    page.section("Another motor: recorded, and simulated as before");
    page.note(&format!(
        "A virtual board whose motor differs in one effect ({}), which the diagnosis below is not told.",
        keys_words(shown.board)
    ));
    comparison::lay_out(&mut page, &[(run, overlay)], &[]);
    page.section("Diagnosis of the gap");
    page.note(&two_measures(found));
    diagnosis::lay_out(&mut page, found, std::slice::from_ref(run), &[])?;
    Ok(page.finish())
}
