//! Errors of a recording of text lines, with their remedies.

use std::io;

use super::CaptureError;
use crate::board::Heard;
use crate::board::text_lines::Skipped;
use crate::plain::shown;

/// Why there is no recording of a sketch.
#[derive(Debug, thiserror::Error)]
pub enum TextError {
    /// The file or the log.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// No line is a sample.
    #[error(
        "no line on {port} could be read as a sample: {}", no_sample(heard, last_skipped.as_ref()), port = shown(port)
    )]
    NoSample {
        /// The port.
        port: String,
        /// Received bytes.
        heard: Box<Heard>,
        /// The last skipped line, and the reason.
        last_skipped: Option<(String, Skipped)>,
    },
    /// The lines contain no command.
    #[error(
        "the lines on {port} do not state the command of the motor\nhint: name what the sketch does with --profile (such as --profile step), or print a column command_v or pwm", port = shown(port)
    )]
    NoCommand {
        /// The port.
        port: String,
    },
    /// The board's time differs from the host's by a factor of 10^3 or 10^6.
    #[error(
        "the time of the lines on {port} runs {} the host's, as if `{named}` were `{meant}`\nhint: --columns {columns}",
        times(*factor), port = shown(port)
    )]
    TimeUnit {
        /// The port.
        port: String,
        /// The factor.
        factor: f64,
        /// The stated unit.
        named: &'static str,
        /// The unit that fits.
        meant: &'static str,
        /// The columns with that unit.
        columns: String,
    },
    /// Reading failed.
    #[error("the line to {port} failed: {source}\nhint: unplug the board and plug it in again, then try again", port = shown(port))]
    Line {
        /// The port.
        port: String,
        /// Cause.
        source: io::Error,
    },
}

fn no_sample(heard: &Heard, last_skipped: Option<&(String, Skipped)>) -> String {
    match last_skipped {
        _ if heard.is_of_protocol() => {
            "the board speaks motorlab's own protocol, which names its columns itself\nhint: leave out --columns".to_owned()
        }
        Some((line, Skipped::ColumnsUnknown)) => format!(
            "its lines look like {line:?}, and nothing names the numbers\nhint: name them with --columns, such as t_us,counts"
        ),
        Some((line, Skipped::FieldCount { expected, found })) => {
            format!(
                "its lines look like {line:?}, {found} fields where --columns has {expected}\nhint: name every field with --columns; `-` leaves one out"
            )
        }
        Some((line, Skipped::NoCountsLabelled { labels })) => format!(
            "its lines look like {line:?}, and none of their labels ({labels}) names encoder counts\nhint: name the fields in their order, such as --columns -,counts"
        ),
        Some((line, Skipped::Clash { label, column })) => format!(
            "its lines look like {line:?}: --columns has `{column}` where the label is `{label}`\nhint: name the columns in the order of the line, or leave --columns at auto"
        ),
        Some((line, _)) => format!(
            "its lines look like {line:?}\nhint: keep them in a file (cat PORT > log.txt) and give that to motorlab import, which reads more forms"
        ),
        None if heard.total() == 0 => {
            "it sent nothing\nhint: check that its sketch prints lines, and that this is its port: `motorlab ports`".to_owned()
        }
        None => format!("it sent {heard}\nhint: give the sketch's baud rate with --baud"),
    }
}

fn times(factor: f64) -> String {
    if factor >= 1.0 {
        format!("{factor} times as fast as")
    } else {
        format!("{} times as slowly as", (1.0 / factor).round())
    }
}
