//! The torque that a model lacks against speed, angle, time and voltage: means in bins.

use super::laid::LaidRun;
use crate::recording::CommandKind;
use crate::report::{Figure, Panel, Series, Stroke};
use crate::units::rpm_from_rad_s;

/// Bins over the whole range.
const BINS: usize = 36;
/// Bins over one turn: three to a period of what repeats thirty times in it.
const ANGLE_BINS: usize = 90;
/// Bins with fewer samples, or fewer looks, are left out.
const FEWEST: usize = 4;
const FEWEST_LOOKS: f64 = 2.0;
/// Neighbours within this time share their parabola's samples: so much of a window is one look.
const ONE_LOOK_S: f64 = 0.045;

/// One sample: where it is on the axis, what the models lack there, and how many looks it is.
struct Sample {
    x: f64,
    missing_mnm: Vec<f64>,
    looks: f64,
}

/// A picture for each quantity that takes several values.
pub(super) fn figures(laid: &[LaidRun<'_>]) -> Vec<Figure> {
    let kind = laid.first().map(|run| run.run.command_kind);
    let command = match kind {
        Some(CommandKind::Current) => "current (A)",
        Some(CommandKind::Torque) => "torque (N m)",
        _ => "voltage (V)",
    };
    let speed = |run: &LaidRun<'_>, k: usize| {
        // The model's own speed has no rounding in it.
        rpm_from_rad_s(
            run.models
                .last()
                .map_or(f64::NAN, |m| m.overlay.true_speed_rad_s[k]),
        )
    };
    let angle = |run: &LaidRun<'_>, k: usize| {
        let turns = run.run.counts[k] as f64 / run.run.counts_per_rev;
        360.0 * turns.rem_euclid(1.0)
    };
    let all = [
        figure(laid, "speed (RPM)", BINS, &speed),
        figure(laid, "angle of the encoder (degrees)", ANGLE_BINS, &angle),
        figure(laid, "time since the run began (s)", BINS, &|run, k| {
            run.run.t_s[k]
        }),
        figure(laid, command, BINS, &|run, k| run.run.command[k]),
    ];
    // One bin has no order.
    let has_order = |figure: &Figure| {
        figure
            .panels
            .iter()
            .flat_map(|panel| &panel.series)
            .any(|s| s.points.len() > 1)
    };
    all.into_iter().filter(has_order).collect()
}

fn figure(
    laid: &[LaidRun<'_>],
    x_label: &str,
    bins: usize,
    x: &dyn Fn(&LaidRun<'_>, usize) -> f64,
) -> Figure {
    // The nominal model's offsets say less than what refitting leaves.
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
    let (mut at, mut means, mut chance) = (Vec::new(), vec![Vec::new(); models.len()], Vec::new());
    for members in boxes {
        let looks: f64 = members.iter().map(|s| s.looks).sum();
        if members.len() < FEWEST || looks < FEWEST_LOOKS {
            continue;
        }
        let count = members.len() as f64;
        at.push(members.iter().map(|s| s.x).sum::<f64>() / count);
        let mut spread = 0.0;
        for (m, means) in means.iter_mut().enumerate() {
            let mean = members.iter().map(|s| s.missing_mnm[m]).sum::<f64>() / count;
            means.push(mean);
            let squares = members.iter().map(|s| (s.missing_mnm[m] - mean).powi(2));
            spread = squares.sum::<f64>() / (count - 1.0);
        }
        chance.push(1.96 * (spread / looks).sqrt());
    }
    let mut series: Vec<Series> = models
        .iter()
        .zip(&means)
        .zip([Stroke::Broad, Stroke::Line])
        .map(|((model, means), stroke)| {
            Series::new(model.name.clone(), stroke, model.colour, &at, means)
        })
        .collect();
    let below: Vec<f64> = chance.iter().map(|c| -c).collect();
    series.push(Series::new("chance", Stroke::Dashed, 6, &at, &chance));
    series.push(Series::new("", Stroke::Dashed, 6, &at, &below));
    Figure {
        title: String::new(),
        x_label: x_label.to_owned(),
        panels: vec![Panel::new("missing torque (mN m)", series).marked(0.0, "")],
    }
}

fn samples(laid: &[LaidRun<'_>], x: &dyn Fn(&LaidRun<'_>, usize) -> f64) -> Vec<Sample> {
    let mut all = Vec::new();
    for run in laid {
        let looks = (run.run.sample_time_s / ONE_LOOK_S).min(1.0);
        for k in 0..run.run.len() {
            let missing: Option<Vec<f64>> = run.models[1..]
                .iter()
                .map(|model| model.missing_nm[k].map(|torque| 1e3 * torque))
                .collect();
            let at = x(run, k);
            if let (Some(missing_mnm), true) = (missing, at.is_finite()) {
                all.push(Sample {
                    x: at,
                    missing_mnm,
                    looks,
                });
            }
        }
    }
    all
}
