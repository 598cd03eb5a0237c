//! Replay of a raw log of text lines into a run file.

use std::io::BufRead;

use super::replay::{ReplayError, Speed, wait_until};
use super::text_capture::{TextCaptured, TextRecording, TextRequest};
use super::{Ending, SharedLive};
use crate::board::rawlog;
use crate::platform::time::Instant;

/// Replays a log of text lines into `request.output`, at the log's arrival times. `stopped` is polled between events.
pub fn replay_text(
    log: &mut rawlog::Reader<impl BufRead>,
    request: TextRequest,
    speed: Speed,
    live: &SharedLive,
    stopped: impl Fn() -> bool,
) -> Result<TextCaptured, ReplayError> {
    let begun = Instant::now();
    let has_end = request.duration_s > 0.0;
    let mut text = TextRecording::new(request, live);
    let ending = loop {
        if stopped() {
            break Ending::Stopped;
        }
        let next = match log.next_event() {
            Ok(next) => next,
            Err(error) => {
                return Err(match text.finish(Ending::LogEnded) {
                    Ok(text) => ReplayError::broken(error, text.captured),
                    // The recording had not begun.
                    Err(_) => error.into(),
                });
            }
        };
        let Some((at_us, event)) = next else {
            // An unlimited recording ends with its log.
            break if has_end || log.torn() {
                Ending::LogEnded
            } else {
                Ending::Complete
            };
        };
        wait_until(begun, at_us, speed, &stopped);
        match event {
            rawlog::Event::FromBoard(bytes) => {
                if let Some(ending) = text.push(at_us, &bytes)? {
                    break ending;
                }
                text.flush_if_due()?;
            }
            rawlog::Event::ToBoard(_) => {}
            rawlog::Event::HangUp => break Ending::Unplugged,
        }
    };
    Ok(text.finish(ending)?)
}
