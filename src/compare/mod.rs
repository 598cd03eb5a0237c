//! Comparison of recorded runs with their simulation: the overlay and its error figures.
//!
//! The simulation runs in open loop from rest through the whole run with the recorded command, so that errors
//! accumulate in the position.

mod metrics;
mod torque;

use serde::Serialize;

use crate::motor::{Drive, Model, Motor, SimulationError, SimulationOptions, simulate};
use crate::recording::{Run, difference_velocities};
use crate::units::rpm_from_rad_s;

pub use torque::missing_torque;

pub use metrics::{
    Alignment, FLOOR_COUNTS, align, rms, root_mean_square_errors, speed_of_one_count,
};

/// One run with its simulation, in columns of the run's length.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// The figures.
    pub figures: RunFigures,
    /// Recorded speed by finite differences in rad/s.
    pub recorded_speed_rad_s: Vec<Option<f64>>,
    /// Simulated speed by the same differences in rad/s.
    pub simulated_speed_rad_s: Vec<Option<f64>>,
    /// Simulated position in counts, not quantized, relative to the recording's first.
    pub simulated_position_counts: Vec<f64>,
    /// Recorded minus simulated position in counts.
    pub residual_counts: Vec<f64>,
    /// The motor's true speed in the simulation, in rad/s: without encoder, sampling and differences.
    pub true_speed_rad_s: Vec<f64>,
}

/// Figures of one run; an entry of `runs` in the shape `motorlab-comparison/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunFigures {
    /// The run's file.
    pub path: String,
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Samples in the run.
    pub samples: usize,
    /// Samples missing between them, by their sequence numbers.
    pub lost: u64,
    /// Recorded against simulated counts, whole run in open loop from rest, RMS.
    pub position_rmse_counts: f64,
    /// Largest difference of position in counts.
    pub position_largest_counts: f64,
    /// Speed by finite differences on both sides, RMS of the difference in RPM.
    pub velocity_rmse_rpm: f64,
    /// The same relative to the variation of the recorded speed.
    pub velocity_nrmse: Option<f64>,
    /// Quantization error of a perfect model in counts RMS.
    pub floor_counts: f64,
    /// Estimated initial fraction of a count.
    pub start_fraction: f64,
    /// Notes of the reader about the file.
    pub notes: Vec<String>,
}

/// All runs of one comparison; serialized as `motorlab-comparison/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the document's shape.
    pub shape: &'static str,
    /// One entry per run.
    pub runs: Vec<RunFigures>,
}

impl Comparison {
    /// The figures of all overlays.
    pub fn of(overlays: &[Overlay]) -> Self {
        Self {
            shape: "motorlab-comparison/1",
            runs: overlays
                .iter()
                .map(|overlay| overlay.figures.clone())
                .collect(),
        }
    }

    /// The largest position error of all runs in counts RMS.
    pub fn worst_position_rmse_counts(&self) -> f64 {
        self.runs
            .iter()
            .map(|run| run.position_rmse_counts)
            .fold(0.0, f64::max)
    }
}

/// Samples missing in a run, by its sequence numbers.
pub fn lost_samples(run: &Run) -> u64 {
    let gaps = run.seq.iter().flat_map(|seq| seq.windows(2));
    gaps.map(|pair| pair[1].saturating_sub(pair[0]).saturating_sub(1))
        .fold(0, u64::saturating_add)
}

/// Simulates the run's command with the motor and compares the two.
///
/// # Errors
/// The motor cannot be simulated with this command.
pub fn compare(run: &Run, motor: &Motor, model: Model) -> Result<Overlay, SimulationError> {
    let command = run.driving_command();
    let drive = Drive {
        t_s: &run.t_s,
        command: &command,
        kind: run.command_kind,
    };
    let options = SimulationOptions {
        model,
        ..SimulationOptions::default()
    };
    let begins_rad = run.counts.first().copied().unwrap_or(0) as f64 / run.counts_per_rev
        * std::f64::consts::TAU;
    let mut motor = run.known.applied_to(motor).with_phase_from(begins_rad);
    motor.parameters.counts_per_rev = run.counts_per_rev;
    if let Some(supply_v) = run.known.supply_v().or(run.supply_v) {
        motor.parameters.supply_v = supply_v;
    }
    let trajectory = simulate(&motor, &drive, &options)?;
    let counts_per_rad = run.counts_per_rev / std::f64::consts::TAU;
    let first = trajectory
        .measured_angle_rad
        .first()
        .copied()
        .unwrap_or(0.0);
    let position: Vec<f64> = trajectory
        .measured_angle_rad
        .iter()
        .map(|angle| (angle - first) * counts_per_rad)
        .collect();
    let alignment = align(&run.counts, &position);
    let seq = run.seq.as_deref();
    let speed =
        |counts: &[i64]| difference_velocities(counts, seq, run.counts_per_rev, run.sample_time_s);
    let recorded_speed_rad_s = speed(&run.counts);
    let simulated_speed_rad_s = speed(&alignment.simulated_counts);
    let (speed_error, relative) =
        root_mean_square_errors(&recorded_speed_rad_s, &simulated_speed_rad_s);
    let origin = run.counts.first().copied().unwrap_or(0) as f64 + alignment.start_fraction - 0.5;
    let largest = alignment
        .residual_counts
        .iter()
        .fold(0.0, |m, r| f64::max(m, r.abs()));
    Ok(Overlay {
        figures: RunFigures {
            path: run
                .path
                .as_ref()
                .map_or_else(String::new, |path| path.display().to_string()),
            sample_time_s: run.sample_time_s,
            samples: run.len(),
            lost: lost_samples(run),
            position_rmse_counts: rms(alignment.residual_counts.iter().copied()),
            position_largest_counts: largest,
            velocity_rmse_rpm: rpm_from_rad_s(speed_error),
            velocity_nrmse: relative.is_finite().then_some(relative),
            floor_counts: FLOOR_COUNTS,
            start_fraction: alignment.start_fraction,
            notes: Vec::new(),
        },
        recorded_speed_rad_s,
        simulated_speed_rad_s,
        simulated_position_counts: position.iter().map(|x| x + origin).collect(),
        residual_counts: alignment.residual_counts,
        true_speed_rad_s: trajectory.speed_rad_s,
    })
}
