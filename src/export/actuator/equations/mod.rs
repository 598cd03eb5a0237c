//! Equations in a notation that every language shares: assignments of expressions with `+ - * /`, comparisons in
//! parentheses, `&`, `|`, and the functions `pick(condition, a, b)`, `sgn`, `mag`, `low`, `high`, `exp`, `log`,
//! `sin`.
//!
//! The state `y` has the motor side's angle and speed, then as needed: current, filtered copper loss, angle and speed
//! of the load side, the touching flank or the slip direction of a clutch, presliding friction. The mode `m` is fixed
//! within a step: voltage, load, directions of slip, whether current flows. The equations are those of
//! `motor-chain`'s `dynamics.rs`, the events those of its `guards.rs` and `transitions.rs`.

use crate::motor::catalogue::ids;
mod events;
mod forces;
mod friction;
mod motion;
mod transmission;

use super::constants::{Division, folded};
use crate::motor::Motor;

#[derive(Debug, Clone)]
pub(super) enum Line {
    /// `name = expression`.
    Let(&'static str, String),
    /// `array = function(arguments)`, and the names of its elements.
    Call(&'static str, &'static str, &'static str, Vec<&'static str>),
}

/// A function of state, mode and constants that returns an array.
#[derive(Debug, Clone)]
pub(super) struct Function {
    pub name: &'static str,
    pub comment: &'static str,
    pub parameters: &'static [&'static str],
    pub lines: Vec<Line>,
    pub gives: Vec<String>,
}

#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Names of the elements of the state.
    pub y: Vec<&'static str>,
    /// Names of the elements of the mode.
    pub m: Vec<&'static str>,
    /// Number of events that end a mode.
    pub guards: usize,
    /// Command at the driver for `u`.
    pub command: String,
    pub functions: Vec<Function>,
    /// Index of angle and speed of the output shaft in the state, or of the motor side if the encoder is there.
    pub output: usize,
    pub encoder: usize,
}

/// Names of the variables of one side of the transmission.
struct Side {
    angle: &'static str,
    speed: &'static str,
    net: &'static str,
    slip: &'static str,
    share: &'static str,
    /// Presliding friction in the state, and its origin: angle, friction, steady friction.
    friction: &'static str,
    from: [&'static str; 3],
    /// Intermediate results: breakaway levels forward and back, steady friction, friction, viscous friction.
    levels: [&'static str; 2],
    steady: &'static str,
    rubs: &'static str,
    viscous: &'static str,
}

const MOTOR: Side = Side {
    angle: "angle",
    speed: "speed",
    net: "net",
    slip: "slip",
    share: "MOTOR_FRICTION_SHARE",
    friction: "friction",
    from: ["from_angle", "from_friction", "from_steady"],
    levels: ["up", "down"],
    steady: "steady",
    rubs: "rubs",
    viscous: "viscous",
};

const LOAD: Side = Side {
    angle: "load_angle",
    speed: "load_speed",
    net: "load_net",
    slip: "load_slip",
    share: "LOAD_FRICTION_SHARE",
    friction: ids::LOAD_FRICTION,
    from: ["load_from_angle", "load_from_friction", "load_from_steady"],
    levels: ["load_up", "load_down"],
    steady: "load_steady",
    rubs: "load_rubs",
    viscous: "load_viscous",
};

/// Margin of the breakaway level: a state found by interpolation lies on the level up to rounding.
const BREAKAWAY: &str = "(1.0 - 1e-9)";

/// Speed in rad/s at which a side leaves rest: the direction of slip is the sign of the speed.
const LEAVING_RAD_S: &str = "1e-9";

fn set(name: &'static str, expression: impl Into<String>) -> Line {
    Line::Let(name, expression.into())
}

/// The equations that this motor needs.
struct Writer<'a> {
    motor: &'a Motor,
    inductive: bool,
    drops: bool,
    limited: bool,
    opens: bool,
    warms: bool,
    weakens: bool,
    preslides: bool,
    sides: Vec<&'static Side>,
    gap: bool,
    spring: bool,
    clutch: bool,
}

impl Equations {
    pub(super) fn of(motor: &Motor) -> Self {
        Writer::new(motor).equations()
    }
}

impl<'a> Writer<'a> {
    fn new(motor: &'a Motor) -> Self {
        let has = |id: &str| motor.effects.get(id).is_some();
        let (gap, spring) = (has(ids::BACKLASH), has(ids::COMPLIANCE));
        let clutch = has(ids::SLIPPING_CLUTCH) && !gap && !spring;
        Self {
            motor,
            inductive: folded(motor).inductance_h > 0.0,
            drops: has(ids::VOLTAGE_DROP) || has(ids::ASYMMETRIC_VOLTAGE_DROP),
            limited: has(ids::CURRENT_LIMIT),
            opens: has(ids::COAST_AT_ZERO) || has(ids::PWM_FREEWHEEL),
            warms: has(ids::WINDING_HEATING) || has(ids::MAGNET_WEAKENING),
            weakens: has(ids::MAGNET_WEAKENING),
            preslides: has(ids::PRESLIDING),
            sides: if gap || spring || clutch {
                vec![&MOTOR, &LOAD]
            } else {
                vec![&MOTOR]
            },
            gap,
            spring,
            clutch,
        }
    }

    fn has(&self, id: &str) -> bool {
        self.motor.effects.get(id).is_some()
    }

    fn two(&self) -> bool {
        self.sides.len() == 2
    }

    fn welds(&self) -> bool {
        (self.gap && !self.spring) || self.clutch
    }

    /// Whether a flank or a clutch is part of the state.
    fn touches(&self) -> bool {
        self.gap || self.clutch
    }

    /// Whether the current can be discontinuous.
    fn halts(&self) -> bool {
        self.inductive && (self.drops || self.limited || self.opens)
    }

    fn equations(&self) -> Equations {
        let mut y = vec!["angle", "speed"];
        let mut m = vec!["u", "load"];
        if self.inductive {
            y.push("current");
        }
        if self.warms {
            y.push("loss");
        }
        if self.two() {
            y.extend(["load_angle", "load_speed"]);
        }
        if self.touches() {
            y.push("contact");
            m.push("touch");
        }
        if self.welds() {
            m.push("joined");
        }
        if self.halts() {
            m.extend(["flows", "way"]);
        }
        for side in &self.sides {
            m.push(side.slip);
            if self.preslides {
                y.push(side.friction);
                m.extend(side.from);
            }
        }
        let division = Division::of(self.motor);
        let output = if self.two() {
            2 + usize::from(self.inductive) + usize::from(self.warms)
        } else {
            0
        };
        let (events, guards) = self.guards();
        Equations {
            command: self.command(),
            functions: vec![
                self.forces(),
                self.mode(&m),
                self.rates(&y),
                events,
                self.snap(&y),
            ],
            y,
            m,
            guards,
            output,
            encoder: if division.is_some_and(|d| d.encoder_on_load) {
                output
            } else {
                0
            },
        }
    }

    fn command(&self) -> String {
        let mut kept = Vec::new();
        if self.has(ids::DEAD_ZONE) {
            kept.push("(mag(u) > DEAD_ZONE_THRESHOLD_V)");
        }
        if self.has(ids::ASYMMETRIC_DEAD_ZONE) {
            kept.push(
                "((u > ASYMMETRIC_DEAD_ZONE_POSITIVE_V) | (u < -ASYMMETRIC_DEAD_ZONE_NEGATIVE_V))",
            );
        }
        if kept.is_empty() {
            "u".to_owned()
        } else {
            format!("pick({}, u, 0.0)", kept.join(" & "))
        }
    }
}
