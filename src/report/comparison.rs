//! The page and figures of a comparison: speed in RPM, position in counts, residual below.

use super::diagnosis::{checks, few_words};
use super::{Figure, Page, Panel, Series, Size, Stroke};
use crate::check::{Finding, fatal_of};
use crate::compare::{Overlay, RunFigures, speed_of_one_count};
use crate::motor::Motor;
use crate::plain::one_line;
use crate::recording::{CommandKind, Run};
use crate::units::rpm_from_rad_s;

/// Colours by meaning, the same in every figure.
pub(super) const RECORDED: usize = 0;
const SIMULATED: usize = 1;
const TRUE_SPEED: usize = 6;
pub(super) const COMMAND: usize = 2;
const RESIDUAL: usize = 3;

/// Above this share of the top speed for one count in one sample, moving averages are drawn as well.
pub(super) const COARSE: f64 = 0.1;
/// Window of the moving average: the lab's slow sample time.
const SMOOTH_S: f64 = 0.03;

/// Moving average over `count` values, over fewer at the beginning.
fn running_mean(values: &[f64], count: usize) -> Vec<f64> {
    let mean = |k: usize| {
        let window = &values[(k + 1).saturating_sub(count)..=k];
        let finite = window.iter().filter(|v| v.is_finite());
        finite.clone().sum::<f64>() / finite.count() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// Speed, position and residual of one run over time, with the command below.
pub fn overlay(run: &Run, overlay: &Overlay, title: &str) -> Figure {
    let t_s = &run.t_s;
    let rpm = |speeds: &[Option<f64>]| -> Vec<f64> {
        speeds
            .iter()
            .map(|speed| speed.map_or(f64::NAN, rpm_from_rad_s))
            .collect()
    };
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let true_rpm: Vec<f64> = overlay
        .true_speed_rad_s
        .iter()
        .map(|&w| rpm_from_rad_s(w))
        .collect();
    let recorded = rpm(&overlay.recorded_speed_rad_s);
    let simulated = rpm(&overlay.simulated_speed_rad_s);
    let top = true_rpm
        .iter()
        .fold(0.0, |top, speed| f64::max(top, speed.abs()));
    let one_count = rpm_from_rad_s(speed_of_one_count(run.counts_per_rev, run.sample_time_s));
    // A coarse difference is read as its moving average.
    let averaged = (SMOOTH_S / run.sample_time_s).round() as usize;
    let coarse = one_count > COARSE * top && averaged > 1;
    let (behind, above) = if coarse {
        (Stroke::FaintStep, Stroke::FaintStep)
    } else {
        (Stroke::BroadStep, Stroke::Step)
    };
    let mut speed = vec![
        Series::new("recorded", behind, RECORDED, t_s, &recorded),
        Series::new("simulated", above, SIMULATED, t_s, &simulated),
    ];
    if coarse {
        let mean = |values: &[f64]| running_mean(values, averaged);
        let name = |what: &str| format!("{what}, mean of {averaged}");
        speed.push(Series::new(
            name("recorded"),
            Stroke::Broad,
            RECORDED,
            t_s,
            &mean(&recorded),
        ));
        speed.push(Series::new(
            name("simulated"),
            Stroke::Line,
            SIMULATED,
            t_s,
            &mean(&simulated),
        ));
    }
    speed.push(Series::new(
        "simulated before quantization",
        Stroke::Dashed,
        TRUE_SPEED,
        t_s,
        &true_rpm,
    ));
    let position = vec![
        Series::new("recorded", Stroke::Broad, RECORDED, t_s, &counts),
        Series::new(
            "simulated",
            Stroke::Line,
            SIMULATED,
            t_s,
            &overlay.simulated_position_counts,
        ),
    ];
    let residual = Series::new(
        "recorded \u{2212} simulated",
        Stroke::Line,
        RESIDUAL,
        t_s,
        &overlay.residual_counts,
    );
    let command = Series::new("command", Stroke::Step, COMMAND, t_s, &run.command);
    Figure {
        title: title.to_owned(),
        x_label: "time (s)".to_owned(),
        panels: vec![
            Panel::new("speed (RPM)", speed).weighing(2.0).robust(),
            Panel::new("position (counts)", position).weighing(1.5),
            Panel::new("error (counts)", vec![residual]).marked(0.0, ""),
            Panel::new(command_label(run), vec![command]).weighing(0.6),
        ],
    }
}

pub(super) fn command_label(run: &Run) -> &'static str {
    match run.command_kind {
        CommandKind::Voltage => "command (V)",
        CommandKind::Current => "command (A)",
        CommandKind::Torque => "command (N m)",
    }
}

pub(super) fn run_words(run: &Run) -> String {
    let profile = run.header.get("profile").and_then(toml::Value::as_str);
    format!(
        "{}, sampled every {} ms",
        profile.unwrap_or("recorded"),
        (run.sample_time_s * 1e6).round() / 1e3
    )
}

/// The figures of all runs as table rows, with the column names.
pub fn figures_table(figures: &[&RunFigures]) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let names = vec![
        "run",
        "TS (s)",
        "samples",
        "lost",
        "position RMSE (counts)",
        "largest (counts)",
        "floor (counts)",
        "speed RMSE (RPM)",
        "speed NRMSE",
    ];
    let rows = figures
        .iter()
        .map(|run| {
            vec![
                one_line(&run.path).into_owned(),
                format!("{}", run.sample_time_s),
                run.samples.to_string(),
                run.lost.to_string(),
                format!("{:.3}", run.position_rmse_counts),
                format!("{:.2}", run.position_largest_counts),
                format!("{:.3}", run.floor_counts),
                format!("{:.3}", run.velocity_rmse_rpm),
                run.velocity_nrmse
                    .map_or("–".to_owned(), |relative| format!("{relative:.4}")),
            ]
        })
        .collect();
    (names, rows)
}

/// Largest position error of an accurate simulation, in quantization errors. Convention.
const ACCURATE: f64 = 1.2;

/// Whether a run is simulated down to the quantization error.
fn is_accurate(figures: &RunFigures) -> bool {
    figures.position_rmse_counts < ACCURATE * figures.floor_counts
}

/// One sentence on the accuracy of a run's simulation; with a fatal finding, the finding and its remedy.
pub fn verdict(figures: &RunFigures, findings: &[Finding]) -> String {
    if let Some(fatal) = fatal_of(findings, &figures.path) {
        return format!(
            "{} is not usable: {}. The comparison is not valid before that is corrected.",
            one_line(&figures.path),
            fatal.sentence()
        );
    }
    let ratio = figures.position_rmse_counts / figures.floor_counts;
    let words = if is_accurate(figures) {
        "the simulation agrees with the recording within quantization"
    } else if ratio < 3.0 {
        "the simulation is close: a little more than quantization is left"
    } else {
        "the simulation and the recording differ by more than quantization"
    };
    format!(
        "{}: {words} ({:.3} counts RMS over the whole run, quantization alone leaves {:.3}).",
        one_line(&figures.path),
        figures.position_rmse_counts,
        figures.floor_counts
    )
}

/// Most runs drawn on a page, the worst first. Convention: each is a third of a megabyte.
const DRAWN: usize = 6;

/// Indices of the runs by decreasing error.
pub fn worst_first(figures: &[&RunFigures]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..figures.len()).collect();
    order.sort_by(|&a, &b| {
        let error = |k: usize| figures[k].position_rmse_counts;
        error(b).total_cmp(&error(a))
    });
    order
}

/// Summary of several runs: how many are accurate, the worst one, and those with fatal findings.
pub fn all_words(figures: &[&RunFigures], findings: &[Finding]) -> String {
    let is_usable = |run: &&RunFigures| fatal_of(findings, &run.path).is_none();
    let (usable, others): (Vec<&RunFigures>, Vec<&RunFigures>) =
        figures.iter().copied().partition(is_usable);
    let accurate = usable.iter().filter(|run| is_accurate(run)).count();
    let mut sentence = match (usable.as_slice(), worst_first(&usable).first()) {
        ([one], _) => verdict(one, &[]),
        (several, Some(&worst)) => format!(
            "Of {} runs the simulation meets {accurate} down to the encoder's own rounding. The worst is {} with {:.3} counts RMS.",
            several.len(),
            one_line(&several[worst].path),
            several[worst].position_rmse_counts
        ),
        (_, None) => "No run is usable.".to_owned(),
    };
    if !others.is_empty() {
        let names = others.iter().map(|run| one_line(&run.path).into_owned());
        let names = few_words(&names.collect::<Vec<_>>());
        sentence += &format!(" Fatal findings: {names}.");
    }
    sentence
}

/// The comparison as one offline page: findings, a row per run, and figures, the worst first.
pub fn page(
    pairs: &[(&Run, &Overlay)],
    findings: &[Finding],
    motor: &Motor,
    title: &str,
) -> String {
    let mut page = Page::new(title);
    checks(&mut page, findings);
    lay_out(&mut page, pairs, findings);
    page.section("Motor");
    page.verbatim(&motor.to_toml());
    page.finish()
}

/// Summary of the runs, all error figures, and figures, the worst first.
pub(super) fn lay_out(page: &mut Page, pairs: &[(&Run, &Overlay)], findings: &[Finding]) {
    let figures: Vec<&RunFigures> = pairs.iter().map(|(_, overlay)| &overlay.figures).collect();
    match figures.as_slice() {
        [one] => page.lead(&verdict(one, findings)),
        several => page.lead(&all_words(several, findings)),
    }
    let (names, rows) = figures_table(&figures);
    page.sortable(&names, &rows);
    page.note(
        "Position: recorded against simulated counts, the whole run in open loop from rest. Speed: by the \
         recorder's difference rule on both sides; NRMSE is relative to how much the recorded speed varies. \
         Floor: what rounding to whole counts leaves of a perfect model, 1/\u{221a}12 counts.",
    );
    let order = worst_first(&figures);
    let drawn = if order.len() > DRAWN { 1 } else { order.len() };
    if drawn < order.len() {
        page.note("The picture is of the worst run; name a run alone for its own.");
    }
    for (run, overlay) in order.iter().take(drawn).map(|&k| pairs[k]) {
        let name = &overlay.figures.path;
        page.section(name);
        if pairs.len() > 1 {
            page.paragraph(&verdict(&overlay.figures, findings));
        }
        for note in &overlay.figures.notes {
            page.note(note);
        }
        let one_count = speed_of_one_count(run.counts_per_rev, run.sample_time_s);
        page.figure(
            &self::overlay(run, overlay, &run_words(run)),
            Size {
                width: 860,
                height: 760,
            },
            &format!(
                "One count in one sample is {:.3} rad/s = {:.2} RPM: the steps of the recorded speed.",
                one_count,
                rpm_from_rad_s(one_count)
            ),
        );
    }
}
