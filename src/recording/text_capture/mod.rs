//! Recording from a sketch that prints its samples as text lines.
//!
//! Lines in, a run file out; there is no handshake and no checksum. The board's time is the time base if lines have
//! it, which shows lost lines; else arrival times are, and the file has `timing = "host"`. The command is that of the
//! lines, else that of the profile.

mod begin;
mod remarks;
mod row;
mod speeds;

use std::future::Future;
use std::path::PathBuf;
use std::time::Duration;

use super::held_line::{ExpectedTiming, HeldLine, Line};
use super::line_clock::{are_enough, told};
use super::recorder::{Finish, Recorder};
use super::text_error::TextError;
use super::unit_of_time::power_of_unit;
use super::{Captured, Ending, Integration, SharedLive};
use crate::board::motion::Motion;
use crate::board::text_lines::{self, Skipped, TextDecoder, TextEvent, TextSample};
use crate::board::{
    Arrival, Damage, Heard, LineReader, Profile, RawLog, UsbIdentity, longest_gather,
};
use crate::platform::time::{Instant, MissedTickBehavior, interval};
use speeds::Speeds;

/// Polling period for flushing rows and for silence.
const TICK: Duration = Duration::from_millis(20);

/// Longest silence of a sketch, in addition to four sample times.
const SILENCE: Duration = Duration::from_millis(1500);

/// Value of the header key `sample_time` if it was not stated.
pub(crate) const MEASURED: &str = "measured from the lines";

/// Settings of a recording from a sketch.
#[derive(Debug, Clone)]
pub struct TextRequest {
    /// Meaning of each number; `None`: from the sketch's header line or labels.
    pub columns: Option<text_lines::Columns>,
    /// Sample time in microseconds; `None`: from the first samples.
    pub sample_time_us: Option<u32>,
    /// Counts per revolution.
    pub counts_per_rev: f64,
    /// Driver supply in V, the reference of a PWM command.
    pub supply_v: f64,
    /// Which of the two values above are the lab handout's defaults.
    pub assumed: Vec<String>,
    /// Integration rule of a speed; `None`: the one that leaves less of a first-order motor.
    pub integrate: Option<Integration>,
    /// Command of the sketch, if its lines lack it.
    pub profile: Option<Profile>,
    /// Duration in s; 0 is unlimited.
    pub duration_s: f64,
    /// Bits per second on the line.
    pub baud: u32,
    /// Time limit for the first sample.
    pub patience: Duration,
    /// Path of the run; an existing file is not overwritten.
    pub output: PathBuf,
    /// The port, as given.
    pub port: String,
    /// The USB device behind it.
    pub usb: Option<UsbIdentity>,
}

/// Shortest interval between two lines for a comparison with the host's clock, in microseconds: lines in one read
/// have no interval (measured: reads of one line are 1 ms and more apart).
const LEAST_INTERVAL_US: u64 = 500;

/// A recording from a sketch, with its notes.
#[derive(Debug)]
pub struct TextCaptured {
    /// The recording.
    pub captured: Captured,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Records until the time is over, `stop` resolves, or the sketch is gone.
pub async fn capture_text(
    reader: &mut LineReader,
    mut log: Option<RawLog>,
    request: TextRequest,
    live: &SharedLive,
    stop: impl Future<Output = ()>,
) -> Result<TextCaptured, TextError> {
    let mut stop = std::pin::pin!(stop);
    let mut tick = interval(TICK);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut heard_at = Instant::now();
    let mut text = TextRecording::new(request, live);
    let ending = loop {
        tokio::select! {
            biased;
            () = &mut stop => break Ending::Stopped,
            arrival = reader.next() => {
                heard_at = Instant::now();
                match arrival {
                    Some(Arrival::Bytes { host_us, bytes }) => {
                        if let Some(log) = &mut log {
                            log.received(host_us, &bytes);
                        }
                        if let Some(ending) = text.push(host_us, &bytes)? {
                            break ending;
                        }
                        text.flush_if_due()?;
                        reader.gather(text.longest_gather());
                    }
                    Some(Arrival::HungUp { host_us }) => {
                        if let Some(log) = &mut log {
                            log.hang_up(host_us);
                        }
                        break Ending::Unplugged;
                    }
                    Some(Arrival::Failed(source)) => {
                        let port = text.request.port.clone();
                        return Err(TextError::Line { port, source });
                    }
                    None => break Ending::Unplugged,
                }
            }
            _ = tick.tick() => {
                text.flush_if_due()?;
                if let Some(log) = &mut log {
                    log.flush();
                }
                if heard_at.elapsed() > text.patience() {
                    break Ending::Silent;
                }
                if text.has_waited_too_long() {
                    return Err(text.no_sample());
                }
            }
        }
    };
    if let Some(log) = &mut log {
        log.flush();
    }
    text.finish(ending)
}

/// A recording of text lines without I/O.
pub(super) struct TextRecording<'a> {
    request: TextRequest,
    live: &'a SharedLive,
    decoder: TextDecoder,
    heard: Heard,
    /// Time of the last sample, or of the start.
    sampled_at: Instant,
    /// Samples before the sample time is known, with their arrival times.
    waiting: Vec<(TextSample, u64)>,
    running: Option<Running>,
    first_line_over: bool,
    /// Board's and host's time of the first and the last sample.
    clocks: Option<[(i64, u64); 2]>,
    /// Largest PWM value.
    largest_pwm: f64,
    /// Largest command in V.
    largest_command_v: f64,
    skipped: u64,
    last_skipped: Option<(String, Skipped)>,
    damage: Damage,
}

/// State after the file has begun.
struct Running {
    recorder: Recorder,
    sample_time_us: i64,
    /// The board's time is the time base.
    device_timed: bool,
    /// Resolution of that time in microseconds if it is coarse; 0 if it is fine.
    coarse_us: i64,
    numbered: bool,
    first_us: i64,
    lines: HeldLine,
    last_us: Option<i64>,
    last_counts: Option<i64>,
    motion: Motion,
    /// Integrated increments or speeds in counts.
    summed_counts: f64,
    /// The speeds themselves.
    speeds: Option<Speeds>,
    seq: u64,
    /// Lines that a reader of run files would reject, without an effect on sample numbers.
    unread: u64,
}

impl<'a> TextRecording<'a> {
    pub(super) fn new(request: TextRequest, live: &'a SharedLive) -> Self {
        Self {
            decoder: TextDecoder::new(request.columns.clone()),
            request,
            live,
            heard: Heard::default(),
            sampled_at: Instant::now(),
            waiting: Vec::new(),
            running: None,
            first_line_over: false,
            clocks: None,
            largest_pwm: 0.0,
            largest_command_v: 0.0,
            skipped: 0,
            last_skipped: None,
            damage: Damage::default(),
        }
    }

    /// Processes bytes; returns the ending, if they cause it.
    pub(super) fn push(&mut self, host_us: u64, bytes: &[u8]) -> Result<Option<Ending>, TextError> {
        for &byte in bytes {
            if self.running.is_none() {
                self.heard.push(byte);
            }
            // The port is opened in the middle of a line, whose rest may resemble a sample.
            let torn = !self.first_line_over;
            self.first_line_over |= matches!(byte, b'\n' | b'\r');
            match self.decoder.push(byte) {
                Some(TextEvent::Sample(_)) if torn => {}
                Some(TextEvent::Sample(sample)) => {
                    if let Some(ending) = self.take(sample, host_us)? {
                        return Ok(Some(ending));
                    }
                }
                Some(TextEvent::Skipped { why, text, .. }) => {
                    self.skipped += u64::from(!torn);
                    self.last_skipped = Some((text, why));
                }
                Some(TextEvent::Header(_) | TextEvent::BadHeader(_)) | None => {}
            }
        }
        Ok(None)
    }

    fn take(&mut self, sample: TextSample, host_us: u64) -> Result<Option<Ending>, TextError> {
        self.compare_with_host_clock(&sample, host_us)?;
        if self.running.is_some() {
            return self.append(sample, host_us);
        }
        self.sampled_at = Instant::now();
        self.waiting.push((sample, host_us));
        let is_enough = match self.request.sample_time_us {
            Some(given_us) => told(&self.waiting, i64::from(given_us)),
            None => are_enough(
                &self.waiting,
                (self.request.duration_s.max(0.0) * 1e6) as u64,
            ),
        };
        if is_enough {
            return self.begin();
        }
        Ok(None)
    }

    /// A unit of time that is wrong by 1000 shows at the second line: the board's time must be off by that factor
    /// since the first line and since the last one, which excludes a late read.
    fn compare_with_host_clock(
        &mut self,
        sample: &TextSample,
        host_us: u64,
    ) -> Result<(), TextError> {
        let Some(time_us) = sample.time_us else {
            return Ok(());
        };
        let [first, last] = self.clocks.unwrap_or([(time_us, host_us); 2]);
        self.clocks = Some([first, (time_us, host_us)]);
        let since = |(board_us, then_us): (i64, u64)| {
            let passed_us = host_us.saturating_sub(then_us);
            let board_us = time_us.saturating_sub(board_us);
            (passed_us >= LEAST_INTERVAL_US)
                .then(|| power_of_unit(board_us as f64 / passed_us as f64))?
                .filter(|power| *power != 0)
        };
        let Some(power) = since(first).filter(|power| since(last) == Some(*power)) else {
            return Ok(());
        };
        let factor = 10f64.powi(power);
        let columns = self.decoder.columns().map_or(&[][..], |c| c.as_slice());
        let renamed = columns
            .iter()
            .find_map(|&column| Some((column, column.in_unit_times(1.0 / factor)?)));
        let Some((named, meant)) = renamed else {
            return Ok(());
        };
        let columns: Vec<&str> = columns
            .iter()
            .map(|&column| {
                if column == named {
                    meant.name()
                } else {
                    column.name()
                }
            })
            .collect();
        Err(TextError::TimeUnit {
            port: self.request.port.clone(),
            factor,
            named: named.name(),
            meant: meant.name(),
            columns: columns.join(","),
        })
    }

    /// Adds a line after the file has begun: an odd one is held back until the next one.
    fn append(&mut self, sample: TextSample, host_us: u64) -> Result<Option<Ending>, TextError> {
        let Some(running) = &mut self.running else {
            return Ok(None);
        };
        let at_us = match sample.time_us {
            Some(time_us) if running.device_timed => time_us,
            _ => host_us as i64,
        };
        let is_fine = running.device_timed && running.coarse_us == 0;
        if is_fine && running.lines.latest_us() == Some(at_us) {
            self.damage.repeated += 1;
            return Ok(None);
        }
        let line = Line {
            sample,
            host_us,
            at_us,
        };
        let usual = ExpectedTiming {
            sample_time_us: running.sample_time_us,
            coarse_us: running.coarse_us,
            is_boards: running.device_timed,
        };
        let taken = running.lines.take(line, usual);
        self.damage.implausible += taken.passed_over;
        for line in taken.write {
            if let Some(ending) = self.write(line)? {
                return Ok(Some(ending));
            }
        }
        Ok(taken.is_reset.then_some(Ending::BoardReset))
    }

    /// How long lines may accumulate before they are read: 0 if arrival times are the time base.
    fn longest_gather(&self) -> Duration {
        match &self.running {
            Some(running) if running.device_timed => longest_gather(
                self.request.baud,
                Duration::from_micros(running.sample_time_us.max(0).unsigned_abs()),
            ),
            _ => Duration::ZERO,
        }
    }

    pub(super) fn flush_if_due(&mut self) -> Result<(), TextError> {
        if let Some(running) = &mut self.running {
            running.recorder.flush_if_due()?;
        }
        Ok(())
    }

    /// Longest silence of the line.
    fn patience(&self) -> Duration {
        match &self.running {
            Some(running) => {
                SILENCE + 4 * Duration::from_micros(running.sample_time_us.unsigned_abs())
            }
            None => Duration::MAX,
        }
    }

    fn has_waited_too_long(&self) -> bool {
        self.running.is_none() && self.sampled_at.elapsed() > self.request.patience
    }

    fn no_sample(&self) -> TextError {
        TextError::NoSample {
            port: self.request.port.clone(),
            heard: Box::new(self.heard.clone()),
            last_skipped: self.last_skipped.clone(),
        }
    }

    pub(super) fn finish(mut self, ending: Ending) -> Result<TextCaptured, TextError> {
        if self.running.is_none() {
            // Fewer samples than the sample time normally needs.
            self.begin()?;
        }
        if let Some(line) = self
            .running
            .as_mut()
            .and_then(|running| running.lines.end())
        {
            // An ending caused by this line is obsolete.
            self.write(line)?;
        }
        let mut notes = self.notes();
        let speeds = self
            .running
            .as_mut()
            .and_then(|running| running.speeds.take());
        let longest = self.decoder.longest_sample_line();
        let (skipped, no_sample) = (self.skipped, self.no_sample());
        let contradictions = self.contradictions(ending);
        let Some(running) = self.running else {
            return Err(no_sample);
        };
        let mut further = toml::Table::new();
        further.insert("skipped_lines".to_owned(), (skipped as i64).into());
        further.insert("longest_line_bytes".to_owned(), (longest as i64).into());
        let captured = running.recorder.finish(
            Finish {
                contradictions,
                lost_at_the_end: running.unread,
                ..Finish::by(ending)
            },
            self.damage,
            further,
        )?;
        let decided = speeds
            .as_ref()
            .and_then(|speeds| speeds.integrate(&captured.path, self.request.integrate));
        if let Some(words) = decided {
            notes.insert(0, format!("the speed is summed up: {words}"));
        }
        Ok(TextCaptured { captured, notes })
    }
}
