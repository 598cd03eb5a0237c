//! `motorlab demo`: the whole workflow without hardware.

use std::path::{Path, PathBuf};
use std::process::Command as Process;

use clap::Args;
use serde_json::json;

use super::output_file::{Force, Form, Outputs};
use super::picture::on_terminal;
use super::signals::StopSignal;
use super::threads::Threads;
use super::virtual_capture::{Order, record};
use super::{Failure, Output, Status};
use crate::compare::{Comparison, Overlay, compare};
use crate::diagnose::{Options, diagnose};
use crate::hint::In;
use crate::motor::{Model, Motor};
use crate::plain::shown;
use crate::recording::{Run, read_run};
use crate::report::comparison::{overlay, verdict};
use crate::report::demo::{Shown, page, two_measures};
use crate::report::{Size, svg};

/// Record virtual boards, compare with the simulation, diagnose a gap, show the page.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab demo\n  motorlab demo --board 'effect=stribeck' -o demo-stribeck"
)]
pub struct Demo {
    /// Folder for the runs and the page.
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// The virtual board, as after `virtual:?` (`motorlab virtual --help` lists the keys). Without an effect of its own, the
    /// diagnosed one drops voltage.
    #[arg(long, value_name = "KEYS", default_value = "")]
    board: String,
    /// Open the page in a browser.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

const PICTURE: Size = Size {
    width: 860,
    height: 760,
};

/// One recording of the demo.
#[derive(Debug, Clone, Copy)]
struct Take {
    name: &'static str,
    sample_time_us: u32,
    profile: &'static str,
    duration_s: f64,
}

/// The handout's step at both of its sample times: rest, step, and more than a second of steady speed.
const STEPS: [Take; 2] = [
    Take {
        name: "step30.csv",
        sample_time_us: 30_000,
        profile: "step",
        duration_s: 1.8,
    },
    Take {
        name: "step3.csv",
        sample_time_us: 3_000,
        profile: "step",
        duration_s: 1.8,
    },
];
/// The diagnosed run: several levels of both signs.
const GAP: Take = Take {
    name: "gap.csv",
    sample_time_us: 10_000,
    profile: "reversing",
    duration_s: 6.0,
};
/// Default effect of that run's board: the voltage drop of a common driver, a sixth of the supply.
const GAP_EFFECT: &str = "effect=voltage_drop&drop_v=0.8";

struct Recorded {
    steps: Vec<PathBuf>,
    gap: PathBuf,
}

impl Demo {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let outputs = self.force.outputs("demo", []);
        self.check(&outputs)?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        let recorded = runtime.block_on(self.record_all(&outputs, output));
        runtime.shutdown_background();
        let Some(recorded) = recorded? else {
            output.message("stopped; the runs recorded so far are whole");
            return Ok(Status::FellShort);
        };
        self.show(&recorded, &outputs, output)
    }

    /// Refuses, before the recording, output files that could not be replaced after it.
    fn check(&self, outputs: &Outputs) -> Result<(), Failure> {
        outputs.may_replace(&self.output.join("index.html"), None)?;
        for take in STEPS.iter().chain([&GAP]) {
            let run = self.output.join(take.name);
            outputs.may_replace(&run, None)?;
            outputs.may_replace(&run.with_extension("svg"), None)?;
        }
        Ok(())
    }

    /// The board of the run with a gap: faster than real time, with an effect.
    fn gap_board(&self) -> String {
        let asked = self.board.trim_start_matches('?');
        let keys = match asked {
            "" => GAP_EFFECT.to_owned(),
            keys if keys.split('&').any(|key| key.starts_with("effect=")) => keys.to_owned(),
            keys => format!("{keys}&{GAP_EFFECT}"),
        };
        format!("speed=max&{keys}")
    }

    /// Records all runs; `None` after Ctrl-C.
    async fn record_all(
        &self,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Option<Recorded>, Failure> {
        let stop = StopSignal::install().map_err(Failure::device)?;
        std::fs::create_dir_all(&self.output).map_err(|error| {
            Failure::device(In::new(
                format!("cannot make {}", shown(&self.output)),
                error,
            ))
        })?;
        let mut steps = Vec::new();
        for take in STEPS {
            match self.take(take, &self.board, &stop, outputs, output).await? {
                Some(path) => steps.push(path),
                None => return Ok(None),
            }
        }
        let board = self.gap_board();
        let gap = self.take(GAP, &board, &stop, outputs, output);
        Ok(gap.await?.map(|gap| Recorded { steps, gap }))
    }

    /// Records one run; `None` after Ctrl-C.
    async fn take(
        &self,
        take: Take,
        board: &str,
        stop: &StopSignal,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Option<PathBuf>, Failure> {
        let file = self.output.join(take.name);
        let part = begin(&file)?;
        output.message(&format!(
            "recording {} from a virtual board every {} ms ...",
            shown(&file),
            f64::from(take.sample_time_us) / 1000.0
        ));
        let order = Order {
            command: "demo",
            board,
            sample_time_us: take.sample_time_us,
            profile: take.profile,
            duration_s: take.duration_s,
            output: &part,
        };
        match record(order, stop.clone(), output).await? {
            Some(captured) => Ok(Some(take_place(&captured.path, file, outputs)?)),
            None => {
                let _ = std::fs::remove_file(&part);
                Ok(None)
            }
        }
    }

    fn show(
        &self,
        recorded: &Recorded,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Status, Failure> {
        let motor = Motor::default();
        let mut laid = Vec::new();
        for path in recorded.steps.iter().chain([&recorded.gap]) {
            let (run, _) = read_run(path).map_err(Failure::input)?;
            let overlay = compare(&run, &motor, Model::default()).map_err(Failure::input)?;
            laid.push((run, overlay));
        }
        let Some(((gap, gap_overlay), met)) = laid.split_last() else {
            return Ok(Status::FellShort);
        };
        output.message("diagnosing the run with a gap ...");
        let found = diagnose(std::slice::from_ref(gap), &motor, &Options::default());
        let found = found.map_err(Failure::input)?;
        let pairs: Vec<_> = met.iter().map(|(run, overlay)| (run, overlay)).collect();
        let html = self.output.join("index.html");
        let board = self.gap_board();
        let shown_there = Shown {
            met: &pairs,
            gap: (gap, gap_overlay, &found),
            board: &board,
        };
        let page = page(&shown_there).map_err(Failure::input)?;
        outputs.write_silently(&html, &page, Form::Markup)?;
        let mut pictures = Vec::new();
        for (run, overlay) in &laid {
            let path = Path::new(&overlay.figures.path).with_extension("svg");
            let figure = self::overlay(run, overlay, &overlay.figures.path);
            outputs.write_silently(&path, &svg::document(&figure, PICTURE), Form::Markup)?;
            pictures.push(path);
        }
        let of = |laid: &[(Run, Overlay)]| {
            let overlays: Vec<Overlay> = laid.iter().map(|(_, overlay)| overlay.clone()).collect();
            Comparison::of(&overlays)
        };
        let comparison = of(met);
        if output.json {
            output.document(&json!({
                "shape": "motorlab-demo/1",
                "html": html,
                "svg": pictures,
                "comparison": comparison,
                "gap": of(&laid[met.len()..]),
                "diagnosis": found,
            }))?;
        } else {
            if let Some((run, overlay)) = met.first() {
                let figure = self::overlay(run, overlay, &overlay.figures.path);
                if let Some(panel) = figure.panels.first() {
                    output.picture(&on_terminal(panel, &figure.x_label))?;
                }
            }
            for (_, overlay) in &laid {
                output.line(&verdict(&overlay.figures, &[]))?;
            }
            output.line(&two_measures(&found))?;
            output.line(&found.sentence)?;
            output.line(&format!("the page with all pictures: {}", shown(&html)))?;
        }
        if self.open {
            open(&html, output);
        }
        let lost: u64 = laid.iter().map(|(_, overlay)| overlay.figures.lost).sum();
        Ok(if lost == 0 {
            Status::Done
        } else {
            Status::FellShort
        })
    }
}

/// Temporary name of a virtual board's run until it is complete; a leftover of a killed call is removed.
pub(super) fn begin(file: &Path) -> Result<PathBuf, Failure> {
    let mut name = std::ffi::OsString::from(".motorlab-");
    name.push(file.file_name().unwrap_or_default());
    let part = file.with_file_name(name);
    match std::fs::remove_file(&part) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Failure::device(
            In::new(format!("cannot remove {}", shown(&part)), error),
        )),
        _ => Ok(part),
    }
}

/// Moves the completed run of a virtual board over that of an earlier call.
pub(super) fn take_place(
    part: &Path,
    file: PathBuf,
    outputs: &Outputs,
) -> Result<PathBuf, Failure> {
    outputs.may_replace(&file, None)?;
    std::fs::rename(part, &file).map_err(|error| {
        Failure::device(In::new(format!("cannot write {}", shown(&file)), error))
    })?;
    Ok(file)
}

/// Opens a page with the desktop's opener; without one, the message with its path suffices.
fn open(html: &Path, output: &Output) {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    if let Err(error) = Process::new(opener).arg(html).spawn() {
        output.message(&format!("cannot open it ({opener}: {error})"));
    }
}
