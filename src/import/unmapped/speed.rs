//! A speed and no position: its steps give the counts back.

use std::f64::consts::TAU;

use super::super::map::Integration;
use super::super::map_file::SpeedSection;
use super::decide::{Decision, short};
use super::grid::step_of;
use super::motion::{FINEST, WHOLE, whole};
use super::said::expected;
use super::units::Role;

/// So many levels of a fine speed without steps are no few levels by chance.
const LEVELS: usize = 50;

impl Decision<'_> {
    pub(super) fn speed(
        &mut self,
        at: usize,
        said_unit: Option<&'static str>,
        step_s: Option<f64>,
    ) {
        let column = self.column(at);
        let name = self.name(at);
        let Some(unit) = said_unit.or(self.says[at].unit) else {
            let flag = self.flag_name(at);
            let is_omega = self.says[at].words.iter().any(|word| word == "omega");
            let proposed = if is_omega { "rad/s" } else { "rpm" };
            let why = format!("{name} names no unit; {}", expected(Role::Speed));
            self.ask("--speed", format!("{flag}:{proposed}"), why);
            self.tentatively(|decision| decision.speed(at, Some(proposed), step_s));
            return;
        };
        let rev_s = match unit {
            "rpm" => Some(1.0 / 60.0),
            "rev/s" => Some(1.0),
            "rad/s" => Some(1.0 / TAU),
            "deg/s" => Some(1.0 / 360.0),
            _ => None,
        };
        let step = column.step();
        let by_rows = match step {
            Some(_) => None,
            None => self.step_by_rows(at),
        };
        // One count in a sample time, or in the time since the row before.
        let turns = match (step, step_s, by_rows) {
            (Some(step), Some(step_s), _) => Some(step * step_s),
            (None, _, Some(travel)) => Some(travel),
            _ => None,
        };
        let found = turns
            .zip(rev_s)
            .map(|(turns, rev_s)| whole(1.0 / (turns * rev_s)));
        let found = found.filter(|counts| (1.0..=FINEST).contains(counts));
        let why = format!(
            "{name} shows no steps to read it off; counts of the encoder in one turn, all four edges counted"
        );
        if step.is_none() || step_s.is_some() {
            self.counts_per_rev(found, why);
        }
        let has_steps = step.is_some() || by_rows.is_some();
        // Encoders give differences of position; a filter's lag comes on top.
        let rule = self.said.integrate.unwrap_or(Integration::Backward);
        self.map.speed = Some(SpeedSection {
            column: self.column_ref(at),
            unit: unit.to_owned(),
            scale: None,
            offset: None,
            integrate: rule,
        });
        let how = match (step, by_rows) {
            (Some(step), _) => format!("in steps of {}", short(step)),
            (None, Some(_)) => "of whole counts from row to row".to_owned(),
            (None, None) => "without steps".to_owned(),
        };
        self.understand(
            "speed",
            Some(at),
            Some(unit),
            format!(
                "{name} in {unit}, {how}; summed up to a position ({})",
                rule.name()
            ),
        );
        if let (Some(found), Some(step_s)) = (found, step_s) {
            match self.said.counts_per_rev.or(self.says[at].counts_per_rev) {
                None => {
                    let words = format!(
                        "{} counts a turn, read off: one count in {} s is a step of the speed. The encoder's number, or a multiple of it \
                         where the sketch averages several rows",
                        short(found),
                        short(step_s)
                    );
                    self.understand("counts_per_rev", None, None, words);
                }
                Some(said) if (said / found - 1.0).abs() > WHOLE => {
                    let times = found / said;
                    let is_mean = times > 1.5 && (times - times.round()).abs() < WHOLE * times;
                    let how = match is_mean {
                        true => format!(
                            ", as the mean of {} samples has: a filter, the effect `speed_filter`",
                            times.round()
                        ),
                        false => String::new(),
                    };
                    self.notes.push(format!(
                        "the steps of {name} are those of {} counts a turn in {} s, not of {}{how}",
                        short(found),
                        short(step_s),
                        short(said)
                    ));
                }
                Some(_) => {}
            }
        }
        if !has_steps && column.is_fine() && column.levels().len() >= LEVELS {
            self.notes.push(format!(
                "{name} lacks the steps that counts in a sample time make: it is filtered, or timed between edges. \
                 A filter delays it: the effect `speed_filter`"
            ));
        }
    }

    /// The travel of one count where speeds were made by the time that really passed: speed times time comes in steps.
    fn step_by_rows(&self, at: usize) -> Option<f64> {
        let (clock, seconds) = self.clock?;
        let (times, speeds) = (self.column(clock), self.column(at));
        let travels: Vec<f64> = (times.numbers.windows(2).zip(speeds.numbers.iter().skip(1)))
            .map(|(pair, speed)| speed * (pair[1] - pair[0]) * seconds)
            .collect();
        let rounding = speeds.rounding() * times.median_step() * seconds;
        step_of(&travels, rounding)
    }
}
