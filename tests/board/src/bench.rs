//! Bench of the board: driver, motor, and the encoder's wheel.

use motorlab::motor::{Motor, Plant, SimulationError};
use motorlab::recording::CommandKind;

/// Angle and speed of the encoder's wheel, in counts and counts/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Angle: the encoder reads the integral part.
    pub counts: f64,
    /// Its rate.
    pub counts_per_s: f64,
}

/// A shaft with an encoder.
pub trait Shaft: Send {
    /// Advances to `until_s`, since power-up, with a voltage at the motor.
    fn run(&mut self, motor_v: f64, until_s: f64) -> Turn;

    /// Driver supply in V.
    fn supply_v(&self) -> f64;
}

/// The simulated motor. It starts at rest half a count into count 0.
#[derive(Debug)]
pub struct MotorShaft {
    plant: Plant,
    counts_per_rad: f64,
    supply_v: f64,
}

/// Initial fraction of a count.
pub const START_COUNT_FRACTION: f64 = 0.5;

impl MotorShaft {
    /// A motor at rest.
    pub fn new(motor: &Motor) -> Result<Self, SimulationError> {
        Ok(Self {
            plant: Plant::starting_at(motor, CommandKind::Voltage, 1, START_COUNT_FRACTION)?,
            counts_per_rad: motor.parameters.counts_per_rev / std::f64::consts::TAU,
            supply_v: motor.parameters.supply_v,
        })
    }
}

impl Shaft for MotorShaft {
    fn run(&mut self, motor_v: f64, until_s: f64) -> Turn {
        self.plant.hold(motor_v, until_s);
        Turn {
            counts: self.plant.angle_rad() * self.counts_per_rad + START_COUNT_FRACTION,
            counts_per_s: self.plant.speed_rad_s() * self.counts_per_rad,
        }
    }

    fn supply_v(&self) -> f64 {
        self.supply_v
    }
}

/// A wheel driven at a steady rate in the direction of the voltage, as by a signal generator on a real board.
#[derive(Debug, Clone)]
pub struct SteadyShaft {
    counts_per_s: f64,
    turn: Turn,
    now_s: f64,
}

impl SteadyShaft {
    /// Turns at this rate in counts a second, in the direction of the voltage.
    pub fn new(counts_per_s: f64) -> Self {
        Self {
            counts_per_s,
            turn: Turn {
                counts: START_COUNT_FRACTION,
                counts_per_s: 0.0,
            },
            now_s: 0.0,
        }
    }
}

impl Shaft for SteadyShaft {
    /// A new voltage takes effect at the end of the call, so that the previously returned rate is valid until then.
    fn run(&mut self, motor_v: f64, until_s: f64) -> Turn {
        self.turn.counts += self.turn.counts_per_s * (until_s - self.now_s);
        self.turn.counts_per_s = if motor_v == 0.0 {
            0.0
        } else {
            self.counts_per_s * motor_v.signum()
        };
        self.now_s = until_s;
        self.turn
    }

    fn supply_v(&self) -> f64 {
        4.5
    }
}

/// Levels of the encoder's two channels at a count: bit 0 A, bit 1 B. Forwards, A leads B.
pub fn levels(count: i64) -> u8 {
    [0b00, 0b01, 0b11, 0b10][count.rem_euclid(4) as usize]
}
