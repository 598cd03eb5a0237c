//! Part 3: recorded step responses against the simulated discretized ones, with and without friction.

use serde::Serialize;

use super::step_response::Contents;
use crate::check::{Finding, fatal_of};
use crate::compare::{FLOOR_COUNTS, Overlay, RunFigures, compare};
use crate::motor::{Model, Motor, SimulationError};
use crate::recording::{CommandKind, Run};
use crate::units::rad_per_count;

/// Up to this multiple of the quantization error, recording and simulation agree.
pub const AT_THE_FLOOR: f64 = 1.2;

/// The models of Part 3, from the simplest on.
pub const MODELS: [Contents; 4] = [
    super::step_response::contents(
        "first_order_frictionless",
        "1st order, no friction",
        Model::FirstOrder,
        false,
        false,
    ),
    super::step_response::contents(
        "first_order_viscous",
        "1st order, viscous friction",
        Model::FirstOrder,
        true,
        false,
    ),
    super::step_response::contents(
        "first_order_coulomb",
        "1st order, viscous and Coulomb friction",
        Model::FirstOrder,
        true,
        true,
    ),
    super::step_response::contents(
        "second_order_coulomb",
        "2nd order, viscous and Coulomb friction",
        Model::SecondOrder,
        true,
        true,
    ),
];
/// Name of the model with the motor file's effects.
pub const WITH_EFFECTS: &str = "2nd order with the motor file's effects";

/// One model compared with one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelFit {
    /// Name.
    pub name: &'static str,
    /// Error figures of the comparison.
    pub figures: RunFigures,
    /// Steady speed of the model at the recording's voltage in rad/s, if it has a closed form.
    pub steady_rad_s: Option<f64>,
    /// Recorded minus simulated position in counts.
    pub residual_counts: Vec<f64>,
    /// Simulated speed by the same differences as the recorded one, in rad/s.
    pub simulated_speed_rad_s: Vec<Option<f64>>,
}

impl ModelFit {
    fn of(name: &'static str, overlay: &Overlay, steady_rad_s: Option<f64>) -> Self {
        Self {
            name,
            figures: overlay.figures.clone(),
            steady_rad_s,
            residual_counts: overlay.residual_counts.clone(),
            simulated_speed_rad_s: overlay.simulated_speed_rad_s.clone(),
        }
    }
}

/// The recorded speed in a steady interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SteadySpeed {
    /// Constant command (V, A or N m).
    pub command: f64,
    /// Begin in s.
    pub from_s: f64,
    /// End in s.
    pub to_s: f64,
    /// Mean speed in rad/s.
    pub speed_rad_s: f64,
    /// Resolution of this mean in rad/s: one count.
    pub one_count_rad_s: f64,
}

/// A recording and its simulations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recorded {
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Steady speed, if the command is constant for long enough.
    pub steady: Option<SteadySpeed>,
    /// Every model, from the simplest on.
    pub models: Vec<ModelFit>,
    /// Fatal findings of the recording with their remedies; `None` if it is usable.
    pub unusable: Option<String>,
    /// The recording with the complete model of the motor file.
    #[serde(skip)]
    pub overlay: Overlay,
    /// The recording.
    #[serde(skip)]
    pub run: Run,
}

/// The longest interval of one command other than 0; its second half is taken as steady.
fn steady_speed(run: &Run) -> Option<SteadySpeed> {
    let last = run.len().checked_sub(1)?;
    let mut best: Option<(usize, usize)> = None;
    let mut from = 0;
    for to in 1..=last {
        let ended = to == last || run.command[to] != run.command[from];
        if !ended {
            continue;
        }
        if run.command[from] != 0.0 && best.is_none_or(|(a, b)| b - a < to - from) {
            best = Some((from, to));
        }
        from = to;
    }
    let (from, to) = best?;
    let middle = from + (to - from) / 2;
    let (from_s, to_s) = (run.t_s[middle], run.t_s[to]);
    (to_s > from_s).then(|| {
        let one_count_rad_s = rad_per_count(run.counts_per_rev) / (to_s - from_s);
        SteadySpeed {
            command: run.command[from],
            from_s,
            to_s,
            speed_rad_s: (run.counts[to] as f64 - run.counts[middle] as f64) * one_count_rad_s,
            one_count_rad_s,
        }
    })
}

impl Recorded {
    /// Compares every model with a recording; `notes` are its reader's.
    ///
    /// # Errors
    /// A model cannot be simulated with the recording's command.
    pub fn of(run: Run, motor: &Motor, notes: &[String]) -> Result<Self, SimulationError> {
        let steady = steady_speed(&run);
        let volts = steady.filter(|_| run.command_kind == CommandKind::Voltage);
        let mut overlay = compare(&run, motor, Model::SecondOrder)?;
        overlay.figures.notes = notes.to_vec();
        let mut models = Vec::new();
        for contents in &MODELS {
            let plain = contents.motor(&motor.parameters);
            let steady_rad_s = volts
                .and_then(|steady| contents.steady_speed_rad_s(&motor.parameters, steady.command));
            let laid = compare(&run, &plain, contents.model)?;
            models.push(ModelFit::of(contents.name, &laid, steady_rad_s));
        }
        if !motor.effects.is_empty() {
            models.push(ModelFit::of(WITH_EFFECTS, &overlay, None));
        }
        Ok(Self {
            sample_time_s: run.sample_time_s,
            steady,
            models,
            unusable: None,
            overlay,
            run,
        })
    }

    /// The recording's file, without its folder.
    pub fn name(&self) -> String {
        let file = self.run.path.as_ref().and_then(|path| path.file_name());
        file.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// The recording with the findings about it.
    pub fn checked(mut self, findings: &[Finding]) -> Self {
        let fatal = fatal_of(findings, &self.overlay.figures.path);
        self.unusable = fatal.map(Finding::sentence);
        self
    }

    /// Whether the recording is usable.
    pub fn is_usable(&self) -> bool {
        self.unusable.is_none()
    }

    /// The model with this name.
    pub fn model(&self, name: &str) -> Option<&ModelFit> {
        self.models.iter().find(|model| model.name == name)
    }

    /// The model with the smallest position error.
    pub fn best(&self) -> Option<&ModelFit> {
        let error = |model: &&ModelFit| model.figures.position_rmse_counts;
        self.models
            .iter()
            .min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    /// Whether the best model's residual is the quantization error.
    pub fn is_at_the_floor(&self) -> bool {
        self.best()
            .is_some_and(|best| best.figures.position_rmse_counts < AT_THE_FLOOR * FLOOR_COUNTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steady_speed_is_that_of_the_second_half_of_the_longest_hold() {
        let samples = 400;
        let w = 5.0;
        let t_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * 0.003).collect();
        let command: Vec<f64> = t_s
            .iter()
            .map(|&t| if t < 0.3 { 0.0 } else { 4.5 })
            .collect();
        let counts = t_s
            .iter()
            .map(|&t| ((t - 0.3).max(0.0) * w * 720.0 / std::f64::consts::TAU).floor() as i64)
            .collect();
        let run = Run {
            sample_time_s: 0.003,
            counts_per_rev: 720.0,
            t_s,
            command,
            counts,
            ..Run::default()
        };
        let steady = steady_speed(&run).unwrap();
        assert_eq!(steady.command, 4.5);
        assert!((steady.from_s - 0.75).abs() < 0.01 && steady.to_s > 1.19);
        assert!((steady.speed_rad_s - w).abs() <= steady.one_count_rad_s);
    }

    #[test]
    fn a_run_of_one_sample_has_no_steady_speed() {
        let run = Run {
            t_s: vec![0.0],
            command: vec![4.5],
            counts: vec![0],
            ..Run::default()
        };
        assert_eq!(steady_speed(&run), None);
    }
}
