//! `motorlab compare`: recorded runs and their simulation.

use std::path::PathBuf;

use clap::Args;

use super::findings::check_and_print;
use super::foreign::{read_runs, refuse_unused};
use super::import_flags::Flags;
use super::known::With;
use super::motor_choice::MotorChoice;
use super::output_file::{Force, Form, Outputs};
use super::picture::on_terminal;
use super::threads::Threads;
use super::{Failure, Output, Status};
use crate::check::Finding;
use crate::compare::{Comparison, Overlay, compare};
use crate::hint::In;
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::Run;
use crate::report::comparison::{all_words, figures_table, overlay, page, verdict, worst_first};
use crate::report::table::Table;
use crate::report::{Size, svg};

/// Compare recorded runs with their simulation, in RPM and in counts.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab compare run.csv\n  motorlab compare step30.csv step3.csv --motor motor.toml --html gap.html\n  motorlab compare run.csv --motor motor.toml --fail-above 1.0 --json"
)]
pub struct Compare {
    /// Run files. A log of another program is imported on the way.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    #[command(flatten)]
    motor: MotorChoice,
    #[command(flatten)]
    with: With,
    /// Exit with status 1 where a run's position error is above this many counts RMS.
    #[arg(long, value_name = "COUNTS")]
    fail_above: Option<f64>,
    /// Write everything as one HTML file that needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the picture of the run with the largest gap as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    log: Flags,
}

/// Figures in the row of a run on a terminal, and their column names.
const SHORT: [(usize, &str); 6] = [
    (0, "run"),
    (1, "TS (s)"),
    (3, "lost"),
    (4, "gap (counts RMS)"),
    (5, "largest"),
    (7, "speed (RPM RMS)"),
];

/// Runs with their simulations and findings.
struct Found {
    runs: Vec<Run>,
    overlays: Vec<Overlay>,
    findings: Vec<Finding>,
}

impl Compare {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let inputs = self.runs.iter().chain(self.motor.file());
        let outputs = self.force.outputs("compare", inputs);
        outputs.check(self.html.iter().chain(&self.svg))?;
        self.with
            .refuse_others(self.runs.iter().map(PathBuf::as_path))?;
        let motor = self.motor.motor(output)?;
        let mut runs = Vec::new();
        let mut overlays = Vec::new();
        for path in &self.runs {
            for (mut run, notes) in read_runs(path, &self.log, output)? {
                self.with.apply(path, &mut run)?;
                let mut overlay = compare(&run, &motor, self.motor.model())
                    .map_err(|error| Failure::input(In::new(shown(path), error)))?;
                overlay.figures.notes = notes.iter().map(ToString::to_string).collect();
                for note in &overlay.figures.notes {
                    output.message(&format!("{}: {note}", shown(path)));
                }
                runs.push(run);
                overlays.push(overlay);
            }
        }
        refuse_unused(&self.log, &runs, output)?;
        let findings = check_and_print(&runs, self.motor.is_given().then_some(&motor), output);
        let found = Found {
            runs,
            overlays,
            findings,
        };
        self.write_files(&outputs, &found, &motor, output)?;
        let comparison = Comparison::of(&found.overlays);
        if output.json {
            output.document(&comparison)?;
        } else {
            self.show(&found, output)?;
        }
        let worst = comparison.worst_position_rmse_counts();
        Ok(match self.fail_above {
            Some(limit) if worst > limit => {
                output.message(&format!(
                    "the gap of {worst:.3} counts RMS is above --fail-above {limit}"
                ));
                Status::FellShort
            }
            _ => Status::Done,
        })
    }

    fn write_files(
        &self,
        outputs: &Outputs,
        found: &Found,
        motor: &Motor,
        output: &Output,
    ) -> Result<(), Failure> {
        let Found {
            runs,
            overlays,
            findings,
        } = found;
        if let Some(path) = &self.html {
            let pairs: Vec<_> = runs.iter().zip(overlays).collect();
            let title = format!("Recorded against simulated ({})", self.motor.words());
            let page = page(&pairs, findings, motor, &title);
            outputs.write(path, &page, Form::Markup, output)?;
        }
        let figures: Vec<_> = overlays.iter().map(|overlay| &overlay.figures).collect();
        if let (Some(path), Some(&worst)) = (&self.svg, worst_first(&figures).first()) {
            let (run, laid) = (&runs[worst], &overlays[worst]);
            let size = Size {
                width: 860,
                height: 760,
            };
            let figure = overlay(run, laid, &laid.figures.path);
            outputs.write(path, &svg::document(&figure, size), Form::Markup, output)?;
        }
        Ok(())
    }

    /// A single run in full; several runs in a row each, with the plot of the worst.
    fn show(&self, found: &Found, output: &Output) -> Result<(), Failure> {
        let Found {
            runs,
            overlays,
            findings,
        } = found;
        let figures: Vec<_> = overlays.iter().map(|overlay| &overlay.figures).collect();
        let Some(&worst) = worst_first(&figures).first() else {
            return Ok(());
        };
        let (run, laid) = (&runs[worst], &overlays[worst]);
        let figure = overlay(run, laid, &laid.figures.path);
        for panel in figure.panels.iter().take(3) {
            output.picture(&on_terminal(panel, &figure.x_label))?;
        }
        output.line(&verdict(&laid.figures, findings))?;
        let (names, rows) = figures_table(&figures);
        if rows.len() > 1 {
            let mut table = Table::new(SHORT.map(|(_, name)| name));
            for row in rows {
                table.row(SHORT.map(|(column, _)| row[column].clone()));
            }
            output.line(table.to_string().trim_end())?;
            output.line(&all_words(&figures, findings))?;
        } else {
            for (name, cell) in names.iter().zip(rows.concat()) {
                output.line(&format!("  {name:<24} {cell}"))?;
            }
        }
        if self.html.is_none() {
            output.message("a page with the pictures: add --html compare.html");
        }
        Ok(())
    }
}
