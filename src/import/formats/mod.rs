//! Files other than text in columns: the format is recognized by the first bytes, and each is read into a [`Table`].
//!
//! Parquet, MCAP, ROS 2 bags and MAT 7.3 need large libraries and are read with the feature `formats`. Sizes stated
//! in a file are checked against its length before memory of that size is allocated.

mod bytes;
#[cfg(feature = "formats")]
mod cdr;
#[cfg(feature = "formats")]
mod contained;
mod decimals;
mod documents;
mod error;
#[cfg(feature = "formats")]
mod hdf5;
mod json;
mod line_protocol;
mod lists;
mod long;
mod lvm;
mod mat5;
#[cfg(feature = "formats")]
mod mcap;
mod mcos;
#[cfg(feature = "formats")]
mod messages;
mod not_read;
mod pairs;
mod pandas;
#[cfg(feature = "formats")]
mod parquet;
mod printed;
#[cfg(feature = "formats")]
mod ros_types;
#[cfg(feature = "formats")]
mod rosbag;
mod scope;
mod series;
mod signals;
mod sysid;
mod teleplot;
mod variables;
mod wordy;
mod workspace;
mod wpilog;

pub use error::FormatError;

use super::table::Table;

/// Bytes at the beginning of a file by which its format is recognized.
pub const RECOGNITION_BYTES: usize = 1 << 14;
/// Largest file in bytes: it is read into memory.
pub const MOST_FILE_BYTES: u64 = 1 << 30;
/// Most values of a table: half a gigabyte of memory, an hour of 20 signals at 500 Hz.
const MOST_VALUES: usize = 1 << 25;

/// A format other than text in columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Apache Parquet.
    Parquet,
    /// MCAP, as ROS 2 and Foxglove record.
    Mcap,
    /// A ROS 2 bag in SQLite.
    Rosbag,
    /// WPILib's data log.
    WpiLog,
    /// WPILib's SysId data.
    SysId,
    /// MATLAB's MAT file of version 5 to 7.
    Mat5,
    /// MATLAB's MAT file of version 7.3, and HDF5.
    Hdf5,
    /// JSON: an object per line, or a table as one document.
    Json,
    /// LabVIEW's measurement file.
    Lvm,
    /// Lines of Teleplot.
    Teleplot,
    /// A pair of columns for each signal.
    Pairs,
    /// Cells with unquoted decimal commas between commas.
    Decimals,
    /// An oscilloscope's samples, with start and increment.
    Scope,
    /// One signal per line.
    Lists,
    /// A matrix as MATLAB prints it.
    Printed,
    /// YAML documents, or one key per line.
    Documents,
    /// InfluxDB's line protocol.
    LineProtocol,
    /// One row for each value of each signal.
    Long,
    /// A table whose cells have lists, units or hexadecimal numbers.
    Wordy,
    /// A known format that is not supported, and how to convert it.
    NotRead(&'static str, &'static str),
}

impl Form {
    /// The format of a file by its first bytes; `None` for text in columns.
    pub fn of(beginning: &[u8]) -> Option<Self> {
        let is_mat5 = beginning.len() >= 128
            && (beginning[124..128] == *b"\x00\x01IM" || beginning[124..128] == *b"\x01\x00MI");
        let is_hdf5 = |at: usize| {
            beginning
                .get(at..)
                .is_some_and(|rest| rest.starts_with(b"\x89HDF\r\n\x1a\n"))
        };
        if is_hdf5(0) || is_hdf5(512) {
            return Some(Self::Hdf5);
        }
        if is_mat5 {
            return Some(Self::Mat5);
        }
        let known: [(&[u8], Self); 4] = [
            (b"PAR1", Self::Parquet),
            (b"\x89MCAP0\r\n", Self::Mcap),
            (b"SQLite format 3\0", Self::Rosbag),
            (b"WPILOG", Self::WpiLog),
        ];
        let found = known.iter().find(|(magic, _)| beginning.starts_with(magic));
        found
            .map(|(_, form)| *form)
            .or_else(|| sysid::is_sysid(beginning).then_some(Self::SysId))
            .or_else(|| not_read::form(beginning))
            .or_else(|| Self::of_text(beginning))
    }

    /// The format of a text other than rows of columns.
    fn of_text(beginning: &[u8]) -> Option<Self> {
        let text = beginning.strip_prefix(b"\xef\xbb\xbf").unwrap_or(beginning);
        type Is = fn(&[u8]) -> bool;
        let forms: [(Is, Self); 12] = [
            (|text| text.starts_with(lvm::MAGIC), Self::Lvm),
            (json::is_json, Self::Json),
            (teleplot::is_teleplot, Self::Teleplot),
            (lists::is_lists, Self::Lists),
            (printed::is_printed, Self::Printed),
            (decimals::is_decimals, Self::Decimals),
            (scope::is_scope, Self::Scope),
            (pairs::is_pairs, Self::Pairs),
            (documents::is_documents, Self::Documents),
            (line_protocol::is_line_protocol, Self::LineProtocol),
            (long::is_long, Self::Long),
            (wordy::is_wordy, Self::Wordy),
        ];
        forms
            .into_iter()
            .find(|(is, _)| is(text))
            .map(|(_, form)| form)
    }

    /// The format by the file's name.
    pub fn of_name(name: &str) -> Option<Self> {
        let is_hoot = name.to_lowercase().ends_with(".hoot");
        is_hoot.then_some(Self::NotRead(
            "a log of CTRE Phoenix (.hoot)",
            "convert it with CTRE's owlet: owlet FILE log.wpilog -f wpilog",
        ))
    }

    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parquet => "a Parquet file",
            Self::Mcap => "an MCAP file",
            Self::Rosbag => "a ROS 2 bag (SQLite)",
            Self::WpiLog => "a WPILOG file",
            Self::SysId => "SysId JSON",
            Self::Mat5 => "a MAT file (version 5)",
            Self::Hdf5 => "a MAT file of version 7.3 (HDF5)",
            Self::Json => "JSON",
            Self::Lvm => "an LVM file of LabVIEW",
            Self::Teleplot => "a log of Teleplot's lines",
            Self::Pairs => "a table with two columns for each signal",
            Self::Scope => "an oscilloscope's export",
            Self::Decimals => "a table with decimal commas between commas",
            Self::Lists => "a table with a signal in each line",
            Self::Printed => "a matrix as MATLAB prints it",
            Self::Documents => "a log of documents, a key a line",
            Self::LineProtocol => "a log of InfluxDB's line protocol",
            Self::Long => "a table with a row for each value of each signal",
            Self::Wordy => "a table with lists or units in its cells",
            Self::NotRead(what, _) => what,
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// A damaged file, no numbers, or an unsupported format.
    pub fn read(self, bytes: &[u8]) -> Result<Table, FormatError> {
        let bytes = match self {
            Self::Json
            | Self::Lvm
            | Self::Teleplot
            | Self::Pairs
            | Self::Scope
            | Self::Decimals
            | Self::Lists
            | Self::Printed
            | Self::Documents
            | Self::LineProtocol
            | Self::Long
            | Self::Wordy => bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            _ => bytes,
        };
        let table = match self {
            Self::Json => json::read(bytes),
            Self::Lvm => lvm::read(bytes),
            Self::Teleplot => teleplot::read(bytes),
            Self::Pairs => pairs::read(bytes),
            Self::Scope => scope::read(bytes),
            Self::Decimals => decimals::read(bytes),
            Self::Lists => lists::read(bytes),
            Self::Printed => printed::read(bytes),
            Self::Documents => documents::read(bytes),
            Self::LineProtocol => line_protocol::read(bytes),
            Self::Long => long::read(bytes),
            Self::Wordy => wordy::read(bytes),
            Self::WpiLog => wpilog::read(bytes),
            Self::SysId => sysid::read(bytes),
            Self::Mat5 => mat5::read(bytes),
            Self::NotRead(what, remedy) => Err(FormatError::NotRead { what, remedy }),
            #[cfg(feature = "formats")]
            Self::Parquet => contained::contained(self, || parquet::read(bytes)),
            #[cfg(feature = "formats")]
            Self::Mcap => mcap::read(bytes),
            #[cfg(feature = "formats")]
            Self::Rosbag => rosbag::read(bytes),
            #[cfg(feature = "formats")]
            Self::Hdf5 => contained::contained(self, || hdf5::read(bytes)),
            #[cfg(not(feature = "formats"))]
            Self::Parquet | Self::Mcap | Self::Rosbag | Self::Hdf5 => {
                Err(FormatError::NotBuilt { what: self.name() })
            }
        }?;
        if table.columns.len() < 2 || table.rows() == 0 {
            return Err(self.nothing(""));
        }
        Ok(table)
    }

    fn broken(self, why: impl ToString) -> FormatError {
        FormatError::Broken {
            what: self.name(),
            why: why.to_string(),
        }
    }

    fn nothing(self, why: &str) -> FormatError {
        FormatError::Nothing {
            what: self.name(),
            why: match why {
                "" => String::new(),
                why => format!(": {why}"),
            },
        }
    }

    fn too_much(self, of: &'static str) -> FormatError {
        FormatError::TooMuch {
            what: self.name(),
            most: MOST_VALUES as u64,
            of,
        }
    }
}
