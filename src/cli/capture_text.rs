//! `capture --columns`: a run from a plain sketch that prints text lines.

use std::path::Path;
use std::time::{Duration, Instant};

use super::capture::{Capture, DURATION_S, capture_failure, say_free_name};
use super::capture_report::report;
use super::progress::ProgressLine;
use super::reconnect::Segments;
use super::signals::StopSignal;
use super::{Failure, Output, Status};
use crate::board::text_lines::Columns;
use crate::board::{BoardError, LineReader, Port, Profile, RawLog, usb_identity};
use crate::motor::Parameters;
use crate::recording::{SharedLive, TextError, TextRequest, capture_text};

/// What `--columns` says where the sketch says it itself.
pub(super) const AUTO: &str = "auto";

/// Reads `--columns`.
pub(super) fn columns(names: &str) -> Result<Option<Columns>, Failure> {
    if names == AUTO {
        return Ok(None);
    }
    Columns::parse(names).map(Some).map_err(Failure::input)
}

/// The exit status of a recording of text lines that failed.
pub(super) fn text_failure(error: TextError) -> Failure {
    match error {
        TextError::Capture(error) => capture_failure(error),
        TextError::NoCommand { .. } => Failure::input(error),
        TextError::NoSample { .. } | TextError::Line { .. } => Failure::device(error),
    }
}

impl Capture {
    pub(super) async fn record_text(
        &self,
        path: &Path,
        names: &str,
        log: Option<RawLog>,
        output: &Output,
        stop: StopSignal,
    ) -> Result<Status, Failure> {
        let request = self.text_request(path, names)?;
        let port = Port::open(path, self.baud)
            .map_err(|error| super::capture::board_failure(BoardError::Open(error)))?;
        let mut reader = LineReader::spawn(port, Instant::now()).map_err(Failure::device)?;
        say_free_name(output, &self.output);
        let live = SharedLive::default();
        let progress = ProgressLine::show(&live);
        let text = capture_text(&mut reader, log, request, &live, stop.asked()).await;
        drop(progress);
        let text = text.map_err(text_failure)?;
        let status = report(
            output,
            &text.captured,
            self.duration != Some(0.0),
            &Segments::default(),
        )?;
        for note in &text.notes {
            output.message(&format!("note: {note}"));
        }
        Ok(status)
    }

    fn text_request(&self, path: &Path, names: &str) -> Result<TextRequest, Failure> {
        let nominal = Parameters::default();
        let supply_v = self.supply.unwrap_or(nominal.supply_v);
        let duration_s = self.duration.unwrap_or(DURATION_S);
        let profile_s = if duration_s > 0.0 {
            duration_s
        } else {
            DURATION_S
        };
        let profile = match &self.profile {
            Some(name) => Some(Profile::named(name, supply_v, profile_s).map_err(Failure::input)?),
            None => None,
        };
        Ok(TextRequest {
            columns: columns(names)?,
            sample_time_us: self.ts,
            counts_per_rev: self.counts_per_rev.unwrap_or(nominal.counts_per_rev),
            supply_v,
            profile,
            duration_s,
            baud: self.baud,
            patience: Duration::from_secs_f64(self.patience),
            output: self.output.clone(),
            port: self.port.clone(),
            usb: usb_identity(path),
        })
    }
}
