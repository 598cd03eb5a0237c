//! Recording from a board into a run file.
//!
//! ```text
//! Board::next -> row (device time from the first sample) -> RunWriter
//!                                                        -> StatisticsGatherer
//!                                                        -> Live (what a display looks at)
//! ```
//!
//! A display never holds this up: it looks at [`Live`] when it likes, and a recorder that finds it
//! being looked at goes on.

use std::collections::VecDeque;
use std::future::Future;
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use firmware_protocol::{EndReason, Hello, SampleFlags};
use serde::Serialize;

use super::{
    Columns, CommandKind, Flags, Observation, Row, RunWriter, Statistics, StatisticsGatherer, Time,
    WriteError,
};
use crate::board::{Board, BoardError, BoardEvent, Damage, Profile, Sample, UsbIdentity};

/// How often rows are handed to the operating system and silence is looked for.
const TICK: Duration = Duration::from_millis(10);

/// How long a recording board may say nothing, beyond four sample times, before it counts as gone.
const SILENCE: Duration = Duration::from_millis(1500);

/// How long an END may take after STOP, and how often STOP is said.
const END_WITHIN: Duration = Duration::from_millis(250);
const STOP_ATTEMPTS: u32 = 4;

/// What to record.
#[derive(Debug, Clone)]
pub struct CaptureRequest {
    /// Sample time in microseconds.
    pub sample_time_us: u32,
    /// What is commanded when.
    pub profile: Profile,
    /// Samples to take; 0 for no end but being asked to stop.
    pub samples: u32,
    /// Counts per revolution, if not what the board says.
    pub counts_per_rev: Option<f64>,
    /// Driver supply in V, if not what the board says.
    pub supply_v: Option<f64>,
    /// Where the run goes; an existing file is not overwritten.
    pub output: PathBuf,
    /// The port, as it was named.
    pub port: String,
    /// The USB device behind it.
    pub usb: Option<UsbIdentity>,
}

/// Why a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// All samples asked for were taken.
    Complete,
    /// It was asked to stop.
    Stopped,
    /// The board heard nothing of this program for half a second and stopped the motor.
    LinkLost,
    /// The board was unplugged.
    Unplugged,
    /// The board was reset in mid-run.
    BoardReset,
    /// The board fell silent.
    Silent,
    /// The line failed.
    LineFailed,
    /// The raw log that was replayed ends before the recording does.
    LogEnded,
}

impl Ending {
    /// Whether the recorder and the board both know that this was the end.
    pub fn is_proper(self) -> bool {
        matches!(self, Self::Complete | Self::Stopped)
    }
}

/// A recording that has ended.
#[derive(Debug)]
pub struct Captured {
    /// Its file.
    pub path: PathBuf,
    /// Why it ended.
    pub ending: Ending,
    /// Its figures.
    pub statistics: Statistics,
    /// What went wrong on the line.
    pub damage: Damage,
    /// Samples that the board says it took; `None` where its END did not arrive.
    pub taken: Option<u32>,
    /// The run file was deleted on the way and its rows went on elsewhere, as this says.
    pub rescued: Option<String>,
}

/// Why there is no recording, or not all of it.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The board.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// The run file.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The raw log.
    #[error("cannot write the raw log any further: {0}")]
    Log(#[source] io::Error),
}

/// What a display may look at while a recording runs.
#[derive(Debug, Clone, Default)]
pub struct Live {
    /// The latest samples, oldest first: time in s, speed in rad/s, command, counts.
    pub recent: VecDeque<LivePoint>,
    /// Samples so far.
    pub samples: u64,
    /// Losses so far.
    pub lost: u64,
    /// Late samples so far.
    pub overruns: u64,
    /// The file being written.
    pub path: PathBuf,
}

/// One sample as a display shows it.
#[derive(Debug, Clone, Copy)]
pub struct LivePoint {
    /// Device time in s from the first sample.
    pub t_s: f64,
    /// Speed in rad/s.
    pub speed_rad_s: f64,
    /// Command in V.
    pub command: f64,
    /// Counts.
    pub counts: i64,
}

/// Samples that a display can look back on.
const RECENT: usize = 4096;

/// Shared with a display.
pub type SharedLive = Arc<Mutex<Live>>;

/// Records until all samples are taken, `stop` resolves, or the board is gone.
pub async fn capture(
    board: &mut Board,
    request: &CaptureRequest,
    live: &SharedLive,
    stop: impl Future<Output = ()>,
) -> Result<Captured, CaptureError> {
    let sample_time_s = f64::from(request.sample_time_us) * 1e-6;
    let commands = request.profile.in_samples(sample_time_s);
    board.configure(request.sample_time_us, &commands).await?;
    let mut recorder = Recorder::create(request, board.hello(), live)?;
    board.start(request.samples).await?;
    let silence = SILENCE + 4 * Duration::from_micros(u64::from(request.sample_time_us));
    let ended = follow(board, &mut recorder, silence, stop).await;
    let (ending, taken) = match ended {
        Ok(ended) => ended,
        Err(error) => {
            // The motor must not run on; the board's END is of no use any more.
            let _ = board.stop();
            return Err(error);
        }
    };
    let _ = board.flush_log();
    recorder.finish(ending, taken, board.damage())
}

/// Takes events until the recording ends; says why, and how many samples the board took.
async fn follow(
    board: &mut Board,
    recorder: &mut Recorder,
    silence: Duration,
    stop: impl Future<Output = ()>,
) -> Result<(Ending, Option<u32>), CaptureError> {
    let mut tick = tokio::time::interval(TICK);
    tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let mut stop = std::pin::pin!(stop);
    let mut stopping = Stopping::default();
    let mut heard_at = Instant::now();
    loop {
        tokio::select! {
            biased;
            () = &mut stop, if !stopping.asked => {
                stopping.ask(board);
            }
            event = board.next() => {
                heard_at = Instant::now();
                match event {
                    Some(BoardEvent::Sample(sample)) => recorder.take(sample)?,
                    Some(BoardEvent::Ended { taken, reason, .. }) => {
                        let ending = match reason {
                            EndReason::Complete => Ending::Complete,
                            EndReason::Stopped if stopping.because_of_silence => Ending::Silent,
                            EndReason::Stopped => Ending::Stopped,
                            EndReason::LinkLost => Ending::LinkLost,
                        };
                        return Ok((ending, Some(taken)));
                    }
                    Some(BoardEvent::Restarted(_)) => return Ok((Ending::BoardReset, None)),
                    Some(BoardEvent::HungUp) | None => return Ok((Ending::Unplugged, None)),
                    Some(BoardEvent::Failed(_)) => return Ok((Ending::LineFailed, None)),
                    Some(BoardEvent::LogFailed(error)) => return Err(CaptureError::Log(error)),
                }
            }
            _ = tick.tick() => {
                recorder.flush_if_due()?;
                board.flush_log().map_err(CaptureError::Log)?;
                if !stopping.asked && heard_at.elapsed() > silence {
                    stopping.because_of_silence = true;
                    stopping.ask(board);
                }
                if stopping.asked && stopping.is_over(board) {
                    return Ok((Ending::Silent, None));
                }
            }
        }
    }
}

/// STOP has been said, and is said again until END comes.
#[derive(Debug, Default)]
struct Stopping {
    asked: bool,
    because_of_silence: bool,
    attempts: u32,
    last: Option<Instant>,
}

impl Stopping {
    fn ask(&mut self, board: &mut Board) {
        self.asked = true;
        self.attempts += 1;
        self.last = Some(Instant::now());
        // A line that is gone shows on the reading side.
        let _ = board.stop();
    }

    fn is_over(&mut self, board: &mut Board) -> bool {
        if self.last.is_some_and(|last| last.elapsed() < END_WITHIN) {
            return false;
        }
        if self.attempts == STOP_ATTEMPTS {
            return true;
        }
        self.ask(board);
        false
    }
}

/// Rows on their way to the file, the figures and the display.
pub(super) struct Recorder {
    writer: RunWriter,
    gatherer: StatisticsGatherer,
    live: SharedLive,
    first_us: Option<u64>,
    /// Points that the display has not got yet, because it was looking.
    waiting: Vec<LivePoint>,
    rescued: Option<String>,
}

impl Recorder {
    /// Begins the run file, before the board is started.
    pub(super) fn create(
        request: &CaptureRequest,
        hello: &Hello,
        live: &SharedLive,
    ) -> Result<Self, WriteError> {
        let columns = Columns {
            supply: hello.fields.supply,
            current: hello.fields.current,
            ..Columns::recorded(CommandKind::Voltage)
        };
        let counts_per_rev = request
            .counts_per_rev
            .unwrap_or(f64::from(hello.counts_per_rev));
        let mut recorder = Self {
            writer: RunWriter::create(&request.output, &header(request, hello), columns)?,
            gatherer: StatisticsGatherer::new(counts_per_rev),
            live: Arc::clone(live),
            first_us: None,
            waiting: Vec::new(),
            rescued: None,
        };
        recorder.show(true);
        Ok(recorder)
    }

    pub(super) fn take(&mut self, sample: Sample) -> Result<(), CaptureError> {
        let first_us = *self.first_us.get_or_insert(sample.device_us);
        let t_us = (sample.device_us - first_us) as i64;
        let flags = flags(sample.flags);
        let command = f64::from(sample.command_mv) / 1000.0;
        let speed = self.writer.append(&Row {
            seq: Some(sample.number),
            time: Time::Micros(t_us),
            host: Some(Time::Micros(sample.host_us as i64)),
            command,
            counts: sample.counts,
            flags,
            supply_v: sample.supply_mv.map(|mv| f64::from(mv) / 1000.0),
            current_a: sample.current_ma.map(|ma| f64::from(ma) / 1000.0),
        });
        let speed = self.survive(speed)?.flatten();
        self.gatherer.add(Observation {
            seq: Some(sample.number),
            device_us: t_us,
            host_us: Some(sample.host_us as i64),
            command,
            counts: sample.counts,
            flags,
        });
        self.waiting.push(LivePoint {
            t_s: t_us as f64 * 1e-6,
            speed_rad_s: speed.unwrap_or(0.0),
            command,
            counts: sample.counts,
        });
        self.flush_if_due()
    }

    pub(super) fn flush_if_due(&mut self) -> Result<(), CaptureError> {
        let flushed = self.writer.flush_if_due();
        self.survive(flushed)?;
        self.show(false);
        Ok(())
    }

    /// A deleted file is no reason to stop: its rows go on elsewhere, and that is said at the end.
    fn survive<T>(&mut self, result: Result<T, WriteError>) -> Result<Option<T>, CaptureError> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error @ WriteError::Vanished { .. }) => {
                self.rescued = Some(error.to_string());
                Ok(None)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Lets the display see, unless it is looking right now.
    fn show(&mut self, with_path: bool) {
        if self.waiting.len() < 8 && !with_path && self.writer.rows() > 8 {
            return;
        }
        let Ok(mut live) = self.live.try_lock() else {
            let excess = self.waiting.len().saturating_sub(RECENT);
            self.waiting.drain(..excess);
            return;
        };
        if with_path {
            live.path = self.writer.path().to_owned();
        }
        live.recent.extend(self.waiting.drain(..));
        let excess = live.recent.len().saturating_sub(RECENT);
        live.recent.drain(..excess);
        (live.samples, live.lost, live.overruns) = self.gatherer.counters();
    }

    pub(super) fn finish(
        mut self,
        ending: Ending,
        taken: Option<u32>,
        damage: Damage,
    ) -> Result<Captured, CaptureError> {
        let seen = self.gatherer.counters();
        if let Some(taken) = taken {
            // Losses at the end, which no sample number shows.
            let (samples, lost, _) = seen;
            self.gatherer
                .add_lost(u64::from(taken).saturating_sub(samples + lost));
        }
        let statistics = self.gatherer.statistics();
        let summary = summary(&statistics, damage, ending);
        let path = self.writer.finish(&summary, ending.is_proper())?;
        Ok(Captured {
            path,
            ending,
            statistics,
            damage,
            taken,
            rescued: self.rescued,
        })
    }
}

fn flags(flags: SampleFlags) -> Flags {
    Flags {
        overrun: flags.overrun,
        dropped: flags.dropped,
        encoder_error: flags.encoder_error,
        saturated: flags.saturated,
    }
}

/// The keys above a recorded run.
fn header(request: &CaptureRequest, hello: &Hello) -> toml::Table {
    let mut header = toml::Table::new();
    let mut put = |key: &str, value: toml::Value| {
        header.insert(key.to_owned(), value);
    };
    put(
        "sample_time_s",
        toml::Value::Float(f64::from(request.sample_time_us) / 1e6),
    );
    let counts_per_rev = request
        .counts_per_rev
        .unwrap_or(f64::from(hello.counts_per_rev));
    put("counts_per_rev", number(counts_per_rev));
    let supply_v = request
        .supply_v
        .unwrap_or(f64::from(hello.supply_mv) / 1000.0);
    put("supply_v", number(supply_v));
    put("profile", request.profile.name.clone().into());
    let now = time::OffsetDateTime::now_utc();
    if let Ok(started) = now.format(&time::format_description::well_known::Rfc3339) {
        put("started", started.into());
    }
    put(
        "recorder",
        concat!("motorlab ", env!("CARGO_PKG_VERSION")).into(),
    );
    put("device", hello.name.as_str().into());
    let (major, minor) = hello.firmware_version;
    put("firmware", format!("{major}.{minor}").into());
    put("boot_id", i64::from(hello.boot_id).into());
    let mut port = toml::Table::new();
    port.insert("name".to_owned(), request.port.clone().into());
    if let Some(usb) = &request.usb {
        port.insert("vid".to_owned(), i64::from(usb.vid).into());
        port.insert("pid".to_owned(), i64::from(usb.pid).into());
        if let Some(serial) = &usb.serial {
            port.insert("serial".to_owned(), serial.clone().into());
        }
    }
    put("port", port.into());
    header
}

/// A whole number as one.
fn number(value: f64) -> toml::Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        toml::Value::Integer(value as i64)
    } else {
        toml::Value::Float(value)
    }
}

/// Rounded to `1 / steps`.
fn rounded(value: f64, steps: f64) -> toml::Value {
    toml::Value::Float((value * steps).round() / steps)
}

/// The keys that a run gets at its end.
fn summary(statistics: &Statistics, damage: Damage, ending: Ending) -> toml::Table {
    let mut summary = toml::Table::new();
    let mut put = |key: &str, value: toml::Value| {
        summary.insert(key.to_owned(), value);
    };
    let count = |count: u64| toml::Value::Integer(count.min(i64::MAX as u64) as i64);
    let ending = serde_json::to_value(ending).ok();
    if let Some(ending) = ending.as_ref().and_then(serde_json::Value::as_str) {
        put("ending", ending.into());
    }
    put("samples", count(statistics.samples));
    put("lost", count(statistics.lost));
    put("overruns", count(statistics.overruns));
    put("dropped", count(statistics.dropped));
    put("encoder_errors", count(statistics.encoder_errors));
    put("saturated", count(statistics.saturated));
    put("bad_frames", count(damage.bad_frames));
    put("implausible", count(damage.implausible));
    put("duration_s", statistics.duration_s.into());
    if let Some(dt) = &statistics.device_dt {
        put("device_dt_min_us", dt.min_us.into());
        put("device_dt_median_us", dt.median_us.into());
        put("device_dt_max_us", dt.max_us.into());
    }
    if let Some(clock) = &statistics.clock {
        put("clock_fast_ppm", rounded(clock.device_fast_ppm, 1e3));
        put("clock_sigma_ppm", rounded(clock.sigma_ppm, 1e3));
        put("clock_residual_rms_s", rounded(clock.residual_rms_s, 1e7));
    }
    if let Some(rpm) = statistics.steady_rpm {
        put("steady_rpm", rounded(rpm, 1e4));
    }
    summary
}
