//! Words of column names by the quantity that they mean, in the languages of the logs that were seen.

pub(super) const TIMES: &[&str] = &[
    "time",
    "t",
    "timestamp",
    "timestamps",
    "stamp",
    "clock",
    "elapsed",
    "uptime",
    "zeit",
    "uhrzeit",
    "tiempo",
    "temps",
    "tempo",
    "datetime",
    "date",
];
pub(super) const POSITIONS: &[&str] = &[
    "counts",
    "count",
    "cnt",
    "enc",
    "encoder",
    "encoders",
    "ticks",
    "tick",
    "pulses",
    "pos",
    "position",
    "angle",
    "theta",
    "phi",
    "φ",
    "θ",
    "winkel",
    "zähler",
    "zaehler",
    "zählerstand",
    "impulse",
    "posición",
    "posicion",
    "ángulo",
    "angulo",
    "codeur",
];
pub(super) const INCREMENTS: &[&str] = &[
    "increment",
    "increments",
    "inc",
    "delta",
    "dcounts",
    "dticks",
];
pub(super) const INTERVALS: &[&str] =
    &["dt", "deltat", "dtime", "deltatime", "interval", "looptime"];
/// With a unit or a word of time beside it, the time that a loop takes.
pub(super) const LOOPS: &[&str] = &["period", "cycle", "loop", "delta", "diff", "zyklus"];
pub(super) const SPEEDS: &[&str] = &[
    "erpm",
    "speed",
    "vel",
    "velocity",
    "omega",
    "ω",
    "rpm",
    "rps",
    "dps",
    "drehzahl",
    "geschwindigkeit",
    "velocidad",
    "vitesse",
    "velocità",
    "velocita",
    "tach",
    "tacho",
];
/// Of an encoder's pulses.
pub(super) const FREQUENCIES: &[&str] = &["freq", "frequency", "frequenz"];
pub(super) const COMMANDS: &[&str] = &[
    "pwm",
    "duty",
    "dutycycle",
    "cmd",
    "command",
    "u",
    "voltage",
    "volts",
    "volt",
    "spannung",
    "voltaje",
    "commande",
    "comando",
    "uq",
    "vq",
];
/// A voltage of a controller that turns its motor's field: its setpoint is the command.
pub(super) const FIELD_VOLTAGES: &[&str] = &["uq", "vq"];
/// German names are one word; what stands at its end is the quantity, what before it says which.
pub(super) const ENDS: &[&str] = &["drehzahl", "geschwindigkeit", "spannung", "winkel", "strom"];
/// Names of a controller's output, if no column is named as a command.
pub(super) const OUTPUTS: &[&str] = &[
    "output",
    "out",
    "op",
    "control",
    "ctrl",
    "effort",
    "throttle",
    "power",
    "actuation",
    "stellgröße",
    "stellgroesse",
    "stellwert",
    "tension",
    "tensión",
    "salida",
    "sortie",
];
/// Names of a controller's measured value.
pub(super) const INPUTS: &[&str] = &[
    "input", "pv", "feedback", "measured", "actual", "ist", "istwert", "entrada",
];
pub(super) const CURRENTS: &[&str] = &[
    "current",
    "amps",
    "strom",
    "iq",
    "corriente",
    "courant",
    "corrente",
];
pub(super) const SUPPLIES: &[&str] = &[
    "battery",
    "batt",
    "bat",
    "vbat",
    "vbatt",
    "supply",
    "vin",
    "vcc",
    "vdd",
    "vsupply",
    "batterie",
    "akku",
    "versorgung",
    "versorgungs",
    "betriebs",
    "alimentation",
];
pub(super) const REFERENCES: &[&str] = &[
    "goal",
    "target",
    "setpoint",
    "set",
    "sp",
    "ref",
    "reference",
    "desired",
    "soll",
    "sollwert",
    "referencia",
    "consigna",
    "consigne",
    "error",
    "err",
];
