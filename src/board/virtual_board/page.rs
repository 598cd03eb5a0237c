//! A virtual board that runs in turns of a page's event loop, which has no threads.

use super::{Bench, Location, POLL_EVERY, Running, VirtualBoardOptions, channel};
use crate::platform::time::{JoinHandle, sleep, spawn};

/// A running virtual board; dropping it unplugs it.
#[derive(Debug)]
pub struct VirtualBoardOnPage {
    location: Location,
    turns: JoinHandle<()>,
}

impl VirtualBoardOnPage {
    /// Plugs in a board with `bench`, with the name `name` in messages.
    pub fn plug_in(name: &str, bench: impl Bench + 'static, options: VirtualBoardOptions) -> Self {
        let (near, far) = channel(name);
        let mut running = Running::new(near, bench, options);
        let turns = spawn(async move {
            // A failing line is closed.
            while !running.hung_up && running.turn().is_ok() {
                sleep(POLL_EVERY).await;
            }
        });
        Self {
            location: Location::InProcess(far),
            turns,
        }
    }

    /// Where it is opened.
    pub fn location(&self) -> &Location {
        &self.location
    }
}

impl Drop for VirtualBoardOnPage {
    fn drop(&mut self) {
        self.turns.abort();
    }
}
