//! Recording from a plain sketch that prints its samples as text lines.
//!
//! Lines in, a run file out; there is no handshake and no checksum. Lines with the board's time have it as time base, which
//! shows lost lines; for others the arrival times are the time base, and the file has `timing = "host"`. The command is
//! that of the lines, else that of the profile.

mod begin;
mod remarks;
mod row;

use std::future::Future;
use std::path::PathBuf;
use std::time::Duration;

use super::held_line::{ExpectedTiming, HeldLine, Line};
use super::line_clock::{are_enough, told};
use super::recorder::{Finish, Recorder};
use super::text_error::TextError;
use super::unit_of_time::power_of_unit;
use super::{Captured, Ending, SharedLive};
use crate::board::motion::Motion;
use crate::board::text_lines::{self, Skipped, TextDecoder, TextEvent, TextSample};
use crate::board::{
    Arrival, Damage, Heard, LineReader, Profile, RawLog, UsbIdentity, longest_gather,
};
use crate::platform::time::{Instant, MissedTickBehavior, interval};

/// How often rows are handed to the operating system and silence is looked for.
const TICK: Duration = Duration::from_millis(20);

/// How long a sketch may print nothing, beyond four sample times, before it counts as gone.
const SILENCE: Duration = Duration::from_millis(1500);

/// Value of the header key `sample_time` where nobody stated it.
pub(crate) const MEASURED: &str = "measured from the lines";

/// Settings of a recording from a sketch.
#[derive(Debug, Clone)]
pub struct TextRequest {
    /// Meaning of each number; `None` takes it from the sketch's header line or labels.
    pub columns: Option<text_lines::Columns>,
    /// Sample time in microseconds; `None` takes it from the first samples.
    pub sample_time_us: Option<u32>,
    /// Counts per revolution.
    pub counts_per_rev: f64,
    /// Driver supply in V, which a PWM command is a fraction of.
    pub supply_v: f64,
    /// Which of the two above is the lab handout's by default: in words.
    pub assumed: Vec<String>,
    /// Command of the sketch, if its lines lack it.
    pub profile: Option<Profile>,
    /// How long to record in s; 0 for no end but being asked to stop.
    pub duration_s: f64,
    /// Bits per second on the line.
    pub baud: u32,
    /// How long the first sample may take.
    pub patience: Duration,
    /// Where the run goes; an existing file is not overwritten.
    pub output: PathBuf,
    /// The port, as it was named.
    pub port: String,
    /// The USB device behind it.
    pub usb: Option<UsbIdentity>,
}

/// Shortest time between two lines that a host's clock is compared with, in microseconds: lines that came in
/// one read have none (measured: reads of one line are 1 ms and more apart).
const LEAST_INTERVAL_US: u64 = 500;

/// A recording of a sketch, with what there is to say about it.
#[derive(Debug)]
pub struct TextCaptured {
    /// The recording.
    pub captured: Captured,
    /// Remarks for the user.
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

/// A recording of text lines under way, without a line of its own.
pub(super) struct TextRecording<'a> {
    request: TextRequest,
    live: &'a SharedLive,
    decoder: TextDecoder,
    heard: Heard,
    /// When the last sample came, or the wait for the first one began.
    sampled_at: Instant,
    /// Samples before the sample time is known, with their arrival times.
    waiting: Vec<(TextSample, u64)>,
    running: Option<Running>,
    first_line_over: bool,
    /// Board's and host's time of the first sample and of the last.
    clocks: Option<[(i64, u64); 2]>,
    /// Largest PWM value that was said.
    largest_pwm: f64,
    /// Largest command in V that was said.
    largest_command_v: f64,
    skipped: u64,
    last_skipped: Option<(String, Skipped)>,
    damage: Damage,
}

/// Facts once the file has begun.
struct Running {
    recorder: Recorder,
    sample_time_us: i64,
    /// The lines have the board's time.
    device_timed: bool,
    /// By how much that time steps, in microseconds, where it is coarse; 0 where it is fine.
    coarse_us: i64,
    numbered: bool,
    first_us: i64,
    lines: HeldLine,
    last_us: Option<i64>,
    last_counts: Option<i64>,
    motion: Motion,
    /// Increments or speeds summed up, in counts.
    summed_counts: f64,
    seq: u64,
    /// Lines that no reader of run files would take, and that no sample number shows.
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

    /// Takes bytes; the ending, if they bring it.
    pub(super) fn push(&mut self, host_us: u64, bytes: &[u8]) -> Result<Option<Ending>, TextError> {
        for &byte in bytes {
            if self.running.is_none() {
                self.heard.push(byte);
            }
            // The port is opened in the middle of a line: what is left of it may look like a sample.
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

    /// A unit of time that is wrong by 1000 shows at the second line: both since the first line and since the
    /// last one the board's time must run by that factor, so that a late read is no reason.
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

    /// Takes a line once the file has begun: an odd one is held back until the next one.
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

    /// How long lines may gather before they are read: not at all where their arrival is the time base.
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

    /// How long the line may be silent.
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

    /// Ends the file.
    pub(super) fn finish(mut self, ending: Ending) -> Result<TextCaptured, TextError> {
        if self.running.is_none() {
            // Fewer samples than the sample time is usually taken from.
            self.begin()?;
        }
        if let Some(line) = self
            .running
            .as_mut()
            .and_then(|running| running.lines.end())
        {
            // Whatever it would end has ended.
            self.write(line)?;
        }
        let notes = self.notes();
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
        Ok(TextCaptured { captured, notes })
    }
}
