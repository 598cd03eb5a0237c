//! Plots on the terminal and in files, for every subcommand.

use std::io::IsTerminal;

use crate::report::{Panel, terminal};

/// A panel as text, as wide as the terminal (80 columns without one), for standard output.
pub(super) fn on_terminal(panel: &Panel, x_label: &str) -> String {
    let columns = std::env::var("COLUMNS")
        .ok()
        .and_then(|text| text.parse().ok());
    let stdout = std::io::stdout();
    #[cfg(unix)]
    let measured = rustix::termios::tcgetwinsize(&stdout)
        .ok()
        .map(|size| usize::from(size.ws_col))
        .filter(|&columns| columns > 0);
    #[cfg(windows)]
    let measured = (stdout.is_terminal())
        .then(ratatui::crossterm::terminal::size)
        .and_then(Result::ok)
        .map(|(columns, _)| usize::from(columns));
    let columns = measured.or(columns).unwrap_or(80).clamp(40, 120);
    let colours = stdout.is_terminal() && std::env::var_os("NO_COLOR").is_none();
    terminal::plot(panel, x_label, columns, 20, colours)
}
