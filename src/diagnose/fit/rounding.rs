//! What rounding leaves of a right model: of recordings that are simulated with it.

use super::Left;
use crate::diagnose::pieces::{Pieces, Recording};
use crate::diagnose::settings::START_PHASES;
use crate::motor::fit::{Simulator, Workspace};
use crate::motor::{CommandKind, Drive, Model, Motor, SimulationError};
use crate::recording::Run;

/// What a motor leaves of recordings of itself, a mean square in counts^2: each run simulated as a whole, rounded down, and predicted in pieces.
pub(crate) fn rounding(
    runs: &[Run],
    pieces: &Pieces,
    (motor, time_constant_s): (&Motor, f64),
    kind: CommandKind,
) -> Option<f64> {
    let mut sum = 0.0;
    for phase in START_PHASES {
        let mut rounded = runs.to_vec();
        for (run, recording) in rounded.iter_mut().zip(&pieces.runs) {
            run.counts = simulated(run, recording, motor, kind, phase).ok()?;
        }
        let own = Pieces::new(&rounded, motor).ok()?;
        let left = Left::of(&own, motor, time_constant_s)?;
        sum += left.iter().map(|r| r * r).sum::<f64>() / left.len().max(1) as f64;
    }
    Some(sum / START_PHASES.len() as f64)
}

/// Counts of a motor from this share of a count beyond where a run begins.
fn simulated(
    run: &Run,
    recording: &Recording,
    motor: &Motor,
    kind: CommandKind,
    phase: f64,
) -> Result<Vec<i64>, SimulationError> {
    let drive = Drive {
        t_s: &recording.t_s,
        command: &recording.command,
        kind,
    };
    let start = (recording.first_counts + phase) * recording.rad;
    let simulator = Simulator::new(&drive, Model::SecondOrder)?
        .knowing(run.known.clone())
        .filtering_samples(run.is_integrated_backward())
        .starting(start, 0.0);
    let mut angles = vec![0.0; recording.t_s.len()];
    simulator.angles(motor, &mut Workspace::default(), &mut angles)?;
    Ok((angles.iter())
        .map(|angle| (angle / recording.rad).floor() as i64)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::ROUNDING;

    /// Rounding of a sample alone leaves 1/sqrt(12) counts (Widrow); the starts of pieces are taken off nearly, and no more than that.
    #[test]
    fn rounding_leaves_what_the_closed_form_bounds() {
        let runs = [recording(&Motor::default(), 1000)];
        let pieces = Pieces::new(&runs, &Motor::default()).expect("a run");
        let found = rounding(
            &runs,
            &pieces,
            (&Motor::default(), 0.034),
            CommandKind::Voltage,
        )
        .expect("a motor");
        assert!(
            found > 0.64 * ROUNDING && found < 1.69 * ROUNDING,
            "{found}"
        );
    }
}
