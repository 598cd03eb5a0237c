//! A board that is plugged in again: identified by its USB identity or, without one, by the port's name and its
//! HELLO; never by the name alone, which another board may have taken.

use std::path::{Path, PathBuf};
use std::time::Duration;

use firmware_protocol::Hello;

use super::Output;
use crate::board::{Board, BoardOptions, Location, LogFailure, PortEntry, UsbIdentity, list_ports};
use crate::hint::Hinted;
use crate::plain::shown;
use crate::recording::Captured;

/// Period of the search.
const POLL_EVERY: Duration = Duration::from_millis(200);

/// Time limit for the HELLO of a board that has come back.
const PATIENCE: Duration = Duration::from_secs(6);

/// Identity of a board across unplugging.
#[derive(Debug, Clone)]
pub(super) struct BoardIdentity {
    location: Location,
    usb: Option<UsbIdentity>,
    name: String,
    counts_per_rev: u32,
}

impl BoardIdentity {
    pub(super) fn of(location: &Location, usb: Option<UsbIdentity>, hello: &Hello) -> Self {
        Self {
            location: location.clone(),
            usb,
            name: hello.name.as_str().to_owned(),
            counts_per_rev: hello.counts_per_rev,
        }
    }

    /// The possible location of the board: the port with its USB identity, under any name. A port without one is
    /// searched at its old location.
    fn candidate(&self, ports: &[PortEntry]) -> Option<Location> {
        match &self.usb {
            Some(usb) => ports
                .iter()
                .find(|port| {
                    port.usb
                        .as_ref()
                        .is_some_and(|other| usb.same_device(other))
                })
                .map(|port| Location::Port(port.path.clone())),
            None => (self.location.is_there()).then(|| self.location.clone()),
        }
    }

    /// Waits for the same board and returns its location. Other boards are left alone.
    pub(super) async fn wait_for_board(&self, baud: u32, output: &Output) -> Location {
        let mut told: Option<String> = None;
        loop {
            tokio::time::sleep(POLL_EVERY).await;
            let Some(location) = self.candidate(&list_ports()) else {
                continue;
            };
            let path = location.path();
            match self.identify(&location, baud).await {
                Ok(()) => {
                    output.message(&format!("the board is back on {}", shown(path)));
                    return location;
                }
                Err(Some(other)) if told.as_ref() != Some(&other) => {
                    output.message(&format!(
                        "{} now is another board ({other}); waiting for {}",
                        shown(path),
                        self.name
                    ));
                    told = Some(other);
                }
                Err(_) => {}
            }
        }
    }

    /// Whether the board at `path` is the same; the identity of another one as error.
    async fn identify(&self, location: &Location, baud: u32) -> Result<(), Option<String>> {
        let options = BoardOptions {
            baud,
            patience: PATIENCE,
            log: None,
        };
        let board = Board::open(location, options).await.map_err(|_| None)?;
        let hello = board.hello();
        if hello.name.as_str() == self.name && hello.counts_per_rev == self.counts_per_rev {
            Ok(())
        } else {
            Err(Some(hello.name.as_str().to_owned()))
        }
    }
}

/// The recordings that ended because the board was unplugged, and all raw logs.
#[derive(Debug, Default)]
pub(super) struct Segments {
    ended: Vec<Captured>,
    logs: Vec<(PathBuf, LogFailure)>,
}

impl Segments {
    pub(super) fn add(&mut self, captured: Captured) {
        self.ended.push(captured);
    }

    /// Keeps a raw log until the end of its recording.
    pub(super) fn add_log(&mut self, path: PathBuf, failure: LogFailure) {
        self.logs.push((path, failure));
    }

    pub(super) fn failed_logs(&self) -> Vec<Hinted> {
        let failed = self
            .logs
            .iter()
            .filter_map(|(path, failure)| Some((path, failure.get()?)));
        failed
            .map(|(path, error)| {
                Hinted::new(
                    format!(
                        "the raw log {} could not be written to the end ({error}), and is good up to its last whole line",
                        shown(path)
                    ),
                    "the run file does not depend on it and is whole; make room, or record without --log",
                )
            })
            .collect()
    }

    /// Removes and returns the latest segment.
    pub(super) fn take_last(&mut self) -> Option<Captured> {
        self.ended.pop()
    }

    /// Header keys of the next segment; empty for the first.
    pub(super) fn header(&self) -> toml::Table {
        let mut header = toml::Table::new();
        if let Some(last) = self.ended.last() {
            header.insert("segment".to_owned(), (self.ended.len() as i64 + 1).into());
            let path = last.path.display().to_string();
            header.insert("segment_before".to_owned(), path.into());
        }
        header
    }

    /// Files of the segments before the last, with their numbers of samples.
    pub(super) fn files(&self) -> impl Iterator<Item = (&Path, u64)> {
        self.ended
            .iter()
            .map(|captured| (captured.path.as_path(), captured.statistics.samples))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.ended.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(path: &str, serial: &str) -> PortEntry {
        PortEntry {
            path: PathBuf::from(path),
            usb: Some(usb(serial)),
            looks_like: None,
        }
    }

    fn usb(serial: &str) -> UsbIdentity {
        UsbIdentity {
            vid: 0x2341,
            pid: 0x43,
            serial: Some(serial.to_owned()),
            product: None,
        }
    }

    #[test]
    fn a_board_is_found_under_another_name_and_another_board_is_not() {
        let board = BoardIdentity {
            location: Location::Port(PathBuf::from("/dev/ttyACM0")),
            usb: Some(usb("75330303")),
            name: "uno".to_owned(),
            counts_per_rev: 720,
        };
        // It came back as ttyACM1, and another board has taken ttyACM0.
        let ports = [
            port("/dev/ttyACM0", "999"),
            port("/dev/ttyACM1", "75330303"),
        ];
        let found = board.candidate(&ports).expect("it is back");
        assert_eq!(found.path(), Path::new("/dev/ttyACM1"));
        assert!(board.candidate(&ports[..1]).is_none());
    }
}
