//! A board with the handout's motor, and checks of its recordings.

use emulated_board::bench::{MotorShaft, Shaft};
use emulated_board::board::Board;
use emulated_board::host::Host;
use emulated_board::mcu::CLOCK_HZ;
use emulated_board::truth::Tick;
use emulated_board::wiring::BoardKind;
use firmware_protocol::{BoardMessage, EndReason, Sample};
use motorlab::motor::Motor;

/// A board after HELLO, with the handout's motor.
pub fn with_motor(kind: BoardKind) -> Host {
    with_shaft(
        kind,
        MotorShaft::new(&Motor::default()).expect("the default motor"),
    )
}

/// A board after HELLO, with any shaft.
pub fn with_shaft(kind: BoardKind, shaft: impl Shaft + 'static) -> Host {
    let mut host = Host::new(Board::new(kind, shaft).expect("a board"));
    host.hello().expect("HELLO");
    host
}

/// END of a recording without losses.
pub fn complete(samples: u32) -> BoardMessage {
    BoardMessage::End {
        taken: samples,
        dropped: 0,
        reason: EndReason::Complete,
    }
}

pub fn micros(cycles: u64) -> f64 {
    cycles as f64 * 1e6 / CLOCK_HZ as f64
}

/// Compares every sample with its tick: the count is exact, and time differences are true within micros()'s
/// resolution of 4 us and the few us after the tick at which it is read.
pub fn assert_true(samples: &[Sample], ticks: &[Tick]) {
    assert!(!samples.is_empty() && samples.len() <= ticks.len());
    let mut index = usize::from(samples[0].sequence);
    let (first, first_tick) = (samples[0], ticks[index]);
    let mut before = first.sequence;
    for sample in samples {
        index += usize::from(sample.sequence.wrapping_sub(before));
        before = sample.sequence;
        let tick = &ticks[index];
        assert_eq!(i64::from(sample.counts), tick.count, "{sample:?} {tick:?}");
        let shown = tick.angle_counts.floor() as i64;
        // An edge is detected at the end of an instruction, within 1 us.
        let moved = tick.counts_per_s.abs() * 1e-6 + 1e-3;
        let near_edge = (tick.angle_counts - tick.angle_counts.round()).abs() < moved;
        assert!(shown == tick.count || near_edge, "{tick:?}");
        let device_us = f64::from(sample.time_us.wrapping_sub(first.time_us));
        let true_us = micros(tick.entered - first_tick.entered);
        assert!((device_us - true_us).abs() <= 12.0, "{sample:?} {tick:?}");
    }
}
