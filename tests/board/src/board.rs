//! The board on its bench: processor, driver, motor and encoder with a common time.
//!
//! Time advances in steps of at most 10 us. At the start of each the driver's pins are read, the motor is advanced,
//! and the encoder's edges within the step are placed at their cycles from angle and speed (a change of the speed
//! within 10 us shifts an edge by less than a nanosecond).

use std::collections::VecDeque;
use std::path::Path;

use crate::bench::{Shaft, Turn, levels};
use crate::mcu::{CLOCK_HZ, Edge, Event, EventKind, Mcu, McuError};
use crate::truth::{Tick, Truth};
use crate::wiring::{BoardKind, Output, Wiring};

/// Longest step in cycles: 10 us.
const TURN_CYCLES: u64 = CLOCK_HZ / 100_000;

/// Cycles of a byte on the line: start bit, 8 bits, stop bit.
const BYTE_CYCLES: u64 = 10 * CLOCK_HZ / firmware_protocol::BAUD as u64;

/// State of the driver, from its pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Mean voltage at the motor.
    pub motor_v: f64,
    /// The driver releases the motor.
    pub coasting: bool,
}

/// A byte sent by the board, with its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SentByte {
    /// Cycle of its stop bit.
    pub cycle: u64,
    /// The byte.
    pub byte: u8,
}

/// A board with the sketch.
pub struct Board {
    mcu: Mcu,
    wiring: &'static Wiring,
    shaft: Box<dyn Shaft>,
    turn: Turn,
    drive: Drive,
    /// Bytes in transit to the board, with their arrival times.
    incoming: VecDeque<(u64, u8)>,
    sent: Vec<SentByte>,
    truth: Truth,
    events: Vec<Event>,
    edges: Vec<Edge>,
    due: Option<u64>,
}

impl Board {
    /// Powers up a board with the project's sketch.
    pub fn new(kind: BoardKind, shaft: impl Shaft + 'static) -> Result<Self, McuError> {
        Self::with_firmware(kind, kind.firmware(), shaft)
    }

    /// Powers up a board with another firmware.
    pub fn with_firmware(
        kind: BoardKind,
        elf: &Path,
        mut shaft: impl Shaft + 'static,
    ) -> Result<Self, McuError> {
        let wiring = kind.wiring();
        let off = Drive {
            motor_v: 0.0,
            coasting: false,
        };
        let turn = shaft.run(0.0, 0.0);
        Ok(Self {
            mcu: Mcu::new(wiring, elf)?,
            wiring,
            shaft: Box::new(shaft),
            turn,
            drive: off,
            incoming: VecDeque::new(),
            sent: Vec::new(),
            truth: Truth::default(),
            events: Vec::new(),
            edges: Vec::new(),
            due: None,
        })
    }

    /// Cycles since power-up.
    pub fn cycle(&self) -> u64 {
        self.mcu.cycle()
    }

    /// Seconds since power-up.
    pub fn now_s(&self) -> f64 {
        seconds(self.cycle())
    }

    /// True events.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Clears the log of true events.
    pub fn clear_truth(&mut self) {
        self.truth = Truth::default();
        self.truth.drives.push((self.cycle(), self.drive));
    }

    /// The wheel now.
    pub fn turn(&self) -> Turn {
        self.turn
    }

    /// Present state of the driver.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Whether pin 13 is lit.
    pub fn led(&self) -> bool {
        self.is_high(self.wiring.led)
    }

    /// Resets the board: bytes in transit to it are lost.
    pub fn reset(&mut self) {
        self.mcu.reset();
        self.incoming.clear();
        self.due = None;
        self.read_drive();
        self.truth.resets.push(self.cycle());
    }

    /// Overwrites a variable of the firmware; `false` if there is none of this name.
    pub fn poke(&mut self, symbol: &str, value: u32) -> bool {
        self.mcu.poke(symbol, value)
    }

    /// Sends bytes to the board: they arrive at the line's rate.
    pub fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let free = self.incoming.back().map_or(0, |&(at, _)| at);
            let at = free.max(self.cycle()) + BYTE_CYCLES;
            self.incoming.push_back((at, byte));
        }
    }

    /// Number of bytes in transit to the board.
    pub fn to_receive(&self) -> usize {
        self.incoming.len()
    }

    /// Bytes from the board since the last call.
    pub fn take_sent(&mut self) -> Vec<SentByte> {
        std::mem::take(&mut self.sent)
    }

    /// Runs until a cycle.
    pub fn run_until(&mut self, until: u64) -> Result<(), McuError> {
        while self.mcu.cycle() < until {
            self.run_turn(until)?;
        }
        Ok(())
    }

    fn run_turn(&mut self, until: u64) -> Result<(), McuError> {
        let now = self.mcu.cycle();
        while self.incoming.front().is_some_and(|&(at, _)| at <= now) {
            if let Some((_, byte)) = self.incoming.pop_front() {
                self.mcu.receive(byte);
                self.truth.last_received = now;
            }
        }
        self.read_drive();
        let next_byte = self.incoming.front().map_or(u64::MAX, |&(at, _)| at);
        let until = until.min(now + TURN_CYCLES).min(next_byte);
        self.set_edges(now, until);
        let before = self.turn;
        self.events.clear();
        let result = self.mcu.run(until, &mut self.events);
        let after = self.mcu.cycle();
        self.turn = self.shaft.run(self.drive.motor_v, seconds(after));
        for index in 0..self.events.len() {
            let event = self.events[index];
            self.take(&event, now, before);
        }
        result
    }

    fn take(&mut self, event: &Event, turn_began: u64, before: Turn) {
        match event.kind {
            EventKind::Byte(byte) => self.sent.push(SentByte {
                cycle: event.cycle + BYTE_CYCLES,
                byte,
            }),
            EventKind::TickDue => self.due = Some(event.cycle),
            EventKind::TickEntered => {
                let passed_s = seconds(event.cycle) - seconds(turn_began);
                self.truth.ticks.push(Tick {
                    due: self.due.take().unwrap_or(event.cycle),
                    entered: event.cycle,
                    count: event.count,
                    angle_counts: before.counts + before.counts_per_s * passed_s,
                    counts_per_s: before.counts_per_s,
                });
            }
        }
    }

    /// Places the edges from now until the end of the step.
    fn set_edges(&mut self, now: u64, until: u64) {
        let shown = self.mcu.count();
        let turn_s = seconds(until) - seconds(now);
        let ends = (self.turn.counts + self.turn.counts_per_s * turn_s).floor() as i64;
        self.edges.clear();
        let up = ends > shown;
        let mut count = shown;
        while count != ends && self.edges.len() < crate::mcu::MAX_EDGES {
            // Upwards a count begins at its angle, downwards it ends at that of the next one.
            let (next, at_counts) = if up {
                (count + 1, (count + 1) as f64)
            } else {
                (count - 1, count as f64)
            };
            let in_s = (at_counts - self.turn.counts) / self.turn.counts_per_s;
            let cycles = if in_s.is_finite() {
                (in_s.clamp(0.0, turn_s) * CLOCK_HZ as f64).round() as u64
            } else {
                0
            };
            self.edges.push(Edge {
                cycle: now + cycles,
                count: next,
                levels: levels(next),
            });
            count = next;
        }
        self.mcu.set_edges(&self.edges);
    }

    fn read_drive(&mut self) {
        let drive = self.drive_by_pins();
        if drive != self.drive {
            self.drive = drive;
            self.truth.drives.push((self.mcu.cycle(), drive));
        }
    }

    /// The driver's mean voltage, from its pins and from the timer of the PWM pin. Pins that are no outputs are
    /// pulled down by the driver, except enable, which it pulls up.
    fn drive_by_pins(&self) -> Drive {
        let wiring = self.wiring;
        let compare = f64::from(self.mcu.data(wiring.pwm_compare));
        let duty = if !self.is_output(wiring.pwm) {
            0.0
        } else if self.mcu.data(wiring.pwm_control) >> 6 == 0 {
            f64::from(u8::from(self.is_high(wiring.pwm)))
        } else if wiring.pwm_fast {
            (compare + 1.0) / 256.0
        } else {
            compare / 255.0
        };
        let sign = if self.is_high(wiring.direction) {
            -1.0
        } else {
            1.0
        };
        let coasting = self.is_output(wiring.enable) && !self.is_high(wiring.enable);
        let motor_v = duty * sign * self.shaft.supply_v();
        Drive {
            motor_v: if duty == 0.0 || coasting {
                0.0
            } else {
                motor_v
            },
            coasting,
        }
    }

    fn is_output(&self, pin: Output) -> bool {
        self.mcu.data(pin.ddr) & (1 << pin.bit) != 0
    }

    fn is_high(&self, pin: Output) -> bool {
        self.is_output(pin) && self.mcu.data(pin.port) & (1 << pin.bit) != 0
    }
}

/// Cycles in s.
pub fn seconds(cycles: u64) -> f64 {
    cycles as f64 / CLOCK_HZ as f64
}
