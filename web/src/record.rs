//! Recording from the virtual board or from a board at the browser's serial port, with the program's recorder.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use firmware_protocol::BAUD;
use motorlab::board::text_lines::Columns;
use motorlab::board::{
    Board, BoardOptions, LineReader, Pace, Profile, VirtualBoardOnPage, VirtualBoardOptions,
};
use motorlab::motor::Plant;
use motorlab::platform::memory;
use motorlab::platform::time::{Instant, sleep, spawn};
use motorlab::recording::{
    CaptureRequest, Captured, CommandKind, Ending, LivePoint, SharedLive, Statistics, TextRequest,
    capture, capture_text, read_run_from,
};
use serde::{Deserialize, Serialize};
use tokio::sync::Notify;
use wasm_bindgen::prelude::*;

use crate::bench::motor_of;
use crate::dropped::Seen;
use crate::failure::{Answer, document, failed};
use crate::serial::PageLine;

/// Refresh period of the display: twenty per second (a film has 24).
const SHOWN_EVERY: Duration = Duration::from_millis(50);

/// Time limit for the HELLO of a board, as in the program: a slow boot loader takes 3 s.
const PATIENCE: Duration = Duration::from_secs(6);

/// Name of a run until the page saves it.
const RUN: &str = "run.csv";

/// Stop request for the current recording.
static STOP: Mutex<Option<Arc<Notify>>> = Mutex::new(None);

fn stop() -> MutexGuard<'static, Option<Arc<Notify>>> {
    STOP.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug, Deserialize)]
struct Order {
    source: From,
    profile: String,
    duration_s: f64,
    sample_time_s: f64,
}

/// Source.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum From {
    /// The virtual board with this motor.
    Virtual {
        motor: String,
        seed: u64,
        /// As fast as the page computes.
        fast: bool,
    },
    /// A board that speaks the protocol.
    Board { port: String },
    /// A board that prints text.
    Text(TextBoard),
}

/// Settings of a board that prints text, from the page's form.
#[derive(Debug, Deserialize)]
struct TextBoard {
    port: String,
    baud: u32,
    /// Meaning of each number; empty if the sketch states it.
    columns: String,
    counts_per_rev: f64,
    supply_v: f64,
    /// The lines have no command: it is the profile's.
    has_profile: bool,
}

impl TextBoard {
    fn request(&self, order: &Order) -> Result<TextRequest, JsError> {
        let columns = match self.columns.trim() {
            "" => None,
            names => Some(Columns::parse(names).map_err(failed)?),
        };
        let profile = self
            .has_profile
            .then(|| Profile::named(&order.profile, self.supply_v, order.duration_s))
            .transpose()
            .map_err(failed)?;
        Ok(TextRequest {
            columns,
            sample_time_us: None,
            counts_per_rev: self.counts_per_rev,
            supply_v: self.supply_v,
            assumed: Vec::new(),
            integrate: None,
            profile,
            duration_s: order.duration_s,
            baud: self.baud,
            patience: PATIENCE,
            output: PathBuf::from(RUN),
            port: self.port.clone(),
            usb: None,
        })
    }
}

/// Update of the display.
#[derive(Debug, Serialize)]
struct Shown {
    samples: u64,
    lost: u64,
    /// Time in s, speed in rad/s, command in V.
    points: Vec<(f64, f64, f64)>,
}

/// A finished recording.
#[derive(Debug, Serialize)]
struct Recorded {
    run: Seen,
    ending: Ending,
    complete: bool,
    statistics: Statistics,
    contradictions: Vec<String>,
    notes: Vec<String>,
}

/// Ends the current recording.
#[wasm_bindgen]
pub fn stop_recording() {
    if let Some(stop) = &*stop() {
        stop.notify_one();
    }
}

/// Records according to `order`; returns the run with its figures.
#[wasm_bindgen]
pub async fn record(order: String) -> Answer {
    let order: Order = serde_json::from_str(&order).map_err(failed)?;
    // Leftover files of a failed recording.
    let _ = memory::take(Path::new(RUN));
    let live = SharedLive::default();
    let asked = Arc::new(Notify::new());
    *stop() = Some(Arc::clone(&asked));
    let told = Arc::new(AtomicU64::new(0));
    let display = {
        let (live, told) = (SharedLive::clone(&live), Arc::clone(&told));
        spawn(async move {
            loop {
                sleep(SHOWN_EVERY).await;
                show(&live, &told);
            }
        })
    };
    let recorded = recorded(&order, &live, &asked).await;
    display.abort();
    show(&live, &told);
    let (captured, notes) = recorded?;
    let text = memory::take(&captured.path).unwrap_or_default();
    let (run, _) = read_run_from(text.as_slice(), RUN).map_err(failed)?;
    document(&Recorded {
        run: Seen::of(RUN, text, &run),
        ending: captured.ending,
        complete: captured.complete,
        statistics: captured.statistics,
        contradictions: captured.contradictions,
        notes,
    })
}

/// Sends the samples since the last update to the page.
fn show(live: &SharedLive, told: &AtomicU64) {
    let live = live.lock().unwrap_or_else(PoisonError::into_inner);
    let before = told.swap(live.samples, Ordering::Relaxed);
    let news = (live.samples.saturating_sub(before) as usize).min(live.recent.len());
    if news == 0 {
        return;
    }
    let point = |p: &LivePoint| (p.t_s, p.speed_rad_s, p.command);
    let latest = live.recent.iter().skip(live.recent.len() - news);
    crate::report(&Shown {
        samples: live.samples,
        lost: live.lost,
        points: latest.map(point).collect(),
    });
}

/// The recording, and notes about it.
async fn recorded(
    order: &Order,
    live: &SharedLive,
    stop: &Notify,
) -> Result<(Captured, Vec<String>), JsError> {
    let options = BoardOptions {
        baud: BAUD,
        patience: PATIENCE,
        log: None,
    };
    match &order.source {
        From::Virtual { motor, seed, fast } => {
            let motor = motor_of(motor)?;
            let plant = Plant::new(&motor, CommandKind::Voltage, *seed).map_err(failed)?;
            let pace = match fast {
                true => Pace::AsFastAsPossible,
                false => Pace::RealTime,
            };
            let settings = VirtualBoardOptions {
                pace,
                ..VirtualBoardOptions::default()
            };
            let plugged = VirtualBoardOnPage::plug_in("virtual:", plant, settings);
            let board = Board::open(plugged.location(), options).await;
            follow(order, "virtual:", board.map_err(failed)?, live, stop).await
        }
        From::Board { port } => {
            let line = PageLine::opened();
            let board = Board::over(Path::new(port), line, Box::new(PageLine), options).await;
            follow(order, port, board.map_err(failed)?, live, stop).await
        }
        From::Text(board) => {
            let request = board.request(order)?;
            let reader = LineReader::spawn(PageLine::opened(), Instant::now());
            let mut reader = reader.map_err(failed)?;
            let text = capture_text(&mut reader, None, request, live, stop.notified()).await;
            let text = text.map_err(failed)?;
            Ok((text.captured, text.notes))
        }
    }
}

/// Records from an open board.
async fn follow(
    order: &Order,
    port: &str,
    mut board: Board,
    live: &SharedLive,
    stop: &Notify,
) -> Result<(Captured, Vec<String>), JsError> {
    let supply_v = f64::from(board.hello().supply_mv) / 1000.0;
    let profile = Profile::named(&order.profile, supply_v, order.duration_s).map_err(failed)?;
    let sample_time_us = (order.sample_time_s * 1e6).round();
    let samples = (order.duration_s * 1e6 / sample_time_us).round();
    let request = CaptureRequest {
        sample_time_us: sample_time_us as u32,
        profile,
        samples: samples as u32,
        counts_per_rev: None,
        supply_v: None,
        output: PathBuf::from(RUN),
        port: port.to_owned(),
        usb: None,
        further: toml::Table::new(),
    };
    let captured = capture(&mut board, &request, live, stop.notified()).await;
    Ok((captured.map_err(failed)?, Vec::new()))
}
