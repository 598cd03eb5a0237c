//! Quantities, and the notations of their units in names and brackets.

/// Quantity of a column, from its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Position,
    /// Counts since the previous row.
    Increments,
    /// Time since the previous row.
    Interval,
    Speed,
    Command,
    Current,
    Supply,
    /// Setpoint of a controller: neither commanded to the motor nor measured.
    Reference,
    /// `input_volts`: the supply of a servo, or the command.
    CommandOrSupply,
}

/// A notation of a unit in names, and that of mapping files.
type Spelling = (&'static str, &'static str);

/// Radians or revolutions per second, depending on the author.
pub(super) const EITHER_PER_S: &str = "rps";

const TIME_UNITS: &[Spelling] = &[
    ("s", "s"),
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("sekunden", "s"),
    ("ms", "ms"),
    ("msec", "ms"),
    ("msecs", "ms"),
    ("millis", "ms"),
    ("millisecond", "ms"),
    ("milliseconds", "ms"),
    ("us", "us"),
    ("usec", "us"),
    ("usecs", "us"),
    ("micros", "us"),
    ("microsecond", "us"),
    ("microseconds", "us"),
    ("ns", "ns"),
    ("nsec", "ns"),
    ("nsecs", "ns"),
    ("nanos", "ns"),
    ("nanosec", "ns"),
    ("nanosecs", "ns"),
    ("nanosecond", "ns"),
    ("nanoseconds", "ns"),
    ("100ns", "100ns"),
    ("min", "min"),
    ("minute", "min"),
    ("minutes", "min"),
    ("days", "d"),
    ("day", "d"),
    ("tage", "d"),
    ("segundos", "s"),
    ("secondes", "s"),
    ("secondi", "s"),
    ("millisekunden", "ms"),
    ("milisegundos", "ms"),
];
const POSITION_UNITS: &[Spelling] = &[
    ("counts", "counts"),
    ("count", "counts"),
    ("cnt", "counts"),
    ("cts", "counts"),
    ("qc", "counts"),
    ("inc", "counts"),
    ("incr", "counts"),
    ("ticks", "counts"),
    ("tick", "counts"),
    ("pulses", "counts"),
    ("impulse", "counts"),
    ("zähler", "counts"),
    ("zaehler", "counts"),
    ("zählerstand", "counts"),
    ("rev", "rev"),
    ("revs", "rev"),
    ("revolutions", "rev"),
    ("turn", "rev"),
    ("turns", "rev"),
    ("rad", "rad"),
    ("rads", "rad"),
    ("radians", "rad"),
    ("mrad", "mrad"),
    ("deg", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("grad", "deg"),
    ("grados", "deg"),
    ("gradi", "deg"),
    ("graus", "deg"),
    ("degrés", "deg"),
    ("degres", "deg"),
    ("umdrehungen", "rev"),
    ("vueltas", "rev"),
    ("tours", "rev"),
    ("giri", "rev"),
    ("m", "m"),
    ("cm", "cm"),
    ("mm", "mm"),
    ("um", "um"),
];
const SPEED_UNITS: &[Spelling] = &[
    ("rpm", "rpm"),
    ("revmin", "rpm"),
    ("umin", "rpm"),
    ("1min", "rpm"),
    ("min1", "rpm"),
    ("rmin", "rpm"),
    ("upm", "rpm"),
    ("trmin", "rpm"),
    ("turnsmin", "rpm"),
    ("girimin", "rpm"),
    ("trs", "rev/s"),
    ("revs", "rev/s"),
    ("rps", EITHER_PER_S),
    ("hz", "rev/s"),
    ("rads", "rad/s"),
    ("rads1", "rad/s"),
    ("radsec", "rad/s"),
    ("degs", "deg/s"),
    ("degs1", "deg/s"),
    ("degsec", "deg/s"),
    ("dps", "deg/s"),
    ("countss", "counts/s"),
    ("countssec", "counts/s"),
    ("cps", "counts/s"),
    ("tickss", "counts/s"),
    ("tickssec", "counts/s"),
    ("ms", "m/s"),
    ("mps", "m/s"),
    ("cms", "cm/s"),
    ("mms", "mm/s"),
    ("kmh", "km/h"),
];
const COMMAND_UNITS: &[Spelling] = &[
    ("v", "V"),
    ("volt", "V"),
    ("volts", "V"),
    ("mv", "mV"),
    ("a", "A"),
    ("ma", "mA"),
    ("nm", "N m"),
    ("mnm", "mN m"),
    ("pwm", "pwm"),
    ("percent", "percent"),
    ("pct", "percent"),
    ("prozent", "percent"),
    ("share", "share"),
    ("servo", "servo"),
    ("esc", "esc"),
];
const CURRENT_UNITS: &[Spelling] = &[("a", "A"), ("amp", "A"), ("amps", "A"), ("ma", "mA")];
const SUPPLY_UNITS: &[Spelling] = &[("v", "V"), ("volt", "V"), ("volts", "V"), ("mv", "mV")];

fn spellings(role: Role) -> &'static [Spelling] {
    match role {
        Role::Time | Role::Interval => TIME_UNITS,
        Role::Position | Role::Increments => POSITION_UNITS,
        Role::Speed => SPEED_UNITS,
        Role::Command | Role::Reference => COMMAND_UNITS,
        Role::Current => CURRENT_UNITS,
        Role::Supply | Role::CommandOrSupply => SUPPLY_UNITS,
    }
}

/// Quantities with units.
const MEASURED: [Role; 5] = [
    Role::Time,
    Role::Position,
    Role::Speed,
    Role::Command,
    Role::Current,
];

/// Whether a text is a unit of any quantity.
pub(in super::super) fn is_known(text: &str) -> bool {
    MEASURED
        .into_iter()
        .any(|role| unit_of(role, text).is_some())
}

/// Whether a text is a notation of this unit of mapping files for some quantity.
#[must_use]
pub fn is_spelling_of(text: &str, unit: &str) -> bool {
    MEASURED
        .into_iter()
        .any(|role| unit_of(role, text) == Some(unit))
}

/// A unit in the notation of mapping files.
pub(super) fn unit_of(role: Role, text: &str) -> Option<&'static str> {
    let text = text
        .trim()
        .replace(['µ', 'μ'], "u")
        .replace('°', "deg")
        .replace('%', "percent")
        .replace('¹', "1");
    let letters: String = (text.to_lowercase().replace("per", "\u{0}").chars())
        .filter(|c| c.is_alphanumeric())
        .collect();
    let whole = match text.to_lowercase().as_str() {
        "percent" => "percent".to_owned(),
        _ => letters,
    };
    // `m/s` is no time.
    let is_rate = text.contains('/') || text.to_lowercase().contains("per");
    if is_rate && matches!(role, Role::Time | Role::Interval) {
        return None;
    }
    let found = spellings(role)
        .iter()
        .find(|(spelling, _)| *spelling == whole);
    found.map(|(_, unit)| *unit)
}
