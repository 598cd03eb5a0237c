//! `motorlab demo`: everything once, without hardware.

use std::path::{Path, PathBuf};
use std::process::Command as Process;

use clap::Args;
use serde_json::json;

use super::output_file::{Force, Form, Outputs};
use super::picture::on_terminal;
use super::signals::StopSignal;
use super::virtual_capture::{Order, record};
use super::{Failure, Output, Status};
use crate::compare::{Comparison, compare};
use crate::motor::{Model, Motor};
use crate::plain::shown;
use crate::recording::read_run;
use crate::report::comparison::{overlay, page, verdict};
use crate::report::{Size, svg};

/// Record a virtual board at both of the lab's sample times, compare with the simulation, show the page.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab demo\n  motorlab demo --board 'effect=stribeck' -o demo-stribeck"
)]
pub struct Demo {
    /// Folder for the two runs and the page.
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// The virtual board, as after `virtual:?` (`motorlab virtual --help` lists the keys).
    #[arg(long, value_name = "KEYS", default_value = "")]
    board: String,
    /// Open the page in a browser.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    force: Force,
}

/// Sample times of the lab handout in us, with the names of their runs.
const SAMPLE_TIMES: [(u32, &str); 2] = [(30_000, "step30.csv"), (3_000, "step3.csv")];
/// How long each run records in s: rest, step and a good second of steady speed.
const DURATION_S: f64 = 1.8;

impl Demo {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let outputs = self.force.outputs("demo", []);
        self.check(&outputs)?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        let recorded = runtime.block_on(self.record_all(&outputs, output));
        runtime.shutdown_background();
        let Some(paths) = recorded? else {
            output.message("stopped; the runs recorded so far are whole");
            return Ok(Status::FellShort);
        };
        self.show(&paths, &outputs, output)
    }

    /// Refuses before the recording what could not be replaced after it.
    fn check(&self, outputs: &Outputs) -> Result<(), Failure> {
        outputs.may_replace(&self.output.join("index.html"), None)?;
        for (_, name) in SAMPLE_TIMES {
            let run = self.output.join(name);
            outputs.may_replace(&run, None)?;
            outputs.may_replace(&run.with_extension("svg"), None)?;
        }
        Ok(())
    }

    /// Records both runs; `None` after Ctrl-C.
    async fn record_all(
        &self,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Option<Vec<PathBuf>>, Failure> {
        let stop = StopSignal::install().map_err(Failure::device)?;
        std::fs::create_dir_all(&self.output).map_err(|error| {
            Failure::device(format!("cannot make {}: {error}", shown(&self.output)))
        })?;
        let mut paths = Vec::new();
        for (sample_time_us, name) in SAMPLE_TIMES {
            let file = self.output.join(name);
            let part = begin(&file)?;
            output.message(&format!(
                "recording {} from a virtual board every {} ms ...",
                shown(&file),
                f64::from(sample_time_us) / 1000.0
            ));
            let order = Order {
                command: "demo",
                board: &self.board,
                sample_time_us,
                profile: "step",
                duration_s: DURATION_S,
                output: &part,
            };
            match record(order, stop.clone(), output).await? {
                Some(captured) => paths.push(take_place(&captured.path, file, outputs)?),
                None => {
                    let _ = std::fs::remove_file(&part);
                    return Ok(None);
                }
            }
        }
        Ok(Some(paths))
    }

    fn show(
        &self,
        paths: &[PathBuf],
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Status, Failure> {
        let motor = Motor::default();
        let mut runs = Vec::new();
        let mut overlays = Vec::new();
        for path in paths {
            let (run, _) = read_run(path).map_err(Failure::input)?;
            let laid = compare(&run, &motor, Model::default()).map_err(Failure::input)?;
            runs.push(run);
            overlays.push(laid);
        }
        let pairs: Vec<_> = runs.iter().zip(&overlays).collect();
        let html = self.output.join("index.html");
        let title = "A recorded motor and its simulation";
        outputs.write_silently(&html, &page(&pairs, &motor, title), Form::Markup)?;
        let mut pictures = Vec::new();
        for (run, laid) in &pairs {
            let path = Path::new(&laid.figures.path).with_extension("svg");
            let figure = overlay(run, laid, &laid.figures.path);
            let size = Size {
                width: 860,
                height: 760,
            };
            outputs.write_silently(&path, &svg::document(&figure, size), Form::Markup)?;
            pictures.push(path);
        }
        let comparison = Comparison::of(&overlays);
        if output.json {
            output.document(&json!({
                "shape": "motorlab-demo/1",
                "html": html,
                "svg": pictures,
                "comparison": comparison,
            }))?;
        } else {
            if let Some((run, laid)) = pairs.first() {
                let figure = overlay(run, laid, &laid.figures.path);
                if let Some(panel) = figure.panels.first() {
                    output.picture(&on_terminal(panel, &figure.x_label))?;
                }
            }
            for laid in &overlays {
                output.line(&verdict(&laid.figures))?;
            }
            output.line(&format!("the page with all pictures: {}", shown(&html)))?;
        }
        if self.open {
            open(&html, output);
        }
        let lost: u64 = comparison.runs.iter().map(|run| run.lost).sum();
        Ok(if lost == 0 {
            Status::Done
        } else {
            Status::FellShort
        })
    }
}

/// Where a virtual board's run is recorded until it is whole; what an earlier call that was killed left there goes.
pub(super) fn begin(file: &Path) -> Result<PathBuf, Failure> {
    let mut name = std::ffi::OsString::from(".motorlab-");
    name.push(file.file_name().unwrap_or_default());
    let part = file.with_file_name(name);
    match std::fs::remove_file(&part) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Failure::device(
            format!("cannot remove {}: {error}", shown(&part)),
        )),
        _ => Ok(part),
    }
}

/// A virtual board's run, which is whole now, takes the place of that of an earlier call.
pub(super) fn take_place(
    part: &Path,
    file: PathBuf,
    outputs: &Outputs,
) -> Result<PathBuf, Failure> {
    outputs.may_replace(&file, None)?;
    std::fs::rename(part, &file)
        .map_err(|error| Failure::device(format!("cannot write {}: {error}", shown(&file))))?;
    Ok(file)
}

/// Opens a page with the desktop's opener; where there is none, the page has been named anyway.
fn open(html: &Path, output: &Output) {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    if let Err(error) = Process::new(opener).arg(html).spawn() {
        output.message(&format!("cannot open it ({opener}: {error})"));
    }
}
