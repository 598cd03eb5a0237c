//! The terminal that the picture is drawn on: how large it is, and its echo.

#[cfg(unix)]
use std::io;

#[cfg(unix)]
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetwinsize, tcsetattr};

/// The terminal without echo, whose Ctrl-C still is a signal.
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
            // Without it typed characters show in the picture, and no harm is done.
            let _ = tcsetattr(io::stderr(), OptionalActions::Now, &quiet);
        }
        Self { before }
    }

    pub fn give_back(&self) {
        if let Some(before) = &self.before {
            let _ = tcsetattr(io::stderr(), OptionalActions::Now, before);
        }
    }
}

/// Columns and rows; 0 where they are not known.
#[cfg(unix)]
pub(super) fn size() -> (u16, u16) {
    let size = tcgetwinsize(io::stderr()).ok();
    size.map_or((0, 0), |size| (size.ws_col, size.ws_row))
}

/// The console as it is: typed characters show only once the program asks for them, which it does not.
#[cfg(windows)]
pub(super) struct SilentTerminal;

#[cfg(windows)]
impl SilentTerminal {
    pub fn take() -> Self {
        Self
    }

    pub fn give_back(&self) {}
}

/// Columns and rows; 0 where they are not known.
#[cfg(windows)]
pub(super) fn size() -> (u16, u16) {
    ratatui::crossterm::terminal::size().unwrap_or((0, 0))
}
