//! The file of rejected rows: every bad row with its line and the reason, beside the run.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::cells::{decode, shortened};
use super::error::RowProblem;
use super::{BadRow, ImportProblem};
use crate::platform::files::{File, remove_file};
use crate::recording::next_free_name;

/// Bad rows that are kept for the summary; the file has all.
const MOST_KEPT: usize = 20;
/// Characters of a bad row that the file shows.
const MOST_SHOWN: usize = 500;

/// Gathers bad rows. The file is made with the first.
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

    /// One more.
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

    /// Where the bad rows are, if there were any.
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

    /// Takes the file away again, where nothing came of the import.
    pub fn forget(mut self) {
        if self.file.take().is_some() {
            // It is only a help; that it stays is no harm.
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
