//! Recordings without faults.

use emulated_board::mcu::CLOCK_HZ;
use emulated_board::wiring::BoardKind;
use firmware_protocol::SampleFlags;
use motorlab::motor::{Drive, Motor, SimulationOptions, simulate};
use motorlab::recording::CommandKind;

use crate::support::{assert_true, complete, micros, with_motor};

/// Step responses of 2 s from rest: sample time in us, samples, samples at rest before the step, command.
const STEPS: [(u32, u16, u16, i16); 4] = [
    (3_000, 667, 100, 4500),
    (3_000, 667, 100, -4500),
    (30_000, 67, 10, 4500),
    (30_000, 67, 10, -4500),
];

#[test]
fn every_sample_of_a_step_equals_the_truth() {
    for kind in BoardKind::ALL {
        for (sample_time_us, samples, rest, command_mv) in STEPS {
            let mut host = with_motor(kind);
            let profile = [(rest, 0), (samples - rest, command_mv)];
            host.configure(sample_time_us, false, &profile)
                .expect("configured");
            let (heard, end) = host.record(u32::from(samples)).expect("a recording");
            assert_eq!(end, complete(u32::from(samples)));
            assert_eq!(heard.len(), usize::from(samples));
            let ticks = &host.board.truth().ticks;
            assert_eq!(ticks.len(), heard.len());
            assert_true(&heard, ticks);
            for (k, sample) in (0..samples).zip(&heard) {
                let commanded = if k < rest { 0 } else { command_mv };
                assert_eq!(sample.sequence, k);
                assert_eq!(sample.command_mv, commanded);
                assert_eq!(sample.flags, SampleFlags::default(), "{sample:?}");
            }
            for pair in ticks.windows(2) {
                let cycles = u64::from(sample_time_us) * CLOCK_HZ / 1_000_000;
                // simavr reports a match at the end of an instruction: some cycles of 16 per us.
                assert!((pair[1].due - pair[0].due).abs_diff(cycles) <= 8);
            }
            let late = ticks.iter().map(|tick| tick.entered - tick.due).max();
            assert!(micros(late.unwrap_or(0)) < 30.0, "{late:?} cycles late");
            assert_eq!(host.bad_frames, 0);
            let steps: Vec<f64> = heard
                .windows(2)
                .map(|pair| f64::from(pair[1].time_us - pair[0].time_us))
                .collect();
            let (shortest, longest) = extremes(&steps);
            println!(
                "{kind:?} TS {sample_time_us} us, {command_mv} mV: device dt {shortest} to {longest} us, \
                 latest tick {:.1} us, {} counts",
                micros(late.unwrap_or(0)),
                heard[heard.len() - 1].counts
            );
            assert!(longest - shortest <= 24.0);
        }
    }
}

fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), &value| (least.min(value), most.max(value)),
    )
}

/// K V / R - tau_C over K^2 / R + b: (0.315 - 0.02) / (0.049 + 0.01) = 5.00 rad/s.
#[test]
fn the_handouts_motor_turns_steadily_at_5_rad_s() {
    for kind in BoardKind::ALL {
        for sign in [1.0, -1.0] {
            let mut host = with_motor(kind);
            let command_mv = if sign > 0.0 { 4500 } else { -4500 };
            host.configure(3000, false, &[(1, command_mv)])
                .expect("configured");
            let (heard, _) = host.record(1000).expect("a recording");
            let turned = f64::from(heard[999].counts - heard[499].counts);
            let speed_rad_s = turned / 720.0 * std::f64::consts::TAU / (500.0 * 0.003);
            // One count in 1.5 s is 0.006 rad/s.
            assert!((speed_rad_s - sign * 5.0).abs() < 0.007, "{speed_rad_s}");
        }
    }
}

#[test]
fn recordings_of_the_board_agree_with_the_simulation() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        let profile = [
            (50, 0),
            (100, 4500),
            (100, -4500),
            (50, 0),
            (100, 2250),
            (100, -1500),
        ];
        host.configure(3000, false, &profile).expect("configured");
        let (heard, _) = host.record(500).expect("a recording");
        let t_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.003).collect();
        let command: Vec<f64> = heard
            .iter()
            .map(|sample| f64::from(sample.command_mv) / 1000.0)
            .collect();
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let run = simulate(&Motor::default(), &drive, &SimulationOptions::default())
            .expect("a simulation");
        // PWM has 255 steps and the command is applied some 30 us after the tick: a few counts over the run.
        let apart = heard
            .iter()
            .zip(&run.counts)
            .map(|(sample, counts)| (i64::from(sample.counts) - counts).abs())
            .max();
        assert!(apart <= Some(3), "{apart:?} counts apart");
        println!("{kind:?}: at most {apart:?} counts from the simulation");
    }
}

#[test]
fn recordings_from_the_same_initial_state_are_bit_identical() {
    let record = || {
        let mut host = with_motor(BoardKind::Uno);
        host.configure(3000, false, &[(10, 0), (90, 4500), (100, -3000)])
            .expect("configured");
        let heard = host.record(300).expect("a recording");
        (heard, host.board.truth().clone())
    };
    assert_eq!(record(), record());
}

/// micros() counts Timer0's overflows, 1024 us each, in 32 bits: it wraps after 2^22 of them.
#[test]
fn time_continues_through_the_wrap_of_micros() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        host.configure(3000, false, &[(1, 4500)])
            .expect("configured");
        assert!(host.board.poke("timer0_overflow_count", (1 << 22) - 500));
        let (heard, end) = host.record(400).expect("a recording");
        assert_eq!(end, complete(400));
        let wraps = heard
            .windows(2)
            .filter(|pair| pair[1].time_us < pair[0].time_us)
            .count();
        assert_eq!(wraps, 1);
        assert_true(&heard, &host.board.truth().ticks);
    }
}

#[test]
fn the_driver_applies_the_command() {
    for kind in BoardKind::ALL {
        let commands = [
            4500, 4482, 3000, 1000, 100, 36, 0, -36, -1000, -3000, -4482, -4500,
        ];
        let mut host = with_motor(kind);
        let profile = commands.map(|command_mv| (1, command_mv));
        host.configure(30_000, false, &profile).expect("configured");
        host.record(commands.len() as u32 + 1).expect("a recording");
        let truth = host.board.truth();
        for (tick, command_mv) in truth.ticks.iter().zip(commands) {
            let after = tick.entered + CLOCK_HZ / 100;
            let drive = truth.drives.iter().rev().find(|(cycle, _)| *cycle <= after);
            let motor_v = drive.map_or(0.0, |(_, drive)| drive.motor_v);
            // Half a step of 4.5 V / 255.
            assert!(
                (motor_v - f64::from(command_mv) / 1000.0).abs() <= 0.0089,
                "{kind:?}: {motor_v} V of {command_mv} mV"
            );
        }
    }
}

#[test]
fn zero_volts_brake_the_motor_or_let_it_coast() {
    for kind in BoardKind::ALL {
        for coast in [false, true] {
            let mut host = with_motor(kind);
            host.configure(3000, coast, &[(20, 4500), (20, 0), (20, -4500), (20, 0)])
                .expect("configured");
            host.record(100).expect("a recording");
            assert!(
                !host.board.drive().coasting,
                "after END the motor is shorted"
            );
            let coasted = host
                .board
                .truth()
                .drives
                .iter()
                .any(|(_, drive)| drive.coasting);
            assert_eq!(coasted, coast);
        }
    }
}
