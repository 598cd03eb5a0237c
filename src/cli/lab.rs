//! `motorlab lab`: the lab handout, computed and answered.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::demo::{begin, take_place};
use super::findings::print_findings;
use super::foreign::unreadable;
use super::lab_class::{ClassRequest, class};
use super::motor_file::motor_file;
use super::output_file::{Force, Form, Outputs};
use super::progress::{set_share, spinner};
use super::signals::StopSignal;
use super::threads::Threads;
use super::virtual_capture::{Order, record};
use super::{Failure, Output, Status};
use crate::hint::In;
use crate::lab::{Lab as Handout, Progress, Source, columns, page};
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::{Run, read_run};
use crate::report::{Figure, Size, svg};

/// Work through the lab handout: curves, transfer functions, sampling, recorded against simulated, every question answered.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab lab\n  motorlab lab --motor motor.toml --run step30.csv --run step3.csv -o report\n  motorlab lab --board 'effect=voltage_drop'\n  motorlab lab --class monday -o monday-page"
)]
pub struct Lab {
    /// Motor file; without it the lab handout's motor.
    #[arg(long, value_name = "FILE")]
    motor: Option<PathBuf>,
    /// A recorded step response, one for each sample time; without any, a virtual board supplies them.
    #[arg(long = "run", value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// The virtual board, as after `virtual:?` (`motorlab virtual --help` lists the keys).
    #[arg(long, value_name = "KEYS", default_value = "", conflicts_with = "runs")]
    board: String,
    /// Do not diagnose the missing effects; for long recordings that takes minutes.
    #[arg(long)]
    no_diagnosis: bool,
    /// A class: this folder has one folder a student, each with recordings (NAME.csv) and perhaps a motor.toml. One page
    /// says what each recording shows, and which are not usable.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["runs", "board", "no_diagnosis"])]
    class: Option<PathBuf>,
    /// Folder for the page, drawings and tables. [default: lab; with --class: class]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// The handout's sample times in us, with the file names of the virtual board's runs.
const SAMPLE_TIMES: [(u32, &str); 2] =
    [(30_000, "virtual-step30.csv"), (3_000, "virtual-step3.csv")];
/// The results as JSON: it carries the mark of the program for the tables beside it.
const WITNESS: &str = "lab.json";
/// Duration of a recording of the virtual board in s: rest, step, and more than a second of steady speed.
const DURATION_S: f64 = 1.8;
const RECORDED: Size = Size {
    width: 860,
    height: 760,
};

impl Lab {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        if let Some(folder) = &self.class {
            let outputs = (self.force).outputs("lab --class", self.motor.iter());
            let asked = ClassRequest {
                folder,
                motor: self.motor.as_ref(),
                to: self.output.as_deref().unwrap_or(Path::new("class")),
            };
            return class(asked, &outputs, output);
        }
        let outputs = (self.force).outputs("lab", self.runs.iter().chain(&self.motor));
        outputs.may_replace(&self.folder().join("index.html"), None)?;
        outputs.may_replace(&self.folder().join(WITNESS), None)?;
        let motor = match &self.motor {
            Some(path) => motor_file(path, output)?,
            None => {
                output.message("no --motor: the lab handout's motor is simulated");
                Motor::default()
            }
        };
        std::fs::create_dir_all(self.folder()).map_err(|error| {
            Failure::device(In::new(
                format!("cannot make {}", shown(self.folder())),
                error,
            ))
        })?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        let worked = runtime.block_on(self.work(motor, &outputs, output));
        runtime.shutdown_background();
        let Some(lab) = worked? else {
            output.message("stopped; the runs recorded so far are whole");
            return Ok(Status::FellShort);
        };
        let files = self.write(&lab, &outputs)?;
        print_findings(lab.findings.clone(), output);
        self.show(&lab, &files, output)?;
        let lost = lab
            .part_3
            .iter()
            .any(|recorded| recorded.overlay.figures.lost > 0);
        Ok(if lost || !lab.is_sound() {
            Status::FellShort
        } else {
            Status::Done
        })
    }

    fn folder(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("lab"))
    }

    /// The virtual board's port: this motor, as fast as possible, and the keys of `--board`.
    fn virtual_board(&self) -> String {
        let mut word = "speed=max".to_owned();
        if let Some(path) = &self.motor {
            let escaped = path
                .display()
                .to_string()
                .replace('%', "%25")
                .replace('&', "%26");
            word += &format!("&motor={escaped}");
        }
        if !self.board.is_empty() {
            word += &format!("&{}", self.board.trim_start_matches('?'));
        }
        word
    }

    /// Records if no runs are given, then computes; `None` after Ctrl-C.
    async fn work(
        &self,
        motor: Motor,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Option<Handout>, Failure> {
        let stop = StopSignal::install().map_err(Failure::device)?;
        let (paths, source) = if self.runs.is_empty() {
            match self.record_all(&stop, outputs, output).await? {
                Some(paths) => (paths, Source::VirtualBoard(self.virtual_board())),
                None => return Ok(None),
            }
        } else {
            (self.runs.clone(), Source::Recorded)
        };
        let runs = read_all(&paths, output)?;
        let spinner = spinner();
        let shown = spinner.clone();
        let diagnosed = !self.no_diagnosis;
        // A virtual board has the simulated motor.
        let is_described = self.motor.is_some() || self.runs.is_empty();
        let computing = tokio::task::spawn_blocking(move || {
            let progress = Progress {
                doing: &|what: &str| shown.set_message(what.to_owned()),
                done: &|share| set_share(&shown, share),
            };
            let progress = diagnosed.then_some(progress);
            Handout::of((motor, is_described), runs, source, progress)
        });
        let computed = tokio::select! {
            computed = computing => computed.map_err(Failure::device)?,
            () = stop.asked() => return Ok(None),
        };
        spinner.finish_and_clear();
        computed.map(Some).map_err(Failure::input)
    }

    async fn record_all(
        &self,
        stop: &StopSignal,
        outputs: &Outputs,
        output: &Output,
    ) -> Result<Option<Vec<PathBuf>>, Failure> {
        let board = self.virtual_board();
        let mut paths = Vec::new();
        for (sample_time_us, name) in SAMPLE_TIMES {
            let file = self.folder().join(name);
            outputs.may_replace(&file, None)?;
            let part = begin(&file)?;
            output.message(&format!(
                "no --run: recording {} from a virtual board",
                shown(&file)
            ));
            let order = Order {
                command: "lab",
                board: &board,
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

    /// Writes the page, and its content as SVG, CSV and JSON; returns the paths, the page first.
    fn write(&self, lab: &Handout, outputs: &Outputs) -> Result<Vec<PathBuf>, Failure> {
        let mut files = Files::new(self.folder(), outputs);
        files.text("index.html", &page::page(lab))?;
        files.text("part1.csv", &columns::step_responses(lab))?;
        files.drawing("part1.svg", &page::step_responses(lab), page::TALL)?;
        for sampled in &lab.part_2.responses {
            let name = format!("part2-ts{}", sampled.sample_time_s);
            files.text(&format!("{name}.csv"), &columns::sampled(sampled))?;
            let figure = page::sampled(sampled, &lab.part_1);
            files.drawing(&format!("{name}.svg"), &figure, Size::SMALL)?;
        }
        for (k, recorded) in lab.part_3.iter().enumerate() {
            let name = format!("part3-{}-ts{}", k + 1, recorded.sample_time_s);
            files.text(&format!("{name}.csv"), &columns::recorded(recorded))?;
            files.drawing(&format!("{name}.svg"), &page::recorded(recorded), RECORDED)?;
            let step = page::step(recorded);
            files.drawing(&format!("{name}-step.svg"), &step, Size::SMALL)?;
            let gaps = page::residuals(recorded);
            files.drawing(&format!("{name}-gaps.svg"), &gaps, Size::SMALL)?;
        }
        // Last: until then, the earlier JSON identifies the tables as outputs of this command.
        let json = serde_json::to_string_pretty(lab).map_err(Failure::input)?;
        files.text(WITNESS, &json)?;
        Ok(files.written)
    }

    fn show(&self, lab: &Handout, files: &[PathBuf], output: &Output) -> Result<(), Failure> {
        if output.json {
            return output.document(&json!({
                "shape": "motorlab-lab-files/1",
                "source": lab.source,
                "findings": lab.findings,
                "answers": lab.answers,
                "not_shown": lab.not_shown,
                "files": files,
            }));
        }
        for answer in &lab.answers {
            output.line(&format!(
                "{}  {}\n     {}",
                answer.number, answer.topic, answer.short
            ))?;
        }
        if let Some(page) = files.first() {
            output.line(&format!("the page: {}", shown(page)))?;
        }
        Ok(())
    }
}

/// The runs with the reader's notes.
fn read_all(paths: &[PathBuf], output: &Output) -> Result<Vec<(Run, Vec<String>)>, Failure> {
    let mut runs = Vec::new();
    for path in paths {
        let (run, notes) = read_run(path).map_err(|error| unreadable(path, error))?;
        let notes: Vec<String> = notes.iter().map(ToString::to_string).collect();
        for note in &notes {
            output.message(&format!("{}: {note}", shown(path)));
        }
        runs.push((run, notes));
    }
    Ok(runs)
}

/// Files written into one folder; earlier outputs are replaced.
struct Files<'a> {
    outputs: &'a Outputs,
    folder: &'a Path,
    written: Vec<PathBuf>,
}

impl<'a> Files<'a> {
    fn new(folder: &'a Path, outputs: &'a Outputs) -> Self {
        Self {
            outputs,
            folder,
            written: Vec::new(),
        }
    }

    fn text(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => self.outputs.write_silently(&path, text, Form::Json)?,
            Some("html" | "svg") => self.outputs.write_silently(&path, text, Form::Markup)?,
            // A table has no comments: the JSON beside it carries the mark.
            _ => {
                let witness = self.folder.join(WITNESS);
                self.outputs
                    .write_bytes(&path, text.as_bytes(), Some(&witness))?;
            }
        }
        self.written.push(path);
        Ok(())
    }

    fn drawing(&mut self, name: &str, figure: &Figure, size: Size) -> Result<(), Failure> {
        self.text(name, &svg::document(figure, size))
    }
}
