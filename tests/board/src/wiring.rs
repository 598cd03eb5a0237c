//! Registers and bits of the sketch's pins on each board.

use std::path::Path;

/// The two boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum BoardKind {
    /// Arduino Uno, ATmega328P.
    Uno,
    /// Arduino Mega 2560.
    Mega,
}

/// An output pin: addresses of its port's PORT and DDR in data memory, and its bit.
#[derive(Debug, Clone, Copy)]
pub struct Output {
    /// Address of PORTx.
    pub port: u16,
    /// Address of DDRx.
    pub ddr: u16,
    /// Bit of both.
    pub bit: u8,
}

/// Registers of the signals, from the data sheets of both processors and the pin tables of the core's variants.
#[derive(Debug)]
pub struct Wiring {
    /// simavr's name of the processor.
    pub processor: &'static str,
    /// Port of pins 2 and 3, encoder A and B.
    pub encoder_port: u8,
    /// Their bits.
    pub encoder_bits: (u8, u8),
    /// Their external interrupts.
    pub encoder_interrupts: (u8, u8),
    /// Vector of Timer1's compare match A.
    pub tick_vector: u8,
    /// Pin 6.
    pub pwm: Output,
    /// TCCRnA of pin 6's timer, whose two highest bits connect the pin to the timer.
    pub pwm_control: u16,
    /// OCRnA of pin 6's timer.
    pub pwm_compare: u16,
    /// Fast PWM is on for compare + 1 of 256 steps, phase-correct PWM for compare of 255.
    pub pwm_fast: bool,
    /// Pin 12.
    pub direction: Output,
    /// Pin 8.
    pub enable: Output,
    /// Pin 13.
    pub led: Output,
}

const UNO: Wiring = Wiring {
    processor: "atmega328p",
    encoder_port: b'D',
    encoder_bits: (2, 3),
    encoder_interrupts: (0, 1),
    tick_vector: 11,
    pwm: output(0x2B, 6),
    pwm_control: 0x44,
    pwm_compare: 0x47,
    pwm_fast: true,
    direction: output(0x25, 4),
    enable: output(0x25, 0),
    led: output(0x25, 5),
};

const MEGA: Wiring = Wiring {
    processor: "atmega2560",
    encoder_port: b'E',
    encoder_bits: (4, 5),
    encoder_interrupts: (4, 5),
    tick_vector: 17,
    pwm: output(0x102, 3),
    pwm_control: 0xA0,
    pwm_compare: 0xA8,
    pwm_fast: false,
    direction: output(0x25, 6),
    enable: output(0x102, 5),
    led: output(0x25, 7),
};

/// DDR directly precedes PORT in both processors.
const fn output(port: u16, bit: u8) -> Output {
    Output {
        port,
        ddr: port - 1,
        bit,
    }
}

impl BoardKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Uno, Self::Mega];

    pub fn wiring(self) -> &'static Wiring {
        match self {
            Self::Uno => &UNO,
            Self::Mega => &MEGA,
        }
    }

    pub fn firmware(self) -> &'static Path {
        Path::new(match self {
            Self::Uno => env!("UNO_ELF"),
            Self::Mega => env!("MEGA_ELF"),
        })
    }
}
