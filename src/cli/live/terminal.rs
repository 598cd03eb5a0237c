//! The terminal of the display: size and echo.

#[cfg(unix)]
use std::io;

#[cfg(unix)]
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetwinsize, tcsetattr};

/// The terminal without echo; Ctrl-C remains a signal.
#[cfg(unix)]
pub(super) struct SilentTerminal {
    before: Option<Termios>,
}

#[cfg(unix)]
impl SilentTerminal {
    pub fn take() -> Self {
        let before = tcgetattr(io::stderr()).ok();
        if let Some(before) = &before {
            let mut quiet = before.clone();
            quiet.local_modes -= LocalModes::ECHO | LocalModes::ICANON;
            // With echo, typed characters appear on the display, which is harmless.
            let _ = tcsetattr(io::stderr(), OptionalActions::Now, &quiet);
        }
        Self { before }
    }

    pub fn restore(&self) {
        if let Some(before) = &self.before {
            let _ = tcsetattr(io::stderr(), OptionalActions::Now, before);
        }
    }
}

/// Columns and rows; 0 if unknown.
#[cfg(unix)]
pub(super) fn size() -> (u16, u16) {
    let size = tcgetwinsize(io::stderr()).ok();
    size.map_or((0, 0), |size| (size.ws_col, size.ws_row))
}

/// A console echoes typed characters only when the program reads them.
#[cfg(windows)]
pub(super) struct SilentTerminal;

#[cfg(windows)]
impl SilentTerminal {
    pub fn take() -> Self {
        Self
    }

    pub fn restore(&self) {}
}

/// Columns and rows; 0 if unknown.
#[cfg(windows)]
pub(super) fn size() -> (u16, u16) {
    ratatui::crossterm::terminal::size().unwrap_or((0, 0))
}
