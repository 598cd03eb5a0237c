//! One run before and after: speed, position, what is left.

use super::laid::{LaidModel, LaidRun};
use crate::compare::speed_of_one_count;
use crate::recording::Run;
use crate::report::comparison::{COARSE, COMMAND, RECORDED, command_label, what_ran};
use crate::report::{Figure, Panel, Series, Stroke};
use crate::units::{rad_per_count, rpm_from_rad_s};

/// Time over which speeds are smoothed where one count in one sample is much of the speed, in s.
const SMOOTH_S: f64 = 0.06;

/// Whether one count in one sample is much of the speed.
fn is_coarse(laid: &LaidRun<'_>) -> bool {
    let run = laid.run;
    let speeds = laid
        .models
        .iter()
        .flat_map(|model| &model.overlay.true_speed_rad_s);
    let top = speeds.fold(0.0, |top, speed| f64::max(top, speed.abs()));
    let one_count = speed_of_one_count(run.counts_per_rev, run.sample_time_s);
    one_count > COARSE * top && run.sample_time_s < SMOOTH_S / 2.0
}

/// Speed in RPM of a position in counts, over the samples around each one.
pub(super) fn smooth_rpm(run: &Run, counts: &[f64]) -> Vec<f64> {
    let half = ((SMOOTH_S / 2.0 / run.sample_time_s).round() as usize).max(1);
    let last = counts.len().saturating_sub(1);
    (0..counts.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let turned_rad = (counts[to] - counts[from]) * rad_per_count(run.counts_per_rev);
            rpm_from_rad_s(turned_rad / (run.t_s[to] - run.t_s[from]))
        })
        .collect()
}

/// Speed in RPM by the recorder's difference.
fn difference_rpm(speeds: &[Option<f64>]) -> Vec<f64> {
    let rpm = speeds.iter().map(|s| s.map_or(f64::NAN, rpm_from_rad_s));
    rpm.collect()
}

/// Speed, position, gap and command of a run, under every model.
pub(super) fn figure(laid: &LaidRun<'_>) -> Figure {
    let run = laid.run;
    let t_s = &run.t_s;
    let coarse = is_coarse(laid);
    let (broad, thin) = if coarse {
        (Stroke::Broad, Stroke::Line)
    } else {
        (Stroke::BroadStep, Stroke::Step)
    };
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let recorded_rpm = match laid.models.first() {
        Some(model) if !coarse => difference_rpm(&model.overlay.recorded_speed_rad_s),
        _ => smooth_rpm(run, &counts),
    };
    let mut speed = vec![Series::new("recorded", broad, RECORDED, t_s, &recorded_rpm)];
    let mut position = vec![Series::new(
        "recorded",
        Stroke::Broad,
        RECORDED,
        t_s,
        &counts,
    )];
    for model in &laid.models {
        let line = |stroke: Stroke, y: &[f64]| {
            Series::new(model.name.clone(), stroke, model.colour, t_s, y)
        };
        let position_counts = &model.overlay.simulated_position_counts;
        let model_rpm = if coarse {
            smooth_rpm(run, position_counts)
        } else {
            difference_rpm(&model.overlay.simulated_speed_rad_s)
        };
        speed.push(line(thin, &model_rpm));
        position.push(line(Stroke::Line, position_counts));
    }
    let gap = |model: &LaidModel| {
        let stroke = Stroke::Line;
        Series::new(
            model.name.clone(),
            stroke,
            model.colour,
            t_s,
            &model.overlay.residual_counts,
        )
    };
    let mut panels = vec![
        Panel::new("speed (RPM)", speed).weighing(2.0),
        Panel::new("position (counts)", position).weighing(1.4),
        Panel::new(
            "gap (counts)",
            laid.models.iter().take(2).map(gap).collect(),
        )
        .marked(0.0, ""),
    ];
    if let Some(with_effects) = laid.models.get(2) {
        panels.push(Panel::new("gap (counts)", vec![gap(with_effects)]).marked(0.0, ""));
    }
    let command = Series::new("command", Stroke::Step, COMMAND, t_s, &run.command);
    panels.push(Panel::new(command_label(run), vec![command]).weighing(0.6));
    Figure {
        title: what_ran(run),
        x_label: "time (s)".to_owned(),
        panels,
    }
}

/// What the picture shows, and each model's figure.
pub(super) fn caption(laid: &LaidRun<'_>) -> String {
    let figures: Vec<String> = laid
        .models
        .iter()
        .map(|model| {
            let figures = &model.overlay.figures;
            format!("{} {:.2}", model.name, figures.position_rmse_counts)
        })
        .collect();
    let mean = if is_coarse(laid) {
        " Speeds are taken over 60 ms: one count in one sample is much of the speed."
    } else {
        ""
    };
    format!(
        "Position gap in counts RMS: {}; the encoder alone leaves 0.29.{mean}",
        figures.join(", ")
    )
}
