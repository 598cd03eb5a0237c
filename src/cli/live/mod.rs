//! `capture --live`: speed, counts, command and losses in full screen during a recording, with the simulated motor.
//!
//! It draws in a separate thread from data that the recorder shares; a blocked terminal stops the display only.

mod terminal;
mod view;

use std::io::{self, BufWriter, IsTerminal, Stderr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{EnterAlternateScreen, LeaveAlternateScreen};
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};

use crate::recording::SharedLive;

use terminal::SilentTerminal;
pub(super) use view::LiveRun;
use view::View;

/// Refresh period.
const EVERY: Duration = Duration::from_millis(50);

/// Longest wait for the last frame: only a blocked terminal needs more.
const LAST_PICTURE: Duration = Duration::from_millis(500);

/// The display; dropping it restores the terminal.
pub(super) struct LiveView {
    over: Arc<AtomicBool>,
    drawing: Option<JoinHandle<()>>,
    terminal: SilentTerminal,
}

impl LiveView {
    /// Draws on standard error; `None` if it is not a terminal.
    pub(super) fn show(live: &SharedLive, run: LiveRun) -> Option<Self> {
        if !io::stderr().is_terminal() {
            return None;
        }
        let terminal = SilentTerminal::take();
        let over = Arc::new(AtomicBool::new(false));
        let drawing = thread::Builder::new().name("live-view".to_owned()).spawn({
            let (live, over) = (Arc::clone(live), Arc::clone(&over));
            move || {
                // A terminal that cannot be drawn on is no reason to stop recording.
                let _ = execute!(io::stderr(), EnterAlternateScreen, Hide);
                let _ = draw_until(&live, run, &over);
                let _ = execute!(io::stderr(), LeaveAlternateScreen, Show);
            }
        });
        Some(Self {
            over,
            drawing: Some(drawing.ok()?),
            terminal,
        })
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let until = Instant::now() + LAST_PICTURE;
        if let Some(drawing) = self.drawing.take() {
            while !drawing.is_finished() && Instant::now() < until {
                thread::sleep(EVERY / 10);
            }
        }
        self.terminal.restore();
    }
}

type Screen = Terminal<CrosstermBackend<BufWriter<Stderr>>>;

fn area() -> Rect {
    let (columns, rows) = terminal::size();
    let or = |value: u16, usual: u16| if value == 0 { usual } else { value };
    Rect::new(0, 0, or(columns, 80), or(rows, 24))
}

fn draw_until(live: &SharedLive, run: LiveRun, over: &AtomicBool) -> io::Result<()> {
    let mut area = self::area();
    let backend = CrosstermBackend::new(BufWriter::new(io::stderr()));
    let viewport = Viewport::Fixed(area);
    let mut screen: Screen = Terminal::with_options(backend, TerminalOptions { viewport })?;
    let mut view = View::new(run);
    while !over.load(Ordering::Relaxed) {
        {
            let live = live.lock().unwrap_or_else(PoisonError::into_inner);
            view.follow(&live);
        }
        let now = self::area();
        if now != area {
            area = now;
            screen.resize(area)?;
        }
        screen.draw(|frame| view.draw(frame))?;
        thread::sleep(EVERY);
    }
    Ok(())
}
