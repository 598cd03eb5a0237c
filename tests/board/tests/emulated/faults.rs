//! Safety in case of failures.

use emulated_board::bench::SteadyShaft;
use emulated_board::board::seconds;
use emulated_board::wiring::BoardKind;
use firmware_protocol::{BoardMessage, EndReason, HostMessage, LINK_TIMEOUT_MS, MAX_WIRE};

use crate::support::{assert_true, complete, with_motor, with_shaft};

#[test]
fn a_reset_during_a_run_stops_the_motor_at_once() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        host.say(&HostMessage::Identify);
        let first = host.hello().expect("HELLO");
        host.configure(3000, false, &[(1, 4500)])
            .expect("configured");
        host.ask(&HostMessage::Start { samples: 0 })
            .expect("started");
        host.run_for(0.5).expect("it runs");
        assert_eq!(host.board.drive().motor_v, 4.5);
        host.board.reset();
        assert_eq!(host.board.drive().motor_v, 0.0);
        let ticks = host.board.truth().ticks.len();
        let reset_at = host.board.cycle();
        let second = host.hello().expect("HELLO after the reset");
        assert_ne!(first.boot_id, second.boot_id);
        host.run_for(0.5).expect("it runs");
        let truth = host.board.truth();
        assert_eq!(truth.ticks.len(), ticks, "it does not go on by itself");
        let driven = |(at, drive): &(u64, emulated_board::board::Drive)| {
            *at > reset_at && drive.motor_v != 0.0
        };
        assert!(!truth.drives.iter().any(driven));
    }
}

#[test]
fn a_lost_connection_stops_the_motor_within_half_a_second() {
    for kind in BoardKind::ALL {
        for sample_time_us in [3_000, 30_000] {
            let mut host = with_motor(kind);
            host.configure(sample_time_us, false, &[(1, -4500)])
                .expect("configured");
            host.ask(&HostMessage::Start { samples: 0 })
                .expect("started");
            host.run_for(0.3).expect("it runs");
            host.alive = false;
            host.say(&HostMessage::Alive);
            while host.board.to_receive() > 0 {
                host.run_for(0.0001).expect("it runs");
            }
            let last_byte = host.board.now_s();
            assert_eq!(host.board.drive().motor_v, -4.5);
            let (_, end) = host.until_end(1.0).expect("END");
            let reason = EndReason::LinkLost;
            assert!(matches!(end, BoardMessage::End { reason: found, .. } if found == reason));
            let (stopped, drive) = *host.board.truth().drives.last().expect("a drive");
            assert_eq!(drive.motor_v, 0.0);
            let after_s = seconds(stopped) - last_byte;
            let limit_s = f64::from(LINK_TIMEOUT_MS) / 1000.0;
            println!(
                "{kind:?} TS {sample_time_us} us: motor off {after_s:.4} s after the last byte"
            );
            assert!((0.4..limit_s).contains(&after_s), "{after_s} s");
        }
    }
}

#[test]
fn noise_on_the_line_to_the_board_is_no_valid_frame() {
    let mut host = with_motor(BoardKind::Uno);
    host.configure(3000, false, &[(1, 4500)])
        .expect("configured");
    host.ask(&HostMessage::Start { samples: 0 })
        .expect("started");
    host.alive = false;
    // Endless bytes without a frame: the board must still stop the motor.
    let mut noise = 1_u32;
    for _ in 0..700 {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        host.board
            .receive(&[(noise >> 24) as u8, (noise >> 16) as u8]);
        host.run_for(0.001).expect("it runs");
    }
    let (_, end) = host.until_end(0.01).expect("END");
    assert!(matches!(
        end,
        BoardMessage::End {
            reason: EndReason::LinkLost,
            ..
        }
    ));
    assert_eq!(host.board.drive().motor_v, 0.0);
}

#[test]
fn a_damaged_message_is_skipped_and_the_next_one_accepted() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        host.alive = false;
        let mut wire = [0; MAX_WIRE];
        let configure = HostMessage::Configure {
            sample_time_us: 5000,
            coast_at_zero: false,
        };
        let length = configure.encode(&mut wire).expect("it fits");
        for bit in 0..8 * (length - 1) {
            let mut hurt = wire;
            hurt[bit / 8] ^= 1 << (bit % 8);
            host.board.receive(&hurt[..length]);
            host.run_for(0.003).expect("it runs");
            assert_eq!(host.take_heard(), [], "bit {bit}");
            // A bit flip may remove or insert the end of the frame: the next 0 resynchronizes.
            host.board.receive(&[0]);
            assert_eq!(host.ask(&configure).expect("taken"), 0, "after bit {bit}");
        }
    }
}

#[test]
fn a_sample_time_that_is_too_short_is_flagged_and_lights_pin_13() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        host.configure(3000, false, &[(1, 4500)])
            .expect("configured");
        host.record(100).expect("a recording");
        assert!(!host.board.led(), "3 ms can be kept");
        host.configure(100, false, &[(1, 4500)])
            .expect("configured");
        let before = host.board.truth().ticks.len();
        host.ask(&HostMessage::Start { samples: 3000 })
            .expect("started");
        let (heard, end) = host.until_end(3.0).expect("END");
        assert!(heard.iter().any(|sample| sample.flags.overrun));
        assert!(host.board.led(), "pin 13");
        let BoardMessage::End { taken, dropped, .. } = end else {
            panic!("{end:?}");
        };
        assert_eq!(taken, 3000);
        assert_eq!(heard.len() as u32, taken - dropped);
        // The sent samples are true nevertheless.
        let ticks = host.board.truth().ticks[before..].to_vec();
        for sample in &heard {
            let tick = &ticks[usize::from(sample.sequence)];
            assert_eq!(i64::from(sample.counts), tick.count, "{sample:?}");
        }
        host.configure(3000, false, &[(1, 4500)])
            .expect("configured");
        let before = host.board.truth().ticks.len();
        let (heard, end) = host.record(100).expect("a recording");
        assert_eq!(end, complete(100));
        assert!(!host.board.led(), "the next START clears it");
        assert_true(&heard, &host.board.truth().ticks[before..]);
    }
}

#[test]
fn a_line_that_is_too_slow_loses_whole_frames_and_reports_it() {
    for kind in BoardKind::ALL {
        let mut host = with_motor(kind);
        host.configure(1000, false, &[(1, 4500)])
            .expect("configured");
        let (heard, end) = host.record(1000).expect("a recording");
        let BoardMessage::End { taken, dropped, .. } = end else {
            panic!("{end:?}");
        };
        assert_eq!(taken, 1000);
        assert!(
            dropped > 100,
            "the line carries 640 of 1000 frames, {dropped} dropped"
        );
        assert_eq!(heard.len() as u32, taken - dropped);
        assert_eq!(host.bad_frames, 0);
        for pair in heard.windows(2) {
            let gap = pair[1].sequence - pair[0].sequence > 1;
            assert_eq!(pair[1].flags.dropped, gap, "{pair:?}");
        }
        assert_true(&heard, &host.board.truth().ticks);
    }
}

#[test]
fn edges_at_too_high_a_rate_are_flagged_before_a_count_is_wrong() {
    for kind in BoardKind::ALL {
        for counts_per_s in [110_000.0, 115_000.0, 120_000.0] {
            let mut host = with_shaft(kind, SteadyShaft::new(counts_per_s));
            host.configure(3000, false, &[(10, 0), (1, 4500)])
                .expect("configured");
            let (heard, _) = host.record(100).expect("a recording");
            let ticks = &host.board.truth().ticks;
            let wrong = heard.iter().find(|sample| {
                let tick = &ticks[usize::from(sample.sequence)];
                i64::from(sample.counts) != tick.count
            });
            let wrong = wrong.expect("edges were lost").sequence;
            let flagged = heard.iter().find(|sample| sample.flags.encoder_error);
            assert!(flagged.is_some_and(|sample| sample.sequence <= wrong));
        }
    }
}
