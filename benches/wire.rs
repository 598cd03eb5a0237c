//! Decode throughput: 100,000 DATA frames (1.8 MB) read from a file in chunks of 4096 bytes.
//!
//! `cargo bench --bench wire`. `merely_read` is the upper bound: the same reads without processing. Each further
//! benchmark adds a layer: frames (COBS, CRC-16), messages (every field in range), samples (counters unwrapped,
//! compared with the previous sample). A serial line at 115200 baud carries 0.0115 MB/s.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use firmware_protocol::{BoardFields, BoardMessage, FrameDecoder, MAX_WIRE, Sample, SampleFlags};
use motorlab::board::{Event, Expectations, Intake};

fn main() {
    divan::main();
}

const SAMPLES: u32 = 100_000;
const SAMPLE_TIME_US: u32 = 3_000;
const COMMAND_MV: i16 = 4_500;

/// Bytes of a board during a recording of a turning motor, so that all fields change.
fn stream() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut wire = [0; MAX_WIRE];
    for k in 0..SAMPLES {
        let message = BoardMessage::Data(Sample {
            sequence: k as u16,
            time_us: k.wrapping_mul(SAMPLE_TIME_US),
            counts: (f64::from(k) * 1.717) as i32,
            command_mv: COMMAND_MV,
            flags: SampleFlags::default(),
            current_ma: None,
            supply_mv: None,
        });
        let length = message.encode(&mut wire).expect("a DATA frame");
        bytes.extend_from_slice(&wire[..length]);
    }
    bytes
}

/// Measures one decoder; `take` processes each chunk, `done` returns its result.
fn over_file<S>(
    bencher: Bencher<'_, '_>,
    start: impl Fn() -> S + Sync,
    take: impl Fn(&mut S, &[u8]) + Sync,
    taken: impl Fn(&S) -> u32,
) {
    let bytes = stream();
    let mut file = tempfile::tempfile().expect("a file");
    std::io::Write::write_all(&mut file, &bytes).expect("room");
    let run = |file: &mut File| {
        let mut state = start();
        let mut chunk = [0; 4096];
        file.seek(SeekFrom::Start(0)).expect("its start");
        loop {
            match file.read(&mut chunk).expect("a file") {
                0 => break state,
                length => take(&mut state, black_box(&chunk[..length])),
            }
        }
    };
    assert_eq!(taken(&run(&mut file)), SAMPLES);
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench_local(|| black_box(run(&mut file)));
}

#[divan::bench]
fn a_merely_read(bencher: Bencher<'_, '_>) {
    // Nothing is decoded here: the count is assumed.
    over_file(bencher, || (), |_, _| (), |()| SAMPLES);
}

#[divan::bench]
fn b_count_zeros(bencher: Bencher<'_, '_>) {
    let zeros = |count: &mut u32, chunk: &[u8]| {
        *count += chunk.iter().filter(|&&byte| byte == 0).count() as u32;
    };
    over_file(bencher, || 0, zeros, |&count| count);
}

#[divan::bench]
fn c_frames(bencher: Bencher<'_, '_>) {
    over_file(
        bencher,
        || (FrameDecoder::new(), 0),
        |(decoder, count), chunk| {
            for &byte in chunk {
                *count += u32::from(matches!(decoder.push(byte), Some(Ok(_))));
            }
        },
        |(_, count)| *count,
    );
}

#[divan::bench]
fn d_messages(bencher: Bencher<'_, '_>) {
    over_file(
        bencher,
        || (FrameDecoder::new(), 0),
        |(decoder, count), chunk| {
            for &byte in chunk {
                if let Some(Ok(frame)) = decoder.push(byte) {
                    let message = BoardMessage::parse(frame, BoardFields::default());
                    *count += u32::from(matches!(message, Ok(BoardMessage::Data(_))));
                }
            }
        },
        |(_, count)| *count,
    );
}

#[divan::bench]
fn e_samples(bencher: Bencher<'_, '_>) {
    over_file(
        bencher,
        || {
            let mut intake = Intake::default();
            intake.expect(Expectations {
                sample_time_us: SAMPLE_TIME_US,
                commands: vec![(u64::from(SAMPLES), COMMAND_MV)],
            });
            (intake, 0)
        },
        |(intake, count), chunk| {
            intake.push(0, chunk, |event| {
                *count += u32::from(matches!(event, Event::Sample(_)));
            });
        },
        |(_, count)| *count,
    );
}
