//! The processor: a safe interface to simavr.

use std::ffi::{CString, c_char, c_int};
use std::path::Path;
use std::ptr::NonNull;

use crate::wiring::Wiring;

/// Clock frequency of both boards in Hz.
pub const CLOCK_HZ: u64 = 16_000_000;

/// Most edges in one call.
pub const MAX_EDGES: usize = 1024;

/// Most events in one call.
const MAX_EVENTS: usize = 4096;

/// A change of the encoder's pins.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Edge {
    /// Its cycle.
    pub cycle: u64,
    /// Counts of the encoder from then on.
    pub count: i64,
    /// Bit 0: channel A, bit 1: channel B.
    pub levels: u8,
}

/// Kind of event in the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The serial port began to send a byte.
    Byte(u8),
    /// Timer1 matched: a sample is due.
    TickDue,
    /// Timer1's interrupt began: the sample is taken, without further edges.
    TickEntered,
}

/// An event in the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// Its cycle.
    pub cycle: u64,
    /// Counts at the encoder's pins until then.
    pub count: i64,
    /// Its kind.
    pub kind: EventKind,
}

#[derive(Clone, Copy, Default)]
#[repr(C)]
struct RawEvent {
    cycle: u64,
    count: i64,
    kind: u8,
    byte: u8,
}

#[repr(C)]
struct Shim {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    fn shim_new(
        processor: *const c_char,
        elf: *const c_char,
        port: c_char,
        pin_a: u8,
        pin_b: u8,
        interrupt_a: u8,
        interrupt_b: u8,
        tick_vector: u8,
    ) -> *mut Shim;
    fn shim_free(shim: *mut Shim);
    fn shim_reset(shim: *mut Shim);
    fn shim_cycle(shim: *const Shim) -> u64;
    fn shim_data(shim: *const Shim, address: u16) -> u8;
    fn shim_set_data(shim: *mut Shim, address: u16, value: u8);
    fn shim_count(shim: *const Shim) -> i64;
    fn shim_receive(shim: *mut Shim, byte: u8);
    fn shim_set_edges(shim: *mut Shim, edges: *const Edge, count: u32);
    fn shim_run(shim: *mut Shim, until: u64) -> c_int;
    fn shim_events(shim: *mut Shim, into: *mut RawEvent) -> c_int;
    fn shim_symbol(shim: *const Shim, name: *const c_char) -> u16;
}

/// Errors of the processor.
#[derive(Debug, thiserror::Error)]
pub enum McuError {
    /// simavr rejects the firmware.
    #[error("simavr cannot run {elf} on a {processor}")]
    NotLoaded {
        /// The firmware.
        elf: String,
        /// The processor.
        processor: &'static str,
    },
    /// The firmware crashed.
    #[error("the processor stopped at cycle {cycle} (simavr's state {state})")]
    Stopped {
        /// Cycle.
        cycle: u64,
        /// State number of simavr.
        state: i32,
    },
    /// More events in one call than the buffer holds.
    #[error("too many events before cycle {cycle}")]
    TooManyEvents {
        /// Cycle.
        cycle: u64,
    },
}

/// A processor with its firmware.
#[derive(Debug)]
pub struct Mcu {
    shim: NonNull<Shim>,
    buffer: Vec<RawEvent>,
}

impl std::fmt::Debug for RawEvent {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} at {}", self.kind, self.cycle)
    }
}

// SAFETY: a simavr instance has no state outside itself; one thread at a time uses it.
unsafe impl Send for Mcu {}

impl Mcu {
    /// Powers the board up with `elf` in its flash.
    pub fn new(wiring: &Wiring, elf: &Path) -> Result<Self, McuError> {
        let not_loaded = || McuError::NotLoaded {
            elf: elf.display().to_string(),
            processor: wiring.processor,
        };
        let processor = CString::new(wiring.processor).map_err(|_| not_loaded())?;
        let path = CString::new(elf.as_os_str().as_encoded_bytes()).map_err(|_| not_loaded())?;
        // SAFETY: both strings live through the call and end with 0; the C side copies them.
        let shim = unsafe {
            shim_new(
                processor.as_ptr(),
                path.as_ptr(),
                wiring.encoder_port as c_char,
                wiring.encoder_bits.0,
                wiring.encoder_bits.1,
                wiring.encoder_interrupts.0,
                wiring.encoder_interrupts.1,
                wiring.tick_vector,
            )
        };
        Ok(Self {
            shim: NonNull::new(shim).ok_or_else(not_loaded)?,
            buffer: vec![RawEvent::default(); MAX_EVENTS],
        })
    }

    /// Cycles since power-up.
    pub fn cycle(&self) -> u64 {
        // SAFETY: `shim` is valid until drop.
        unsafe { shim_cycle(self.shim.as_ptr()) }
    }

    /// A byte of the data memory: registers, I/O and RAM.
    pub fn data(&self, address: u16) -> u8 {
        // SAFETY: `shim` is valid until drop, and simavr's data memory has room for 16-bit addresses
        // below `ramend`, the only ones that the wiring and the firmware's symbols name.
        unsafe { shim_data(self.shim.as_ptr(), address) }
    }

    /// Overwrites a variable of the firmware, little-endian; `false` if there is none of this name.
    pub fn poke(&mut self, symbol: &str, value: u32) -> bool {
        let Some(address) = self.symbol(symbol) else {
            return false;
        };
        for (offset, byte) in (0..).zip(value.to_le_bytes()) {
            // SAFETY: as in `data`.
            unsafe { shim_set_data(self.shim.as_ptr(), address + offset, byte) };
        }
        true
    }

    fn symbol(&self, name: &str) -> Option<u16> {
        let name = CString::new(name).ok()?;
        // SAFETY: `shim` is valid until drop, `name` through the call.
        let address = unsafe { shim_symbol(self.shim.as_ptr(), name.as_ptr()) };
        (address != 0).then_some(address)
    }

    pub fn count(&self) -> i64 {
        // SAFETY: `shim` is valid until drop.
        unsafe { shim_count(self.shim.as_ptr()) }
    }

    pub fn reset(&mut self) {
        // SAFETY: `shim` is valid until drop.
        unsafe { shim_reset(self.shim.as_ptr()) }
    }

    /// A byte arrives at the serial port.
    pub fn receive(&mut self, byte: u8) {
        // SAFETY: `shim` is valid until drop.
        unsafe { shim_receive(self.shim.as_ptr(), byte) }
    }

    /// Sets the coming edges, in order of time; pending earlier ones are discarded.
    pub fn set_edges(&mut self, edges: &[Edge]) {
        let edges = &edges[..edges.len().min(MAX_EDGES)];
        // SAFETY: the slice is valid through the call, which copies it.
        unsafe { shim_set_edges(self.shim.as_ptr(), edges.as_ptr(), edges.len() as u32) }
    }

    /// Runs until `cycle`, or the end of the instruction that passes it, and returns the events.
    pub fn run(&mut self, until: u64, events: &mut Vec<Event>) -> Result<(), McuError> {
        // SAFETY: `shim` is valid until drop; the buffer has room for all that the C side keeps.
        let (state, count) = unsafe {
            let state = shim_run(self.shim.as_ptr(), until);
            (
                state,
                shim_events(self.shim.as_ptr(), self.buffer.as_mut_ptr()),
            )
        };
        let cycle = self.cycle();
        let count = usize::try_from(count).map_err(|_| McuError::TooManyEvents { cycle })?;
        events.extend(self.buffer[..count].iter().map(|raw| Event {
            cycle: raw.cycle,
            count: raw.count,
            kind: match raw.kind {
                0 => EventKind::Byte(raw.byte),
                1 => EventKind::TickDue,
                _ => EventKind::TickEntered,
            },
        }));
        match state {
            0 => Ok(()),
            state => Err(McuError::Stopped { cycle, state }),
        }
    }
}

impl Drop for Mcu {
    fn drop(&mut self) {
        // SAFETY: made by `shim_new`, freed once.
        unsafe { shim_free(self.shim.as_ptr()) }
    }
}
