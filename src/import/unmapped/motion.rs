//! The position or speed of a log: its column, and its resolution.

use std::f64::consts::TAU;

use super::super::map_file::PositionSection;
use super::column::Column;
use super::decide::Decision;
use super::given::expected;
use super::names::is_input;
use super::turns::{is_sensor, turn_in};
use super::unclear::Unclear;
use super::units::Role;
use crate::plain::short;

/// Largest counts per revolution derived from a column's digits: finer ones are a float's.
pub(super) const FINEST: f64 = 1e6;
/// Tolerance of integral counts per revolution: rounding.
pub(super) const WHOLE: f64 = 0.005;

/// Definition of counts per revolution.
pub(super) const COUNTED: &str = "counts of the encoder in one turn, all four edges counted";

/// `pos_estimate` and `vel_estimate` of an ODrive are in revolutions.
pub(super) const ODRIVE: &str = "estimate";
/// Least share of a turn that a wrapping angle covers.
const FILLED: f64 = 0.9;
/// Counts per revolution of sensors of 10, 12 or 14 bits.
const POWERS: [f64; 3] = [1024.0, 4096.0, 16_384.0];
/// Ranges of 16-bit and 32-bit counters.
const COUNTERS: [f64; 2] = [65_536.0, 4_294_967_296.0];

impl Decision<'_> {
    /// The column of the motion, if known.
    pub(super) fn motion(&mut self, step_s: Option<f64>) -> Result<Option<usize>, Unclear> {
        let given = self.given;
        match (&given.position, &given.speed) {
            (Some(_), Some(_)) => Err(Unclear::Conflict(
                "--position and --speed exclude each other\nhint: leave --speed out: a speed is read only where there is no position",
            )),
            (Some(text), None) if text == "none" => {
                self.map.position = Some(PositionSection {
                    recorded: Some(false),
                    ..PositionSection::default()
                });
                self.counts_per_rev(
                    None,
                    "there is no position, but a run file has the number".to_owned(),
                );
                self.understand("position", None, None, "not recorded".to_owned());
                Ok(None)
            }
            (Some(text), None) => {
                let (at, unit) = self.given_column("--position", Role::Position, text)?;
                self.position(at, unit);
                Ok(Some(at))
            }
            (None, Some(text)) => {
                let (at, unit) = self.given_column("--speed", Role::Speed, text)?;
                self.speed(at, unit, step_s);
                Ok(Some(at))
            }
            (None, None) => Ok(self.named_motion(step_s)),
        }
    }

    /// By the names: a position before a speed, counts before an angle.
    fn named_motion(&mut self, step_s: Option<f64>) -> Option<usize> {
        let mut positions = self.candidates(Role::Position);
        positions.extend(self.candidates(Role::Increments));
        let mut speeds = self.beside_said(self.candidates(Role::Speed));
        if speeds.iter().any(|&at| !self.name_facts[at].is_electrical) {
            speeds.retain(|&at| !self.name_facts[at].is_electrical);
        }
        if positions.len() + speeds.len() > 1 {
            positions.retain(|&at| !self.column(at).is_row_number() && !self.is_tick_clock(at));
        }
        if let Some(channels) = self.channels()
            && channels.iter().all(|at| positions.contains(at))
        {
            positions.retain(|at| !channels.contains(at));
        }
        positions = self.beside_said(positions);
        let in_counts: Vec<usize> = (positions.iter().copied())
            .filter(|&at| self.name_facts[at].unit == Some("counts"))
            .collect();
        if in_counts.len() == 1 {
            positions = in_counts;
        }
        match (positions.as_slice(), speeds.as_slice()) {
            ([at], _) => {
                self.position(*at, None);
                return Some(*at);
            }
            ([], [at]) => {
                self.speed(*at, None, step_s);
                return Some(*at);
            }
            ([], []) => {}
            ([], several) => {
                let first = several[0];
                self.which("--speed", "speed", several);
                self.tentatively(|decision| decision.speed(first, None, step_s));
                return Some(first);
            }
            (several, _) => {
                // Whole turns beside an angle are the coarser of the two.
                let is_coarse = |at: &usize| {
                    self.name_facts[*at].unit == Some("rev") && self.column(*at).is_whole()
                };
                let mut several = several.to_vec();
                several.sort_by_key(is_coarse);
                let first = several[0];
                self.which("--position", "position", &several);
                self.tentatively(|decision| decision.position(first, None));
                return Some(first);
            }
        }
        let mut rest: Vec<usize> = (0..self.survey.columns.len())
            .filter(|&at| self.name_facts[at].role.is_none() && self.column(at).is_numeric())
            .filter(|&at| !is_sensor(&self.name_facts[at]) && !self.used.contains(&at))
            .collect();
        if rest.len() > 1 {
            rest.retain(|&at| !self.column(at).is_row_number());
        }
        let inputs: Vec<usize> = (rest.iter().copied())
            .filter(|&at| is_input(&self.name_facts[at]))
            .collect();
        if let [_] = inputs.as_slice() {
            rest = inputs;
        }
        if let [one] = rest.as_slice() {
            let flag = self.flag_name(*one);
            let name = self.name(*one);
            let why = format!(
                "{name} may be a position ({}) or a speed ({}): --position {flag}:UNIT or --speed {flag}:UNIT",
                expected(Role::Position),
                expected(Role::Speed)
            );
            let one = *one;
            let in_metres = self.name_facts[one].words.len() > 1
                && self.name_facts[one]
                    .words
                    .last()
                    .is_some_and(|word| word == "m");
            let is_speed = !in_metres && self.column(one).steps().iter().any(|step| *step < 0.0);
            if is_speed {
                self.ask("--speed", format!("{flag}:rpm"), why);
                self.tentatively(|decision| decision.speed(one, Some("rpm"), step_s));
            } else {
                let unit = if in_metres { "m" } else { "counts" };
                self.ask("--position", format!("{flag}:{unit}"), why);
                self.tentatively(|decision| decision.position(one, Some(unit)));
            }
            return Some(one);
        }
        let why = format!(
            "no column is named as a position or a speed; the columns are {}; --speed COLUMN:UNIT for a speed{}{}",
            self.all_names(),
            self.analogue(),
            self.levels_of_channels()
        );
        self.ask("--position", "COLUMN:UNIT".to_owned(), why);
        self.counts_per_rev(None, COUNTED.to_owned());
        None
    }

    /// Candidates that belong to the given command.
    fn beside_said(&self, candidates: Vec<usize>) -> Vec<usize> {
        let command = self
            .given
            .command
            .as_deref()
            .and_then(|text| self.given_column("--command", Role::Command, text).ok());
        let Some((at, _)) = command.filter(|_| candidates.len() > 1) else {
            return candidates;
        };
        let is_common = |word: &String| {
            candidates
                .iter()
                .all(|&one| self.name_facts[one].words.contains(word))
        };
        let belongs = |&one: &usize| {
            let words = &self.name_facts[one].words;
            words
                .iter()
                .any(|word| !is_common(word) && self.name_facts[at].words.contains(word))
        };
        let beside: Vec<usize> = candidates.iter().copied().filter(belongs).collect();
        if beside.is_empty() {
            candidates
        } else {
            beside
        }
    }

    /// Several columns for one quantity: the user has to choose.
    pub(super) fn which(&mut self, flag: &'static str, quantity: &str, several: &[usize]) {
        let names: Vec<String> = several.iter().map(|&at| self.name(at)).collect();
        let first = self.flag_name(several[0]);
        let others: Vec<String> = several[1..]
            .iter()
            .map(|&at| format!("{flag} {}", self.flag_name(at)))
            .collect();
        let why = format!(
            "{} columns hold a {quantity}: {}; or {}",
            several.len(),
            names.join(", "),
            others.join(", ")
        );
        self.used.extend(several.first());
        self.ask(flag, first, why);
    }

    fn position(&mut self, at: usize, given_unit: Option<&'static str>) {
        let column = self.column(at);
        let name = self.name(at);
        let is_increments =
            self.given.increments || self.name_facts[at].role == Some(Role::Increments);
        let words = &self.name_facts[at].words;
        let is_encoder = words
            .iter()
            .any(|word| matches!(word.as_str(), "enc" | "encoder" | "encoders"));
        let named = given_unit.or(self.name_facts[at].unit);
        let counted = (is_encoder && column.is_whole()).then_some("counts");
        let Some(unit) = named.or(counted).or_else(|| unit_of_wrapping(column)) else {
            let flag = self.flag_name(at);
            let is_angle = words
                .iter()
                .any(|word| matches!(word.as_str(), "angle" | "theta" | "phi" | "winkel"));
            // Only a proposal: motors make more than one turn, so that angles in degrees exceed 360, or cover one
            // turn.
            let range = column.highest() - column.lowest();
            let fills = |turn: &f64| (FILLED * turn..=*turn).contains(&range);
            let raw_turn = POWERS.into_iter().find(fills);
            let (unit, turn) = match (is_angle, column.is_whole()) {
                _ if let Some((unit, _)) = self.unit_of_counts(at) => (unit, None),
                (_, false) if words.iter().any(|word| word == ODRIVE) => ("rev", None),
                (true, true) if raw_turn.is_some() => ("counts", raw_turn),
                (false, true) => ("counts", None),
                _ if fills(&360.0) => ("deg", Some(360.0)),
                (true, true) => ("deg", None),
                _ if column.most() > 360.0 => ("deg", None),
                _ => ("rad", None),
            };
            let steps = match self.unit_of_counts(at) {
                Some((unit, counts)) => format!(
                    ", and moves in steps of 1/{} of a turn in {unit}",
                    short(counts)
                ),
                None => String::new(),
            };
            let why = format!("{name} names no unit{steps}; {}", expected(Role::Position));
            self.ask("--position", format!("{flag}:{unit}"), why);
            if let (Some(turn), None) = (turn, self.given.wrap) {
                let turn = short(turn);
                let why = format!("{name} stays within one turn of {turn}, so that it begins anew");
                self.ask("--wrap", turn, why);
            }
            self.tentatively(|decision| decision.position(at, Some(unit)));
            return;
        };
        if !is_increments && self.follows_command(at) {
            match unit {
                "counts" => self.doubt_position(at),
                _ => self.notes.push(format!(
                    "{name} follows the command as a speed does, and not as a position; hint: --speed {}:UNIT, or --increments where it \
                     is the travel since the row before",
                    self.flag_name(at)
                )),
            }
        }
        if matches!(unit, "m" | "cm" | "mm" | "um") {
            self.travel(at, unit);
        }
        if let Some((other, counts)) = self.unit_of_counts(at)
            && other != unit
            && let Some(turn) = turn_in(unit)
        {
            let step = column.step().unwrap_or_default();
            self.notes.push(format!(
                "{name} moves in steps of {}: 1/{} of a turn in {other}, and 1/{} in {unit}, which is no whole number of counts; \
                 hint: --position {}:{other}",
                short(step),
                short(counts),
                short(turn / step),
                self.flag_name(at)
            ));
        }
        let turn = turn_in(unit);
        // Integral degrees are integral in other logs of the kind as well.
        let digit = Some(2.0 * column.rounding()).filter(|digit| *digit > 0.0);
        let step = match column.is_whole() {
            true => Some(1.0),
            false => column.step().or(digit),
        };
        let by_steps = turn.zip(step).map(|(turn, step)| whole(turn / step));
        let found = by_steps.filter(|counts| *counts <= FINEST);
        let why = match turn {
            None => COUNTED.to_owned(),
            Some(_) => format!(
                "{name} shows no steps; counts of the encoder in one turn, or any finer number"
            ),
        };
        let counts_per_rev = self.counts_per_rev(found, why);
        let counters = COUNTERS.into_iter().chain(counts_per_rev);
        let wraps: Vec<f64> = match turn {
            Some(turn) => vec![turn],
            None => counters.collect(),
        };
        let wrap = self.given.wrap.or_else(|| {
            let found = wraps.into_iter().find(|wrap| is_wrapping(column, *wrap));
            found.filter(|_| !is_increments)
        });
        self.map.position = Some(PositionSection {
            column: Some(self.column_ref(at)),
            unit: Some(unit.to_owned()),
            wrap,
            increments: is_increments.then_some(true),
            ..PositionSection::default()
        });
        let mut words = format!("{name} in {unit}");
        if is_increments {
            words.push_str(", each counted since the row before");
        }
        if let Some(wrap) = wrap {
            words.push_str(&format!(", begins anew after {}", short(wrap)));
        }
        self.understand("position", Some(at), Some(unit), words);
        if let (Some(counts), None, None) = (
            found,
            self.given.counts_per_rev,
            self.name_facts[at].counts_per_rev,
        ) {
            let words = format!(
                "{} counts per revolution, read off the steps of {name} of {} {unit}",
                short(counts),
                short(step.unwrap_or_default())
            );
            self.understand("counts_per_rev", None, None, words);
        }
    }

    /// Travel of a linear axis in one turn, needed for metres.
    pub(super) fn travel(&mut self, at: usize, unit: &str) {
        if self.given.m_per_rev.is_none() {
            let name = self.name(at);
            let why = format!(
                "travel of the axis in one turn of the encoder in m, the circumference of a wheel: {name} is in {unit}"
            );
            self.ask("--m-per-rev", "METRES".to_owned(), why);
        }
    }

    /// Counts per revolution of the run: given, in a name, or derived (`found`); else requested.
    pub(super) fn counts_per_rev(&mut self, found: Option<f64>, why: String) -> Option<f64> {
        let named = self
            .name_facts
            .iter()
            .find_map(|facts| facts.counts_per_rev);
        let counts = self.given.counts_per_rev.or(named).or(found);
        match counts {
            Some(counts) => self.map.counts_per_rev = counts,
            None => self.ask("--counts-per-rev", "COUNTS".to_owned(), why),
        }
        counts
    }
}

/// A number rounded if it is integral within the tolerance.
pub(super) fn whole(number: f64) -> f64 {
    let whole = number.round();
    if whole > 0.0 && (number / whole - 1.0).abs() < WHOLE {
        whole
    } else {
        number
    }
}

/// Whether a column wraps at `wrap`: it stays within, jumps by more than half of it, and is smooth otherwise.
fn is_wrapping(column: &Column, wrap: f64) -> bool {
    let steps = column.steps();
    let is_within = column.highest() - column.lowest() <= wrap * 1.001;
    let jumps = steps.iter().filter(|step| step.abs() > wrap / 2.0).count();
    let is_smooth = |step: &&f64| (**step - wrap * (**step / wrap).round()).abs() < wrap / 4.0;
    let smooth = steps.iter().filter(is_smooth).count();
    is_within && jumps > 0 && smooth * 100 >= steps.len() * 98
}

/// The unit of a wrapping angle: degrees at 360, radians at 2 pi.
fn unit_of_wrapping(column: &Column) -> Option<&'static str> {
    let range = column.highest() - column.lowest();
    let spans = |wrap: f64| range > FILLED * wrap && is_wrapping(column, wrap);
    [(360.0, "deg"), (TAU, "rad")]
        .into_iter()
        .find(|(wrap, _)| spans(*wrap))
        .map(|(_, unit)| unit)
}
