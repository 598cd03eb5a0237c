//! The location of the error: stage of the chain, time intervals, and residual torque against speed, angle, time and
//! voltage.

use super::ordered;
use super::overlaid_run::OverlaidRun;
use super::overlay::smooth_rpm;
use super::words;
use crate::diagnose::{Diagnosis, Region};
use crate::motor::catalogue::Stage;
use crate::report::comparison::{COMMAND, RECORDED, command_label};
use crate::report::number::{percent, probability};
use crate::report::{Band, Bar, Bars, Figure, Page, Panel, Scale, Series, Size, Stroke};

/// Opacity of the darkest shade.
const DARKEST: f64 = 0.45;

/// A stage below this probability has no visible bar.
const LEAST: f64 = 0.001;

pub(super) fn section(page: &mut Page, diagnosis: &Diagnosis, laid: &[OverlaidRun<'_>]) {
    page.section("Where the error lies");
    let stages = stages(diagnosis);
    if stages.bars.iter().all(|bar| bar.value < LEAST) {
        page.paragraph("No stage of the chain has a probable effect.");
    } else {
        page.bars(
            &stages,
            "Probability that a stage has an effect, in the order in which a signal passes the stages.",
        );
    }
    let is_unexplained = diagnosis.unexplained.share > 0.0;
    let listed = &diagnosis.place.regions[..];
    regions(page, if is_unexplained { listed } else { &[] }, laid);
    let (name, unit) = words::residual_words(diagnosis);
    page.subsection(&format!(
        "Residual {name} against speed, angle, time and command"
    ));
    page.paragraph(&format!(
        "Additional {name} that would remove the position error of a model. Of a complete model it stays between the dashed lines."
    ));
    let pictures = ordered::figures(laid, &format!("residual {name} ({unit})"));
    page.figures(pictures.iter().map(|figure| (figure, "")));
    page.note("Dashed: 95 % interval of the mean of a bin without a dependence.");
}

fn stages(diagnosis: &Diagnosis) -> Bars {
    let bars = Stage::ALL.iter().map(|stage| {
        let value = diagnosis.place.stage_probabilities.get(stage.id());
        let value = value.copied().unwrap_or(0.0);
        Bar {
            name: stage.id().to_owned(),
            value,
            text: probability(value),
            interval: None,
            colour: 0,
        }
    });
    Bars {
        title: "Stage of the chain".to_owned(),
        scale: Scale(1.0),
        bars: bars.collect(),
    }
}

fn regions(page: &mut Page, regions: &[Region], laid: &[OverlaidRun<'_>]) {
    page.subsection("Time intervals with the largest residual");
    if regions.is_empty() {
        page.paragraph("No significant error above the noise floor remains.");
        return;
    }
    let most = regions.iter().fold(0.0, |most, r| f64::max(most, r.share));
    for run in laid {
        let mine: Vec<(usize, &Region)> = regions
            .iter()
            .enumerate()
            .filter(|(_, region)| region.run == run.id)
            .collect();
        if mine.is_empty() {
            continue;
        }
        page.figure(
            &intervals(run, &mine, most),
            Size::SMALL,
            "Recorded speed; shaded in proportion to the share of the error. The numbers are those of the table.",
        );
    }
    let rows: Vec<Vec<String>> = regions
        .iter()
        .enumerate()
        .map(|(k, region)| {
            let run = laid.iter().find(|run| run.id == region.run);
            vec![
                (k + 1).to_string(),
                run.map_or_else(|| region.run.clone(), |run| run.name.clone()),
                format!("{:.3}", region.from_s),
                format!("{:.3}", region.to_s),
                region.regime.words().to_owned(),
                percent(region.share),
            ]
        })
        .collect();
    page.table(&["", "run", "from (s)", "to (s)", "regime", "share"], &rows);
    let listed: f64 = regions.iter().map(|region| region.share).sum();
    page.note(&format!(
        "Shares of the unexplained squared error above the noise floor. Intervals with smaller shares have the other {}.",
        percent((1.0 - listed).max(0.0))
    ));
}

fn intervals(laid: &OverlaidRun<'_>, regions: &[(usize, &Region)], most: f64) -> Figure {
    let run = laid.run;
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let rpm = smooth_rpm(run, &counts);
    let mut bands: Vec<Band> = regions
        .iter()
        .map(|(k, region)| Band {
            from: region.from_s,
            to: region.to_s,
            strength: DARKEST * (region.share / most).sqrt(),
            label: (k + 1).to_string(),
        })
        .collect();
    bands.sort_by(|a, b| a.from.total_cmp(&b.from));
    let speed = Series::new("", Stroke::Line, RECORDED, &run.t_s, &rpm);
    let command = Series::new("", Stroke::Step, COMMAND, &run.t_s, &run.command);
    Figure {
        title: laid.name.clone(),
        x_label: "time (s)".to_owned(),
        panels: vec![
            Panel::new("speed (RPM)", vec![speed])
                .weighing(2.0)
                .robust()
                .shaded(bands),
            Panel::new(command_label(run), vec![command]),
        ],
    }
}
