//! Test vectors shared by crate and sketch: `vectors/frames.txt`, one frame per line, `name: message = bytes on the
//! wire`. The bytes were computed by `vectors/make.py`, which shares no code with this crate.

use firmware_protocol::{
    BoardFields, BoardMessage, Chunk, EndReason, FrameDecoder, Hello, HostMessage, MAX_WIRE,
    ProfileSegment, Refusal, Sample, SampleFlags, ShortText, profile_crc,
};

fn vector(name: &str) -> Vec<u8> {
    let line = include_str!("../vectors/frames.txt")
        .lines()
        .find_map(|line| line.strip_prefix(&format!("{name}: ")))
        .unwrap_or_else(|| panic!("no vector `{name}`"));
    line.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).expect("a hexadecimal byte"))
        .collect()
}

const FIELDS: BoardFields = BoardFields {
    current: true,
    supply: true,
    counts_16_bit: false,
};

fn board_messages() -> Vec<(&'static str, BoardFields, BoardMessage)> {
    let sample = Sample {
        sequence: 258,
        time_us: 4_294_964_296,
        counts: -720,
        command_mv: 4500,
        flags: SampleFlags {
            overrun: true,
            ..SampleFlags::default()
        },
        current_ma: None,
        supply_mv: None,
    };
    let measured = Sample {
        current_ma: Some(-100),
        supply_mv: Some(4480),
        ..sample
    };
    let hello = Hello {
        protocol_version: 1,
        firmware_version: (1, 0),
        boot_id: 0x0102_0304,
        sample_time_us: 3000,
        shortest_sample_time_us: 1500,
        counts_per_rev: 720,
        supply_mv: 4500,
        fields: BoardFields::default(),
        max_segments: 200,
        name: ShortText::new(b"uno"),
    };
    let none = BoardFields::default();
    vec![
        ("hello", none, BoardMessage::Hello(hello)),
        (
            "ack",
            none,
            BoardMessage::Ack {
                of: 0x84,
                detail: 12,
            },
        ),
        (
            "nak",
            none,
            BoardMessage::Nak {
                of: 0x82,
                reason: Refusal::SampleTime,
            },
        ),
        ("data", none, BoardMessage::Data(sample)),
        ("data_measured", FIELDS, BoardMessage::Data(measured)),
        (
            "end",
            none,
            BoardMessage::End {
                taken: 1334,
                dropped: 2,
                reason: EndReason::Stopped,
            },
        ),
        ("text", none, BoardMessage::Text(ShortText::new(b"ready"))),
    ]
}

fn host_messages() -> Vec<(&'static str, HostMessage)> {
    let segments = [
        ProfileSegment {
            samples: 100,
            command_mv: 0,
        },
        ProfileSegment {
            samples: 1234,
            command_mv: -4500,
        },
    ];
    vec![
        ("identify", HostMessage::Identify),
        (
            "configure",
            HostMessage::Configure {
                sample_time_us: 30_000,
                coast_at_zero: true,
            },
        ),
        (
            "profile",
            HostMessage::Profile {
                segments: 2,
                crc: profile_crc(segments),
            },
        ),
        (
            "chunk",
            HostMessage::Chunk(Chunk::new(0, &segments).unwrap()),
        ),
        ("start", HostMessage::Start { samples: 1334 }),
        ("stop", HostMessage::Stop),
        ("alive", HostMessage::Alive),
    ]
}

fn decode<T>(bytes: &[u8], parse: impl Fn(firmware_protocol::RawFrame<'_>) -> T) -> Vec<T> {
    let mut decoder = FrameDecoder::new();
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(frame) = decoder.push(byte) {
            found.push(parse(frame.expect("a good frame")));
        }
    }
    found
}

#[test]
fn board_messages_are_the_bytes_of_the_vectors() {
    for (name, fields, message) in board_messages() {
        let mut wire = [0; MAX_WIRE];
        let length = message.encode(&mut wire).unwrap();
        assert_eq!(wire[..length], vector(name), "{name}");
        let parsed = decode(&wire[..length], |raw| BoardMessage::parse(raw, fields));
        assert_eq!(parsed, [Ok(message)], "{name}");
    }
}

#[test]
fn host_messages_are_the_bytes_of_the_vectors() {
    for (name, message) in host_messages() {
        let mut wire = [0; MAX_WIRE];
        let length = message.encode(&mut wire).unwrap();
        assert_eq!(wire[..length], vector(name), "{name}");
        let parsed = decode(&wire[..length], HostMessage::parse);
        assert_eq!(parsed, [Ok(message)], "{name}");
    }
}

#[test]
fn every_vector_is_used() {
    let used = board_messages().len() + host_messages().len();
    let lines = include_str!("../vectors/frames.txt").lines();
    assert_eq!(lines.filter(|l| !l.starts_with('#')).count(), used);
}

#[test]
fn a_data_frame_is_eighteen_bytes() {
    assert_eq!(vector("data").len(), 18);
}

#[test]
fn protocol_md_shows_the_vectors_bytes() {
    let text = include_str!("../PROTOCOL.md");
    for name in ["hello", "data", "start", "end"] {
        let line: Vec<_> = vector(name).iter().map(|b| format!("{b:02x}")).collect();
        assert!(text.contains(&line.join(" ")), "{name}: {}", line.join(" "));
    }
}
