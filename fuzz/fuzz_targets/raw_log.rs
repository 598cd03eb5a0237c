//! Arbitrary bytes as a raw log: no panic, events survive writing and reading, and the replay is a readable run file.
#![no_main]

use std::fs;

use motorlab::board::Profile;
use motorlab::board::rawlog::{Event, Reader, Writer};
use motorlab::recording::{CaptureRequest, SharedLive, Speed, read_run, replay};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(mut reader) = Reader::new(bytes) else {
        return;
    };
    let mut events = Vec::new();
    while let Ok(Some(event)) = reader.next_event() {
        events.push(event);
    }
    let mut log = Vec::new();
    let mut writer = Writer::new(&mut log, &toml::Table::new()).expect("memory");
    for (at_us, event) in &events {
        match event {
            Event::FromBoard(bytes) => writer.from_board(*at_us, bytes),
            Event::ToBoard(bytes) => writer.to_board(*at_us, bytes),
            Event::HangUp => writer.hang_up(*at_us),
        }
        .expect("memory");
    }
    // Events without bytes are not written.
    events.retain(
        |(_, event)| !matches!(event, Event::FromBoard(b) | Event::ToBoard(b) if b.is_empty()),
    );
    let mut again = Reader::new(log.as_slice()).expect("a log of our own");
    for event in &events {
        assert_eq!(
            again.next_event().expect("a line of our own").as_ref(),
            Some(event)
        );
    }
    assert!(again.next_event().expect("the end").is_none() && !again.torn());

    let output = std::env::temp_dir().join(format!("raw-log-fuzz-{}.csv", std::process::id()));
    let request = CaptureRequest {
        sample_time_us: 0,
        profile: Profile {
            name: "replayed".to_owned(),
            segments: Vec::new(),
        },
        samples: 0,
        counts_per_rev: None,
        supply_v: None,
        output: output.clone(),
        port: "replayed".to_owned(),
        usb: None,
        further: toml::Table::new(),
    };
    let mut reader = Reader::new(bytes).expect("it was read before");
    let replayed = replay(
        &mut reader,
        &request,
        Speed::Max,
        &SharedLive::default(),
        || false,
    );
    if let Ok(captured) = replayed
        && captured.statistics.samples > 0
    {
        read_run(&output).expect("a run file of our own");
    }
    let _ = fs::remove_file(&output);
});
