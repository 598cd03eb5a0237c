//! The file of rejected rows with line and reason, beside the run.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::cells::{decode, shortened};
use super::error::RowProblem;
use super::{BadRow, ImportProblem};
use crate::platform::files::{File, remove_file};
use crate::recording::next_free_name;

/// Most rejected rows in the summary; the file has all.
const MOST_KEPT: usize = 20;
/// Most characters of a rejected row in the file.
const MOST_SHOWN: usize = 500;

/// Collects rejected rows. The file is created with the first.
#[derive(Debug)]
pub(super) struct Rejected {
    path: PathBuf,
    file: Option<BufWriter<File>>,
    pub count: u64,
    pub first: Vec<BadRow>,
}

impl Rejected {
    /// `run.rejected.csv` beside `run.csv`.
    pub fn beside(output: &Path) -> Self {
        Self {
            path: output.with_extension("rejected.csv"),
            file: None,
            count: 0,
            first: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(
        &mut self,
        line: u64,
        problem: &RowProblem,
        content: &[u8],
    ) -> Result<(), ImportProblem> {
        let row = BadRow {
            line,
            why: problem.to_string(),
        };
        self.write(&row, content)
            .map_err(|source| ImportProblem::Rejected {
                path: self.path.clone(),
                source,
            })?;
        self.count += 1;
        if self.first.len() < MOST_KEPT {
            self.first.push(row);
        }
        Ok(())
    }

    fn write(&mut self, row: &BadRow, content: &[u8]) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            None => {
                self.path = next_free_name(&self.path);
                let mut file = BufWriter::new(File::create_new(&self.path)?);
                writeln!(file, "line,why,row")?;
                self.file.insert(file)
            }
        };
        let content = &content[..content.len().min(MOST_SHOWN)];
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let text: String = decode(content)
            .chars()
            .filter(|c| !c.is_control() || *c == '\t')
            .collect();
        writeln!(file, "{},{},{}", row.line, quoted(&row.why), quoted(&text))
    }

    /// Path of the file, if there were rejected rows.
    pub fn finish(mut self) -> Result<Option<PathBuf>, ImportProblem> {
        let Some(mut file) = self.file.take() else {
            return Ok(None);
        };
        match file.flush() {
            Ok(()) => Ok(Some(self.path)),
            Err(source) => Err(ImportProblem::Rejected {
                path: self.path,
                source,
            }),
        }
    }

    /// Removes the file of a failed import.
    pub fn forget(mut self) {
        if self.file.take().is_some() {
            // A leftover is harmless.
            let _ = remove_file(&self.path);
        }
    }
}

/// The value of a split column as part of a file name.
pub(super) fn for_file_name(value: &str) -> String {
    let good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_' | '+');
    let name: String = shortened(value)
        .chars()
        .map(|c| if good(c) { c } else { '_' })
        .collect();
    name
}
