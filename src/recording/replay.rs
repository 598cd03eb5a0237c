//! Replay of a raw log through the decoder into a run file.
//!
//! The host's messages give sample time, profile and number of samples; the board's give the samples, with the
//! arrival times of the log.

use std::io::BufRead;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use firmware_protocol::{EndReason, FrameDecoder, Hello, HostMessage};

use super::capture::{BoardRecorder, ending_by_hello};
use super::end::{End, Ended};
use super::{CaptureError, CaptureRequest, Captured, Ending, SharedLive, TextError};
use crate::board::{Event, Expectations, Intake, rawlog};
use crate::plain::shown;
use crate::platform::time::Instant;

/// Playback speed of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// Multiple of the recorded speed.
    Times(f64),
    /// As fast as it is decoded.
    Max,
}

/// Why a log cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// An error of the log before the run begins.
    #[error(transparent)]
    Log(#[from] rawlog::ReadError),
    /// An error of the log during the run; the run is complete up to there.
    #[error("{} holds {rows} rows, and the log gives no more: {error}", shown(run))]
    Broken {
        /// The error.
        error: rawlog::ReadError,
        /// The run file.
        run: PathBuf,
        /// Its number of rows.
        rows: u64,
    },
    /// The run file.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// A recording of text lines.
    #[error(transparent)]
    Text(#[from] TextError),
    /// The log is not a recording.
    #[error(
        "the raw log holds no recording: {0}\nhint: record again with --log, from before the board starts until the recording ends"
    )]
    NoRecording(&'static str),
}

impl ReplayError {
    /// The line of the error in the log, from 1.
    pub fn line(&self) -> Option<u64> {
        match self {
            Self::Log(error) | Self::Broken { error, .. } => error.line(),
            Self::Capture(_) | Self::Text(_) | Self::NoRecording(_) => None,
        }
    }

    /// A log that is unreadable from some line on, with the part recorded before.
    pub(super) fn broken(error: rawlog::ReadError, captured: Captured) -> Self {
        Self::Broken {
            error,
            run: captured.path,
            rows: captured.statistics.samples,
        }
    }
}

/// Host messages of a log so far.
#[derive(Debug, Default)]
struct HostMessages {
    decoder: FrameDecoder,
    sample_time_us: u32,
    samples: u32,
    commands: Vec<(u64, i16)>,
    started: bool,
    stopped: bool,
}

impl HostMessages {
    fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(Ok(frame)) = self.decoder.push(byte) else {
                continue;
            };
            match HostMessage::parse(frame) {
                Ok(HostMessage::Configure { sample_time_us, .. }) => {
                    self.sample_time_us = sample_time_us;
                }
                Ok(HostMessage::Profile { .. }) => self.commands.clear(),
                Ok(HostMessage::Chunk(chunk)) => {
                    self.commands.truncate(usize::from(chunk.first));
                    let segments = chunk.segments().iter();
                    self.commands
                        .extend(segments.map(|s| (u64::from(s.samples), s.command_mv)));
                }
                Ok(HostMessage::Start { samples }) => {
                    self.samples = samples;
                    self.started = true;
                }
                Ok(HostMessage::Stop) => self.stopped = true,
                _ => {}
            }
        }
    }
}

/// Replays a log into `request.output`. Sample time and number of samples are the log's; of the request only names
/// and overrides apply. `stopped` is polled between events.
pub fn replay(
    log: &mut rawlog::Reader<impl BufRead>,
    request: &CaptureRequest,
    speed: Speed,
    live: &SharedLive,
    stopped: impl Fn() -> bool,
) -> Result<Captured, ReplayError> {
    let begun = Instant::now();
    let mut intake = Intake::default();
    let mut told = HostMessages::default();
    let mut hello: Option<Hello> = None;
    let mut recorder: Option<BoardRecorder> = None;
    let mut events = Vec::new();
    let ended: Ended = 'playing: loop {
        if stopped() {
            break Ending::Stopped.into();
        }
        let next = match (log.next_event(), recorder) {
            (Ok(next), kept) => {
                recorder = kept;
                next
            }
            (Err(error), Some(recorder)) => {
                let captured = recorder.finish(Ending::LogEnded.into(), intake.damage())?;
                return Err(ReplayError::broken(error, captured));
            }
            (Err(error), None) => return Err(error.into()),
        };
        let Some((at_us, event)) = next else {
            break Ending::LogEnded.into();
        };
        wait_until(begun, at_us, speed, &stopped);
        match event {
            rawlog::Event::ToBoard(bytes) => {
                told.push(&bytes);
                if told.started && recorder.is_none() {
                    let Some(hello) = &hello else {
                        return Err(ReplayError::NoRecording("no HELLO comes before START"));
                    };
                    if told.sample_time_us == 0 {
                        let missing = "no sample time is said before START";
                        return Err(ReplayError::NoRecording(missing));
                    }
                    let request = CaptureRequest {
                        sample_time_us: told.sample_time_us,
                        samples: told.samples,
                        ..request.clone()
                    };
                    recorder = Some(BoardRecorder::begin(&request, hello, live)?);
                    intake.encoder(request.counts_per_rev(hello));
                    intake.expect(Expectations {
                        sample_time_us: told.sample_time_us,
                        commands: std::mem::take(&mut told.commands),
                    });
                }
            }
            rawlog::Event::FromBoard(bytes) => {
                intake.push(at_us, &bytes, |event| events.push(event));
                for event in events.drain(..) {
                    match (event, &mut recorder) {
                        (Event::Hello(new), None) => hello = Some(new),
                        (Event::Hello(new), Some(_)) => {
                            let ending = match &hello {
                                Some(known) => ending_by_hello(known, &new),
                                None => Ending::BoardReset,
                            };
                            break 'playing ending.into();
                        }
                        (Event::Sample(sample), Some(recorder)) => {
                            recorder.take(sample)?;
                        }
                        (
                            Event::End {
                                taken,
                                dropped,
                                reason,
                            },
                            Some(recorder),
                        ) => {
                            let ending = match reason {
                                EndReason::Stopped if recorder.is_beyond() => Ending::Complete,
                                reason => reason.into(),
                            };
                            let end = End {
                                taken,
                                dropped,
                                reason,
                            };
                            break 'playing Ended {
                                ending,
                                end: Some(end),
                                host_stopped: told.stopped,
                            };
                        }
                        _ => {}
                    }
                }
                if let Some(recorder) = &mut recorder {
                    recorder.recorder.flush_if_due()?;
                }
            }
            rawlog::Event::HangUp => break Ending::Unplugged.into(),
        }
    };
    match recorder {
        Some(recorder) => Ok(recorder.finish(ended, intake.damage())?),
        None if hello.is_none() => Err(ReplayError::NoRecording(
            "no board says HELLO in it (text lines of a plain sketch? say --columns auto, or their names)",
        )),
        None => Err(ReplayError::NoRecording("the board is never started")),
    }
}

/// Sleeps until `at_us` of the log is due, in short waits, so that a stop is noticed.
pub(super) fn wait_until(begun: Instant, at_us: u64, speed: Speed, stopped: &impl Fn() -> bool) {
    let Speed::Times(factor) = speed else {
        return;
    };
    // Slow enough, a log is played for ever.
    let due = Duration::try_from_secs_f64(at_us as f64 * 1e-6 / factor).unwrap_or(Duration::MAX);
    while let Some(left) = due.checked_sub(begun.elapsed()) {
        if stopped() {
            return;
        }
        thread::sleep(left.min(Duration::from_millis(50)));
    }
}
