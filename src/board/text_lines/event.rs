//! The result of a line: a sample, a header, or why it was skipped.

use super::{Column, ColumnError, Columns};

/// One sample as printed by a text board; missing values are `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TextSample {
    /// Unwrapped board time in microseconds, on the board's origin.
    pub time_us: Option<i64>,
    /// Sample number.
    pub sequence: Option<u64>,
    /// Encoder counts; those of a 16-bit `int` are unwrapped.
    pub counts: i64,
    /// Value to be integrated to counts, in the column's unit.
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

/// Why a line was skipped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Skipped {
    /// Words in place of numbers: a banner, or a line cut by a reset.
    NotNumbers,
    /// The number of fields differs from that of the columns.
    FieldCount {
        /// Number of columns.
        expected: usize,
        /// Number of fields.
        found: usize,
    },
    /// A number that is invalid in its column: not finite, or counts with a fraction.
    BadValue {
        /// The column's name.
        column: &'static str,
    },
    /// Longer than [`MAX_LINE_BYTES`](super::MAX_LINE_BYTES).
    TooLong,
    /// The columns are still unknown: no header line, no labels, no `--columns`.
    ColumnsUnknown,
    /// No label is a name of counts.
    NoCountsLabelled {
        /// The labels, joined by commas.
        labels: String,
    },
    /// A label means another quantity than the column in its place.
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
    /// A header line, or the first labelled line, with the meaning of the columns.
    Header(Columns),
    /// A header line that names columns, but is invalid.
    BadHeader(ColumnError),
    /// A skipped line, with its text (lossy) for messages.
    Skipped {
        /// Line number, from 1.
        line: u64,
        /// Reason.
        why: Skipped,
        /// The line's text.
        text: String,
    },
}
