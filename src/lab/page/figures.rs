//! The drawings of the report.

use crate::lab::recorded::Recorded;
use crate::lab::sampling::Sampled;
use crate::lab::step_response::END_S;
use crate::lab::{Lab, StepResponses};
use crate::report::comparison::overlay;
use crate::report::{Figure, Panel, Series, Stroke};
use crate::units::rpm_from_rad_s;

/// Time shown before a recorded step, in s.
const LEAD_S: f64 = 0.06;

fn rpm(speeds: &[f64]) -> Vec<f64> {
    speeds.iter().map(|&speed| rpm_from_rad_s(speed)).collect()
}

/// Part 1: the five curves, and the difference of the orders below.
pub fn step_responses(lab: &Lab) -> Figure {
    let part = &lab.part_1;
    // The handout's colours: blue, red, green; cyan and magenta dashed.
    let strokes = [
        (Stroke::Line, 0),
        (Stroke::Dashed, 1),
        (Stroke::Line, 2),
        (Stroke::Line, 5),
        (Stroke::Dashed, 3),
    ];
    let curves = part
        .curves
        .iter()
        .zip(strokes)
        .map(|(curve, (stroke, colour))| {
            Series::new(
                curve.name,
                stroke,
                colour,
                &part.t_s,
                &rpm(&curve.speed_rad_s),
            )
        })
        .collect();
    let between = |name: &str, colour: usize, first: usize, second: usize| {
        let pairs = part.curves[first]
            .speed_rad_s
            .iter()
            .zip(&part.curves[second].speed_rad_s);
        let difference: Vec<f64> = pairs.map(|(a, b)| rpm_from_rad_s(a - b)).collect();
        Series::new(name, Stroke::Line, colour, &part.t_s, &difference)
    };
    Figure {
        title: format!("Step of {} V", lab.parameters.supply_v),
        x_label: "time (s)".to_owned(),
        panels: vec![
            Panel::new("speed (RPM)", curves).weighing(2.2),
            Panel::new(
                "1st \u{2212} 2nd order (RPM)",
                vec![
                    between("with viscous friction", 0, 0, 1),
                    between("no friction", 3, 3, 4),
                ],
            ),
        ],
    }
}

/// Part 2: one discretized response over the true speed.
pub fn sampled(sampled: &Sampled, part_1: &StepResponses) -> Figure {
    let speeds: Vec<f64> = sampled
        .speed_rad_s
        .iter()
        .map(|speed| speed.map_or(f64::NAN, rpm_from_rad_s))
        .collect();
    let truth = &part_1.curves[0];
    Figure {
        title: format!(
            "First order, discretised at TS = {} s",
            sampled.sample_time_s
        ),
        x_label: "time (s)".to_owned(),
        panels: vec![Panel::new(
            "speed (RPM)",
            vec![
                Series::new(
                    "true speed",
                    Stroke::Line,
                    6,
                    &part_1.t_s,
                    &rpm(&truth.speed_rad_s),
                ),
                Series::new(
                    "by encoder and difference",
                    Stroke::Step,
                    0,
                    &sampled.t_s,
                    &speeds,
                ),
            ],
        )],
    }
}

/// Part 3: the step, recorded and simulated with and without friction.
pub fn step(recorded: &Recorded) -> Figure {
    let run = &recorded.run;
    let steps_at = run.command.iter().position(|&command| command != 0.0);
    let from_s = steps_at.map_or(0.0, |k| run.t_s[k]) - LEAD_S;
    let to_s = from_s + LEAD_S + END_S;
    let shown: Vec<usize> = (0..run.len())
        .filter(|&k| (from_s..=to_s).contains(&run.t_s[k]))
        .collect();
    let t_s: Vec<f64> = shown.iter().map(|&k| run.t_s[k]).collect();
    let series = |name: &str, stroke, colour, speeds: &[Option<f64>]| {
        let rpm: Vec<f64> = shown
            .iter()
            .map(|&k| speeds[k].map_or(f64::NAN, rpm_from_rad_s))
            .collect();
        Series::new(name, stroke, colour, &t_s, &rpm)
    };
    let mut drawn = Vec::new();
    if let Some(without) = recorded.models.first() {
        let speeds = &without.simulated_speed_rad_s;
        drawn.push(series(without.name, Stroke::Step, 3, speeds));
    }
    if let Some(with) = recorded.models.last() {
        drawn.push(series(
            with.name,
            Stroke::Step,
            1,
            &with.simulated_speed_rad_s,
        ));
    }
    drawn.push(series(
        "recorded",
        Stroke::Dots,
        0,
        &recorded.overlay.recorded_speed_rad_s,
    ));
    Figure {
        title: format!("{}, TS = {} s", recorded.name(), recorded.sample_time_s),
        x_label: "time (s)".to_owned(),
        panels: vec![Panel::new("speed (RPM)", drawn)],
    }
}

/// Part 3: recorded and simulated speed and position, and their difference.
pub fn recorded(recorded: &Recorded) -> Figure {
    let name = recorded.models.last().map_or("", |model| model.name);
    let title = format!("TS = {} s; simulated: {name}", recorded.sample_time_s);
    overlay(&recorded.run, &recorded.overlay, &title)
}

/// Part 3: position residuals of every model.
pub fn residuals(recorded: &Recorded) -> Figure {
    let t_s = &recorded.run.t_s;
    let series = recorded
        .models
        .iter()
        .enumerate()
        .map(|(colour, model)| {
            Series::new(
                model.name,
                Stroke::Line,
                colour,
                t_s,
                &model.residual_counts,
            )
        })
        .collect();
    Figure {
        title: format!("Position gap, TS = {} s", recorded.sample_time_s),
        x_label: "time (s)".to_owned(),
        panels: vec![Panel::new("recorded \u{2212} simulated (counts)", series)],
    }
}
