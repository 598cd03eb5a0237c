//! Residual torque (or command, where no torque is known) against speed, angle, time and voltage: means in bins.

use super::overlaid_run::OverlaidRun;
use crate::recording::CommandKind;
use crate::report::{Figure, Panel, Series, Stroke};
use crate::units::rpm_from_rad_s;

const BINS: usize = 36;
/// Bins over one turn: three per period of a ripple of order 30.
const ANGLE_BINS: usize = 90;
/// Bins with fewer samples, or fewer independent ones, are left out.
const FEWEST: usize = 4;
const FEWEST_INDEPENDENT: f64 = 2.0;
/// Correlation time: samples within it share the window of their parabola and count as one independent sample.
const INDEPENDENT_S: f64 = 0.045;

/// One sample: its abscissa, the residual torque of the models, and its weight in independent samples.
struct Sample {
    x: f64,
    /// In thousandths of the unit.
    residual: Vec<f64>,
    independent: f64,
}

/// A figure for each quantity that takes several values.
pub(super) fn figures(laid: &[OverlaidRun<'_>], y_label: &str) -> Vec<Figure> {
    let kind = laid.first().map(|run| run.run.command_kind);
    let command = match kind {
        Some(CommandKind::Current) => "current (A)",
        Some(CommandKind::Torque) => "torque (N m)",
        _ => "voltage (V)",
    };
    let speed = |run: &OverlaidRun<'_>, k: usize| {
        // The model's own speed is not quantized.
        rpm_from_rad_s(
            run.models
                .last()
                .map_or(f64::NAN, |m| m.overlay.true_speed_rad_s[k]),
        )
    };
    let angle = |run: &OverlaidRun<'_>, k: usize| {
        let turns = run.run.counts[k] as f64 / run.run.counts_per_rev;
        360.0 * turns.rem_euclid(1.0)
    };
    let all = [
        figure(laid, y_label, "speed (RPM)", BINS, &speed),
        figure(
            laid,
            y_label,
            "angle of the encoder (degrees)",
            ANGLE_BINS,
            &angle,
        ),
        figure(
            laid,
            y_label,
            "time since the run began (s)",
            BINS,
            &|run, k| run.run.t_s[k],
        ),
        figure(laid, y_label, command, BINS, &|run, k| run.run.command[k]),
    ];
    // A single bin shows no dependence.
    let is_dependence = |figure: &Figure| {
        figure
            .panels
            .iter()
            .flat_map(|panel| &panel.series)
            .any(|s| s.points.len() > 1)
    };
    all.into_iter().filter(is_dependence).collect()
}

fn figure(
    laid: &[OverlaidRun<'_>],
    y_label: &str,
    x_label: &str,
    bins: usize,
    x: &dyn Fn(&OverlaidRun<'_>, usize) -> f64,
) -> Figure {
    // The nominal model's offsets would hide the residual after re-identification.
    let models = laid.first().map_or(&[][..], |run| &run.models[1..]);
    let samples = samples(laid, x);
    let (low, high) = samples.iter().fold((f64::MAX, f64::MIN), |(low, high), s| {
        (low.min(s.x), high.max(s.x))
    });
    let width = ((high - low) / bins as f64).max(f64::MIN_POSITIVE);
    let mut boxes: Vec<Vec<&Sample>> = vec![Vec::new(); bins];
    for sample in &samples {
        boxes[(((sample.x - low) / width) as usize).min(bins - 1)].push(sample);
    }
    let (mut at, mut means, mut null95) = (Vec::new(), vec![Vec::new(); models.len()], Vec::new());
    for members in boxes {
        let independent: f64 = members.iter().map(|s| s.independent).sum();
        if members.len() < FEWEST || independent < FEWEST_INDEPENDENT {
            continue;
        }
        let count = members.len() as f64;
        at.push(members.iter().map(|s| s.x).sum::<f64>() / count);
        let mut spread = 0.0;
        for (m, means) in means.iter_mut().enumerate() {
            let mean = members.iter().map(|s| s.residual[m]).sum::<f64>() / count;
            means.push(mean);
            let squares = members.iter().map(|s| (s.residual[m] - mean).powi(2));
            spread = squares.sum::<f64>() / (count - 1.0);
        }
        null95.push(1.96 * (spread / independent).sqrt());
    }
    let mut series: Vec<Series> = models
        .iter()
        .zip(&means)
        .zip([Stroke::Broad, Stroke::Line])
        .map(|((model, means), stroke)| {
            Series::new(model.name.clone(), stroke, model.colour, &at, means)
        })
        .collect();
    let below: Vec<f64> = null95.iter().map(|half| -half).collect();
    series.push(Series::new(
        "no dependence",
        Stroke::Dashed,
        6,
        &at,
        &null95,
    ));
    series.push(Series::new("", Stroke::Dashed, 6, &at, &below));
    Figure {
        title: String::new(),
        x_label: x_label.to_owned(),
        panels: vec![Panel::new(y_label, series).marked(0.0, "")],
    }
}

fn samples(laid: &[OverlaidRun<'_>], x: &dyn Fn(&OverlaidRun<'_>, usize) -> f64) -> Vec<Sample> {
    let mut all = Vec::new();
    for run in laid {
        let independent = (run.run.sample_time_s / INDEPENDENT_S).min(1.0);
        for k in 0..run.run.len() {
            let residual: Option<Vec<f64>> = run.models[1..]
                .iter()
                .map(|model| model.residual[k].map(|residual| 1e3 * residual))
                .collect();
            let at = x(run, k);
            if let (Some(residual), true) = (residual, at.is_finite()) {
                all.push(Sample {
                    x: at,
                    residual,
                    independent,
                });
            }
        }
    }
    all
}
