//! Progress on the terminal: of a recording, in a separate thread, and of a long computation.

use std::fmt;
use std::fs::File;
use std::io::{self, IsTerminal, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, WeakProgressBar};

use crate::recording::{Live, SharedLive};
use crate::units::rpm_from_rad_s;

/// Refresh period.
const EVERY: Duration = Duration::from_millis(100);

/// Characters of the plot.
const WIDTH: usize = 32;

/// Delay before progress is shown.
const DELAY: Duration = Duration::from_secs(2);

/// Steps of a computation of which only the share is known.
const PARTS: f64 = 1000.0;

/// Least share from which the remaining time is estimated.
const ESTIMATED_FROM: f64 = 0.03;

/// Whether progress of computations is hidden: with `--json`.
static IS_HIDDEN: AtomicBool = AtomicBool::new(false);

/// The progress on the terminal, which is suspended for messages.
static DRAWN: Mutex<Option<WeakProgressBar>> = Mutex::new(None);

pub(super) fn hide() {
    IS_HIDDEN.store(true, Ordering::Relaxed);
}

/// Progress of a long computation: activity, share, remaining time. On standard error if that is a terminal, after a
/// delay.
pub(super) fn spinner() -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {msg}{far}");
    after_delay(
        ProgressBar::with_draw_target(Some(PARTS as u64), ProgressDrawTarget::hidden()).with_style(
            style
                .unwrap_or_else(|_| ProgressStyle::default_spinner())
                .with_key("far", far),
        ),
    )
}

/// The same for a number of items, with a bar.
pub(super) fn bar(items: usize, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {pos} of {len} {msg}{far}");
    after_delay(
        ProgressBar::with_draw_target(Some(items as u64), ProgressDrawTarget::hidden())
            .with_style(
                style
                    .unwrap_or_else(|_| ProgressStyle::default_bar())
                    .with_key("far", far),
            )
            .with_message(what),
    )
}

pub(super) fn set_share(bar: &ProgressBar, share: f64) {
    bar.set_position((share.clamp(0.0, 1.0) * PARTS) as u64);
}

/// Writes to the terminal while the progress is suspended.
pub(super) fn with_progress_suspended<R>(write: impl FnOnce() -> R) -> R {
    let drawn = DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
    match drawn.as_ref().and_then(WeakProgressBar::upgrade) {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

fn after_delay(bar: ProgressBar) -> ProgressBar {
    if IS_HIDDEN.load(Ordering::Relaxed) || !io::stderr().is_terminal() {
        return bar;
    }
    let later = bar.downgrade();
    let shown = thread::Builder::new()
        .name("progress".to_owned())
        .spawn(move || {
            thread::sleep(DELAY);
            let Some(bar) = later.upgrade().filter(|bar| !bar.is_finished()) else {
                return;
            };
            *DRAWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(later);
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(EVERY);
        });
    // Without a thread there is no progress, and the computation continues.
    drop(shown);
    bar
}

/// The share and the estimated remaining time, or the elapsed time if neither is known.
fn far(state: &ProgressState, to: &mut dyn fmt::Write) {
    let share = state.pos() as f64 / state.len().unwrap_or(1).max(1) as f64;
    let _ = to.write_str(&words(share, state.elapsed()));
}

fn words(share: f64, elapsed: Duration) -> String {
    let so_far_s = elapsed.as_secs_f64();
    if share < ESTIMATED_FROM {
        return format!(", {so_far_s:.0} s so far");
    }
    let left_s = so_far_s * (1.0 - share) / share;
    let left = match left_s {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    };
    format!(", {:.0} %, about {left} left", 100.0 * share)
}

/// A file that is read with progress.
pub(super) struct FileProgress {
    file: File,
    read: u64,
    length: u64,
    bar: ProgressBar,
}

impl FileProgress {
    pub fn new(file: File, name: &str) -> Self {
        let bar = spinner();
        bar.set_message(format!("reading {name}"));
        // A pipe has length 0; only the elapsed time is known.
        let length = file.metadata().map_or(0, |found| found.len());
        Self {
            file,
            read: 0,
            length,
            bar,
        }
    }
}

impl Read for FileProgress {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let bytes = self.file.read(into)?;
        self.read += bytes as u64;
        if self.length > 0 {
            set_share(&self.bar, self.read as f64 / self.length as f64);
        }
        Ok(bytes)
    }
}

impl Drop for FileProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The line; dropping it erases the line. A blocked terminal blocks this thread only.
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
            // Long enough for an unblocked terminal; a blocked one is not waited for.
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

/// The speed of the recent samples, the oldest at the left: eight heights from the slowest to the fastest.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remaining_time_is_proportional_to_the_remaining_work() {
        let of = |share, seconds| words(share, Duration::from_secs(seconds));
        assert_eq!(of(0.0, 3), ", 3 s so far");
        assert_eq!(of(0.25, 10), ", 25 %, about 30 s left");
        assert_eq!(of(0.1, 60), ", 10 %, about 9 min left");
        assert_eq!(of(0.05, 1200), ", 5 %, about 6.3 h left");
        assert_eq!(of(1.0, 20), ", 100 %, about 0 s left");
    }
}
