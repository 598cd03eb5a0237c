//! Responses of the sketch, message by message; its frames are compared bytewise with the crate's.

use emulated_board::wiring::BoardKind;
use firmware_protocol::host_message::kind;
use firmware_protocol::{
    BoardFields, BoardMessage, Chunk, EndReason, FrameDecoder, HostMessage, MAX_WIRE,
    ProfileSegment, Refusal, encode_frame,
};

use crate::support::with_motor;

/// The test vectors of the crate.
const VECTORS: &str = include_str!("../../../../firmware-protocol/vectors/frames.txt");

fn vector(name: &str) -> Vec<u8> {
    let line = VECTORS
        .lines()
        .find_map(|line| line.strip_prefix(&format!("{name}: ")));
    line.unwrap_or_else(|| panic!("no vector {name}"))
        .split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).expect("a byte"))
        .collect()
}

/// Responses of the board within 50 ms of raw bytes.
fn answers(host: &mut emulated_board::host::Host, bytes: &[u8]) -> Vec<BoardMessage> {
    host.take_heard();
    host.board.receive(bytes);
    host.run_for(0.05).expect("it runs");
    host.take_heard()
        .into_iter()
        .map(|(_, message)| message)
        .collect()
}

fn nak(of: u8, reason: Refusal) -> Vec<BoardMessage> {
    vec![BoardMessage::Nak { of, reason }]
}

fn ack(of: u8, detail: u16) -> Vec<BoardMessage> {
    vec![BoardMessage::Ack { of, detail }]
}

#[test]
fn the_boards_decoder_accepts_the_shared_vectors_of_the_host() {
    for board in BoardKind::ALL {
        let mut host = with_motor(board);
        host.alive = false;
        assert_eq!(answers(&mut host, &vector("alive")), []);
        let hello = answers(&mut host, &vector("identify"));
        assert!(matches!(hello[..], [BoardMessage::Hello(_)]), "{hello:?}");
        assert_eq!(
            answers(&mut host, &vector("configure")),
            ack(kind::CONFIGURE, 0)
        );
        let hello = answers(&mut host, &vector("identify"));
        assert!(
            matches!(hello[..], [BoardMessage::Hello(hello)] if hello.sample_time_us == 30_000)
        );
        assert_eq!(
            answers(&mut host, &vector("stop")),
            nak(kind::STOP, Refusal::State)
        );
        assert_eq!(
            answers(&mut host, &vector("profile")),
            ack(kind::PROFILE, 0)
        );
        // The last chunk is acknowledged only if the CRC over the whole profile is that of "profile".
        assert_eq!(answers(&mut host, &vector("chunk")), ack(kind::CHUNK, 2));
        let started = answers(&mut host, &vector("start"));
        assert_eq!(started[..1], ack(kind::START, 0));
        let ended = answers(&mut host, &vector("stop"));
        let stopped = |message: &BoardMessage| matches!(message, BoardMessage::End { reason, .. } if *reason == EndReason::Stopped);
        assert!(ended.iter().any(stopped), "{ended:?}");
    }
}

#[test]
fn frames_of_the_board_equal_those_of_the_crate() {
    for board in BoardKind::ALL {
        let mut host = with_motor(board);
        host.configure(3000, false, &[(3, 0), (50, 6000), (50, -700)])
            .expect("configured");
        host.ask(&HostMessage::Start { samples: 200 })
            .expect("started");
        // Without the host's decoder: the bytes themselves are compared.
        let mut raw = Vec::new();
        for _ in 0..800 {
            let now = host.board.cycle();
            host.board.run_until(now + 16_000).expect("it runs");
            raw.extend(host.board.take_sent().iter().map(|sent| sent.byte));
            host.say(&HostMessage::Alive);
        }
        let mut frames = 0;
        for frame in raw.split_inclusive(|&byte| byte == 0) {
            let mut decoder = FrameDecoder::new();
            let mut message = None;
            for &byte in frame {
                if let Some(decoded) = decoder.push(byte) {
                    let decoded = decoded.expect("an undamaged frame");
                    message = Some(BoardMessage::parse(decoded, BoardFields::default()));
                }
            }
            let message = message.expect("a frame").expect("a message");
            let mut wire = [0; MAX_WIRE];
            let length = message.encode(&mut wire).expect("it fits");
            assert_eq!(frame, &wire[..length], "{message:?}");
            frames += 1;
        }
        assert!(frames > 190, "{frames}");
    }
}

#[test]
fn invalid_requests_are_refused_with_a_reason() {
    for board in BoardKind::ALL {
        let mut host = with_motor(board);
        let raw = |kind: u8, body: &[u8]| {
            let mut wire = [0; MAX_WIRE];
            let length = encode_frame(kind, body, &mut wire).expect("it fits");
            wire[..length].to_vec()
        };
        host.alive = false;
        let cases = [
            (raw(0x90, &[]), nak(0x90, Refusal::Unknown)),
            (
                raw(kind::CONFIGURE, &[1, 2]),
                nak(kind::CONFIGURE, Refusal::Length),
            ),
            (raw(kind::START, &[]), nak(kind::START, Refusal::Length)),
            (
                raw(kind::CHUNK, &[0, 0, 1, 0, 2]),
                nak(kind::CHUNK, Refusal::Length),
            ),
            (
                raw(kind::CONFIGURE, &[99, 0, 0, 0, 0]),
                nak(kind::CONFIGURE, Refusal::SampleTime),
            ),
            (
                raw(kind::CONFIGURE, &[0xFF; 5]),
                nak(kind::CONFIGURE, Refusal::SampleTime),
            ),
            (
                raw(kind::PROFILE, &[0xFF; 4]),
                nak(kind::PROFILE, Refusal::ProfileTooLong),
            ),
            (raw(kind::PROFILE, &[2, 0, 0, 0]), ack(kind::PROFILE, 0)),
            (
                raw(kind::START, &[1, 0, 0, 0]),
                nak(kind::START, Refusal::State),
            ),
            (
                raw(kind::CHUNK, &[1, 0, 1, 0, 1, 0]),
                nak(kind::CHUNK, Refusal::ChunkOrder),
            ),
            (raw(kind::CHUNK, &[0, 0, 1, 0, 1, 0]), ack(kind::CHUNK, 1)),
            (raw(kind::CHUNK, &[0, 0, 1, 0, 1, 0]), ack(kind::CHUNK, 1)),
            (
                raw(kind::CHUNK, &[1, 0, 1, 0, 1, 0]),
                nak(kind::CHUNK, Refusal::ProfileCrc),
            ),
            (
                raw(kind::START, &[1, 0, 0, 0]),
                nak(kind::START, Refusal::State),
            ),
        ];
        for (bytes, expected) in cases {
            assert_eq!(answers(&mut host, &bytes), expected, "{bytes:02x?}");
        }
    }
}

#[test]
fn during_a_recording_only_stop_alive_and_identify_are_accepted() {
    for board in BoardKind::ALL {
        let mut host = with_motor(board);
        host.configure(30_000, false, &[(1, 4500)])
            .expect("configured");
        host.ask(&HostMessage::Start { samples: 0 })
            .expect("started");
        let segments = [ProfileSegment {
            samples: 1,
            command_mv: 1,
        }];
        let refused = [
            HostMessage::Configure {
                sample_time_us: 3000,
                coast_at_zero: false,
            },
            HostMessage::Profile {
                segments: 1,
                crc: 0,
            },
            HostMessage::Chunk(Chunk::new(0, &segments).expect("a chunk")),
            HostMessage::Start { samples: 1 },
        ];
        for message in refused {
            host.say(&message);
            let reason = host.hear("NAK", 0.1, |heard| match heard {
                BoardMessage::Nak { of, reason } if *of == message.kind() => Some(*reason),
                _ => None,
            });
            assert_eq!(reason.expect("a refusal"), Refusal::State);
        }
        host.say(&HostMessage::Identify);
        host.hello().expect("HELLO during a run");
        host.say(&HostMessage::Stop);
        let (_, end) = host.until_end(0.2).expect("END");
        let ticks = host.board.truth().ticks.len() as u32;
        let stopped = BoardMessage::End {
            taken: ticks,
            dropped: 0,
            reason: EndReason::Stopped,
        };
        assert_eq!(end, stopped);
        assert_eq!(host.board.drive().motor_v, 0.0);
    }
}
