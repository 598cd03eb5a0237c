//! Boards that print plain text: an ordinary Arduino sketch with `Serial.println`.
//!
//! A line contains one sample: numbers separated by spaces, tabs, commas or semicolons, or `label:value` pairs of the
//! Arduino serial plotter. The meaning of each number is given by `--columns`, by the labels (including Teleplot's,
//! `>counts:590:17`), or by a header line that the sketch prints once. Increments and speeds replace counts where
//! there are none. Banners and incomplete lines are skipped and counted, never guessed.
//!
//! A line of `n` bytes takes `10 n / baud` seconds on the wire. If that exceeds the sample time, `print` blocks and
//! samples are late: [`longest_line_bytes`] is the limit for a warning.

mod columns;
mod decoder;
mod event;
mod fields;
mod meanings;
mod speed_unit;
mod teleplot;
mod unwrapper;

pub use columns::{Column, ColumnError, Columns};
pub use decoder::{MAX_LINE_BYTES, TextDecoder};
pub use event::{Skipped, TextEvent, TextSample};
pub use speed_unit::SpeedUnit;

/// Longest line in bytes, end of line included, that `baud` transmits in one sample time.
///
/// Ten bits a byte (8N1): 34 bytes at 115200 baud and 3 ms.
pub fn longest_line_bytes(baud: u32, sample_time_s: f64) -> usize {
    (f64::from(baud) / 10.0 * sample_time_s) as usize
}

#[cfg(test)]
mod tests {
    use super::longest_line_bytes;

    #[test]
    fn thirty_four_bytes_fit_into_three_milliseconds() {
        assert_eq!(longest_line_bytes(115_200, 0.003), 34);
        assert_eq!(longest_line_bytes(115_200, 0.03), 345);
    }
}
