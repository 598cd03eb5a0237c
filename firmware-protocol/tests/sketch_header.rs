//! The sketch's header of wire constants agrees with the crate.

use firmware_protocol::board_message::kind as board;
use firmware_protocol::host_message::kind as host;
use firmware_protocol::{
    BAUD, EndReason, LINK_TIMEOUT_MS, MAGIC, MAX_WIRE, PROTOCOL_VERSION, Refusal, SampleFlags,
};

/// Every `#define MLAB_NAME value` of the header.
fn defines() -> Vec<(&'static str, &'static str)> {
    include_str!("../arduino/motorlab/motorlab_wire.h")
        .lines()
        .filter_map(|line| line.strip_prefix("#define MLAB_")?.split_once(' '))
        .collect()
}

fn flags(set: impl Fn(&mut SampleFlags)) -> u32 {
    let mut flags = SampleFlags::default();
    set(&mut flags);
    u32::from(flags.bits())
}

#[test]
fn the_header_holds_the_crates_constants_and_no_others() {
    let mut wanted = vec![
        ("PROTOCOL_VERSION", u32::from(PROTOCOL_VERSION)),
        ("BAUD", BAUD),
        ("MAX_WIRE", MAX_WIRE as u32),
        ("LINK_TIMEOUT_MS", LINK_TIMEOUT_MS),
        ("HELLO", u32::from(board::HELLO)),
        ("ACK", u32::from(board::ACK)),
        ("NAK", u32::from(board::NAK)),
        ("DATA", u32::from(board::DATA)),
        ("END", u32::from(board::END)),
        ("TEXT", u32::from(board::TEXT)),
        ("IDENTIFY", u32::from(host::IDENTIFY)),
        ("CONFIGURE", u32::from(host::CONFIGURE)),
        ("PROFILE", u32::from(host::PROFILE)),
        ("CHUNK", u32::from(host::CHUNK)),
        ("START", u32::from(host::START)),
        ("STOP", u32::from(host::STOP)),
        ("ALIVE", u32::from(host::ALIVE)),
        ("FLAG_OVERRUN", flags(|f| f.overrun = true)),
        ("FLAG_DROPPED", flags(|f| f.dropped = true)),
        ("FLAG_ENCODER_ERROR", flags(|f| f.encoder_error = true)),
        ("FLAG_SATURATED", flags(|f| f.saturated = true)),
        ("END_COMPLETE", EndReason::Complete as u32),
        ("END_STOPPED", EndReason::Stopped as u32),
        ("END_LINK_LOST", EndReason::LinkLost as u32),
        ("REFUSED_UNKNOWN", Refusal::Unknown as u32),
        ("REFUSED_LENGTH", Refusal::Length as u32),
        ("REFUSED_STATE", Refusal::State as u32),
        ("REFUSED_SAMPLE_TIME", Refusal::SampleTime as u32),
        ("REFUSED_PROFILE_TOO_LONG", Refusal::ProfileTooLong as u32),
        ("REFUSED_CHUNK_ORDER", Refusal::ChunkOrder as u32),
        ("REFUSED_PROFILE_CRC", Refusal::ProfileCrc as u32),
    ];
    let number = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => text.parse(),
    };
    for (name, value) in defines() {
        if name == "MAGIC" {
            assert_eq!(value.trim_matches('"').as_bytes(), MAGIC);
            continue;
        }
        let place = wanted.iter().position(|(wanted, _)| *wanted == name);
        let place = place.unwrap_or_else(|| panic!("the crate has no {name}"));
        let (_, expected) = wanted.swap_remove(place);
        assert_eq!(number(value), Ok(expected), "{name}");
    }
    assert!(wanted.is_empty(), "the header lacks {wanted:?}");
}

#[test]
fn the_crate_contains_every_file_of_the_sketch() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("arduino/motorlab");
    let mut there: Vec<String> = std::fs::read_dir(folder)
        .expect("the sketch")
        .map(|entry| {
            entry
                .expect("a file")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    let mut handed_out = firmware_protocol::sketch::FILES.map(|(name, _)| name.to_owned());
    there.sort();
    handed_out.sort();
    assert_eq!(there, handed_out);
}
