//! A line on the terminal that shows a recording while it runs, on a thread of its own.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::recording::{Live, SharedLive};
use crate::units::rpm_from_rad_s;

/// How often the line is drawn.
const EVERY: Duration = Duration::from_millis(100);

/// Characters of the picture.
const WIDTH: usize = 32;

/// Progress of a long computation with its time, on standard error if that is a terminal.
pub(super) fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(EVERY);
    spinner
}

/// The line; dropping it wipes the line away. A terminal that blocks blocks this thread alone.
pub(super) struct ProgressLine(Option<Arc<AtomicBool>>);

impl ProgressLine {
    /// Draws on standard error if that is a terminal.
    pub(super) fn show(live: &SharedLive) -> Self {
        if !io::stderr().is_terminal() {
            return Self(None);
        }
        let over = Arc::new(AtomicBool::new(false));
        let drawing = thread::Builder::new().name("progress".to_owned()).spawn({
            let (live, over) = (Arc::clone(live), Arc::clone(&over));
            move || {
                while !over.load(Ordering::Relaxed) {
                    let text = {
                        let live = live.lock().unwrap_or_else(PoisonError::into_inner);
                        line(&live)
                    };
                    if write!(io::stderr(), "\r{text}\x1b[K").is_err() {
                        return;
                    }
                    thread::sleep(EVERY);
                }
                let _ = write!(io::stderr(), "\r\x1b[K");
            }
        });
        Self(drawing.ok().map(|_| over))
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if let Some(over) = &self.0 {
            over.store(true, Ordering::Relaxed);
            // Long enough for an unblocked terminal, and not a moment longer for a blocked one.
            thread::sleep(EVERY + Duration::from_millis(20));
        }
    }
}

fn line(live: &Live) -> String {
    let Some(last) = live.recent.back() else {
        return "waiting for the first sample".to_owned();
    };
    format!(
        "{:8.2} s {:8} samples {:3} lost {:7.1} RPM {:6.2} V {}",
        last.t_s,
        live.samples,
        live.lost,
        mean_rpm(
            live.recent
                .iter()
                .rev()
                .take(16)
                .map(|point| point.speed_rad_s)
        ),
        last.command,
        picture(live)
    )
}

fn mean_rpm(speeds: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = speeds.fold((0.0, 0), |(sum, count), speed| (sum + speed, count + 1));
    rpm_from_rad_s(sum / f64::from(count.max(1)))
}

/// The speed of the recent samples, oldest left: eight heights from the slowest to the fastest.
fn picture(live: &Live) -> String {
    const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let count = live.recent.len();
    let columns: Vec<f64> = (0..WIDTH.min(count))
        .map(|column| {
            let (from, to) = (
                column * count / WIDTH.min(count),
                (column + 1) * count / WIDTH.min(count),
            );
            mean_rpm(live.recent.range(from..to).map(|point| point.speed_rad_s))
        })
        .collect();
    let low = columns.iter().copied().fold(0.0, f64::min);
    let high = columns.iter().copied().fold(0.0, f64::max);
    let scale = if high > low { 7.0 / (high - low) } else { 0.0 };
    columns
        .iter()
        .map(|speed| HEIGHTS[(((speed - low) * scale).round() as usize).min(7)])
        .collect()
}
