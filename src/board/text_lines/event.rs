//! The results of a line: a sample, a header, or why it was skipped.

use super::{Column, ColumnError, Columns};

/// One sample as a text board printed it; what the line does not have is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TextSample {
    /// Board time in microseconds, unwrapped, on the board's own origin.
    pub time_us: Option<i64>,
    /// Sample number.
    pub sequence: Option<u64>,
    /// Encoder counts; those of a 16-bit `int` are unwrapped.
    pub counts: i64,
    /// Quantity to be summed up to counts, in the column's unit.
    pub summand: Option<(Column, f64)>,
    /// Command in V.
    pub command_v: Option<f64>,
    /// Command as a signed 8-bit PWM value.
    pub command_pwm255: Option<f64>,
    /// Measured supply in V.
    pub supply_v: Option<f64>,
    /// Measured current in A.
    pub current_a: Option<f64>,
}

/// Why a line gave no sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Skipped {
    /// Words where numbers should be: a banner, or a line torn by a reset.
    NotNumbers,
    /// Another number of fields than there are columns.
    FieldCount {
        /// Fields that the columns ask for.
        expected: usize,
        /// Fields of the line.
        found: usize,
    },
    /// A number that its column cannot hold: not finite, or counts with a fraction.
    BadValue {
        /// The column's name.
        column: &'static str,
    },
    /// Longer than [`MAX_LINE_BYTES`](super::MAX_LINE_BYTES).
    TooLong,
    /// The columns are not known yet: no header line, no labels, no `--columns`.
    ColumnsUnknown,
    /// The line's labels name no counts.
    NoCountsLabelled {
        /// The labels, joined by commas.
        labels: String,
    },
    /// A label of the line means another quantity than the column at its place.
    Clash {
        /// The label.
        label: String,
        /// The column's name.
        column: &'static str,
    },
}

/// Result of one line.
#[derive(Debug, Clone, PartialEq)]
pub enum TextEvent {
    /// A sample.
    Sample(TextSample),
    /// A header line, or the first labelled line, told what the columns mean.
    Header(Columns),
    /// A header line that names columns, but cannot be used.
    BadHeader(ColumnError),
    /// A line that gave no sample, with its text (lossy) for messages.
    Skipped {
        /// Line number, the first being 1.
        line: u64,
        /// Why.
        why: Skipped,
        /// The line's text.
        text: String,
    },
}
