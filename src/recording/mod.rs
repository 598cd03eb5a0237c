//! A run: what was commanded and what the encoder counted, with its file and the velocity rule.

mod capture;
mod driven;
mod end;
mod header;
mod line_limit;
mod read_error;
mod reader;
mod recorder;
mod replay;
mod replay_text;
mod row;
mod rows;
mod run;
mod statistics;
mod text_capture;
pub(crate) mod unit_of_time;
mod velocity;
mod write_error;
mod write_run;
mod writer;

pub use crate::motor::CommandKind;
pub use capture::{CaptureError, CaptureRequest, capture};
pub use driven::known_differences;
pub use read_error::{ReadError, ReadNote, ReadProblem};
pub use reader::{read_run, read_run_from};
pub use recorder::{Captured, Ending, Live, LivePoint, SharedLive};
pub use replay::{ReplayError, Speed, replay};
pub use replay_text::replay_text;
pub use row::{Columns, Row, Time};
pub use run::{Flags, Run, UnknownFlag};
pub use statistics::{Intervals, Observation, Statistics, StatisticsGatherer};
pub use text_capture::{TextCaptured, TextError, TextRequest, capture_text};
pub use velocity::{difference_velocities, velocity_rad_s};
pub use write_error::WriteError;
pub use write_run::write_run;
pub use writer::{FLUSH_EVERY, RUN_FORMAT, RunWriter, next_free_name};
