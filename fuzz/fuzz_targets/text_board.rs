//! Arbitrary bytes as output of a plain sketch: no panic, a line that is no sample gives none, and the recording is a
//! readable run file.
//!
//! The first byte selects the recorder's settings (columns, sample time, profile), the second the chunks of the rest.
#![no_main]

use std::fs;
use std::time::Duration;

use motorlab::board::Profile;
use motorlab::board::rawlog::{Reader, Writer};
use motorlab::board::text_lines::{Columns, TextDecoder};
use motorlab::recording::{SharedLive, Speed, TextRequest, read_run, replay_text};

const COLUMNS: [Option<&str>; 5] = [
    None,
    Some("t_us,counts,pwm"),
    Some("t_ms,counts,command_v,supply_v,current_a"),
    Some("counts"),
    Some("t_us,rpm,pwm"),
];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let &[told, chunk_length, ref text @ ..] = bytes else {
        return;
    };
    let columns = COLUMNS[usize::from(told % 5)].and_then(|list| Columns::parse(list).ok());
    let mut decoder = TextDecoder::new(columns.clone());
    let is_end = |byte: &&u8| matches!(byte, b'\n' | b'\r');
    let lines = text.iter().filter(is_end).count();
    let events = text.iter().filter_map(|&byte| decoder.push(byte)).count();
    assert!(events <= lines);
    if chunk_length & 1 != 0 {
        // Lines alone are a hundred times as fast as recordings.
        return;
    }

    let mut log = Vec::new();
    let mut writer = Writer::new(&mut log, &toml::Table::new()).expect("memory");
    for (k, chunk) in text.chunks(usize::from(chunk_length) + 1).enumerate() {
        writer.from_board(k as u64 * 3000, chunk).expect("memory");
    }
    let output = std::env::temp_dir().join(format!("text-board-fuzz-{}.csv", std::process::id()));
    let request = TextRequest {
        columns,
        sample_time_us: (told & 4 != 0).then_some(3000),
        counts_per_rev: 720.0,
        supply_v: 9.0,
        assumed: Vec::new(),
        integrate: None,
        profile: (told & 8 != 0)
            .then(|| Profile::named("step", 9.0, 4.0).ok())
            .flatten(),
        duration_s: 0.0,
        baud: 115_200,
        patience: Duration::from_secs(1),
        output: output.clone(),
        port: "replayed".to_owned(),
        usb: None,
    };
    let mut reader = Reader::new(log.as_slice()).expect("a log of our own");
    let live = SharedLive::default();
    if let Ok(recorded) = replay_text(&mut reader, request, Speed::Max, &live, || false)
        && recorded.captured.statistics.samples > 0
    {
        let (run, _) = read_run(&output).expect("a run file of our own");
        assert_eq!(run.len() as u64, recorded.captured.statistics.samples);
    }
    let _ = fs::remove_file(&output);
});
