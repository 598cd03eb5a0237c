//! One run, recorded and simulated: speed, position and error; each segment starts from its measured initial state,
//! as in the error budget.

use super::spread::Spread;
use super::words;
use crate::compare::speed_of_one_count;
use crate::diagnose::{Diagnosis, PredictedRun};
use crate::recording::Run;
use crate::report::comparison::{COARSE, COMMAND, RECORDED, command_label, run_words};
use crate::report::number::figure as digits;
use crate::report::{Figure, Panel, Series, Stroke};
use crate::units::{rad_per_count, rpm_from_rad_s};

/// Smoothing window in s for speeds that are coarsely quantized.
const SMOOTH_S: f64 = 0.06;
/// Colours of the models, from the nominal on.
const COLOURS: [usize; 3] = [6, 4, 1];

/// A run with the predictions of the models.
pub(super) struct RunWithModels<'a> {
    pub run: &'a Run,
    pub predicted: &'a PredictedRun,
    /// Names of the models; two if no effect is identified.
    pub models: Vec<String>,
}

impl<'a> RunWithModels<'a> {
    /// The runs of the error budget.
    pub fn all(diagnosis: &'a Diagnosis, runs: &'a [Run]) -> Vec<Self> {
        let both = diagnosis.predicted.iter().filter_map(|predicted| {
            let run = runs.get(predicted.run)?;
            Some(Self {
                run,
                predicted,
                models: words::models(diagnosis),
            })
        });
        both.filter(|both| both.predicted.gap_counts[0].len() == both.run.len())
            .collect()
    }

    /// Starts of the segments except the first, in s, where the model restarts from the measured state.
    fn restarts_s(&self) -> Vec<f64> {
        let restarts = self.restarts();
        restarts.map(|k| self.run.t_s[k]).collect()
    }

    fn restarts(&self) -> impl Iterator<Item = usize> {
        let starts = self.predicted.starts.iter().copied();
        starts.filter(|k| *k > 0 && *k < self.run.len())
    }

    /// A curve with gaps at restarts, so that a restart is not read as a step.
    fn broken(&self, values: &[f64]) -> Vec<f64> {
        let mut broken = values.to_vec();
        self.restarts().for_each(|k| broken[k] = f64::NAN);
        broken
    }

    fn position(&self, model: usize) -> Vec<f64> {
        let gaps = &self.predicted.gap_counts[model];
        let both = self.run.counts.iter().zip(gaps);
        both.map(|(&counts, gap)| counts as f64 - gap).collect()
    }

    /// Speed of a predicted position, differentiated within each segment.
    fn speed(&self, position: &[f64], is_coarse: bool) -> Vec<f64> {
        let starts = &self.predicted.starts;
        let ends = starts.iter().skip(1).copied().chain([position.len()]);
        let mut rpm = vec![f64::NAN; position.len()];
        for (&from, to) in starts.iter().zip(ends) {
            let segment = smooth(
                self.run,
                position,
                from..to,
                if is_coarse { SMOOTH_S } else { 0.0 },
            );
            rpm[from..to].copy_from_slice(&segment);
        }
        rpm
    }
}

/// The recorded speed of a run.
pub fn recorded_speed(run: &Run) -> Panel {
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let rpm = smooth_rpm(run, &counts);
    let series = Series::new("recorded", Stroke::Line, RECORDED, &run.t_s, &rpm);
    Panel::new("speed (RPM)", vec![series]).robust()
}

/// Whether one count in one sample is a large share of the speed.
pub(super) fn is_coarse(run: &Run) -> bool {
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let top = smooth_rpm(run, &counts)
        .iter()
        .fold(0.0, |top, speed| f64::max(top, speed.abs()));
    let one_count = rpm_from_rad_s(speed_of_one_count(run.counts_per_rev, run.sample_time_s));
    one_count > COARSE * top && run.sample_time_s < SMOOTH_S / 2.0
}

/// Speed in RPM of a position in counts, over the neighbouring samples.
pub(super) fn smooth_rpm(run: &Run, counts: &[f64]) -> Vec<f64> {
    smooth(run, counts, 0..counts.len(), SMOOTH_S)
}

/// The same within a range of samples; over a time of 0, from the previous sample.
fn smooth(run: &Run, counts: &[f64], samples: std::ops::Range<usize>, over_s: f64) -> Vec<f64> {
    let half = (over_s / 2.0 / run.sample_time_s).round() as usize;
    let (first, last) = (samples.start, samples.end.saturating_sub(1));
    let speed = |k: usize| {
        let (from, to) = match half {
            0 => (k.saturating_sub(1).max(first), k),
            half => (k.saturating_sub(half).max(first), (k + half).min(last)),
        };
        let turned_rad = (counts[to] - counts[from]) * rad_per_count(run.counts_per_rev);
        rpm_from_rad_s(turned_rad / (run.t_s[to] - run.t_s[from]))
    };
    samples.clone().map(speed).collect()
}

/// Errors of the last model in all runs: speed in RPM and position in counts.
pub(super) struct ErrorSpreads {
    speed: Spread,
    position: Spread,
}

impl ErrorSpreads {
    pub fn of(all: &[RunWithModels<'_>]) -> Self {
        let last = |beside: &RunWithModels<'_>| beside.models.len() - 1;
        let position = all.iter().map(|beside| {
            let errors = beside.predicted.gap_counts[last(beside)].clone();
            (beside.predicted, errors)
        });
        let speed = all.iter().map(|beside| {
            let predicted = beside.speed(&beside.position(last(beside)), is_coarse(beside.run));
            let recorded = recorded_rpm(beside.run);
            let errors = recorded.iter().zip(&predicted).map(|(a, b)| a - b);
            (beside.predicted, errors.collect())
        });
        Self {
            speed: Spread::of(speed),
            position: Spread::of(position),
        }
    }
}

/// The recorded speed with the smoothing of the predictions.
fn recorded_rpm(run: &Run) -> Vec<f64> {
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let over_s = if is_coarse(run) { SMOOTH_S } else { 0.0 };
    smooth(run, &counts, 0..counts.len(), over_s)
}

pub(super) fn figure(beside: &RunWithModels<'_>, spreads: &ErrorSpreads) -> Figure {
    let run = beside.run;
    let t_s = &run.t_s;
    let coarse = is_coarse(run);
    let (broad, thin) = if coarse {
        (Stroke::Broad, Stroke::Line)
    } else {
        (Stroke::BroadStep, Stroke::Step)
    };
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let recorded_rpm = recorded_rpm(run);
    let recorded = |stroke, y: &[f64]| Series::new("recorded", stroke, RECORDED, t_s, y);
    let mut speed = vec![recorded(broad, &recorded_rpm)];
    let mut position = vec![recorded(Stroke::Broad, &counts)];
    let mut gaps = Vec::new();
    for (k, (name, colour)) in beside.models.iter().zip(COLOURS).enumerate() {
        let line = |stroke, y: &[f64]| Series::new(name.clone(), stroke, colour, t_s, y);
        let predicted = beside.position(k);
        let rpm = beside.speed(&predicted, coarse);
        speed.push(line(thin, &beside.broken(&rpm)));
        position.push(line(Stroke::Line, &beside.broken(&predicted)));
        gaps.push(line(
            Stroke::Line,
            &beside.broken(&beside.predicted.gap_counts[k]),
        ));
        if k + 1 == beside.models.len() {
            let band = |spread: &Spread, middle: &[f64]| {
                spread.around(beside.predicted, t_s, &beside.broken(middle), colour)
            };
            speed.extend(band(&spreads.speed, &rpm));
            position.extend(band(&spreads.position, &predicted));
        }
    }
    let restarts = &beside.restarts_s();
    let with_effects = gaps.split_off(gaps.len().min(2));
    let mut panels = vec![
        Panel::new("speed (RPM)", speed).weighing(2.0).robust(),
        Panel::new("position (counts)", position).weighing(1.4),
        Panel::new("error (counts)", gaps).marked(0.0, ""),
    ];
    if !with_effects.is_empty() {
        panels.push(Panel::new("error (counts)", with_effects).marked(0.0, ""));
    }
    panels = (panels.into_iter())
        .map(|panel| panel.restarting_at(restarts))
        .collect();
    let command = Series::new("command", Stroke::Step, COMMAND, t_s, &run.command);
    panels.push(Panel::new(command_label(run), vec![command]).weighing(0.6));
    Figure {
        title: run_words(run),
        x_label: "time (s)".to_owned(),
        panels,
    }
}

pub(super) fn caption(beside: &RunWithModels<'_>) -> String {
    let figures = beside.models.iter().enumerate();
    let figures: Vec<String> = figures
        .map(|(k, name)| format!("{name} {}", digits(beside.predicted.rms(k), 3)))
        .collect();
    format!(
        "Prediction error of the position in counts RMS: {}.",
        figures.join(", ")
    )
}
