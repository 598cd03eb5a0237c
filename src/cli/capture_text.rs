//! `capture --columns`: a run from a plain sketch that prints text lines.

use std::path::Path;
use std::time::{Duration, Instant};

use super::capture::{Capture, DURATION_S, capture_failure, say_free_name};
use super::capture_report::report;
use super::reconnect::Segments;
use super::signals::StopSignal;
use super::{Failure, Output, Status};
use crate::board::text_lines::Columns;
use crate::board::{BoardError, LineReader, Location, Profile, usb_identity};
use crate::motor::Parameters;
use crate::recording::{SharedLive, TextError, TextRequest, capture_text};

/// `--columns` for a sketch that states its columns.
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
        TextError::NoCommand { .. } | TextError::TimeUnit { .. } => Failure::input(error),
        TextError::NoSample { .. } | TextError::Line { .. } => Failure::device(error),
    }
}

impl Capture {
    pub(super) async fn record_text(
        &self,
        location: &Location,
        names: &str,
        output: &Output,
        stop: StopSignal,
    ) -> Result<Status, Failure> {
        let request = self.text_request(location.path(), names)?;
        let mut segments = Segments::default();
        let log = self.begin_log(&mut segments, output)?;
        let port = location
            .open(self.baud)
            .map_err(|error| super::capture::board_failure(BoardError::Open(error)))?;
        let mut reader = LineReader::spawn(port, Instant::now()).map_err(Failure::device)?;
        say_free_name(output, &self.output);
        let live = SharedLive::default();
        let profile = request.profile.as_ref();
        let profile = profile.map_or("as the sketch says", |profile| profile.name.as_str());
        let display = self.display(&live, request.counts_per_rev, profile, output)?;
        let text = capture_text(&mut reader, log, request, &live, stop.asked()).await;
        drop(display);
        let text = text.map_err(text_failure)?;
        let status = report(
            output,
            &text.captured,
            self.duration != Some(0.0),
            &segments,
        )?;
        for note in &text.notes {
            output.message(&format!("note: {note}"));
        }
        Ok(status)
    }

    /// Puts into a raw log's header what a replay of text lines must know.
    pub(super) fn describe_text(&self, columns: &str, header: &mut toml::Table) {
        header.insert("columns".to_owned(), columns.into());
        if let Some(profile) = &self.profile {
            header.insert("profile".to_owned(), profile.as_str().into());
        }
        let sample_time_s = self.ts.map(|us| f64::from(us) / 1e6);
        for (key, value) in [
            ("sample_time_s", sample_time_s),
            ("duration_s", Some(self.duration.unwrap_or(DURATION_S))),
            ("supply_v", self.supply),
            ("counts_per_rev", self.counts_per_rev),
        ] {
            if let Some(value) = value {
                header.insert(key.to_owned(), value.into());
            }
        }
    }

    fn text_request(&self, path: &Path, names: &str) -> Result<TextRequest, Failure> {
        let told = TextFacts {
            columns: names,
            profile: self.profile.as_deref(),
            sample_time_us: self.ts,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply,
            duration_s: self.duration,
        };
        Ok(TextRequest {
            baud: self.baud,
            patience: Duration::from_secs_f64(self.patience),
            usb: usb_identity(path),
            ..told.request(&self.output, &self.port)?
        })
    }
}

/// Facts about a sketch's text lines, from options or a raw log's header.
#[derive(Debug)]
pub(super) struct TextFacts<'a> {
    pub columns: &'a str,
    pub profile: Option<&'a str>,
    pub sample_time_us: Option<u32>,
    pub counts_per_rev: Option<f64>,
    pub supply_v: Option<f64>,
    pub duration_s: Option<f64>,
}

impl TextFacts<'_> {
    /// A request with the nominal motor's values for what is not told.
    pub(super) fn request(&self, output: &Path, port: &str) -> Result<TextRequest, Failure> {
        let nominal = Parameters::default();
        let supply_v = self.supply_v.unwrap_or(nominal.supply_v);
        let mut assumed = Vec::new();
        if self.counts_per_rev.is_none() {
            assumed.push(format!(
                "the counts of a turn (--counts-per-rev, taken as {})",
                nominal.counts_per_rev
            ));
        }
        if self.supply_v.is_none() {
            assumed.push(format!(
                "the driver's supply (--supply, taken as {} V)",
                nominal.supply_v
            ));
        }
        let duration_s = self.duration_s.unwrap_or(DURATION_S);
        let profile_s = if duration_s > 0.0 {
            duration_s
        } else {
            DURATION_S
        };
        let profile = match self.profile {
            Some(name) => Some(Profile::named(name, supply_v, profile_s).map_err(Failure::input)?),
            None => None,
        };
        Ok(TextRequest {
            columns: columns(self.columns)?,
            sample_time_us: self.sample_time_us,
            counts_per_rev: self.counts_per_rev.unwrap_or(nominal.counts_per_rev),
            supply_v,
            assumed,
            profile,
            duration_s,
            baud: firmware_protocol::BAUD,
            patience: Duration::MAX,
            output: output.to_owned(),
            port: port.to_owned(),
            usb: None,
        })
    }
}
