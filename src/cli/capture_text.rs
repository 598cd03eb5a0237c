//! `capture --columns`: a run from a plain sketch that prints text lines.

use std::path::Path;
use std::time::{Duration, Instant};

use super::capture::{Capture, DURATION_S, capture_failure, print_free_name};
use super::capture_report::report;
use super::reconnect::Segments;
use super::signals::StopSignal;
use super::{Failure, Output, Status};
use crate::board::text_lines::Columns;
use crate::board::{BoardError, LineReader, Location, Profile, usb_identity};
use crate::motor::Parameters;
use crate::recording::{Integration, SharedLive, TextError, TextRequest, capture_text};

/// Value of `--columns` for a sketch that states its columns.
pub(super) const AUTO: &str = "auto";

/// Reads `--columns`.
pub(super) fn columns(names: &str) -> Result<Option<Columns>, Failure> {
    if names == AUTO {
        return Ok(None);
    }
    Columns::parse(names).map(Some).map_err(Failure::input)
}

/// Failure and exit status of a recording of text lines.
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
        print_free_name(output, &self.output);
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

    /// Adds to a raw log's header what a replay of text lines needs.
    pub(super) fn describe_text(
        &self,
        columns: &str,
        header: &mut toml::Table,
    ) -> Result<(), Failure> {
        let (_, duration_s) = self.text_facts(columns).played()?;
        header.insert("columns".to_owned(), columns.into());
        if let Some(profile) = &self.profile {
            header.insert("profile".to_owned(), profile.as_str().into());
        }
        if let Some(rule) = self.integrate {
            header.insert("integrate".to_owned(), rule.name().into());
        }
        let sample_time_s = self.ts.map(|us| f64::from(us) / 1e6);
        for (key, value) in [
            ("sample_time_s", sample_time_s),
            ("duration_s", Some(duration_s)),
            ("supply_v", self.supply),
            ("counts_per_rev", self.counts_per_rev),
        ] {
            if let Some(value) = value {
                header.insert(key.to_owned(), value.into());
            }
        }
        Ok(())
    }

    fn text_facts<'a>(&'a self, columns: &'a str) -> TextFacts<'a> {
        TextFacts {
            columns,
            profile: self.profile.as_deref(),
            sample_time_us: self.ts,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply,
            duration_s: self.duration,
            integrate: self.integrate,
        }
    }

    fn text_request(&self, path: &Path, names: &str) -> Result<TextRequest, Failure> {
        Ok(TextRequest {
            baud: self.baud,
            patience: Duration::from_secs_f64(self.patience),
            usb: usb_identity(path),
            ..self.text_facts(names).request(&self.output, &self.port)?
        })
    }
}

/// Properties of a sketch's text lines, from options or a raw log's header.
#[derive(Debug)]
pub(super) struct TextFacts<'a> {
    pub columns: &'a str,
    pub profile: Option<&'a str>,
    pub sample_time_us: Option<u32>,
    pub counts_per_rev: Option<f64>,
    pub supply_v: Option<f64>,
    pub duration_s: Option<f64>,
    pub integrate: Option<Integration>,
}

impl TextFacts<'_> {
    fn supply_v(&self) -> f64 {
        self.supply_v.unwrap_or(Parameters::default().supply_v)
    }

    /// The profile that the sketch plays, and the duration in s: that of the profile unless one is given.
    fn played(&self) -> Result<(Option<Profile>, f64), Failure> {
        let built_in_s = self.duration_s.filter(|s| *s > 0.0).unwrap_or(DURATION_S);
        let named = |name| Profile::named(name, self.supply_v(), built_in_s);
        let profile = (self.profile.map(named).transpose()).map_err(Failure::input)?;
        let own_s = profile.as_ref().map_or(DURATION_S, Profile::duration_s);
        Ok((profile, self.duration_s.unwrap_or(own_s)))
    }

    /// A request with the nominal motor's values where none are given.
    pub(super) fn request(&self, output: &Path, port: &str) -> Result<TextRequest, Failure> {
        let nominal = Parameters::default();
        let supply_v = self.supply_v();
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
        let (profile, duration_s) = self.played()?;
        Ok(TextRequest {
            columns: columns(self.columns)?,
            sample_time_us: self.sample_time_us,
            counts_per_rev: self.counts_per_rev.unwrap_or(nominal.counts_per_rev),
            supply_v,
            assumed,
            integrate: self.integrate,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sketch_is_recorded_as_long_as_its_profile() {
        let duration_s = |profile, duration_s| {
            let facts = TextFacts {
                columns: AUTO,
                profile,
                sample_time_us: None,
                counts_per_rev: None,
                supply_v: None,
                duration_s,
                integrate: None,
            };
            let (_, duration_s) = facts.played().expect("a profile");
            duration_s
        };
        assert_eq!(duration_s(None, None), 4.0);
        assert_eq!(duration_s(Some("chirp"), None), 4.0);
        assert_eq!(duration_s(Some("chirp,5s"), None), 5.0);
        assert_eq!(duration_s(Some("chirp,5s"), Some(3.0)), 3.0);
        assert_eq!(duration_s(Some("chirp,5s"), Some(0.0)), 0.0);
    }
}
