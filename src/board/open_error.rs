//! Errors of opening a serial port, with their remedies.

use std::path::{Path, PathBuf};
use std::time::Duration;

#[cfg(not(target_family = "wasm"))]
use super::port_list::list_ports;
use crate::plain::shown;

/// Timeout of one read, and so the delay with which a stopped reader ends. On Windows a write waits for the current
/// read, so that it is a fifth there.
pub const READ_PATIENCE: Duration = Duration::from_millis(if cfg!(windows) { 20 } else { 100 });

/// Why a port cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The path does not exist.
    #[error("there is no port {path}{}", known_ports(known), path = shown(path))]
    NotFound {
        /// Requested path.
        path: PathBuf,
        /// Existing ports.
        known: Vec<PathBuf>,
    },
    /// The node's permissions exclude this user.
    #[error(
        "no permission to open {path}: it belongs to group {group} ({mode}), and this user is not in it\nhint: join the group, then log in again:\n  {command}", path = shown(path))]
    PermissionDenied {
        /// The port.
        path: PathBuf,
        /// Group of the node.
        group: String,
        /// Its permissions, as `ls` shows them.
        mode: String,
        /// Command to type.
        command: String,
    },
    /// Another program has it.
    #[error("port {path} is in use by {holder}\nhint: {advice}", path = shown(path))]
    Busy {
        /// The port.
        path: PathBuf,
        /// The other program, if visible.
        holder: String,
        /// Remedy.
        advice: String,
    },
    /// A file, a directory or another kind of device.
    #[error("{path} is {what}, not a serial port\nhint: `motorlab ports` lists the serial ports", path = shown(path))]
    NotASerialPort {
        /// Requested path.
        path: PathBuf,
        /// Description.
        what: &'static str,
    },
    /// Any other error.
    #[error("cannot open port {path}: {description}\nhint: unplug the board and plug it in again; `motorlab ports` lists the ports that can be opened", path = shown(path))]
    Failed {
        /// The port.
        path: PathBuf,
        /// Message of the operating system.
        description: String,
    },
}

fn known_ports(known: &[PathBuf]) -> String {
    if known.is_empty() {
        return "\nhint: no serial port is connected: plug the board in; virtual: is a board without hardware"
            .to_owned();
    }
    let names: Vec<String> = known.iter().map(shown).collect();
    format!("\nhint: the ports are {}", names.join(", "))
}

impl OpenError {
    #[cfg(not(target_family = "wasm"))]
    pub(super) fn not_found(path: &Path) -> Self {
        Self::NotFound {
            path: path.to_owned(),
            known: list_ports().into_iter().map(|port| port.path).collect(),
        }
    }

    pub(super) fn failed(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::Failed {
            path: path.to_owned(),
            description: error.to_string(),
        }
    }
}
