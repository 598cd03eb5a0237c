//! The page of a recording with a fatal finding, which has no diagnosis.

use super::overlaid_run::names;
use super::{OVERLAY, checks};
use crate::check::Finding;
use crate::diagnose::BadRecording;
use crate::recording::Run;
use crate::report::comparison::{COMMAND, RECORDED, command_label, run_words};
use crate::report::{Figure, Page, Panel, Series, Size, Stroke};

/// Most runs drawn.
const DRAWN: usize = 6;
/// Two panels of the same height as on other pages.
const HEIGHT: u32 = OVERLAY.height / 2;

/// The findings, and the recorded runs.
pub fn bad_recording_page(findings: &[Finding], runs: &[Run]) -> String {
    let mut page = Page::new("A finding about the recording is fatal");
    checks(&mut page, findings);
    page.lead(&BadRecording::of(findings.to_vec()).sentence);
    page.section("As recorded");
    for (run, name) in runs.iter().zip(names(runs)).take(DRAWN) {
        page.subsection(&name);
        let size = Size {
            height: HEIGHT,
            ..OVERLAY
        };
        page.figure(&recorded(run), size, "Position in counts over the command.");
    }
    page.finish()
}

/// Recorded position and command.
pub fn recorded(run: &Run) -> Figure {
    let counts: Vec<f64> = run.counts.iter().map(|&n| n as f64).collect();
    let position = Series::new("recorded", Stroke::Step, RECORDED, &run.t_s, &counts);
    let command = Series::new("command", Stroke::Step, COMMAND, &run.t_s, &run.command);
    Figure {
        title: run_words(run),
        x_label: "time (s)".to_owned(),
        panels: vec![
            Panel::new("position (counts)", vec![position]).weighing(2.0),
            Panel::new(command_label(run), vec![command]),
        ],
    }
}
