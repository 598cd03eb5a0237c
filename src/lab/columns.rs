//! Figures of the lab as CSV: units in the column names, full precision.

use std::fmt::Write;

use super::Lab;
use super::recorded::Recorded;
use super::sampling::Sampled;
use crate::units::rpm_from_rad_s;

/// Columns of equal length as CSV; a missing value is an empty cell.
fn csv(columns: &[(String, Vec<Option<f64>>)]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut out = names.join(",");
    out.push('\n');
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    for row in 0..rows {
        for (k, (_, values)) in columns.iter().enumerate() {
            if k > 0 {
                out.push(',');
            }
            if let Some(value) = values.get(row).copied().flatten() {
                let _ = write!(out, "{value}");
            }
        }
        out.push('\n');
    }
    out
}

fn column(name: &str, values: impl IntoIterator<Item = f64>) -> (String, Vec<Option<f64>>) {
    (name.to_owned(), values.into_iter().map(Some).collect())
}

fn rpm_column(name: &str, speeds: &[Option<f64>]) -> (String, Vec<Option<f64>>) {
    let rpm = speeds.iter().map(|speed| speed.map(rpm_from_rad_s));
    (name.to_owned(), rpm.collect())
}

fn true_rpm(speeds: &[f64]) -> impl Iterator<Item = f64> {
    speeds.iter().map(|&speed| rpm_from_rad_s(speed))
}

/// Part 1: the five curves in RPM.
pub fn step_responses(lab: &Lab) -> String {
    let mut columns = vec![column("t_s", lab.part_1.t_s.iter().copied())];
    for curve in &lab.part_1.curves {
        columns.push(column(
            &format!("{}_rpm", curve.id),
            true_rpm(&curve.speed_rad_s),
        ));
    }
    csv(&columns)
}

/// Part 2: one discretized response.
pub fn sampled(sampled: &Sampled) -> String {
    csv(&[
        column("t_s", sampled.t_s.iter().copied()),
        column("counts", sampled.counts.iter().map(|&n| n as f64)),
        rpm_column("speed_rpm", &sampled.speed_rad_s),
        column("true_speed_rpm", true_rpm(&sampled.true_speed_rad_s)),
    ])
}

/// Part 3: one recording, the simulation with the most effects, and the residuals of every model.
pub fn recorded(recorded: &Recorded) -> String {
    let (run, overlay) = (&recorded.run, &recorded.overlay);
    let mut columns = vec![
        column("t_s", run.t_s.iter().copied()),
        column(run.command_kind.column(), run.command.iter().copied()),
        column("recorded_counts", run.counts.iter().map(|&n| n as f64)),
        column(
            "simulated_counts",
            overlay.simulated_position_counts.iter().copied(),
        ),
        rpm_column("recorded_rpm", &overlay.recorded_speed_rad_s),
        rpm_column("simulated_rpm", &overlay.simulated_speed_rad_s),
        column("true_speed_rpm", true_rpm(&overlay.true_speed_rad_s)),
    ];
    for model in &recorded.models {
        let name: String = model
            .name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
            .collect();
        let name = name.replace("__", "_");
        columns.push(rpm_column(
            &format!("rpm_{name}"),
            &model.simulated_speed_rad_s,
        ));
        columns.push(column(
            &format!("residual_counts_{name}"),
            model.residual_counts.iter().copied(),
        ));
    }
    csv(&columns)
}
