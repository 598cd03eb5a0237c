//! Recording from a board into a run file: configuration, start, samples, end.

use std::future::Future;
use std::path::PathBuf;
use std::time::Duration;

use firmware_protocol::{EndReason, Hello, SampleFlags};

use super::end::{End, Ended, ReceivedSamples};
use super::header::{Facts, header};
use super::recorder::{Finish, Measured, Recorder};
use super::{Captured, Columns, CommandKind, Ending, Flags, Observation, SharedLive, WriteError};
use crate::board::{Board, BoardError, BoardEvent, Damage, Leap, Profile, Sample, UsbIdentity};
use crate::platform::time::{Instant, MissedTickBehavior, interval};

/// Polling period for silence.
const TICK: Duration = Duration::from_millis(100);

/// Longest silence of a recording board, in addition to four sample times.
const SILENCE: Duration = Duration::from_millis(1500);

/// Time limit for an END after STOP, and number of attempts.
const END_WITHIN: Duration = Duration::from_millis(250);
const STOP_ATTEMPTS: u32 = 4;

/// Settings of a recording.
#[derive(Debug, Clone)]
pub struct CaptureRequest {
    /// Sample time in microseconds.
    pub sample_time_us: u32,
    /// Command over time.
    pub profile: Profile,
    /// Samples to take; 0 is unlimited.
    pub samples: u32,
    /// Counts per revolution, if they differ from the board's.
    pub counts_per_rev: Option<f64>,
    /// Driver supply in V, if it differs from the board's.
    pub supply_v: Option<f64>,
    /// Path of the run; an existing file is not overwritten.
    pub output: PathBuf,
    /// The port, as given.
    pub port: String,
    /// The USB device behind it.
    pub usb: Option<UsbIdentity>,
    /// Additional keys of the run's header.
    pub further: toml::Table,
}

impl CaptureRequest {
    /// Counts per revolution: as given, or the board's.
    pub(super) fn counts_per_rev(&self, hello: &Hello) -> f64 {
        self.counts_per_rev
            .unwrap_or(f64::from(hello.counts_per_rev))
    }

    /// Supply in V: as given, or the board's.
    fn supply_v(&self, hello: &Hello) -> f64 {
        self.supply_v.unwrap_or(f64::from(hello.supply_mv) / 1000.0)
    }

    fn silence(&self) -> Duration {
        SILENCE + 4 * Duration::from_micros(u64::from(self.sample_time_us))
    }

    /// An encoder with 0 counts gives no speed, and a driver with 0 V no command.
    fn refuse_zeros(&self, hello: &Hello) -> Result<(), BoardError> {
        let states = |what, option| BoardError::StatesZero {
            path: self.port.clone(),
            what,
            option,
        };
        if self.counts_per_rev(hello) == 0.0 {
            return Err(states("counts_per_rev", "--counts-per-rev"));
        }
        if self.supply_v(hello) == 0.0 {
            return Err(states("its supply", "--supply"));
        }
        Ok(())
    }
}

/// Errors of a recording.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The board.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// The run file.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Records until all samples are taken, `stop` resolves, or the board is gone.
pub async fn capture(
    board: &mut Board,
    request: &CaptureRequest,
    live: &SharedLive,
    stop: impl Future<Output = ()>,
) -> Result<Captured, CaptureError> {
    let sample_time_s = f64::from(request.sample_time_us) * 1e-6;
    let commands = request.profile.in_samples(sample_time_s);
    request.refuse_zeros(board.hello())?;
    board.configure(request.sample_time_us, &commands).await?;
    let mut recorder = BoardRecorder::begin(request, board.hello(), live)?;
    board.encoder(request.counts_per_rev(board.hello()));
    if let Err(error) = board.start(request.samples).await {
        // No motor has turned and no sample was received: the file would have a header only.
        recorder.recorder.discard();
        return Err(error.into());
    }
    let ended = follow(board, &mut recorder, request.silence(), stop).await;
    let ended = match ended {
        Ok(ended) => ended,
        Err(error) => {
            // The motor must be stopped; the board's END is not needed.
            let _ = board.stop();
            return Err(error);
        }
    };
    board.flush_log();
    let captured = recorder.finish(ended, board.damage())?;
    if !captured.contradictions.is_empty() {
        // A board with a contradictory END may still be running.
        let _ = board.stop();
    }
    Ok(captured)
}

/// Processes events until the recording ends; returns the reason, and the board's END.
async fn follow(
    board: &mut Board,
    recorder: &mut BoardRecorder,
    silence: Duration,
    stop: impl Future<Output = ()>,
) -> Result<Ended, CaptureError> {
    let mut tick = interval(TICK);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut stop = std::pin::pin!(stop);
    let mut stopping = Stopping::default();
    let mut heard_at = Instant::now();
    loop {
        tokio::select! {
            biased;
            () = &mut stop, if stopping.why.is_none() => stopping.begin(board, Why::Asked),
            event = board.next() => {
                heard_at = Instant::now();
                match event {
                    Some(BoardEvent::Sample(sample)) => {
                        if recorder.take(sample)? == SampleResult::BeyondTheEnd
                            && stopping.why.is_none()
                        {
                            stopping.begin(board, Why::RunsOn);
                        }
                        if !board.has_more() {
                            flush_both(recorder, board)?;
                        }
                    }
                    Some(BoardEvent::Ended { taken, dropped, reason }) => {
                        let end = End { taken, dropped, reason };
                        let ending = stopping.ending_of(reason);
                        return Ok(Ended { ending, end: Some(end), host_stopped: stopping.why.is_some() });
                    }
                    Some(BoardEvent::Restarted(hello)) => {
                        let ending = ending_by_hello(board.hello(), &hello);
                        // A board that was not reset is still running.
                        let _ = board.stop();
                        return Ok(ending.into());
                    }
                    Some(BoardEvent::HungUp) | None => return Ok(Ending::Unplugged.into()),
                    Some(BoardEvent::Failed(_)) => return Ok(Ending::LineFailed.into()),
                }
            }
            () = recorder.recorder.due() => flush_both(recorder, board)?,
            _ = tick.tick() => {
                board.flush_log();
                if stopping.why.is_none() && heard_at.elapsed() > silence {
                    stopping.begin(board, Why::Silence);
                }
                if stopping.is_over(board) {
                    let runs_on = stopping.why == Some(Why::RunsOn);
                    return Ok(if runs_on { Ending::RanOn } else { Ending::Silent }.into());
                }
            }
        }
    }
}

/// Ending for a different HELLO during the run.
pub(super) fn ending_by_hello(known: &Hello, said: &Hello) -> Ending {
    if known.boot_id == said.boot_id {
        Ending::BoardChanged
    } else {
        Ending::BoardReset
    }
}

/// Flushes rows and raw log to the operating system when they are due.
fn flush_both(recorder: &mut BoardRecorder, board: &Board) -> Result<(), CaptureError> {
    if recorder.recorder.flush_if_due()? {
        board.flush_log();
    }
    Ok(())
}

/// Why the board is told to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    /// Requested by the caller.
    Asked,
    /// The board is silent.
    Silence,
    /// The board continues after the requested samples.
    RunsOn,
}

/// STOP was sent, and is repeated until END arrives.
#[derive(Debug, Default)]
struct Stopping {
    why: Option<Why>,
    attempts: u32,
    last: Option<Instant>,
}

impl Stopping {
    fn begin(&mut self, board: &mut Board, why: Why) {
        self.why = Some(why);
        self.say(board);
    }

    fn say(&mut self, board: &mut Board) {
        self.attempts += 1;
        self.last = Some(Instant::now());
        // An error shows on the reading side.
        let _ = board.stop();
    }

    /// Whether all attempts were made without an END.
    fn is_over(&mut self, board: &mut Board) -> bool {
        if self.why.is_none() || self.last.is_some_and(|last| last.elapsed() < END_WITHIN) {
            return false;
        }
        if self.attempts == STOP_ATTEMPTS {
            return true;
        }
        self.say(board);
        false
    }

    /// The ending for an END with this reason.
    fn ending_of(&self, reason: EndReason) -> Ending {
        match (reason, self.why) {
            (EndReason::Stopped, Some(Why::Silence)) => Ending::Silent,
            // All requested samples were received.
            (EndReason::Stopped, Some(Why::RunsOn)) => Ending::Complete,
            _ => reason.into(),
        }
    }
}

/// Recorder of a board's samples, with times relative to the first one.
pub(super) struct BoardRecorder {
    pub(super) recorder: Recorder,
    first_us: Option<u64>,
    /// Requested samples; 0 is unlimited.
    asked: u32,
    /// Most samples that can be missing after the last one: more would have been silence.
    most_missing_at_the_end: u64,
    /// Samples received beyond the requested ones.
    beyond: u64,
    /// Number of the last received sample, plus one.
    came: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SampleResult {
    /// It is a row.
    Recorded,
    /// It was not requested; it is counted, but no row.
    BeyondTheEnd,
}

impl BoardRecorder {
    /// Begins the run file, before the board is started.
    pub(super) fn begin(
        request: &CaptureRequest,
        hello: &Hello,
        live: &SharedLive,
    ) -> Result<Self, CaptureError> {
        request.refuse_zeros(hello)?;
        let columns = Columns {
            supply: hello.fields.supply,
            current: hello.fields.current,
            ..Columns::recorded(CommandKind::Voltage)
        };
        let counts_per_rev = request.counts_per_rev(hello);
        let facts = Facts {
            sample_time_s: f64::from(request.sample_time_us) / 1e6,
            counts_per_rev,
            supply_v: request.supply_v(hello),
            profile: &request.profile.name,
            port: &request.port,
            usb: request.usb.as_ref(),
        };
        let (major, minor) = hello.firmware_version;
        let mut further = toml::Table::new();
        further.insert("device".to_owned(), hello.name.as_str().into());
        further.insert("firmware".to_owned(), format!("{major}.{minor}").into());
        further.insert("boot_id".to_owned(), i64::from(hello.boot_id).into());
        further.extend(request.further.clone());
        let header = header(facts, further);
        Ok(Self {
            recorder: Recorder::begin(&request.output, &header, columns, counts_per_rev, live)?,
            first_us: None,
            asked: request.samples,
            most_missing_at_the_end: request.silence().as_micros() as u64
                / u64::from(request.sample_time_us.max(1)),
            beyond: 0,
            came: 0,
        })
    }

    /// Records one sample, if it was requested.
    pub(super) fn take(&mut self, sample: Sample) -> Result<SampleResult, CaptureError> {
        self.came = sample.number + 1;
        if self.asked > 0 && sample.number >= u64::from(self.asked) {
            self.beyond += 1;
            return Ok(SampleResult::BeyondTheEnd);
        }
        let first_us = match self.first_us {
            Some(first_us) => first_us,
            None => {
                // START resets the numbers to 0.
                self.recorder.lost_before_the_first(sample.number);
                *self.first_us.insert(sample.device_us)
            }
        };
        let observation = Observation {
            seq: Some(sample.number),
            device_us: (sample.device_us - first_us) as i64,
            host_us: Some(sample.host_us as i64),
            command: f64::from(sample.command_mv) / 1000.0,
            counts: sample.counts,
            flags: flags(sample.flags, sample.leap),
        };
        let measured = Measured {
            supply_v: sample.supply_mv.map(|mv| f64::from(mv) / 1000.0),
            current_a: sample.current_ma.map(|ma| f64::from(ma) / 1000.0),
        };
        self.recorder
            .append(observation, sample.host_us, measured)?;
        Ok(SampleResult::Recorded)
    }

    pub(super) fn is_beyond(&self) -> bool {
        self.beyond > 0
    }

    /// Ends the file after comparing the board's END with the received samples.
    pub(super) fn finish(self, ended: Ended, damage: Damage) -> Result<Captured, CaptureError> {
        let (lost, dropped_rows) = self.recorder.missing();
        let came = ReceivedSamples {
            asked: self.asked,
            lost,
            dropped_rows,
            up_to: self.came,
            beyond: self.beyond,
            most_missing_at_the_end: self.most_missing_at_the_end,
        };
        let verdict = came.judge(&ended);
        let mut further = toml::Table::new();
        if self.asked > 0 {
            further.insert("asked".to_owned(), i64::from(self.asked).into());
        }
        if self.beyond > 0 {
            further.insert("beyond".to_owned(), (self.beyond as i64).into());
        }
        let end = Finish {
            ending: ended.ending,
            lost_at_the_end: verdict.lost_at_the_end,
            taken: ended.end.map(|end| end.taken),
            asked: (self.asked > 0 && ended.ending == Ending::Complete)
                .then_some(u64::from(self.asked)),
            contradictions: verdict.contradictions,
        };
        self.recorder.finish(end, damage, further)
    }
}

fn flags(flags: SampleFlags, leap: Leap) -> Flags {
    Flags {
        time_leap: leap.time,
        counts_leap: leap.counts,
        overrun: flags.overrun,
        dropped: flags.dropped,
        encoder_error: flags.encoder_error,
        saturated: flags.saturated,
    }
}
