//! `motorlab replay`: play a raw serial log, through the decoder or as a serial device.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
#[cfg(unix)]
use std::time::Duration;

use clap::Args;
#[cfg(unix)]
use serde_json::json;

use super::capture::{capture_failure, print_free_name};
use super::capture_report::report;
use super::capture_text::TextFacts;
use super::numbers::{counts_per_rev, supply_v};
use super::progress::ProgressLine;
use super::reconnect::Segments;
use super::signals::StopSignal;
use super::virtual_board::needs_unix;
use super::{Failure, Output, Status};
#[cfg(unix)]
use crate::board::ReplayedDevice;
use crate::board::{Profile, rawlog};
use crate::hint::In;
use crate::motor::plausible;
use crate::plain::shown;
use crate::recording::{
    CaptureRequest, Captured, Integration, ReplayError, SharedLive, Speed, TextRequest,
    refuse_no_file, replay, replay_text,
};

/// Most events of a log that is played as a device, which holds it in memory.
#[cfg(unix)]
const MOST_PLAYED: usize = 4_000_000;

/// Play a raw serial log: into a run file, or as a serial device that `capture` opens.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab capture virtual: --log raw.log\n  motorlab replay raw.log -o again.csv\n  motorlab replay raw.log --pty --speed 10"
)]
pub struct Replay {
    /// Raw log, as `capture --log` writes it.
    log: PathBuf,
    /// How fast: 1 as it was recorded, another factor, or max. [default: max, with --pty 1]
    #[arg(long, value_parser = speed)]
    speed: Option<Speed>,
    /// Be a serial device and print its path (not on Windows).
    #[arg(long)]
    pty: bool,
    /// Where the run goes. An existing file is not overwritten: the next free name is taken.
    #[arg(
        short,
        long,
        value_name = "FILE",
        default_value = "run.csv",
        conflicts_with = "pty"
    )]
    output: PathBuf,
    /// Encoder counts per revolution, if not what the board says.
    #[arg(long, value_name = "COUNTS", value_parser = counts_per_rev)]
    counts_per_rev: Option<f64>,
    /// Driver supply in V, if not what the board says.
    #[arg(long, value_name = "VOLTS", value_parser = supply_v)]
    supply: Option<f64>,
    /// The log is of a plain sketch's text lines: what its columns mean, or `auto`. [default: what the
    /// log's header says]
    #[arg(
        long,
        value_name = "NAMES",
        conflicts_with = "pty",
        allow_hyphen_values = true
    )]
    columns: Option<String>,
    /// How a speed in text lines becomes a position: backward, trapezoid or forward, as of `capture`. [default: what the log's
    /// header says]
    #[arg(long, value_name = "RULE", conflicts_with = "pty")]
    integrate: Option<Integration>,
}

/// Duration in a log's header: 0 is unlimited.
const ANY_DURATION_S: plausible::Range = plausible::Range {
    lo: 0.0,
    ..plausible::DURATION_S
};

fn text<'a>(header: &'a toml::Table, key: &str) -> Option<&'a str> {
    header.get(key).and_then(toml::Value::as_str)
}

fn speed(text: &str) -> Result<Speed, String> {
    match (text, text.parse::<f64>()) {
        ("max", _) => Ok(Speed::Max),
        (_, Ok(factor)) if factor > 0.0 && factor.is_finite() => Ok(Speed::Times(factor)),
        _ => Err("a speed is a factor above 0, or max\nhint: --speed 10 is ten times as fast as recorded, --speed max as fast as possible".to_owned()),
    }
}

impl Replay {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        if !self.pty {
            refuse_no_file(&self.output).map_err(capture_failure)?;
        } else if cfg!(windows) {
            return Err(needs_unix(
                "replay its file instead: motorlab replay LOG -o FILE",
            ));
        }
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        let _inside = runtime.enter();
        let stop = StopSignal::install().map_err(Failure::device)?;
        let file = File::open(&self.log)
            .map_err(|error| Failure::input(In::new(shown(&self.log), error)))?;
        let mut log =
            rawlog::Reader::new(BufReader::new(file)).map_err(|e| self.in_log(e.into()))?;
        #[cfg(unix)]
        if self.pty {
            return runtime.block_on(self.be_a_device(output, &mut log, &stop));
        }
        print_free_name(output, &self.output);
        let live = SharedLive::default();
        let progress = ProgressLine::show(&live);
        let replayed = self.play(&mut log, &live, &stop);
        drop(progress);
        if log.torn() {
            output.message(&format!(
                "{} ends in a torn line, which is left out",
                shown(&self.log)
            ));
        }
        let (captured, notes) = replayed?;
        let status = report(output, &captured, true, &Segments::default())?;
        for note in notes {
            output.message(&format!("note: {note}"));
        }
        Ok(status)
    }

    /// Replays into a run file: frames, or text lines if the log or `--columns` says so.
    fn play(
        &self,
        log: &mut rawlog::Reader<BufReader<File>>,
        live: &SharedLive,
        stop: &StopSignal,
    ) -> Result<(Captured, Vec<String>), Failure> {
        let speed = self.speed.unwrap_or(Speed::Max);
        let header = log.header();
        let played = match self.columns.as_deref().or_else(|| text(header, "columns")) {
            Some(columns) => {
                let request = self.text_request(columns, header)?;
                let played = replay_text(log, request, speed, live, || stop.is_asked());
                played.map(|text| (text.captured, text.notes))
            }
            None => {
                let request = self.request(header);
                let played = replay(log, &request, speed, live, || stop.is_asked());
                played.map(|captured| (captured, Vec::new()))
            }
        };
        played.map_err(|error| match error {
            ReplayError::Capture(error) => capture_failure(error),
            other => self.in_log(other),
        })
    }

    fn text_request(&self, columns: &str, header: &toml::Table) -> Result<TextRequest, Failure> {
        // Values of the log's header are checked against the same ranges as a flag.
        let number = |key: &str, range: plausible::Range| {
            let value = header.get(key).and_then(|value| {
                let whole = value.as_integer().map(|whole| whole as f64);
                value.as_float().or(whole)
            });
            match value {
                Some(value) if !range.holds(value) => Err(Failure::wrong(
                    format!(
                        "{}: header key `{key}` is {}, but must be {range}",
                        shown(&self.log),
                        plausible::Shown(value),
                    ),
                    format!("correct the line `# {key} = ...` at the top of the raw log"),
                )),
                value => Ok(value),
            }
        };
        let sample_time_s = number("sample_time_s", plausible::SAMPLE_TIME_S)?;
        let duration_s = match number("duration_s", ANY_DURATION_S)? {
            // Without a duration in its header, the log is replayed to its end.
            None => Some(0.0),
            stated => stated,
        };
        let integrate = text(header, "integrate").map(str::parse).transpose();
        let integrate = integrate.map_err(|error: String| {
            Failure::wrong(
                format!("{}: header key `integrate`: {error}", shown(&self.log)),
                "correct the line `# integrate = ...` at the top of the raw log".to_owned(),
            )
        })?;
        let told = TextFacts {
            columns,
            profile: text(header, "profile"),
            sample_time_us: sample_time_s.map(|s| (s * 1e6).round() as u32),
            counts_per_rev: match self.counts_per_rev {
                None => number("counts_per_rev", plausible::COUNTS_PER_REV)?,
                given => given,
            },
            supply_v: match self.supply {
                None => number("supply_v", plausible::SUPPLY_V)?,
                given => given,
            },
            duration_s,
            integrate: self.integrate.or(integrate),
        };
        told.request(&self.output, text(header, "port").unwrap_or("replayed"))
    }

    fn in_log(&self, error: ReplayError) -> Failure {
        let line = error.line();
        Failure::input(In::new(shown(&self.log), error))
            .at(&self.log)
            .in_row(line)
    }

    fn request(&self, header: &toml::Table) -> CaptureRequest {
        CaptureRequest {
            sample_time_us: 0,
            profile: Profile {
                name: text(header, "profile").unwrap_or("replayed").to_owned(),
                segments: Vec::new(),
            },
            samples: 0,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply,
            output: self.output.clone(),
            port: text(header, "port").unwrap_or("replayed").to_owned(),
            usb: None,
            further: toml::Table::new(),
        }
    }

    #[cfg(unix)]
    async fn be_a_device(
        &self,
        output: &Output,
        log: &mut rawlog::Reader<BufReader<File>>,
        stop: &StopSignal,
    ) -> Result<Status, Failure> {
        let mut events = Vec::new();
        while let Some(event) = log.next_event().map_err(|e| self.in_log(e.into()))? {
            events.push(event);
            if events.len() > MOST_PLAYED {
                return Err(Failure::wrong(
                    format!(
                        "{} has more than {MOST_PLAYED} events, as many as --pty plays",
                        shown(&self.log)
                    ),
                    "replay it without --pty, or cut the raw log after a whole line",
                ));
            }
        }
        let faster = match self.speed {
            None => Some(1.0),
            Some(Speed::Times(factor)) => Some(factor),
            Some(Speed::Max) => None,
        };
        let device = ReplayedDevice::spawn(&events, faster).map_err(Failure::device)?;
        if output.json {
            output.document(&json!({ "port": device.path() }))?;
        } else {
            output.line(&shown(device.path()))?;
        }
        while !stop.is_asked() && !device.is_gone() {
            // Polls whether the log has reached its hang-up.
            let _ = tokio::time::timeout(Duration::from_millis(200), stop.clone().asked()).await;
        }
        Ok(Status::Done)
    }
}
