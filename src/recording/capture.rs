//! Recording from a board into a run file: configure it, start it, take what comes until it ends.

use std::future::Future;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use firmware_protocol::{EndReason, Hello, SampleFlags};

use super::header::{Facts, header};
use super::recorder::{Measured, Recorder};
use super::{Captured, Columns, CommandKind, Ending, Flags, Observation, SharedLive, WriteError};
use crate::board::{Board, BoardError, BoardEvent, Profile, Sample, UsbIdentity};

/// How often silence is looked for.
const TICK: Duration = Duration::from_millis(100);

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
    /// Further keys for the run's header.
    pub further: toml::Table,
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
    let mut recorder = BoardRecorder::begin(request, board.hello(), live)?;
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
    recorder
        .recorder
        .finish(ending, taken, board.damage(), toml::Table::new())
}

/// Takes events until the recording ends; says why, and how many samples the board took.
async fn follow(
    board: &mut Board,
    recorder: &mut BoardRecorder,
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
                    Some(BoardEvent::Sample(sample)) => {
                        recorder.take(sample)?;
                        if !board.has_more() {
                            hand_on(recorder, board)?;
                        }
                    }
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
            () = recorder.recorder.due() => hand_on(recorder, board)?,
            _ = tick.tick() => {
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

/// Hands rows and raw log to the operating system when they are due.
fn hand_on(recorder: &mut BoardRecorder, board: &Board) -> Result<(), CaptureError> {
    if recorder.recorder.flush_if_due()? {
        board.flush_log().map_err(CaptureError::Log)?;
    }
    Ok(())
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

/// A recorder of a board's samples, whose time is counted from the first one.
pub(super) struct BoardRecorder {
    pub(super) recorder: Recorder,
    first_us: Option<u64>,
}

impl BoardRecorder {
    /// Begins the run file, before the board is started.
    pub(super) fn begin(
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
        let facts = Facts {
            sample_time_s: f64::from(request.sample_time_us) / 1e6,
            counts_per_rev,
            supply_v: request
                .supply_v
                .unwrap_or(f64::from(hello.supply_mv) / 1000.0),
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
        })
    }

    /// Takes one sample.
    pub(super) fn take(&mut self, sample: Sample) -> Result<(), CaptureError> {
        let first_us = match self.first_us {
            Some(first_us) => first_us,
            None => {
                // START makes the numbers begin at 0.
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
            flags: flags(sample.flags),
        };
        let measured = Measured {
            supply_v: sample.supply_mv.map(|mv| f64::from(mv) / 1000.0),
            current_a: sample.current_ma.map(|ma| f64::from(ma) / 1000.0),
        };
        self.recorder.append(observation, sample.host_us, measured)
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
