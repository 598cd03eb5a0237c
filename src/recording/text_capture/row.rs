//! Conversion of a text line to a row: time, counts, command.

use super::super::held_line::Line;
use super::super::recorder::Measured;
use super::super::{Ending, Flags, Observation};
use super::{TextError, TextRecording};
use crate::board::leap::most_counts;
use crate::board::text_lines::TextSample;
use crate::motor::plausible::{COMMAND, COUNTS};

/// Largest delay of an arrival in a burst, in microseconds (measured: 35 to 40 ms; generous).
const BUNCH_US: u64 = 250_000;

/// Largest value of `analogWrite`.
pub(super) const PWM_FULL_SCALE: f64 = 255.0;

impl TextRecording<'_> {
    /// Writes the row of a line.
    pub(super) fn write(&mut self, line: Line) -> Result<Option<Ending>, TextError> {
        let Some(running) = &mut self.running else {
            return Ok(None);
        };
        let Line {
            mut sample,
            host_us,
            at_us,
        } = line;
        let pwm = sample.command_pwm255.unwrap_or(0.0).abs();
        self.largest_pwm = self.largest_pwm.max(pwm);
        let said_v = sample.command_v.unwrap_or(0.0).abs();
        self.largest_command_v = self.largest_command_v.max(said_v);
        let mut t_us = at_us.saturating_sub(running.first_us);
        if let Some(last_us) = running.last_us {
            if running.coarse_us > 0 {
                // Evenly spaced between the stamps: no line is before its own stamp or after the next one.
                let even_us = last_us.saturating_add(running.sample_time_us);
                t_us = even_us.clamp(t_us, t_us.saturating_add(running.coarse_us));
            }
            if running.coarse_us > 0 || !running.device_timed {
                // Lines of one read have the same arrival time; times of a run must increase.
                t_us = t_us.max(last_us + 1);
            }
            let steps = (t_us - last_us).saturating_add(running.sample_time_us / 2)
                / running.sample_time_us.max(1);
            running.seq += steps.max(1) as u64;
        } else {
            t_us = t_us.max(0);
        }
        let passed_us = running.last_us.map_or(0, |last_us| t_us.abs_diff(last_us));
        let passed_s = running
            .last_us
            .map(|last_us| (t_us - last_us) as f64 * 1e-6);
        if let Some((_, value)) = sample.summand {
            // Counts up to the first row precede the recording.
            running.summed_counts += match (passed_s, &running.speeds) {
                (None, _) => 0.0,
                (Some(passed_s), Some(speeds)) => speeds.counts_in(value, passed_s),
                (Some(_), None) => value,
            };
            sample.counts = running.summed_counts.round() as i64;
        }
        running.last_us = Some(t_us);
        // Arrivals come in bursts: without the board's time any step may take a quarter of a second.
        let bunch_us = if running.device_timed { 0 } else { BUNCH_US };
        let counts_per_rev = self.request.counts_per_rev;
        let goes_round = self.decoder.counts_wrap();
        let counts_leap = match running.last_counts.replace(sample.counts) {
            None => false,
            Some(last) => {
                let limit = most_counts(counts_per_rev, passed_us.saturating_add(bunch_us));
                let moved = sample.counts.saturating_sub(last) as f64;
                let is_gap = passed_us > 2 * running.sample_time_us.unsigned_abs();
                let is_leap = sample.counts.abs_diff(last) > limit
                    || running.motion.is_reset(moved, sample.counts)
                    || (goes_round
                        && is_gap
                        && running.motion.may_have_wrapped(passed_us as f64, 0.0));
                if !is_leap {
                    running.motion.push(moved, passed_us as f64);
                }
                is_leap
            }
        };
        let command = command_v(&sample, self.request.supply_v)
            .or(self
                .request
                .profile
                .as_ref()
                .map(|profile| profile.command_at(t_us as f64 * 1e-6)))
            .unwrap_or(0.0);
        let next_us = t_us as f64 + running.sample_time_us as f64;
        let over = self.request.duration_s > 0.0 && next_us >= self.request.duration_s * 1e6;
        let ending = over.then_some(Ending::Complete);
        if !can_be_read(&sample, self.request.supply_v) {
            self.damage.implausible += 1;
            running.unread += 1;
            return Ok(ending);
        }
        if running.numbered {
            // They show in the number of the next row.
            running.unread = 0;
        }
        let observation = Observation {
            seq: match sample.sequence {
                Some(sequence) => Some(sequence),
                None => running.numbered.then_some(running.seq),
            },
            device_us: t_us,
            host_us: running.device_timed.then_some(host_us as i64),
            command,
            counts: sample.counts,
            flags: Flags {
                counts_leap,
                ..Flags::default()
            },
        };
        let measured = Measured {
            supply_v: sample.supply_v,
            current_a: sample.current_a,
        };
        running.recorder.append(observation, host_us, measured)?;
        if let (Some((_, value)), Some(speeds)) = (sample.summand, &mut running.speeds) {
            speeds.push(value);
        }
        Ok(ending)
    }
}

fn command_v(sample: &TextSample, supply_v: f64) -> Option<f64> {
    let of_pwm = |pwm: f64| pwm / PWM_FULL_SCALE * supply_v;
    sample.command_v.or(sample.command_pwm255.map(of_pwm))
}

/// Whether a reader of run files accepts the line: an invalid row invalidates the file.
fn can_be_read(sample: &TextSample, supply_v: f64) -> bool {
    let measured = [
        command_v(sample, supply_v),
        sample.supply_v,
        sample.current_a,
    ];
    measured
        .into_iter()
        .flatten()
        .all(|value| COMMAND.holds(value))
        && COUNTS.holds(sample.counts as f64)
}
