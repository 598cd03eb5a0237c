//! Import of logs of other programs as run files.
//!
//! A mapping ([`Map`]) states quantity and unit of each column. [`import`] reads the log line by line, converts each
//! row to SI units and writes it; only the first 4096 rows of a run are held in memory, to determine its sample time.
//! A row that cannot be used is counted, reported with its line, written to a file of rejected rows with the reason,
//! and leaves a gap in `seq`, so that it counts as lost.
//!
//! A file of another format (Parquet, MAT, MCAP and others) is read into a [`Table`] by its [`Form`], and then
//! processed as equivalent text.

mod bare;
mod cells;
mod clock;
mod convert;
mod error;
mod file;
mod formats;
mod kind;
mod labels;
mod layout;
mod lines;
mod log;
mod logger;
mod map;
mod map_command;
mod map_file;
mod map_values;
mod range;
mod rejected;
mod segment;
mod source;
mod stamp;
mod table;
mod thin;
mod unit;
mod unmapped;
mod unwrap;

pub use crate::recording::Integration;
pub use error::{BadRow, ImportError, ImportProblem, MapError};
pub use file::{Imported, ImportedRun, import};
pub use formats::{Form, FormatError, MOST_FILE_BYTES, RECOGNITION_BYTES};
pub use kind::Kind;
pub use lines::{MAX_LINE_BYTES, MOST_LINE_BYTES};
pub use map::Map;
pub use source::{Source, SourceError};
pub use table::{Table, TableColumn, TableText};
pub use unmapped::{
    GivenFlags, HEAD_BYTES, Missing, Reading, Ready, Unclear, Understood, is_spelling_of, map_over,
    understand, understand_table,
};
