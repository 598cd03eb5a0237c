//! The crash-safe writer of run files.
//!
//! Rows are appended and flushed to the operating system at least every [`FLUSH_EVERY`], so that the file of a killed
//! process has every complete row up to then. The summary is known only at the end but belongs into the header: a
//! block of comment lines is reserved there, and [`RunWriter::finish`] overwrites it in place with `complete = true`
//! and the summary. A file without that line ended irregularly.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::WriteError;
use super::free_name::create_free;
use super::row::{Columns, Row, RowFormatter};
use super::rows::MAX_ROWS;
use crate::plain::one_line_table;
use crate::platform::files::{File, has_vanished, remove_file, write_at};
use crate::platform::time::Instant;

/// Value of the `format` key.
pub const RUN_FORMAT: &str = "motorlab-run/1";

/// Longest time that rows wait in memory (if [`RunWriter::flush_if_due`] is called when they are [`RunWriter::due`]).
pub const FLUSH_EVERY: Duration = Duration::from_millis(25);

/// Shortest time between two flushes.
const FLUSH_REST: Duration = Duration::from_micros(500);

/// Bytes reserved in the header for the summary: 30 keys of 40 characters, more than any has.
const RESERVED_BYTES: usize = 1200;

/// Most bytes of rows in memory.
const MOST_BUFFERED: usize = 1 << 18;

/// Writer of one run file. Dropping it without [`RunWriter::finish`] leaves a readable, incomplete file.
#[derive(Debug)]
pub struct RunWriter {
    file: File,
    path: PathBuf,
    formatter: RowFormatter,
    buffer: Vec<u8>,
    /// Bytes of header and complete rows passed to the operating system.
    written_bytes: u64,
    rows: u64,
    buffered_rows: u64,
    last_flush: Instant,
    reserved_at: u64,
}

impl RunWriter {
    /// Begins a file with `header` and the key `format`. An existing file is never overwritten: the next free name is
    /// taken, as [`RunWriter::path`] states.
    pub fn create(path: &Path, header: &toml::Table, columns: Columns) -> Result<Self, WriteError> {
        let (file, path) = create_free(path)?;
        let mut writer = Self {
            file,
            path,
            formatter: RowFormatter::new(columns, header),
            buffer: Vec::with_capacity(1 << 14),
            written_bytes: 0,
            rows: 0,
            buffered_rows: 0,
            last_flush: Instant::now(),
            reserved_at: 0,
        };
        writer.reserved_at = writer.write_header(header)?;
        writer.flush()?;
        Ok(writer)
    }

    /// Writes the header into the buffer; returns the offset of its reserved block.
    fn write_header(&mut self, header: &toml::Table) -> Result<u64, WriteError> {
        let (tables, plain): (toml::Table, toml::Table) = one_line_table(header)
            .into_iter()
            .filter(|(key, _)| key != "format" && key != "complete" && key != "summary")
            .partition(|(_, value)| value.is_table());
        comment_lines(&mut self.buffer, &format!("format = \"{RUN_FORMAT}\""));
        comment_lines(&mut self.buffer, &toml::to_string(&plain)?);
        let reserved_at = self.buffer.len() as u64;
        fill(&mut self.buffer, RESERVED_BYTES);
        comment_lines(&mut self.buffer, &toml::to_string(&tables)?);
        self.formatter.push_names(&mut self.buffer);
        Ok(reserved_at)
    }

    /// Path of the file: the requested one, or the next free name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Rows appended so far.
    pub fn rows(&self) -> u64 {
        self.rows + self.buffered_rows
    }

    /// Appends one row with its speed estimate, which is returned in rad/s.
    pub fn append(&mut self, row: &Row) -> Result<Option<f64>, WriteError> {
        if self.rows() >= MAX_ROWS as u64 {
            self.flush()?;
            return Err(WriteError::Append {
                path: self.path.clone(),
                rows: self.rows,
                source: io::Error::other("a run has no more rows than that; begin another file"),
            });
        }
        let speed = self.formatter.push_row(&mut self.buffer, row);
        self.buffered_rows += 1;
        if self.buffer.len() >= MOST_BUFFERED {
            self.flush()?;
        }
        Ok(speed)
    }

    /// Flushes the rows if the last flush is at least half a millisecond ago; returns whether it is.
    pub fn flush_if_due(&mut self) -> Result<bool, WriteError> {
        if self.last_flush.elapsed() < FLUSH_REST {
            return Ok(false);
        }
        self.flush().map(|()| true)
    }

    /// Time by which the rows in memory must be flushed; `None` if there are none.
    pub fn due(&self) -> Option<Instant> {
        (self.buffered_rows > 0).then(|| self.last_flush + FLUSH_EVERY)
    }

    /// Flushes all rows to the operating system. After an error the file ends with a complete row; after
    /// [`WriteError::Vanished`] the writer remains usable and continues in the rescued copy.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.last_flush = Instant::now();
        if self.buffer.is_empty() {
            return Ok(());
        }
        self.refuse_altered()?;
        if let Err(source) = self.file.write_all(&self.buffer) {
            return Err(self.cut_back(source));
        }
        self.written_bytes += self.buffer.len() as u64;
        self.rows += std::mem::take(&mut self.buffered_rows);
        self.buffer.clear();
        if has_vanished(&self.file, &self.path) {
            return self.rescue();
        }
        Ok(())
    }

    /// Appending to a file that another program has truncated would leave a hole of zeros.
    fn refuse_altered(&self) -> Result<(), WriteError> {
        let found_bytes = self.file.metadata().map_or(0, |metadata| metadata.len());
        if found_bytes == self.written_bytes {
            return Ok(());
        }
        Err(WriteError::Altered {
            path: self.path.clone(),
            rows: self.rows,
            written_bytes: self.written_bytes,
            found_bytes,
        })
    }

    /// Removes the file of a recording that did not begin.
    pub fn discard(self) {
        if self.rows() == 0 && !has_vanished(&self.file, &self.path) {
            // If this fails, a file with a header and no rows remains.
            let _ = remove_file(&self.path);
        }
    }

    /// After a failed write: keeps the complete rows.
    fn cut_back(&mut self, source: io::Error) -> WriteError {
        let on_disk = self.file.metadata().map_or(0, |metadata| metadata.len());
        let got_through = on_disk.saturating_sub(self.written_bytes) as usize;
        let got_through = &self.buffer[..got_through.min(self.buffer.len())];
        let whole = got_through
            .iter()
            .rposition(|&byte| byte == b'\n')
            .map_or(0, |newline| newline + 1);
        let newlines = got_through[..whole].iter().filter(|&&byte| byte == b'\n');
        self.rows += (newlines.count() as u64).min(self.buffered_rows);
        self.written_bytes += whole as u64;
        self.buffer.clear();
        self.buffered_rows = 0;
        let cut = self.file.set_len(self.written_bytes);
        WriteError::Append {
            path: self.path.clone(),
            rows: self.rows,
            source: cut.err().unwrap_or(source),
        }
    }

    /// Copies a deleted file, whose open handle is still valid, to an existing folder, and continues there.
    fn rescue(&mut self) -> Result<(), WriteError> {
        let name = self.path.file_name().unwrap_or("run.csv".as_ref());
        let places = [PathBuf::new(), std::env::temp_dir()];
        let copy = places.iter().find_map(|place| {
            let (mut file, path) = create_free(&place.join(name)).ok()?;
            let copied = copy_all(&self.file, &mut file);
            copied.ok().map(|()| (file, path))
        });
        let Some((file, rescued)) = copy else {
            return Err(WriteError::Append {
                path: self.path.clone(),
                rows: 0,
                source: io::Error::new(
                    io::ErrorKind::NotFound,
                    "the file vanished, and there is no other place for it",
                ),
            });
        };
        self.file = file;
        let path = std::mem::replace(&mut self.path, rescued.clone());
        Err(WriteError::Vanished { path, rescued })
    }

    /// Ends the file: flushes, writes `summary` into the header, and `complete = true` if `complete`.
    pub fn finish(mut self, summary: &toml::Table, complete: bool) -> Result<PathBuf, WriteError> {
        match self.flush() {
            Ok(()) | Err(WriteError::Vanished { .. }) => {}
            Err(error) => return Err(error),
        }
        self.refuse_altered()?;
        let mut block = Vec::new();
        if complete {
            comment_lines(&mut block, "complete = true");
        }
        for (key, value) in summary {
            let before = block.len();
            comment_lines(&mut block, &format!("summary.{key} = {value}"));
            if block.len() + SHORTEST_FILL > RESERVED_BYTES {
                block.truncate(before);
            }
        }
        let free = RESERVED_BYTES - block.len();
        fill(&mut block, free);
        let patch = |file: &File| -> io::Result<()> {
            file.sync_data()?;
            write_at(file, &block, self.reserved_at)?;
            file.sync_data()
        };
        patch(&self.file).map_err(|source| WriteError::Append {
            path: self.path.clone(),
            rows: self.rows,
            source,
        })?;
        Ok(self.path)
    }
}

fn comment_lines(buffer: &mut Vec<u8>, text: &str) {
    for line in text.lines() {
        buffer.extend_from_slice(if line.is_empty() { b"#" } else { b"# " });
        buffer.extend_from_slice(line.as_bytes());
        buffer.push(b'\n');
    }
}

/// Shortest line that is a comment in TOML as well: `# #` and the newline.
const SHORTEST_FILL: usize = 4;

/// Appends exactly `length` bytes (0, or at least [`SHORTEST_FILL`]) of empty comment lines.
fn fill(buffer: &mut Vec<u8>, mut length: usize) {
    const LINE: usize = 100;
    while length >= SHORTEST_FILL {
        let line = if length >= LINE + SHORTEST_FILL {
            LINE
        } else {
            length
        };
        buffer.extend_from_slice(b"# #");
        buffer.resize(buffer.len() + line - SHORTEST_FILL, b'.');
        buffer.push(b'\n');
        length -= line;
    }
}

/// Copies all of `from` into `to`, which is left at its end.
fn copy_all(mut from: &File, to: &mut File) -> io::Result<()> {
    use std::io::Seek;
    from.rewind()?;
    io::copy(&mut from, to)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{CommandKind, difference_velocities, next_free_name};
    use crate::recording::{Flags, Time};

    fn header() -> toml::Table {
        "sample_time_s = 0.003\ncounts_per_rev = 720\nprofile = \"step\"\nport = { vid = 9025 }"
            .parse()
            .expect("TOML")
    }

    fn row(seq: u64, counts: i64) -> Row {
        Row {
            seq: Some(seq),
            time: Time::Micros(seq as i64 * 3000),
            host: Some(Time::Micros(seq as i64 * 3001 + 12)),
            command: 4.5,
            counts,
            flags: Flags::default(),
            supply_v: None,
            current_a: None,
        }
    }

    /// The leading comment lines as one TOML document.
    fn header_of(text: &str) -> toml::Table {
        text.lines()
            .map_while(|line| line.strip_prefix('#'))
            .map(|line| format!("{}\n", line.trim_start_matches(' ')))
            .collect::<String>()
            .parse()
            .expect("the header is TOML")
    }

    #[test]
    fn an_ended_file_has_its_summary_at_the_top() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("run.csv");
        let columns = Columns::recorded(CommandKind::Voltage);
        let mut writer = RunWriter::create(&path, &header(), columns).expect("writable");
        let counts = [0, 2, 8, -5];
        let seq = [0, 1, 4, 5];
        let mut speeds = Vec::new();
        for (&seq, &counts) in seq.iter().zip(&counts) {
            speeds.push(writer.append(&row(seq, counts)).expect("writable"));
        }
        writer.flush().expect("writable");
        let before = std::fs::read_to_string(&path).expect("text");
        assert!(!header_of(&before).contains_key("complete"));
        let summary = "samples = 4\nlost = 2\nclock = { ppm = 1.5 }"
            .parse()
            .expect("TOML");
        writer.finish(&summary, true).expect("writable");

        let text = std::fs::read_to_string(&path).expect("text");
        assert_eq!(text.len(), before.len());
        let read = header_of(&text);
        assert_eq!(read["format"].as_str(), Some(RUN_FORMAT));
        assert_eq!(read["complete"].as_bool(), Some(true));
        assert_eq!(read["summary"]["lost"].as_integer(), Some(2));
        assert_eq!(read["port"]["vid"].as_integer(), Some(9025));
        let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(
            rows[0],
            "seq,t_s,host_t_s,command_v,counts,velocity_rad_s,flags"
        );
        assert_eq!(rows[1], "0,0.000000,0.000012,4.5,0,,");
        assert!(rows[3].starts_with("4,0.012000,0.012016,4.5,8,5.81776"));
        assert_eq!(
            speeds,
            difference_velocities(&counts, Some(&seq), 720.0, 0.003)
        );
    }

    #[test]
    fn an_existing_file_is_never_overwritten() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("run.csv");
        let columns = Columns::recorded(CommandKind::Voltage);
        let names: Vec<PathBuf> = (0..3)
            .map(|_| {
                let free = next_free_name(&path);
                let writer = RunWriter::create(&path, &header(), columns).expect("writable");
                assert_eq!(writer.path(), free);
                free
            })
            .collect();
        let expected =
            ["run.csv", "run-2.csv", "run-3.csv"].map(|name| directory.path().join(name));
        assert_eq!(names, expected);
    }

    #[test]
    fn a_file_truncated_by_another_program_is_reported() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("run.csv");
        let columns = Columns::recorded(CommandKind::Voltage);
        let mut writer = RunWriter::create(&path, &header(), columns).expect("writable");
        writer.append(&row(0, 0)).expect("writable");
        writer.flush().expect("writable");
        let cut = File::options().write(true).open(&path).expect("writable");
        cut.set_len(10).expect("writable");
        writer.append(&row(1, 1)).expect("buffered");
        let error = writer.flush().expect_err("it was cut");
        assert!(
            matches!(
                error,
                WriteError::Altered {
                    rows: 1,
                    found_bytes: 10,
                    ..
                }
            ),
            "{error}"
        );
        assert_eq!(std::fs::metadata(&path).expect("a file").len(), 10);
        assert!(writer.finish(&toml::Table::new(), true).is_err());
    }

    #[test]
    fn a_missing_directory_is_reported() {
        let columns = Columns::recorded(CommandKind::Voltage);
        let error = RunWriter::create(Path::new("/nowhere/run.csv"), &header(), columns)
            .expect_err("no such directory");
        assert!(error.to_string().contains("/nowhere/run.csv"));
        let kind = match error {
            WriteError::Create { source, .. } => source.kind(),
            other => panic!("{other}"),
        };
        assert_eq!(kind, io::ErrorKind::NotFound);
    }

    #[test]
    fn a_file_deleted_while_it_is_written_is_rescued() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("vanishing-run.csv");
        let columns = Columns::recorded(CommandKind::Voltage);
        let mut writer = RunWriter::create(&path, &header(), columns).expect("writable");
        writer.append(&row(0, 0)).expect("writable");
        writer.flush().expect("writable");
        std::fs::remove_file(&path).expect("deletable");
        writer.append(&row(1, 1)).expect("writable");
        let error = writer.flush().expect_err("it vanished");
        let WriteError::Vanished { rescued, .. } = error else {
            panic!("{error}");
        };
        writer.append(&row(2, 2)).expect("writable");
        writer.finish(&toml::Table::new(), true).expect("writable");
        let text = std::fs::read_to_string(&rescued).expect("text");
        std::fs::remove_file(&rescued).expect("deletable");
        assert_eq!(
            text.lines().filter(|line| !line.starts_with('#')).count(),
            4
        );
        assert_eq!(header_of(&text)["complete"].as_bool(), Some(true));
    }

    #[test]
    fn the_reserved_block_is_filled_to_the_byte() {
        for length in (SHORTEST_FILL..700).chain([RESERVED_BYTES]) {
            let mut buffer = Vec::new();
            fill(&mut buffer, length);
            assert_eq!(buffer.len(), length);
            let text = String::from_utf8(buffer).expect("text");
            assert!(text.lines().all(|line| line.starts_with("# #")));
            assert!(text.ends_with('\n'));
        }
    }
}
