//! Start of a recording of text lines: the sample time from the first lines, and the file's header.

use super::super::header::{Facts, header};
use super::super::held_line::HeldLine;
use super::super::line_clock::line_clock;
use super::super::recorder::Recorder;
use super::super::{CaptureError, Columns, CommandKind, Ending};
use super::speeds::Speeds;
use super::{MEASURED, Running, TextError, TextRecording};
use crate::board::motion::Motion;
use crate::board::text_lines::Column;

impl TextRecording<'_> {
    /// Begins the file and writes the samples that waited for it.
    pub(super) fn begin(&mut self) -> Result<Option<Ending>, TextError> {
        let waiting = std::mem::take(&mut self.waiting);
        let Some(&(first, first_host_us)) = waiting.first() else {
            return Ok(None);
        };
        let clock = line_clock(&waiting);
        let device_timed = clock.is_boards;
        let says_command = first.command_v.is_some() || first.command_pwm255.is_some();
        if !says_command && self.request.profile.is_none() {
            return Err(TextError::NoCommand {
                port: self.request.port.clone(),
            });
        }
        let sample_time_us = match self.request.sample_time_us {
            Some(given) => i64::from(given),
            None => clock.sample_time_us,
        };
        let numbered = device_timed || first.sequence.is_some();
        let columns = Columns {
            seq: numbered,
            supply: first.supply_v.is_some(),
            current: first.current_a.is_some(),
            ..Columns::recorded(CommandKind::Voltage)
        };
        let profile = match &self.request.profile {
            Some(profile) if !says_command => profile.name.as_str(),
            _ => "as the sketch says",
        };
        let mut further = toml::Table::new();
        let timing = if device_timed { "device" } else { "host" };
        further.insert("timing".to_owned(), timing.into());
        further.insert("device".to_owned(), "text lines".into());
        if self.request.sample_time_us.is_none() {
            further.insert("sample_time".to_owned(), MEASURED.into());
        }
        if clock.coarse_us > 0 {
            let coarse_s = clock.coarse_us as f64 * 1e-6;
            further.insert("clock_step_s".to_owned(), coarse_s.into());
        }
        if let Some(columns) = self.decoder.columns() {
            further.insert("text_columns".to_owned(), columns.to_string().into());
            if let Some(summed_up) = columns.summed_up() {
                let how = match summed_up {
                    Column::Increments => "increments, summed up".to_owned(),
                    speed => format!("integrated from {}, backward", speed.name()),
                };
                further.insert("text_position".to_owned(), how.into());
            }
        }
        let facts = Facts {
            sample_time_s: sample_time_us as f64 / 1e6,
            counts_per_rev: self.request.counts_per_rev,
            supply_v: self.request.supply_v,
            profile,
            port: &self.request.port,
            usb: self.request.usb.as_ref(),
        };
        let recorder = Recorder::begin(
            &self.request.output,
            &header(facts, further),
            columns,
            self.request.counts_per_rev,
            self.live,
        );
        self.running = Some(Running {
            recorder: recorder.map_err(CaptureError::Write)?,
            sample_time_us,
            device_timed,
            coarse_us: clock.coarse_us,
            numbered,
            first_us: match first.time_us.filter(|_| device_timed) {
                Some(first_us) => first_us.saturating_add(clock.first_late_us),
                None => first_host_us as i64,
            },
            lines: HeldLine::default(),
            last_us: None,
            last_counts: None,
            motion: Motion::default(),
            summed_counts: 0.0,
            speeds: (self
                .decoder
                .columns()
                .and_then(|columns| columns.summed_up()))
            .and_then(|column| Speeds::of(column, self.request.counts_per_rev)),
            seq: 0,
            unread: 0,
        });
        for (sample, host_us) in waiting {
            if let Some(ending) = self.append(sample, host_us)? {
                return Ok(Some(ending));
            }
        }
        Ok(None)
    }
}
