//! Notes about a recording of text lines: contradictions, and limits of its times and counts.

use super::super::Ending;
use super::TextRecording;
use super::row::PWM_FULL_SCALE;
use crate::board::text_lines::{self, Column, SpeedUnit};
use crate::motor::plausible::Shown;

/// Tolerance of a command relative to full scale: a tenth.
const BEYOND: f64 = 1.1;

impl TextRecording<'_> {
    /// Contradictions in the lines, which cause a non-zero exit status.
    pub(super) fn contradictions(&self, ending: Ending) -> Vec<String> {
        let mut found = Vec::new();
        let supply_v = self.request.supply_v;
        if self.largest_pwm > BEYOND * PWM_FULL_SCALE {
            found.push(format!(
                "pwm reached {}, beyond the {PWM_FULL_SCALE} of full scale: commands of up to {} V on a supply of {supply_v} V; print command_v, or scale it to {PWM_FULL_SCALE}",
                Shown(self.largest_pwm),
                Shown(self.largest_pwm / PWM_FULL_SCALE * supply_v)
            ));
        }
        // Of 255 no motor turns; of 1 it is full drive.
        if self.largest_pwm > 0.0 && self.largest_pwm <= 1.0 {
            found.push(format!(
                "pwm never exceeded {} of {PWM_FULL_SCALE}: commands of at most {} V on a supply of {supply_v} V; print a share of full drive as percent or in V",
                Shown(self.largest_pwm),
                Shown(self.largest_pwm / PWM_FULL_SCALE * supply_v)
            ));
        }
        if self.largest_command_v > BEYOND * supply_v {
            found.push(format!(
                "command_v reached {} V on a supply of {supply_v} V; say the right supply with --supply, or print what the driver is given, in V",
                Shown(self.largest_command_v)
            ));
        }
        if let Some(running) = &self.running
            && ending == Ending::Complete
            && 2.0 * running.sample_time_us as f64 > self.request.duration_s * 1e6
            && self.request.duration_s > 0.0
        {
            found.push(format!(
                "a sample time of {} s does not go with a recording of {} s: is the unit of the time right?",
                running.sample_time_us as f64 * 1e-6,
                self.request.duration_s
            ));
        }
        found
    }

    /// Uncertainty of integrated counts.
    fn summed_up(&self) -> Option<String> {
        let summed_up = self.decoder.columns()?.summed_up()?;
        Some(match summed_up {
            Column::Increments => {
                "the counts are increments summed up, and the file says so: what a lost line counted is lost for good; print the counts where you can".to_owned()
            }
            speed => {
                let taken = match speed {
                    Column::Speed(SpeedUnit::Unsaid) => {
                        "`speed` is taken as rpm (name it rad_s, deg_s, rev_s or counts_s if it is another); "
                    }
                    _ => "",
                };
                format!(
                    "{taken}the counts are `{}` summed up over time at {} counts per revolution, and the file says so: they drift by what is rounded off, and lag by what is filtered; print the counts where you can",
                    speed.name(),
                    self.request.counts_per_rev
                )
            }
        })
    }

    /// Notes for the user.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let Some(running) = &self.running else {
            return notes;
        };
        let sample_time_s = running.sample_time_us as f64 / 1e6;
        notes.extend(self.summed_up());
        if !self.request.assumed.is_empty() {
            notes.push(format!(
                "nothing says {}; the file has the lab handout's",
                self.request.assumed.join(" nor ")
            ));
        }
        if !running.device_timed {
            notes.push(
                "the lines have no time of the board: the run's timing is the host's, late by milliseconds and bunched, and the file says so; print micros() first on each line"
                    .to_owned(),
            );
        }
        let longest = self.decoder.longest_sample_line();
        let fits = text_lines::longest_line_bytes(self.request.baud, sample_time_s);
        if longest > fits {
            notes.push(format!(
                "the longest line has {longest} bytes, and {fits} fit into {sample_time_s} s at {} baud: print blocks and sampling slips; print fewer digits, or use 250000 baud",
                self.request.baud
            ));
        }
        if self.skipped > 0 {
            let example = self
                .last_skipped
                .as_ref()
                .map_or_else(String::new, |(text, _)| format!(", the last one {text:?}"));
            notes.push(format!(
                "{} lines were no samples and were skipped{example}",
                self.skipped
            ));
        }
        if self.damage.implausible > 0 {
            notes.push(format!(
                "{} lines did not go with the lines around them (a time or a count that leaps and comes back) and were skipped",
                self.damage.implausible
            ));
        }
        if running.coarse_us > 0 {
            notes.push(format!(
                "the lines' time advances by {} s at a time, and they come every {sample_time_s} s: a coarse clock, between whose steps they are spread evenly; print micros(), or more decimals",
                running.coarse_us as f64 / 1e6
            ));
        }
        if self.damage.repeated > 0 {
            notes.push(format!(
                "{} lines had the time of the line before them and were skipped",
                self.damage.repeated
            ));
        }
        if self.request.sample_time_us.is_none() {
            notes.push(format!(
                "the sample time of {sample_time_s} s was measured from the lines; say it with --ts if it is another"
            ));
        }
        notes
    }
}
