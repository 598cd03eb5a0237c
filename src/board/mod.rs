//! Boards: everything between a serial device and validated samples.

mod bench;
mod board_error;
mod board_side;
mod channel;
mod clock;
mod connection;
pub mod faults;
mod heard;
mod intake;
pub(crate) mod leap;
mod line;
mod location;
pub(crate) mod motion;
mod open_error;
#[cfg(not(target_family = "wasm"))]
mod port;
#[cfg(target_family = "wasm")]
#[path = "port_none.rs"]
mod port;
mod port_list;
#[cfg(unix)]
mod port_unix;
#[cfg(windows)]
mod port_windows;
mod profile;
mod profile_file;
mod profile_levels;
mod profile_words;
#[cfg(unix)]
pub mod pty;
pub mod rawlog;
mod reader;
#[cfg(unix)]
mod replayed;
pub mod text_lines;
mod virtual_board;

pub use bench::{Bench, IdealBench};
pub use board_error::BoardError;
pub use board_side::{BoardSide, Readiness};
pub use channel::{Channel, ChannelBoard, channel};
pub use clock::{ClockFit, ClockFitter};
pub use connection::{Board, BoardEvent, BoardOptions, wire_segments};
pub use heard::Heard;
pub use intake::{Damage, Event, Expectations, Intake, Sample};
pub use leap::Leap;
pub use line::{LogFailure, RawLog};
pub use location::{Location, SerialLine};
pub use open_error::{OpenError, READ_PATIENCE};
pub use port::Port;
pub use port_list::{PortEntry, UsbIdentity, known_board, list_ports, list_ports_of, usb_identity};
pub use profile::{BUILT_IN, Profile, ProfileError, STEP_REST_S, Segment};
pub use reader::{Arrival, LONGEST_GATHER, LineReader, longest_gather};
#[cfg(unix)]
pub use replayed::ReplayedDevice;
#[cfg(target_family = "wasm")]
pub use virtual_board::VirtualBoardOnPage;
pub use virtual_board::{FirmwareOptions, Pace, VirtualBoard, VirtualBoardOptions};
