//! `motorlab virtual`: a board without hardware, for programs that open serial ports.

#[cfg(unix)]
use std::time::Duration;

use clap::Args;
#[cfg(unix)]
use serde_json::json;

#[cfg(unix)]
use super::signals::StopSignal;
#[cfg(unix)]
use super::virtual_spec::VirtualSpec;
use super::virtual_spec::{BOARD_KEYS, PREFIX};
use super::{Failure, Output, Status};
#[cfg(unix)]
use crate::plain::shown;

/// Plug in a virtual board and print the serial port to open; Ctrl-C unplugs it. Not on Windows.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct Virtual {
    /// The board and its motor: `virtual:?effect=backlash&gap_rad=0.02&seed=7`.
    #[arg(default_value = "virtual:")]
    board: String,
}

fn after_help() -> String {
    let keys: String = BOARD_KEYS
        .iter()
        .map(|(key, what)| format!("  {key:<14} {what}\n"))
        .collect();
    format!(
        "Keys of a virtual board (besides a motor file's keys, effect=ID and that effect's parameters):\n{keys}\nExample:\n  motorlab virtual 'virtual:?effect=backlash&gap_rad=0.02&seed=7' &\n  motorlab capture /dev/pts/5"
    )
}

/// On Windows a program cannot provide a serial port.
pub(super) fn needs_unix(instead: &str) -> Failure {
    Failure::wrong(
        "a serial port for other programs needs a pseudo-terminal, which Windows does not have",
        instead,
    )
    .of_kind("needs_unix")
}

impl Virtual {
    #[cfg(not(unix))]
    pub(super) fn run(&self, _: &Output) -> Result<Status, Failure> {
        let word = format!(
            "{PREFIX}{}",
            self.board.strip_prefix(PREFIX).unwrap_or(&self.board)
        );
        Err(needs_unix(&format!(
            "record from the board within this program: motorlab capture \"{word}\""
        )))
    }

    #[cfg(unix)]
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let text = self.board.strip_prefix(PREFIX).unwrap_or(&self.board);
        let board = VirtualSpec::parse(text)
            .map_err(Failure::input)?
            .with_reported_gaps(output);
        let board = board.offer().map_err(Failure::input)?;
        if output.json {
            output.document(&json!({ "port": board.path() }))?;
        } else {
            output.line(&shown(board.path()))?;
        }
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(Failure::device)?;
        runtime.block_on(async {
            let stop = StopSignal::install().map_err(Failure::device)?;
            while !stop.is_asked() && !board.is_gone() {
                let asked = stop.clone().asked();
                // Polls whether the board has unplugged itself.
                let _ = tokio::time::timeout(Duration::from_millis(200), asked).await;
            }
            Ok(Status::Done)
        })
    }
}
