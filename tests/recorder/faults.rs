//! Effect of a bad line on a recording: samples sent, recorded and reported lost always agree, and no wrong sample is
//! recorded.

use std::fmt::Write as _;
use std::io::{Cursor, Read};

use crate::support::command::{RunFile, run};
use firmware_protocol::{BoardMessage, EndReason, MAX_WIRE, SampleFlags};
use motorlab::board::faults::{Faults, FaultyPort};
use motorlab::board::{Event, Expectations, Intake};
use motorlab::recording::{Flags, Observation, StatisticsGatherer};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Samples of one recording.
const SENT: u32 = 20_000;

/// Sample `k` of a reversing motor; wraps its counters like a board.
fn sample(k: u32, sample_time_us: u32) -> firmware_protocol::Sample {
    let t_s = f64::from(k) * f64::from(sample_time_us) * 1e-6;
    firmware_protocol::Sample {
        sequence: k as u16,
        time_us: (k.wrapping_mul(sample_time_us)).wrapping_add(4_200_000_000),
        counts: (3000.0 * (0.3 * t_s).sin()) as i32,
        command_mv: if (k / 1000).is_multiple_of(2) {
            4500
        } else {
            -2000
        },
        flags: SampleFlags::default(),
        current_ma: None,
        supply_mv: None,
    }
}

/// Profile on the board.
fn expectations(sample_time_us: u32) -> Expectations {
    let segments = SENT.div_ceil(1000);
    Expectations {
        sample_time_us,
        commands: (0..segments)
            .map(|k| (1000, if k.is_multiple_of(2) { 4500 } else { -2000 }))
            .collect(),
    }
}

fn push(bytes: &mut Vec<u8>, message: &BoardMessage) {
    let mut wire = [0; MAX_WIRE];
    let length = message.encode(&mut wire).expect("a message fits");
    bytes.extend_from_slice(&wire[..length]);
}

/// Result of a recording.
#[derive(Debug, Default)]
struct Outcome {
    /// Samples whose last byte left the board.
    sent: u64,
    /// Rows.
    recorded: u64,
    /// Rows that differ from what was sent.
    wrong: u64,
    /// Samples that the recorder reports as lost.
    lost: u64,
    bad_frames: u64,
    implausible: u64,
}

/// Sends a whole recording through the faults, then an undamaged END.
fn record(faults: Faults, sample_time_us: u32) -> Outcome {
    let mut bytes = Vec::new();
    let mut ends = Vec::new();
    for k in 0..SENT {
        push(&mut bytes, &BoardMessage::Data(sample(k, sample_time_us)));
        ends.push(bytes.len() as u64);
    }
    let cut = faults.hang_up_after.unwrap_or(u64::MAX);
    let mut hurt = Vec::new();
    let mut port = FaultyPort::new(Cursor::new(bytes), faults);
    let mut buffer = [0; 512];
    let gone = loop {
        match port.read(&mut buffer) {
            Ok(0) => break false,
            Ok(count) => hurt.extend_from_slice(&buffer[..count]),
            Err(error) if error.kind() == std::io::ErrorKind::TimedOut => {}
            Err(_) => break true,
        }
    };
    if !gone {
        hurt.push(0);
        let end = BoardMessage::End {
            taken: SENT,
            dropped: 0,
            reason: EndReason::Complete,
        };
        push(&mut hurt, &end);
    }
    let mut outcome = Outcome {
        sent: ends.iter().filter(|end| **end <= cut).count() as u64,
        ..Outcome::default()
    };
    let mut figures = StatisticsGatherer::new(720.0);
    let mut taken = None;
    let mut intake = Intake::default();
    intake.expect(expectations(sample_time_us));
    for block in hurt.chunks(97) {
        intake.push(0, block, |event| match event {
            Event::Sample(got) => {
                let sent = sample(got.number as u32, sample_time_us);
                let right = got.number < u64::from(SENT)
                    && got.counts == i64::from(sent.counts)
                    && got.command_mv == sent.command_mv
                    && got.device_us as u32 == sent.time_us;
                outcome.recorded += 1;
                outcome.wrong += u64::from(!right);
                if outcome.recorded == 1 {
                    figures.add_lost(got.number);
                }
                figures.add(Observation {
                    seq: Some(got.number),
                    device_us: got.device_us as i64,
                    host_us: None,
                    command: 0.0,
                    counts: got.counts,
                    flags: Flags::default(),
                });
            }
            Event::End { taken: n, .. } => taken = Some(n),
            _ => {}
        });
    }
    if let Some(taken) = taken {
        let (samples, lost, _) = figures.counters();
        figures.add_lost(u64::from(taken).saturating_sub(samples + lost));
    }
    outcome.lost = figures.statistics().lost;
    outcome.bad_frames = intake.damage().bad_frames;
    outcome.implausible = intake.damage().implausible;
    outcome
}

/// Fault kinds by name; the rate is of bytes.
fn kinds(rate: f64) -> Vec<(&'static str, Faults)> {
    let seed = (rate * 1e6) as u64;
    let faults = Faults {
        seed,
        ..Faults::default()
    };
    vec![
        (
            "drop",
            Faults {
                drop: rate,
                ..faults
            },
        ),
        (
            "flip",
            Faults {
                flip: rate,
                ..faults
            },
        ),
        (
            "duplicate",
            Faults {
                duplicate: rate,
                ..faults
            },
        ),
        (
            "all three, split",
            Faults {
                drop: rate,
                flip: rate,
                duplicate: rate,
                split: true,
                ..faults
            },
        ),
    ]
}

#[test]
fn the_sweep() {
    let mut table = String::from(
        "fault at rate (of bytes)    TS in ms   sent  recorded   lost   wrong  bad frames  implausible\n",
    );
    let mut row = |name: &str, faults: Faults, sample_time_us: u32| {
        let outcome = record(faults, sample_time_us);
        let Outcome {
            sent,
            recorded,
            wrong,
            lost,
            ..
        } = outcome;
        writeln!(
            table,
            "{name:<27} {:>8}  {sent:>5}  {recorded:>8}  {lost:>5}  {wrong:>6}  {:>10}  {:>11}",
            sample_time_us / 1000,
            outcome.bad_frames,
            outcome.implausible
        )
        .expect("memory");
        assert_eq!(wrong, 0, "{name}");
        assert_eq!(sent, recorded + lost, "{name}");
    };
    for sample_time_us in [3_000, 30_000] {
        row("none", Faults::default(), sample_time_us);
        for rate in [1e-5, 1e-4, 1e-3, 1e-2] {
            for (name, faults) in kinds(rate) {
                row(&format!("{name} {rate}"), faults, sample_time_us);
            }
        }
        for (name, faults) in [
            (
                "split at every byte",
                Faults {
                    split: true,
                    ..Faults::default()
                },
            ),
            (
                "stalled at one in 10,000",
                Faults {
                    stall: 1e-4,
                    ..Faults::default()
                },
            ),
            (
                "silent after 100 kB",
                Faults {
                    silent_after: Some(100_000),
                    ..Faults::default()
                },
            ),
            (
                "cut in a frame at 100 kB",
                Faults {
                    hang_up_after: Some(100_000),
                    ..Faults::default()
                },
            ),
        ] {
            row(name, faults, sample_time_us);
        }
    }
    insta::assert_snapshot!(table);
}

#[test]
fn frames_with_an_accidentally_valid_crc_are_rejected() {
    // Every byte after the type is random, so that one frame in 65,536 has a right CRC.
    const FRAMES: u64 = 4_000_000;
    let mut random = Pcg64::seed_from_u64(1);
    let mut intake = Intake::default();
    intake.expect(expectations(3_000));
    let mut recorded = 0_u32;
    let mut good = Vec::new();
    for k in 0..10 {
        push(&mut good, &BoardMessage::Data(sample(k, 3_000)));
    }
    intake.push(0, &good, |_| recorded += 1);
    assert_eq!(recorded, 10);
    let mut frame = [0; 18];
    let mut passed = 0;
    for _ in 0..FRAMES {
        // Content without zeros is its own COBS encoding after the code byte 17.
        frame[0] = 17;
        frame[1] = firmware_protocol::board_message::kind::DATA;
        for byte in &mut frame[2..17] {
            *byte = random.random_range(1..=255);
        }
        intake.push(0, &frame, |event| {
            if matches!(event, Event::Sample(_)) {
                passed += 1;
            }
        });
    }
    let damage = intake.damage();
    let right_crc = FRAMES - damage.bad_frames;
    assert_eq!(passed, 0);
    // 61 expected; five standard deviations.
    assert!((22..=100).contains(&right_crc), "{right_crc}");
    // All but the last one, which waits for a second that agrees with it.
    assert!(damage.implausible + 1 >= right_crc, "{damage:?}");
}

#[test]
fn the_rate_of_accepted_noise_frames_is_the_documented_one() {
    // Noise with the right CRC and the profile's command for its number.
    const FRAMES: u32 = 2_000_000;
    let mut random = Pcg64::seed_from_u64(2);
    let steady = Expectations {
        sample_time_us: 3_000,
        commands: vec![(1, 4500)],
    };
    let mut at_zero = Intake::default();
    at_zero.expect(steady);
    let mut first = Vec::new();
    push(&mut first, &BoardMessage::Data(sample(0, 3_000)));
    at_zero.push(0, &first, |_| {});
    let mut passed = 0;
    for _ in 0..FRAMES {
        let noise = firmware_protocol::Sample {
            sequence: random.random(),
            time_us: random.random(),
            counts: random.random(),
            ..sample(0, 3_000)
        };
        let mut frame = Vec::new();
        push(&mut frame, &BoardMessage::Data(noise));
        at_zero.clone().push(0, &frame, |_| passed += 1);
    }
    // docs/method/recorder.md: 7e-6 of them, 14 expected; four standard deviations.
    assert!((1..=29).contains(&passed), "{passed}");
}

#[test]
fn a_repeated_frame_is_recorded_once() {
    let mut bytes = Vec::new();
    for k in 0..100 {
        for _ in 0..1 + k % 3 {
            push(&mut bytes, &BoardMessage::Data(sample(k, 3_000)));
        }
    }
    let mut intake = Intake::default();
    intake.expect(expectations(3_000));
    let mut numbers = Vec::new();
    intake.push(0, &bytes, |event| {
        if let Event::Sample(sample) = event {
            numbers.push(sample.number);
        }
    });
    assert_eq!(numbers, (0..100).collect::<Vec<u64>>());
    assert_eq!(intake.damage().repeated, 99);
}

#[test]
fn the_first_partial_frame_is_dropped_and_is_no_damage() {
    let mut bytes = Vec::new();
    for k in 0..50 {
        push(&mut bytes, &BoardMessage::Data(sample(k, 3_000)));
    }
    // The port is opened in the middle of the first frame.
    for cut in 1..17 {
        let mut intake = Intake::default();
        intake.expect(expectations(3_000));
        let mut numbers = Vec::new();
        intake.push(0, &bytes[cut..], |event| {
            if let Event::Sample(sample) = event {
                numbers.push(sample.number);
            }
        });
        assert_eq!(numbers, (1..50).collect::<Vec<u64>>(), "{cut}");
        assert_eq!(intake.damage().bad_frames, 0, "{cut}");
    }
}

#[test]
fn a_late_board_is_accepted_when_two_samples_agree() {
    let mut bytes = Vec::new();
    for k in 0..100 {
        let mut late = sample(k, 3_000);
        // A gap of 40 ms in the board's time at sample 50, not visible in its stamps.
        late.time_us = late.time_us.wrapping_add(if k >= 50 { 40_000 } else { 0 });
        push(&mut bytes, &BoardMessage::Data(late));
    }
    let mut intake = Intake::default();
    intake.expect(expectations(3_000));
    let mut times = Vec::new();
    intake.push(0, &bytes, |event| {
        if let Event::Sample(sample) = event {
            times.push(sample.device_us);
        }
    });
    assert_eq!(times.len(), 100);
    assert_eq!(times[50] - times[49], 43_000);
}

proptest::proptest! {
    #[test]
    fn arbitrary_bytes_do_not_make_the_intake_panic(
        bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..2000),
        cuts in proptest::collection::vec(1_usize..50, 1..10),
    ) {
        let mut intake = Intake::default();
        let mut rest = &bytes[..];
        for cut in cuts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (block, after) = rest.split_at((*cut).min(rest.len()));
            intake.push(0, block, |_| {});
            rest = after;
        }
        let _ = intake.heard().to_string();
    }
}

/// Captures over a pseudo-terminal from a board whose line has these faults; every row must be that of the same board
/// on a good line.
fn capture_with(faults: &str, expected_status: i32) -> RunFile {
    let directory = tempfile::tempdir().expect("a directory");
    let capture = |board: &str, name: &str| {
        let arguments = [
            "capture",
            board,
            "--profile",
            "reversing",
            "--duration",
            "30",
            "-o",
            name,
        ];
        run(directory.path(), &arguments)
    };
    let clean = capture("virtual:?speed=max", "clean.csv");
    assert_eq!(clean.status, Some(0), "{}", clean.messages);
    let clean = RunFile::read(&directory.path().join("clean.csv"));
    let done = capture(&format!("virtual:?speed=max&seed=3&{faults}"), "hurt.csv");
    assert_eq!(
        done.status,
        Some(expected_status),
        "{faults}: {}",
        done.messages
    );
    let hurt = RunFile::read(&directory.path().join("hurt.csv"));
    assert_eq!(hurt.summary("samples") as usize, hurt.rows.len());
    let numbers = hurt.column("seq");
    let same = |name: &str, offset: f64| {
        let (clean, hurt) = (clean.column(name), hurt.column(name));
        for (number, value) in numbers.iter().zip(&hurt) {
            assert!(
                (clean[*number as usize] - value - offset).abs() < 1e-9,
                "{name}"
            );
        }
    };
    same("counts", 0.0);
    same("command_v", 0.0);
    // Time is relative to the first sample received.
    same("t_s", numbers[0] * 0.003);
    if expected_status < 3 {
        assert_eq!(hurt.rows.len() as i64 + hurt.summary("lost"), 10_000);
        // A complete run has everything that was requested.
        assert_eq!(hurt.complete(), hurt.summary("lost") == 0);
    } else {
        // Without an END losses are known up to the last sample received.
        let last = numbers.last().map_or(-1, |number| *number as i64);
        assert_eq!(hurt.rows.len() as i64 + hurt.summary("lost"), last + 1);
        assert!(!hurt.complete());
    }
    hurt
}

#[test]
fn losses_before_the_first_sample_are_counted_without_an_end_message() {
    // `capture_with` compares rows and losses with the last number; some seeds lose the first frame.
    let lost_the_first = (7..17).any(|seed| {
        let faults = format!("seed={seed}&drop=0.02&hang_up_after=20000");
        capture_with(&faults, 3).column("seq")[0] > 0.0
    });
    assert!(lost_the_first);
}

#[test]
fn a_line_that_loses_bytes() {
    let hurt = capture_with("drop=0.0005", 1);
    assert!(hurt.summary("lost") > 20 && hurt.summary("bad_frames") > 20);
}

#[test]
fn a_line_that_flips_bits_and_repeats_bytes() {
    let hurt = capture_with("flip=0.0005&duplicate=0.0005", 1);
    assert!(hurt.summary("lost") > 40);
}

#[test]
fn a_line_that_stalls_and_splits_every_byte() {
    let hurt = capture_with("stall=0.00002&stall_ms=150&split=1", 0);
    assert_eq!(hurt.summary("lost"), 0);
}

#[test]
fn an_unplugged_board_keeps_every_complete_frame() {
    let hurt = capture_with("hang_up_after=50000", 3);
    // 18 bytes per frame, after HELLO and the responses.
    let expected = (50_000 - 100) / 18;
    assert!(
        (expected - 20..=expected + 5).contains(&(hurt.rows.len() as i64)),
        "{}",
        hurt.rows.len()
    );
    assert_eq!(hurt.header["summary"]["ending"].as_str(), Some("unplugged"));
}

#[test]
fn a_silent_board_ends_the_recording() {
    let hurt = capture_with("silent_after=50000", 3);
    assert_eq!(hurt.header["summary"]["ending"].as_str(), Some("silent"));
    assert!(hurt.rows.len() > 2700);
}
