//! A recording from a virtual board over a pseudo-terminal, as by `motorlab capture virtual:`.

use std::path::Path;
use std::time::Duration;

use motorlab::board::{
    Bench, Board, BoardOptions, Pace, Profile, VirtualBoard, VirtualBoardOptions,
};
use motorlab::recording::{CaptureRequest, Captured, SharedLive, capture};

/// Records `samples` samples of 3 ms as fast as the line transmits them, into `output`.
pub fn record(bench: impl Bench + 'static, samples: u32, output: &Path) -> Captured {
    let options = VirtualBoardOptions {
        pace: Pace::AsFastAsPossible,
        ..VirtualBoardOptions::default()
    };
    let plugged = VirtualBoard::spawn(bench, options).expect("a pseudo-terminal");
    let duration_s = f64::from(samples) * 0.003;
    let request = CaptureRequest {
        sample_time_us: 3_000,
        profile: Profile::named("step", 4.5, duration_s).expect("a built-in profile"),
        samples,
        counts_per_rev: None,
        supply_v: None,
        output: output.to_owned(),
        port: "virtual:".to_owned(),
        usb: None,
        further: toml::Table::new(),
    };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .expect("a runtime");
    let captured = runtime.block_on(async {
        let options = BoardOptions {
            baud: firmware_protocol::BAUD,
            patience: Duration::from_secs(6),
            log: None,
        };
        let mut board = Board::open(plugged.path(), options).await.expect("a board");
        let never = std::future::pending();
        capture(&mut board, &request, &SharedLive::default(), never).await
    });
    captured.expect("a recording")
}
