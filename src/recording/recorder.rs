//! The path of every recording: samples in, rows of the run file, statistics and display state out.
//!
//! ```text
//! sample -> row (device time from the first sample) -> RunWriter
//!                                                   -> StatisticsGatherer
//!                                                   -> Live (what a display looks at)
//! ```
//!
//! The display never delays the recording: it reads [`Live`] at any time, and the recorder skips the update if it is
//! locked.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use firmware_protocol::EndReason;
use serde::Serialize;

use super::{
    CaptureError, Columns, Observation, Row, RunWriter, Statistics, StatisticsGatherer, Time,
    WriteError,
};
use crate::board::Damage;
use crate::platform::time::sleep_until;

/// Reason for the end of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// All requested samples were taken.
    Complete,
    /// A stop was requested.
    Stopped,
    /// The board received no message for half a second and stopped the motor.
    LinkLost,
    /// The board was unplugged.
    Unplugged,
    /// The board was reset during the run.
    BoardReset,
    /// The board sent another HELLO without a reset.
    BoardChanged,
    /// The board continued after the requested samples and did not stop on request.
    RanOn,
    /// The board fell silent.
    Silent,
    /// The line failed.
    LineFailed,
    /// The replayed raw log ends before the recording.
    LogEnded,
}

impl Ending {
    /// Whether recorder and board agree on the end.
    pub fn is_proper(self) -> bool {
        matches!(self, Self::Complete | Self::Stopped)
    }
}

impl From<EndReason> for Ending {
    fn from(reason: EndReason) -> Self {
        match reason {
            EndReason::Complete => Self::Complete,
            EndReason::Stopped => Self::Stopped,
            EndReason::LinkLost => Self::LinkLost,
        }
    }
}

/// Facts at the end of a recording, besides its rows.
#[derive(Debug)]
pub(super) struct Finish {
    /// Why it ended.
    pub ending: Ending,
    /// Samples lost at the end, without an effect on sample numbers.
    pub lost_at_the_end: u64,
    /// Samples taken, as the board states.
    pub taken: Option<u32>,
    /// Expected number of rows; `None` if unlimited, or after a stop.
    pub asked: Option<u64>,
    /// Contradictions.
    pub contradictions: Vec<String>,
}

impl Finish {
    /// For a recording with no facts but its rows.
    pub(super) fn by(ending: Ending) -> Self {
        Self {
            ending,
            lost_at_the_end: 0,
            taken: None,
            asked: None,
            contradictions: Vec::new(),
        }
    }
}

/// A finished recording.
#[derive(Debug)]
pub struct Captured {
    /// Its file.
    pub path: PathBuf,
    /// Why it ended.
    pub ending: Ending,
    /// Its figures.
    pub statistics: Statistics,
    /// Damage on the line.
    pub damage: Damage,
    /// Samples taken, as the board states; `None` without its END.
    pub taken: Option<u32>,
    /// Contradictions between the board's statements and its samples.
    pub contradictions: Vec<String>,
    /// All requested samples are in the file.
    pub complete: bool,
    /// The run file was deleted during the recording, and its rows continue at this path.
    pub rescued: Option<String>,
}

/// State of a running recording for a display.
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
    /// Sample time in s; 0 before the recording begins.
    pub sample_time_s: f64,
}

/// One sample for a display.
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

/// Samples kept for a display.
const RECENT: usize = 4096;

/// Shared with a display.
pub type SharedLive = Arc<Mutex<Live>>;

/// Measured values of a sample from a board with sensors.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Measured {
    /// Supply in V.
    pub supply_v: Option<f64>,
    /// Motor current in A.
    pub current_a: Option<f64>,
}

pub(super) struct Recorder {
    writer: RunWriter,
    gatherer: StatisticsGatherer,
    live: SharedLive,
    sample_time_s: f64,
    /// Points not yet passed to the display, because it was locked.
    waiting: Vec<LivePoint>,
    rescued: Option<String>,
}

impl Recorder {
    /// Begins the run file, before the motor turns.
    pub(super) fn begin(
        output: &Path,
        header: &toml::Table,
        columns: Columns,
        counts_per_rev: f64,
        live: &SharedLive,
    ) -> Result<Self, WriteError> {
        let mut recorder = Self {
            writer: RunWriter::create(output, header, columns)?,
            gatherer: StatisticsGatherer::new(counts_per_rev),
            live: Arc::clone(live),
            sample_time_s: header
                .get("sample_time_s")
                .and_then(toml::Value::as_float)
                .unwrap_or(0.0),
            waiting: Vec::new(),
            rescued: None,
        };
        recorder.show(true);
        Ok(recorder)
    }

    /// Records one sample: time since the first one, arrival time, and measured values.
    pub(super) fn append(
        &mut self,
        sample: Observation,
        arrived_us: u64,
        measured: Measured,
    ) -> Result<(), CaptureError> {
        let speed = self.writer.append(&Row {
            seq: sample.seq,
            time: Time::Micros(sample.device_us),
            host: Some(Time::Micros(arrived_us as i64)),
            command: sample.command,
            counts: sample.counts,
            flags: sample.flags,
            supply_v: measured.supply_v,
            current_a: measured.current_a,
        });
        let speed = self.survive(speed)?.flatten();
        self.gatherer.add(sample);
        self.waiting.push(LivePoint {
            t_s: sample.device_us as f64 * 1e-6,
            speed_rad_s: speed.unwrap_or(0.0),
            command: sample.command,
            counts: sample.counts,
        });
        Ok(())
    }

    /// Samples lost before the first received one, according to its number.
    pub(super) fn lost_before_the_first(&mut self, samples: u64) {
        self.gatherer.add_lost(samples);
    }

    /// Call when no data is pending: flushes the rows if the last flush is long enough ago, and returns whether it
    /// is.
    pub(super) fn flush_if_due(&mut self) -> Result<bool, CaptureError> {
        let flushed = self.writer.flush_if_due();
        let flushed = self.survive(flushed)?;
        self.show(false);
        Ok(flushed.unwrap_or(true))
    }

    /// Waits until rows must be flushed; for ever without rows. Cancel-safe.
    pub(super) async fn due(&self) {
        match self.writer.due() {
            Some(due) => sleep_until(due.into()).await,
            None => std::future::pending().await,
        }
    }

    /// A deleted file does not stop the recording: its rows continue elsewhere, which is reported at the end.
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

    /// Updates the display state, unless it is locked.
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
            live.sample_time_s = self.sample_time_s;
        }
        live.recent.extend(self.waiting.drain(..));
        let excess = live.recent.len().saturating_sub(RECENT);
        live.recent.drain(..excess);
        (live.samples, live.lost, live.overruns) = self.gatherer.counters();
    }

    /// Removes the file of a recording that did not begin.
    pub(super) fn discard(self) {
        self.writer.discard();
    }

    /// Losses according to sample numbers, and rows before which the board reports dropped frames.
    pub(super) fn missing(&self) -> (u64, u64) {
        let (_, lost, _) = self.gatherer.counters();
        (lost, self.gatherer.dropped())
    }

    /// Ends the file. `further` keys are added to its summary.
    pub(super) fn finish(
        mut self,
        end: Finish,
        damage: Damage,
        further: toml::Table,
    ) -> Result<Captured, CaptureError> {
        self.gatherer.add_lost(end.lost_at_the_end);
        let statistics = self.gatherer.statistics();
        let mut summary = summary(&statistics, damage, end.ending);
        summary.extend(further);
        if !end.contradictions.is_empty() {
            let count = end.contradictions.len() as i64;
            summary.insert("contradictions".to_owned(), count.into());
        }
        let complete = end.ending.is_proper()
            && statistics.lost == 0
            && end.asked.is_none_or(|asked| statistics.samples == asked);
        let path = self.writer.finish(&summary, complete)?;
        Ok(Captured {
            path,
            ending: end.ending,
            statistics,
            damage,
            taken: end.taken,
            contradictions: end.contradictions,
            complete,
            rescued: self.rescued,
        })
    }
}

/// Rounded to `1 / steps`.
fn rounded(value: f64, steps: f64) -> toml::Value {
    toml::Value::Float((value * steps).round() / steps)
}

/// The summary keys of a run.
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
    put("time_leaps", count(statistics.time_leaps));
    put("counts_leaps", count(statistics.counts_leaps));
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
