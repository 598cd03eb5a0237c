//! `motorlab capture`: record a run from a board.

use std::any::Any;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::capture_report::report;
use super::live::{LiveRun, LiveView};
use super::motor_file::motor_file;
use super::numbers::{counts_per_rev, supply_v};
use super::progress::ProgressLine;
use super::reconnect::{BoardIdentity, Segments};
use super::signals::StopSignal;
use super::threads::Threads;
use super::until_known::{UntilKnown, until_known};
use super::virtual_spec::{PREFIX, VirtualSpec, nearly};
use super::{Failure, Output, Status};
use crate::board::text_lines::Column;
use crate::board::{
    BUILT_IN, Board, BoardError, BoardOptions, Location, OpenError, Profile, RawLog, VirtualBoard,
    usb_identity,
};
use crate::hint::In;
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::{
    CaptureError, CaptureRequest, Captured, Ending, Integration, MAX_ROWS, SharedLive, WriteError,
    capture, next_free_name, refuse_no_file,
};

/// Default duration of a built-in profile in s.
pub(super) const DURATION_S: f64 = 4.0;

/// Record a run from a board, or from a virtual one.
#[derive(Debug, Clone, Args)]
#[command(after_help = after_help())]
pub struct Capture {
    /// Serial port (`motorlab ports` lists them), or `virtual:` for a board without hardware.
    pub(super) port: String,
    /// Sample time in s. [default: 0.003; of a text board what its lines show]
    #[arg(long, value_name = "SECONDS", value_parser = sample_time_us)]
    pub(super) ts: Option<u32>,
    /// Command: a built-in profile, or a file of rows `t_s,command_v`. [default: step; of a
    /// text board what its lines say]
    #[arg(long)]
    pub(super) profile: Option<String>,
    /// How long to record in s; 0 records until Ctrl-C. [default: 4, or as long as the profile's file or name says]
    #[arg(long, value_name = "SECONDS", value_parser = duration)]
    pub(super) duration: Option<f64>,
    /// Where the run goes. An existing file is not overwritten: the next free name is taken. A folder, a device or a pipe is refused.
    #[arg(short, long, value_name = "FILE", default_value = "run.csv")]
    pub(super) output: PathBuf,
    /// Write every byte with its time to this raw log, which `motorlab replay` plays. A full disk ends the log and not
    /// the recording; the exit status is 3 then.
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Bits per second on the line.
    #[arg(long, default_value_t = firmware_protocol::BAUD)]
    pub(super) baud: u32,
    /// Encoder counts per revolution, if not what the board says.
    #[arg(long, value_name = "COUNTS", value_parser = counts_per_rev)]
    pub(super) counts_per_rev: Option<f64>,
    /// Driver supply in V, if not what the board says.
    #[arg(long, value_name = "VOLTS", value_parser = supply_v)]
    pub(super) supply: Option<f64>,
    /// How long a board may take to say who it is, in s.
    #[arg(long, value_name = "SECONDS", default_value = "6", value_parser = duration)]
    pub(super) patience: f64,
    /// Read the text lines of a plain sketch: what its columns mean, such as `t_us,counts,pwm`, or
    /// `auto` where it prints a header line or `label:value` pairs.
    #[arg(long, value_name = "NAMES", allow_hyphen_values = true)]
    pub(super) columns: Option<String>,
    /// How a speed in these lines becomes a position: backward, where it is the mean since the row before; trapezoid, where it is
    /// the speed at the instant of the row; forward, where it holds until the next row. [default: the rule that leaves less
    /// of a first-order motor, else backward]
    #[arg(long, value_name = "RULE", requires = "columns")]
    pub(super) integrate: Option<Integration>,
    /// When the board is unplugged, wait for the same board to come back, under whatever name, and
    /// record again from the start into a new file.
    #[arg(long, conflicts_with = "columns")]
    reconnect: bool,
    /// Show speed, counts, command and losses on the whole terminal, with the simulation running along.
    #[arg(long, group = "simulating")]
    live: bool,
    #[command(flatten)]
    until: UntilKnown,
    /// Motor file that is simulated along, or diagnosed against. [default: the lab handout's motor]
    #[arg(long, value_name = "FILE", requires = "simulating")]
    pub(super) motor: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
}

/// Default sample time in microseconds.
const SAMPLE_TIME_US: u32 = 3000;

fn after_help() -> String {
    let columns = Column::names().replace(", command_v", ",\n  command_v");
    let profiles: String = BUILT_IN
        .iter()
        .map(|(name, what)| format!("  {name:<10} {what}\n"))
        .collect();
    format!(
        "Built-in profiles:\n{profiles}  NAME@SHARE,SECONDSs: with that share of the supply, that long (crawl@0.25,8s)\n\nColumns of text lines:\n  {columns}\n  One of counts, increments and a speed has to be there; the last two are summed up, and the run says so.\n\nExamples:\n  motorlab capture /dev/ttyACM0 --ts 0.003 --profile step --duration 4 -o run.csv\n  motorlab capture 'virtual:?effect=backlash&seed=7' --profile reversing\n  motorlab capture /dev/ttyACM0 --until-known 60s -o run.csv\n  motorlab capture /dev/ttyUSB0 --columns t_us,counts,pwm --supply 9\n  motorlab capture COM7 --columns \"t_ms,rpm,pwm\" --supply 12 --counts-per-rev 360"
    )
}

fn sample_time_us(text: &str) -> Result<u32, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| "a number of seconds, as in 0.003 for 3 ms")?;
    let micros = (seconds * 1e6).round();
    if (100.0..=60e6).contains(&micros) {
        Ok(micros as u32)
    } else {
        Err("a sample time is between 0.0001 and 60 s\nhint: --ts 0.003 is 3 ms".to_owned())
    }
}

fn duration(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e7).contains(&seconds) => Ok(seconds),
        _ => Err("a duration is a number of seconds between 0 and 10,000,000\nhint: --duration 4 records 4 s, --duration 0 until Ctrl-C".to_owned()),
    }
}

impl Capture {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        self.threads.set()?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        let result = match self.until.bound() {
            Some(bound) => runtime.block_on(until_known(self, bound, output)),
            None => runtime.block_on(self.record(output)),
        };
        // Nothing may keep the process alive: the run is in its file.
        runtime.shutdown_background();
        result
    }

    async fn record(&self, output: &Output) -> Result<Status, Failure> {
        for path in std::iter::once(&self.output).chain(&self.log) {
            refuse_no_file(path).map_err(capture_failure)?;
        }
        let stop = StopSignal::install().map_err(Failure::device)?;
        let plugged = self.plug_in(output)?;
        let mut location = plugged.as_ref().map_or_else(
            || Location::Port(PathBuf::from(&self.port)),
            |board| board.location().clone(),
        );
        if let Some(columns) = &self.columns {
            return self.record_text(&location, columns, output, stop).await;
        }
        let mut segments = Segments::default();
        let mut identity: Option<BoardIdentity> = None;
        loop {
            let options = BoardOptions {
                baud: self.baud,
                patience: Duration::from_secs_f64(self.patience),
                log: self.begin_log(&mut segments, output)?,
            };
            let opened = tokio::select! {
                board = Board::open(&location, options) => board,
                () = stop.clone().asked() => return self.end_without_board(segments, output),
            };
            let recorded = match opened {
                Ok(board) => {
                    identity.get_or_insert_with(|| {
                        BoardIdentity::of(&location, usb_identity(location.path()), board.hello())
                    });
                    self.record_from(board, location.path(), &segments, output, &stop)
                        .await?
                }
                Err(error) => Err(error),
            };
            match recorded {
                Ok(captured)
                    if self.reconnect
                        && !stop.is_asked()
                        && matches!(captured.ending, Ending::Unplugged | Ending::BoardReset) =>
                {
                    output.message(&format!(
                        "the board is gone; {} holds {} samples up to there. Waiting for it to come back (Ctrl-C ends)",
                        shown(&captured.path),
                        captured.statistics.samples
                    ));
                    segments.add(captured);
                }
                Ok(captured) => {
                    return report(output, &captured, self.duration != Some(0.0), &segments);
                }
                // The board came back and is gone again.
                Err(error) if !segments.is_empty() => output.message(&error.to_string()),
                Err(error) => return Err(board_failure(error)),
            }
            let Some(identity) = &identity else {
                return self.end_without_board(segments, output);
            };
            location = tokio::select! {
                location = identity.wait_for_board(self.baud, output) => location,
                () = stop.clone().asked() => return self.end_without_board(segments, output),
            };
        }
    }

    /// Records from a board that has identified itself. The inner error is the board's and may be retried.
    async fn record_from(
        &self,
        mut board: Board,
        path: &Path,
        segments: &Segments,
        output: &Output,
        stop: &StopSignal,
    ) -> Result<Result<Captured, BoardError>, Failure> {
        let mut request = self.request(&board, path)?;
        request.further = segments.header();
        if !segments.is_empty() {
            // The board may have come back under another name.
            request.port = path.display().to_string();
        }
        print_free_name(output, &request.output);
        let live = SharedLive::default();
        let counts_per_rev = self
            .counts_per_rev
            .unwrap_or(f64::from(board.hello().counts_per_rev));
        let display = self.display(&live, counts_per_rev, &request.profile.name, output)?;
        let captured = capture(&mut board, &request, &live, stop.clone().asked()).await;
        drop(display);
        match captured {
            Ok(captured) => Ok(Ok(captured)),
            Err(CaptureError::Board(error)) => Ok(Err(error)),
            Err(error) => Err(capture_failure(error)),
        }
    }

    /// Ends a recording that is stopped while the board is missing: the last segment is complete.
    fn end_without_board(
        &self,
        mut segments: Segments,
        output: &Output,
    ) -> Result<Status, Failure> {
        match segments.take_last() {
            Some(last) => {
                output.message("stopped; the board did not come back");
                report(output, &last, self.duration != Some(0.0), &segments)
            }
            None => {
                let stopped = Failure::wrong(
                    "stopped before the board said who it is, and nothing was recorded",
                    "a board starts within two seconds of opening its port: wait for the first samples before stopping",
                );
                output.message(&stopped.to_string());
                output.failed(&stopped.of_kind("stopped"));
                Ok(Status::FellShort)
            }
        }
    }

    pub(super) fn display(
        &self,
        live: &SharedLive,
        counts_per_rev: f64,
        profile: &str,
        output: &Output,
    ) -> Result<Display, Failure> {
        if self.live {
            let motor = match &self.motor {
                Some(path) => motor_file(path, output)?,
                None => Motor::default(),
            };
            let run = LiveRun {
                motor,
                counts_per_rev,
                port: self.port.clone(),
                profile: profile.to_owned(),
            };
            if let Some(view) = LiveView::show(live, run) {
                return Ok(Box::new(view));
            }
            output.message("standard error is no terminal: recording without --live");
        }
        Ok(Box::new(ProgressLine::show(live)))
    }

    /// The virtual board, if the port names one.
    fn plug_in(&self, output: &Output) -> Result<Option<VirtualBoard>, Failure> {
        let Some(text) = self.port.strip_prefix(PREFIX) else {
            return nearly(&self.port).map_or(Ok(None), Err);
        };
        let spec = VirtualSpec::parse(text)
            .map_err(Failure::input)?
            .with_reported_gaps(output);
        spec.plug_in(&self.port).map(Some).map_err(Failure::input)
    }

    /// Creates the raw log, if requested, and adds it to the segments.
    pub(super) fn begin_log(
        &self,
        segments: &mut Segments,
        output: &Output,
    ) -> Result<Option<RawLog>, Failure> {
        let Some(asked) = &self.log else {
            return Ok(None);
        };
        let path = next_free_name(asked);
        if path != *asked {
            output.message(&format!(
                "{} exists and stays as it is; the raw log goes to {}",
                shown(asked),
                shown(&path)
            ));
        }
        let cannot = |error: io::Error| {
            Failure::device(In::new(
                format!("cannot write the raw log {}", shown(&path)),
                error,
            ))
        };
        let file = File::create_new(&path).map_err(cannot)?;
        let mut header = toml::Table::new();
        header.insert("port".to_owned(), self.port.clone().into());
        header.insert("baud".to_owned(), i64::from(self.baud).into());
        match &self.columns {
            Some(columns) => self.describe_text(columns, &mut header)?,
            None => drop(header.insert("profile".to_owned(), self.profile_name().into())),
        }
        let log = RawLog::begin(file, &header).map_err(cannot)?;
        segments.add_log(path.clone(), log.failure());
        Ok(Some(log))
    }

    fn profile_name(&self) -> &str {
        self.profile.as_deref().unwrap_or("step")
    }

    pub(super) fn request(&self, board: &Board, path: &Path) -> Result<CaptureRequest, Failure> {
        let hello = board.hello();
        let supply_v = self.supply.unwrap_or(f64::from(hello.supply_mv) / 1000.0);
        let sample_time_us = self.ts.unwrap_or(SAMPLE_TIME_US);
        let sample_time_s = f64::from(sample_time_us) * 1e-6;
        // Without an end, a built-in profile has its default length.
        let profile_s = self.duration.filter(|&s| s > 0.0).unwrap_or(DURATION_S);
        let profile =
            Profile::named(self.profile_name(), supply_v, profile_s).map_err(Failure::input)?;
        let duration_s = self.duration.unwrap_or_else(|| profile.duration_s());
        let samples = (duration_s / sample_time_s).round();
        if samples > MAX_ROWS as f64 {
            return Err(Failure::wrong(
                format!("{samples:.0} samples are more than the {MAX_ROWS} rows that a run has"),
                "lower --duration or raise --ts",
            ));
        }
        Ok(CaptureRequest {
            sample_time_us,
            profile,
            samples: samples as u32,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply,
            output: self.output.clone(),
            port: self.port.clone(),
            usb: usb_identity(path),
            further: toml::Table::new(),
        })
    }
}

/// Display of a recording; dropping it ends it.
pub(super) type Display = Box<dyn Any>;

/// An existing file is not overwritten, and the message comes before the recording.
pub(super) fn print_free_name(output: &Output, asked: &Path) {
    let free = next_free_name(asked);
    if free != asked {
        output.message(&format!(
            "{} exists and stays as it is; recording into {}",
            shown(asked),
            shown(&free)
        ));
    }
}

pub(super) fn board_failure(error: BoardError) -> Failure {
    match error {
        BoardError::Open(OpenError::NotFound { .. } | OpenError::NotASerialPort { .. })
        | BoardError::Command { .. }
        | BoardError::StatesZero { .. }
        | BoardError::Refused { .. } => Failure::input(error),
        _ => Failure::device(error),
    }
}

pub(super) fn capture_failure(error: impl Into<CaptureError>) -> Failure {
    match error.into() {
        CaptureError::Board(error) => board_failure(error),
        CaptureError::Write(error @ WriteError::NoFile { .. }) => {
            Failure::input(error).of_kind("output_refused")
        }
        CaptureError::Write(error) => Failure::device(error),
    }
}
