//! Recording from a plain sketch that prints its samples as text lines.
//!
//! There is no handshake and no checksum: what is recorded is what the lines say. Where they have the
//! board's time, it is the time base and tells losses; where they have not, the arrival times must do,
//! and the file says `timing = "host"`. Where they do not say what is commanded, the profile does.

use std::future::Future;
use std::path::PathBuf;
use std::time::Duration;

use super::header::{Facts, header};
use super::held_line::{HeldLine, Line, Usual};
use super::line_clock::{are_enough, line_clock, told};
use super::recorder::{Finish, Measured, Recorder};
use super::text_error::TextError;
use super::unit_of_time::power_of_unit;
use super::{CaptureError, Captured, Columns, CommandKind, Ending, Flags, Observation, SharedLive};
use crate::board::leap::most_counts;
use crate::board::motion::Motion;
use crate::board::text_lines::{
    self, Column, Skipped, SpeedUnit, TextDecoder, TextEvent, TextSample,
};
use crate::board::{
    Arrival, Damage, Heard, LineReader, Profile, RawLog, UsbIdentity, longest_gather,
};
use crate::motor::plausible::{COMMAND, COUNTS, Shown};
use crate::platform::time::{Instant, MissedTickBehavior, interval};

/// How often rows are handed to the operating system and silence is looked for.
const TICK: Duration = Duration::from_millis(20);

/// How long a sketch may print nothing, beyond four sample times, before it counts as gone.
const SILENCE: Duration = Duration::from_millis(1500);

/// Value of the header key `sample_time` where nobody stated it.
pub(crate) const MEASURED: &str = "measured from the lines";

/// By how much arrivals may come in bunches, in microseconds (measured elsewhere: 35 to 40 ms; generous).
const BUNCH_US: u64 = 250_000;

/// Largest value of `analogWrite`, and by how much more a command may be before it is said: a tenth.
const PWM_FULL_SCALE: f64 = 255.0;
const BEYOND: f64 = 1.1;

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

/// Shortest time between two lines that a host's clock is held against, in microseconds: lines that came in
/// one read have none (measured: reads of one line are 1 ms and more apart).
const TELLING_US: u64 = 500;

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
        self.hold_against_the_hosts_clock(&sample, host_us)?;
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
    fn hold_against_the_hosts_clock(
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
            (passed_us >= TELLING_US)
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

    /// Begins the file and takes the samples that waited for it.
    fn begin(&mut self) -> Result<Option<Ending>, TextError> {
        let waiting = std::mem::take(&mut self.waiting);
        let Some(&(first, first_host_us)) = waiting.first() else {
            return Ok(None);
        };
        let clock = line_clock(&waiting);
        let device_timed = clock.is_boards;
        let says_command = first.command_v.is_some() || first.command_pwm255.is_some();
        if !says_command && self.request.profile.is_none() {
            return Err(TextError::NoCommand {
                port: self.request.port.clone(),
            });
        }
        let sample_time_us = match self.request.sample_time_us {
            Some(given) => i64::from(given),
            None => clock.sample_time_us,
        };
        let numbered = device_timed || first.sequence.is_some();
        let columns = Columns {
            seq: numbered,
            supply: first.supply_v.is_some(),
            current: first.current_a.is_some(),
            ..Columns::recorded(CommandKind::Voltage)
        };
        let profile = match &self.request.profile {
            Some(profile) if !says_command => profile.name.as_str(),
            _ => "as the sketch says",
        };
        let mut further = toml::Table::new();
        let timing = if device_timed { "device" } else { "host" };
        further.insert("timing".to_owned(), timing.into());
        further.insert("device".to_owned(), "text lines".into());
        if self.request.sample_time_us.is_none() {
            further.insert("sample_time".to_owned(), MEASURED.into());
        }
        if clock.coarse_us > 0 {
            let coarse_s = clock.coarse_us as f64 * 1e-6;
            further.insert("clock_step_s".to_owned(), coarse_s.into());
        }
        if let Some(columns) = self.decoder.columns() {
            further.insert("text_columns".to_owned(), columns.to_string().into());
            if let Some(summed_up) = columns.summed_up() {
                let how = match summed_up {
                    Column::Increments => "increments, summed up".to_owned(),
                    speed => format!("integrated from {}, backward", speed.name()),
                };
                further.insert("text_position".to_owned(), how.into());
            }
        }
        let facts = Facts {
            sample_time_s: sample_time_us as f64 / 1e6,
            counts_per_rev: self.request.counts_per_rev,
            supply_v: self.request.supply_v,
            profile,
            port: &self.request.port,
            usb: self.request.usb.as_ref(),
        };
        let recorder = Recorder::begin(
            &self.request.output,
            &header(facts, further),
            columns,
            self.request.counts_per_rev,
            self.live,
        );
        self.running = Some(Running {
            recorder: recorder.map_err(CaptureError::Write)?,
            sample_time_us,
            device_timed,
            coarse_us: clock.coarse_us,
            numbered,
            first_us: match first.time_us.filter(|_| device_timed) {
                Some(first_us) => first_us.saturating_add(clock.first_late_us),
                None => first_host_us as i64,
            },
            lines: HeldLine::default(),
            last_us: None,
            last_counts: None,
            motion: Motion::default(),
            summed_counts: 0.0,
            seq: 0,
            unread: 0,
        });
        for (sample, host_us) in waiting {
            if let Some(ending) = self.append(sample, host_us)? {
                return Ok(Some(ending));
            }
        }
        Ok(None)
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
        let usual = Usual {
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

    /// Writes the row of a line.
    fn write(&mut self, line: Line) -> Result<Option<Ending>, TextError> {
        let Some(running) = &mut self.running else {
            return Ok(None);
        };
        let Line {
            mut sample,
            host_us,
            at_us,
        } = line;
        let pwm = sample.command_pwm255.unwrap_or(0.0).abs();
        self.largest_pwm = self.largest_pwm.max(pwm);
        let said_v = sample.command_v.unwrap_or(0.0).abs();
        self.largest_command_v = self.largest_command_v.max(said_v);
        let mut t_us = at_us.saturating_sub(running.first_us);
        if let Some(last_us) = running.last_us {
            if running.coarse_us > 0 {
                // Evenly spread between the stamps: no line comes before its own, nor after the next one.
                let even_us = last_us.saturating_add(running.sample_time_us);
                t_us = even_us.clamp(t_us, t_us.saturating_add(running.coarse_us));
            }
            if running.coarse_us > 0 || !running.device_timed {
                // Lines that came with one read have one arrival time; that of a run rises.
                t_us = t_us.max(last_us + 1);
            }
            let steps = (t_us - last_us).saturating_add(running.sample_time_us / 2)
                / running.sample_time_us.max(1);
            running.seq += steps.max(1) as u64;
        } else {
            t_us = t_us.max(0);
        }
        let passed_us = running.last_us.map_or(0, |last_us| t_us.abs_diff(last_us));
        let passed_s = running
            .last_us
            .map(|last_us| (t_us - last_us) as f64 * 1e-6);
        if let Some(summand) = sample.summand {
            running.summed_counts += counts_since(summand, passed_s, self.request.counts_per_rev);
            sample.counts = running.summed_counts.round() as i64;
        }
        running.last_us = Some(t_us);
        // Arrivals come in bunches: without the board's time a quarter of a second passes for any step.
        let bunch_us = if running.device_timed { 0 } else { BUNCH_US };
        let counts_per_rev = self.request.counts_per_rev;
        let goes_round = self.decoder.counts_go_round();
        let counts_leap = match running.last_counts.replace(sample.counts) {
            None => false,
            Some(last) => {
                let limit = most_counts(counts_per_rev, passed_us.saturating_add(bunch_us));
                let moved = sample.counts.saturating_sub(last) as f64;
                let is_gap = passed_us > 2 * running.sample_time_us.unsigned_abs();
                let is_leap = sample.counts.abs_diff(last) > limit
                    || running.motion.is_reset(moved, sample.counts)
                    || (goes_round
                        && is_gap
                        && running.motion.may_have_gone_round(passed_us as f64, 0.0));
                if !is_leap {
                    running.motion.push(moved, passed_us as f64);
                }
                is_leap
            }
        };
        let command = command_v(&sample, self.request.supply_v)
            .or(self
                .request
                .profile
                .as_ref()
                .map(|profile| profile.command_at(t_us as f64 * 1e-6)))
            .unwrap_or(0.0);
        let next_us = t_us as f64 + running.sample_time_us as f64;
        let over = self.request.duration_s > 0.0 && next_us >= self.request.duration_s * 1e6;
        let ending = over.then_some(Ending::Complete);
        if !can_be_read(&sample, self.request.supply_v) {
            self.damage.implausible += 1;
            running.unread += 1;
            return Ok(ending);
        }
        if running.numbered {
            // The number of the next row shows them.
            running.unread = 0;
        }
        let observation = Observation {
            seq: match sample.sequence {
                Some(sequence) => Some(sequence),
                None => running.numbered.then_some(running.seq),
            },
            device_us: t_us,
            host_us: running.device_timed.then_some(host_us as i64),
            command,
            counts: sample.counts,
            flags: Flags {
                counts_leap,
                ..Flags::default()
            },
        };
        let measured = Measured {
            supply_v: sample.supply_v,
            current_a: sample.current_a,
        };
        running.recorder.append(observation, host_us, measured)?;
        Ok(ending)
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

    /// Contradictions of the lines: then the exit status is no good one.
    fn contradictions(&self, ending: Ending) -> Vec<String> {
        let mut found = Vec::new();
        let supply_v = self.request.supply_v;
        if self.largest_pwm > BEYOND * PWM_FULL_SCALE {
            found.push(format!(
                "pwm reached {}, beyond the {PWM_FULL_SCALE} of full scale: commands of up to {} V on a supply of {supply_v} V; print command_v, or scale it to {PWM_FULL_SCALE}",
                Shown(self.largest_pwm),
                Shown(self.largest_pwm / PWM_FULL_SCALE * supply_v)
            ));
        }
        if self.largest_command_v > BEYOND * supply_v {
            found.push(format!(
                "command_v reached {} V on a supply of {supply_v} V; say the right supply with --supply, or print what the driver is given, in V",
                Shown(self.largest_command_v)
            ));
        }
        if let Some(running) = &self.running
            && ending == Ending::Complete
            && 2.0 * running.sample_time_us as f64 > self.request.duration_s * 1e6
            && self.request.duration_s > 0.0
        {
            found.push(format!(
                "a sample time of {} s does not go with a recording of {} s: is the unit of the time right?",
                running.sample_time_us as f64 * 1e-6,
                self.request.duration_s
            ));
        }
        found
    }

    /// Error of counts that are a sum.
    fn summed_up(&self) -> Option<String> {
        let summed_up = self.decoder.columns()?.summed_up()?;
        Some(match summed_up {
            Column::Increments => {
                "the counts are increments summed up, and the file says so: what a lost line counted is lost for good; print the counts where you can".to_owned()
            }
            speed => {
                let taken = match speed {
                    Column::Speed(SpeedUnit::Unsaid) => {
                        "`speed` is taken as rpm (name it rad_s, deg_s, rev_s or counts_s if it is another); "
                    }
                    _ => "",
                };
                format!(
                    "{taken}the counts are `{}` summed up over time at {} counts per revolution, and the file says so: they drift by what is rounded off, and lag by what is filtered; print the counts where you can",
                    speed.name(),
                    self.request.counts_per_rev
                )
            }
        })
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let Some(running) = &self.running else {
            return notes;
        };
        let sample_time_s = running.sample_time_us as f64 / 1e6;
        notes.extend(self.summed_up());
        if !self.request.assumed.is_empty() {
            notes.push(format!(
                "nothing says {}; the file has the lab handout's",
                self.request.assumed.join(" nor ")
            ));
        }
        if !running.device_timed {
            notes.push(
                "the lines have no time of the board: the run's timing is the host's, late by milliseconds and bunched, and the file says so; print micros() first on each line"
                    .to_owned(),
            );
        }
        let longest = self.decoder.longest_sample_line();
        let fits = text_lines::longest_line_bytes(self.request.baud, sample_time_s);
        if longest > fits {
            notes.push(format!(
                "the longest line has {longest} bytes, and {fits} fit into {sample_time_s} s at {} baud: print blocks and sampling slips; print fewer digits, or use 250000 baud",
                self.request.baud
            ));
        }
        if self.skipped > 0 {
            let example = self
                .last_skipped
                .as_ref()
                .map_or_else(String::new, |(text, _)| format!(", the last one {text:?}"));
            notes.push(format!(
                "{} lines were no samples and were passed over{example}",
                self.skipped
            ));
        }
        if self.damage.implausible > 0 {
            notes.push(format!(
                "{} lines did not go with the lines around them (a time or a count that leaps and comes back) and were passed over",
                self.damage.implausible
            ));
        }
        if running.coarse_us > 0 {
            notes.push(format!(
                "the lines' time goes on by {} s at a time, and they come every {sample_time_s} s: a coarse clock, between whose steps they are spread evenly; print micros(), or more decimals",
                running.coarse_us as f64 / 1e6
            ));
        }
        if self.damage.repeated > 0 {
            notes.push(format!(
                "{} lines had the time of the line before them and were passed over",
                self.damage.repeated
            ));
        }
        if self.request.sample_time_us.is_none() {
            notes.push(format!(
                "the sample time of {sample_time_s} s was measured from the lines; say it with --ts if it is another"
            ));
        }
        notes
    }
}

/// Counts since the row before by what a line says; those of the first row came before the recording. A speed is taken to have
/// held since the row before, as one does that was made of a difference.
fn counts_since((column, value): (Column, f64), passed_s: Option<f64>, counts_per_rev: f64) -> f64 {
    let Some(passed_s) = passed_s else {
        return 0.0;
    };
    let turns_per_s = match column {
        Column::Speed(unit) => unit.in_turns(),
        _ => return value,
    };
    value * turns_per_s.map_or(1.0, |factor| factor * counts_per_rev) * passed_s
}

/// The command in V that a line says, if it says one.
fn command_v(sample: &TextSample, supply_v: f64) -> Option<f64> {
    let of_pwm = |pwm: f64| pwm / PWM_FULL_SCALE * supply_v;
    sample.command_v.or(sample.command_pwm255.map(of_pwm))
}

/// Whether no reader of run files refuses what a line says: a row that does so takes its whole file with it.
fn can_be_read(sample: &TextSample, supply_v: f64) -> bool {
    let measured = [
        command_v(sample, supply_v),
        sample.supply_v,
        sample.current_a,
    ];
    measured
        .into_iter()
        .flatten()
        .all(|value| COMMAND.holds(value))
        && COUNTS.holds(sample.counts as f64)
}
