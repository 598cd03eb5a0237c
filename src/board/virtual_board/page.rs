//! A virtual board whose turns are taken by the event loop of a page, which has no threads.

use super::{Bench, LOOK_AGAIN, Location, Running, VirtualBoardOptions, channel};
use crate::platform::time::{JoinHandle, sleep, spawn};

/// A running virtual board; dropping it unplugs it.
#[derive(Debug)]
pub struct VirtualBoardOnPage {
    location: Location,
    turns: JoinHandle<()>,
}

impl VirtualBoardOnPage {
    /// Plugs in a board that drives `bench`; messages call it `name`.
    pub fn plug_in(name: &str, bench: impl Bench + 'static, options: VirtualBoardOptions) -> Self {
        let (near, far) = channel(name);
        let mut running = Running::new(near, bench, options);
        let turns = spawn(async move {
            // A line that fails is one that is not there any more.
            while !running.hung_up && running.turn().is_ok() {
                sleep(LOOK_AGAIN).await;
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
