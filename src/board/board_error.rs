//! Errors of a board, with their remedies.

use std::io;
use std::path::PathBuf;

use firmware_protocol::{Hello, PROTOCOL_VERSION, Refusal};

use super::line::ATTEMPTS;
use super::{Heard, OpenError};
use crate::plain::shown;

/// Error of a board.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// The port cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Another device is on the line.
    #[error(
        "{path} is not a motorlab board: {}", other_bytes(heard, *patience_s), path = shown(path))]
    NotABoard {
        /// The port.
        path: PathBuf,
        /// The bytes received instead.
        heard: Box<Heard>,
        /// How long it was queried.
        patience_s: f64,
    },
    /// Another protocol version.
    #[error(
        "the board on {path} speaks protocol version {found}, this program version {PROTOCOL_VERSION}\nhint: update the sketch on the board: motorlab flash {path}", path = shown(path))]
    OtherVersion {
        /// The port.
        path: PathBuf,
        /// The board's version.
        found: u8,
    },
    /// The board refused a message.
    #[error("the board on {path} refused {what}: {reason}{}", refusal_advice(*reason, hello), path = shown(path))]
    Refused {
        /// The port.
        path: PathBuf,
        /// Refused request.
        what: &'static str,
        /// Reason.
        reason: Refusal,
        /// The board's HELLO.
        hello: Box<Hello>,
    },
    /// No response.
    #[error("the board on {path} does not answer {what} (asked {ATTEMPTS} times)\nhint: check the cable and the supply, press the board's reset button, then try again", path = shown(path))]
    NoAnswer {
        /// The port.
        path: PathBuf,
        /// Request.
        what: &'static str,
    },
    /// A reset, or another HELLO, between the first message and START.
    #[error(
        "the board on {path} was reset while it was set up, before the motor turned\nhint: try again; if it recurs, give the motor a supply of its own and keep other programs off the port", path = shown(path))]
    Restarted {
        /// The port.
        path: PathBuf,
    },
    /// A value of the HELLO is 0, with which no recording is possible.
    #[error(
        "the board on {path} says that {what} is 0\nhint: give the right one with {option}, or correct the sketch on the board", path = shown(path))]
    StatesZero {
        /// The port.
        path: String,
        /// The value.
        what: &'static str,
        /// Flag that states it.
        option: &'static str,
    },
    /// The board was unplugged.
    #[error("the board on {path} was unplugged\nhint: plug it in; `motorlab ports` shows its port, which may have another name now", path = shown(path))]
    Gone {
        /// The port.
        path: PathBuf,
    },
    /// The line failed.
    #[error("the line to {path} failed: {source}\nhint: unplug the board and plug it in again, then try again", path = shown(path))]
    Line {
        /// The port.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A command outside the range of the protocol.
    #[error(
        "the profile commands {command} V, and a board takes -32.767 to 32.767 V\nhint: lower the share of the supply, as in --profile step@0.5, or the voltages of the profile's file"
    )]
    Command {
        /// The command in V.
        command: f64,
    },
}

fn other_bytes(heard: &Heard, patience_s: f64) -> String {
    if heard.total() == 0 {
        return format!(
            "it sent nothing in {patience_s} s\nhint: upload the sketch with `motorlab flash PORT`, or name another port: `motorlab ports` lists them"
        );
    }
    let hint = if heard.is_text() {
        "this looks like a sketch that prints text: name its columns, such as --columns t_us,counts"
    } else {
        "give the sketch's baud rate with --baud, or upload the sketch with `motorlab flash PORT`"
    };
    format!("it sent {heard}\nhint: {hint}")
}

fn refusal_advice(reason: Refusal, hello: &Hello) -> String {
    match reason {
        Refusal::SampleTime => format!(
            "\nhint: its shortest sample time is {} s: raise --ts",
            f64::from(hello.shortest_sample_time_us) * 1e-6
        ),
        Refusal::ProfileTooLong => format!(
            "\nhint: it holds {} segments: name a profile with fewer changes of the command",
            hello.max_segments
        ),
        _ => "\nhint: upload the sketch of this version: motorlab flash PORT".to_owned(),
    }
}
