//! Meaning of a column's name: quantity and unit.
//!
//! A name is split into words at all characters other than letters and digits, and at a capital after a small letter.
//! The words determine the quantity; a unit is in brackets or at the end.

use super::name_words::{
    COMMANDS, CURRENTS, ENDS, FIELD_VOLTAGES, FREQUENCIES, INCREMENTS, INPUTS, INTERVALS, LOOPS,
    OUTPUTS, POSITIONS, REFERENCES, SPEEDS, SUPPLIES, TIMES,
};
use super::units::{Role, unit_of};

/// Meaning of a name.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct NameFacts {
    pub role: Option<Role>,
    /// In the notation of mapping files.
    pub unit: Option<&'static str>,
    /// The unit of a command, if it is one.
    command_unit: Option<&'static str>,
    /// `duty_255`, `pwm_885max`.
    pub full: Option<f64>,
    /// `counts_8192_per_rev`.
    pub counts_per_rev: Option<f64>,
    /// `rpm_x10`: factor of its numbers.
    pub times: Option<f64>,
    /// The words, to find related columns: `left` of `rpm_left`.
    pub words: Vec<String>,
    /// The quantity is named by a word, not by a unit alone.
    pub is_named: bool,
    /// The electrical speed: the shaft's times the number of pole pairs.
    pub is_electrical: bool,
}

/// Full drive in per mille.
const PER_MILLE: f64 = 1000.0;
/// Least number in a name that is a full scale and not the number of a motor.
const LEAST_FULL: f64 = 50.0;

/// Meaning of a name and of a unit below it.
pub(super) fn name_facts(name: &str, unit_line: Option<&str>) -> NameFacts {
    let (outside, inside) = bracketed(name);
    let words = words(&outside);
    let mut found = NameFacts {
        words: words.clone(),
        ..NameFacts::default()
    };
    let per_rev = words.windows(3).position(|three| {
        let is_number = three[0].parse::<f64>().is_ok();
        is_number && three[1] == "per" && matches!(three[2].as_str(), "rev" | "turn")
    });
    let mut words = words;
    if let Some(at) = per_rev {
        found.counts_per_rev = words[at].parse().ok();
        words.drain(at..at + 3);
    }
    // Of the Arduino library Encoder.
    let is_read_and_reset = words.concat().contains("readandreset");
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    found.is_electrical = is_electrical(&words);
    let role = if has(FIELD_VOLTAGES) {
        Some(Role::Command)
    } else if has(REFERENCES) && !is_voltage_reached(&words) {
        Some(Role::Reference)
    } else if has(SUPPLIES) {
        Some(Role::Supply)
    } else if has(CURRENTS) && !has(SPEEDS) && !has(POSITIONS) {
        Some(Role::Current)
    } else if has(SPEEDS) || (has(POSITIONS) && (is_per_time(&words) || is_frequency(&words))) {
        // `speed_cmd` is the setpoint of a controller.
        let is_asked = has(&["cmd", "command", "u"]);
        Some(if is_asked {
            Role::Reference
        } else {
            Role::Speed
        })
    } else if is_interval(&words, inside.iter().map(String::as_str).chain(unit_line)) {
        Some(Role::Interval)
    } else if is_read_and_reset || is_per_row(&words) || (has(INCREMENTS) && !has(TIMES)) {
        Some(Role::Increments)
    } else if has(POSITIONS) && !has(&["pwm", "duty", "voltage"]) {
        let is_asked = has(&["cmd", "command"]);
        Some(if is_asked {
            Role::Reference
        } else {
            Role::Position
        })
    } else if has(COMMANDS) {
        let is_input = has(&["input", "in"]) && has(&["voltage", "volts", "volt"]);
        Some(if is_input {
            Role::CommandOrSupply
        } else {
            Role::Command
        })
    } else if has(TIMES) {
        Some(Role::Time)
    } else {
        None
    };
    found.is_named = role.is_some();
    let beside: Vec<&str> = inside.iter().map(String::as_str).chain(unit_line).collect();
    found.role = role.or_else(|| role_of_unit(&words, &beside));
    let unit = |role| {
        let by_text = beside.iter().find_map(|text| unit_of(role, text));
        by_text.or_else(|| unit_at_end(role, &words))
    };
    found.command_unit = unit(Role::Command);
    let Some(role) = found.role else {
        return found;
    };
    found.unit = unit(role).or(is_read_and_reset.then_some("counts"));
    found.times = times(&words);
    // Ten times a unit is another one, and so is the electrical rpm.
    found.unit = (found.unit)
        .filter(|_| found.times.is_none() && !found.is_electrical && !is_frequency(&words));
    if role == Role::Command && is_per_mille(name, unit_line) {
        (found.unit, found.full) = (Some("pwm"), Some(PER_MILLE));
    } else if role == Role::Command {
        found.full = words.iter().find_map(|word| {
            let digits = word.strip_suffix("max").unwrap_or(word);
            digits.parse().ok().filter(|full| *full >= LEAST_FULL)
        });
    }
    found
}

/// Whether a name or the unit below it is in per mille.
fn is_per_mille(name: &str, unit_line: Option<&str>) -> bool {
    let texts = [Some(name), unit_line].into_iter().flatten();
    texts.map(str::to_lowercase).any(|text| {
        ["‰", "permille", "promille", "per_mille"]
            .into_iter()
            .any(|word| text.contains(word))
    })
}

/// Whether the words are those of a frequency, of an encoder's pulses or of the shaft's revolutions.
pub(super) fn is_frequency(words: &[String]) -> bool {
    (words.iter()).any(|word| FREQUENCIES.contains(&word.as_str()))
}

/// Whether the words are those of an electrical speed: `erpm`, `eRPM`, `Motor Electrical Speed`.
fn is_electrical(words: &[String]) -> bool {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let is_e = words.windows(2).any(|two| two[0] == "e" && two[1] == "rpm");
    is_e || has(&["erpm"]) || (has(&["electrical", "elec"]) && has(SPEEDS))
}

/// `Sollspannung`: the setpoint of an open loop is the command.
fn is_voltage_reached(words: &[String]) -> bool {
    words
        .windows(2)
        .any(|two| two[0] == "soll" && two[1] == "spannung")
}

/// Names of a controller's columns: without a named command, its output is the command.
pub(super) fn name_outputs(all: &mut [NameFacts], is_numeric: impl Fn(usize) -> bool) {
    if all
        .iter()
        .any(|facts| matches!(facts.role, Some(Role::Command | Role::CommandOrSupply)))
    {
        return;
    }
    for (at, facts) in all.iter_mut().enumerate() {
        let is_output = facts
            .words
            .iter()
            .any(|word| OUTPUTS.contains(&word.as_str()));
        if facts.role.is_none() && is_output && is_numeric(at) {
            facts.role = Some(Role::Command);
            facts.is_named = true;
            facts.unit = facts.command_unit;
        }
    }
}

/// Whether a name is that of a controller's measured value.
pub(super) fn is_input(facts: &NameFacts) -> bool {
    facts
        .words
        .iter()
        .any(|word| INPUTS.contains(&word.as_str()))
}

/// Whether the words are those of the time since the previous row: `dt`, `dt_us`, `delta_t`, `delta_ms`.
fn is_interval<'a>(words: &'a [String], units: impl Iterator<Item = &'a str>) -> bool {
    let is_time = |word: &str| TIMES.contains(&word) || unit_of(Role::Time, word).is_some();
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let mut all = words.iter().map(String::as_str).chain(units);
    let is_d_t = matches!(words, [d, t, ..] if d == "d" && t == "t");
    let is_since_last = has(&["since"]) && has(&["last", "prev", "previous"]);
    has(INTERVALS) || is_d_t || ((has(LOOPS) || is_since_last) && all.any(is_time))
}

/// A name that is only a unit determines the quantity, such as `millis`, `vir_V` and `x [rad]`.
fn role_of_unit(words: &[String], beside: &[&str]) -> Option<Role> {
    let by_text = |text: &str| {
        let roles = [Role::Time, Role::Speed, Role::Position, Role::Command];
        // Percent may be an efficiency or a charge; `ms` may be metres per second, `m/s` nothing else.
        let is_clear = |unit: &str| {
            !matches!(
                unit,
                "m/s" | "m" | "min" | "A" | "mA" | "rev/s" | "percent" | "servo" | "esc"
            ) || (unit == "m/s" && text.contains('/'))
        };
        roles
            .into_iter()
            .find(|role| unit_of(*role, text).is_some_and(is_clear))
    };
    let alone = match words {
        [one] if one.len() > 1 => by_text(one),
        _ => None,
    };
    let at_end = || {
        let roles = [Role::Speed, Role::Position];
        let by_last = match words.last().map(String::as_str) {
            Some("v" | "volts") if words.len() > 1 => Some(Role::Command),
            Some("a") if words.len() > 1 => Some(Role::Current),
            Some("ms" | "us" | "ns") if words.len() > 1 => Some(Role::Time),
            Some("s") if words.len() > 2 && is_metres_per_s(words) => Some(Role::Speed),
            _ => None,
        };
        let by_unit = roles.into_iter().find(|role| {
            let unit = unit_at_end(*role, words);
            words.len() > 1 && unit.is_some_and(|unit| !matches!(unit, "m" | "m/s" | "rev/s"))
        });
        by_last.or(by_unit)
    };
    alone
        .or_else(|| beside.iter().find_map(|text| by_text(text)))
        .or_else(at_end)
}

/// `deg_per_sample`: since the previous row.
fn is_per_row(words: &[String]) -> bool {
    const ROWS: [&str; 8] = [
        "sample",
        "samples",
        "row",
        "loop",
        "cycle",
        "step",
        "frame",
        "iteration",
    ];
    (words.windows(2)).any(|two| two[0] == "per" && ROWS.contains(&two[1].as_str()))
}

/// Whether the last words are `m_s`, `mm_s`: of `ms` they are the letters of another unit.
fn is_metres_per_s(words: &[String]) -> bool {
    matches!(words, [.., metres, _] if matches!(metres.as_str(), "m" | "cm" | "mm"))
}

/// Whether the last words are a unit of speed: `angle_deg_s`.
fn is_per_time(words: &[String]) -> bool {
    (2..=words.len().min(3)).any(|count| {
        let last = words[words.len() - count..].join("_");
        unit_of(Role::Speed, &last).is_some()
    })
}

/// The unit of the last words together: `rad_per_s`, `rad_s`, `ms`.
fn unit_at_end(role: Role, words: &[String]) -> Option<&'static str> {
    (1..=words.len().min(3))
        .rev()
        .find_map(|count| {
            let last = words[words.len() - count..].join("_");
            unit_of(role, &last)
        })
        .or_else(|| {
            words
                .iter()
                .find_map(|word| unit_of(role, word).filter(|_| word.len() > 1))
        })
}

/// `x10`, `x100` after other words.
fn times(words: &[String]) -> Option<f64> {
    let at = words.iter().skip(1).position(|word| word == "x")? + 1;
    let times = words.get(at + 1)?;
    matches!(times.as_str(), "10" | "100" | "1000" | "10000")
        .then(|| times.parse().ok())
        .flatten()
}

/// A name without its brackets, and their content.
fn bracketed(name: &str) -> (String, Option<String>) {
    let open = name.find(['(', '[', '{']);
    let close = name.rfind([')', ']', '}']);
    match (open, close) {
        (Some(open), Some(close)) if open < close => {
            let inside = name[open + 1..close].to_owned();
            (
                format!("{} {}", &name[..open], &name[close + 1..]),
                Some(inside),
            )
        }
        _ => (name.to_owned(), None),
    }
}

/// The words of a name in small letters.
fn words(name: &str) -> Vec<String> {
    let name = name
        .replace(['µ', 'μ'], "u")
        .replace('°', "deg")
        .replace('%', " percent ")
        .replace('¹', "1");
    let mut words: Vec<String> = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let is_new = c.is_uppercase() && before.is_lowercase();
        if is_new || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    // `enc1`, `pwm2`: the number of a motor is a separate word.
    words
        .into_iter()
        .flat_map(|word| {
            let end = ENDS
                .iter()
                .find_map(|end| Some((word.strip_suffix(end)?, *end)));
            match end {
                Some((before, end)) if !before.is_empty() => {
                    vec![before.to_owned(), end.to_owned()]
                }
                _ => vec![word],
            }
        })
        .flat_map(|word| {
            let letters = word.trim_end_matches(|c: char| c.is_ascii_digit());
            let digits = &word[letters.len()..];
            match (letters.is_empty(), digits.is_empty()) {
                (false, false) => vec![letters.to_owned(), digits.to_owned()],
                _ => vec![word],
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_field_are_understood() {
        use Role::{
            Command, Current, Increments, Interval, Position, Reference, Speed, Supply, Time,
        };
        for (name, role, unit) in [
            ("time", Time, None),
            ("t", Time, None),
            ("millis", Time, Some("ms")),
            ("micros()", Time, Some("us")),
            ("t_us", Time, Some("us")),
            ("time_ms", Time, Some("ms")),
            ("timeMs", Time, Some("ms")),
            ("Time (ms)", Time, Some("ms")),
            ("Time[s]", Time, Some("s")),
            ("ms", Time, Some("ms")),
            ("timestamp", Time, None),
            ("Zeit [s]", Time, Some("s")),
            ("__time", Time, None),
            ("counts", Position, Some("counts")),
            ("left_counts", Position, Some("counts")),
            ("EncoderCount", Position, Some("counts")),
            ("enc", Position, None),
            ("enc1", Position, None),
            ("angle_deg", Position, Some("deg")),
            ("Winkel [°]", Position, Some("deg")),
            ("theta (rad)", Position, Some("rad")),
            ("pos_rad", Position, Some("rad")),
            ("rpm", Speed, Some("rpm")),
            ("rpm_left", Speed, Some("rpm")),
            ("speed [rpm]", Speed, Some("rpm")),
            ("encoder_rpm", Speed, Some("rpm")),
            ("motorSpeed", Speed, None),
            ("vel_rad_s", Speed, Some("rad/s")),
            ("omega (rad/s)", Speed, Some("rad/s")),
            ("wheel_speed_rad_per_s", Speed, Some("rad/s")),
            ("counts_per_s", Speed, Some("counts/s")),
            ("angle_deg_s", Speed, Some("deg/s")),
            ("current_position", Position, None),
            ("Drehzahl [U/min]", Speed, Some("rpm")),
            ("pwm", Command, Some("pwm")),
            ("duty %", Command, Some("percent")),
            ("duty_cycle", Command, None),
            ("u", Command, None),
            ("voltage", Command, None),
            ("motor voltage (V)", Command, Some("V")),
            ("cmd_V", Command, Some("V")),
            ("vir_V", Command, Some("V")),
            ("battery_mV", Supply, Some("mV")),
            ("vin_V", Supply, Some("V")),
            ("current", Current, None),
            ("iq_measured_A", Current, Some("A")),
            ("goal_rad", Reference, None),
            ("target_rpm", Reference, None),
            ("speed_cmd", Reference, None),
            ("dt", Interval, None),
            ("dt_us", Interval, Some("us")),
            ("deltaT", Interval, None),
            ("delta_ms", Interval, Some("ms")),
            ("dT (ms)", Interval, Some("ms")),
            ("period_us", Interval, Some("us")),
            ("Loop time [ms]", Interval, Some("ms")),
            ("v [m/s]", Speed, Some("m/s")),
            ("velocity [cm/s]", Speed, Some("cm/s")),
            ("Zähler", Position, Some("counts")),
            ("Impulse", Position, Some("counts")),
            ("velocidad (rpm)", Speed, Some("rpm")),
            ("vitesse [rad/s]", Speed, Some("rad/s")),
            ("Delta Time (s)", Interval, Some("s")),
            ("sec", Time, Some("s")),
            ("nanosec", Time, Some("ns")),
            ("header.stamp.nsecs", Time, Some("ns")),
            ("increments", Increments, None),
            ("deg_per_sample", Increments, Some("deg")),
            ("delta_counts", Increments, Some("counts")),
            ("Uq", Command, None),
            ("Vq_setpoint", Command, None),
            ("Motorspannung", Command, None),
            ("Sollspannung [V]", Command, Some("V")),
            ("Batteriespannung [V]", Supply, Some("V")),
            ("Solldrehzahl [U/min]", Reference, None),
            ("Istdrehzahl [U/min]", Speed, Some("rpm")),
            ("Motorstrom [A]", Current, Some("A")),
            ("commande", Command, None),
            ("n in min⁻¹", Speed, Some("rpm")),
            ("n [min^-1]", Speed, Some("rpm")),
            ("ω/(rad·s⁻¹)", Speed, Some("rad/s")),
            ("φ [°]", Position, Some("deg")),
            ("encoder_freq_hz", Speed, None),
            ("erpm", Speed, None),
            ("eRPM[0]", Speed, None),
            ("Motor Electrical Speed (RPM)", Speed, None),
        ] {
            let found = name_facts(name, None);
            assert_eq!(found.role, Some(role), "{name}");
            if role != Reference {
                assert_eq!(found.unit, unit, "{name}");
            }
        }
        for name in ["direction", "temp_C", "trial", "mode", "x"] {
            assert_eq!(name_facts(name, None).role, None, "{name}");
        }
    }

    #[test]
    fn full_scales_and_counts_per_turn_stand_in_names() {
        assert_eq!(name_facts("left_duty_255", None).full, Some(255.0));
        assert_eq!(name_facts("pwm_counts_885max", None).full, Some(885.0));
        assert_eq!(name_facts("pwm2", None).full, None);
        for (name, unit) in [
            ("duty_permille", None),
            ("PWM [‰]", None),
            ("duty", Some("‰")),
        ] {
            let found = name_facts(name, unit);
            assert_eq!(
                (found.unit, found.full),
                (Some("pwm"), Some(1000.0)),
                "{name}"
            );
        }
        let found = name_facts("position_counts_8192_per_rev", None);
        assert_eq!(found.counts_per_rev, Some(8192.0));
        assert_eq!(found.unit, Some("counts"));
    }

    #[test]
    fn a_line_of_units_is_read_with_the_names() {
        assert_eq!(name_facts("angle", Some("deg")).unit, Some("deg"));
        assert_eq!(name_facts("x", Some("rad/s")).role, Some(Role::Speed));
    }
}
