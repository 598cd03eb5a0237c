//! Runs the `motorlab` command and reads its results.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// The command with these arguments, in `directory`, with captured output.
pub fn motorlab(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motorlab"));
    command
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Runs it to its end.
pub fn run(directory: &Path, arguments: &[&str]) -> Finished {
    let output = motorlab(directory, arguments).output();
    Finished::from(output.expect("the command starts"))
}

/// Starts it.
pub fn start(directory: &Path, arguments: &[&str]) -> Child {
    motorlab(directory, arguments)
        .spawn()
        .expect("the command starts")
}

/// Waits for its end.
pub fn finish(child: Child) -> Finished {
    Finished::from(child.wait_with_output().expect("the command ends"))
}

/// A finished command.
#[derive(Debug)]
pub struct Finished {
    /// Exit status; `None` if a signal killed it.
    pub status: Option<i32>,
    /// Standard output.
    pub output: String,
    /// Standard error.
    pub messages: String,
}

impl From<Output> for Finished {
    fn from(output: Output) -> Self {
        Self {
            status: output.status.code(),
            output: String::from_utf8_lossy(&output.stdout).into_owned(),
            messages: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

/// A run file as text: its header as TOML, the names of its columns, its rows.
#[derive(Debug)]
pub struct RunFile {
    /// The leading comment lines.
    pub header: toml::Table,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Cells by row, without an incomplete last row.
    pub rows: Vec<Vec<String>>,
    /// The whole file.
    pub text: String,
}

impl RunFile {
    /// Reads the file without the program's code.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a run file");
        let header: String = text
            .lines()
            .map_while(|line| line.strip_prefix('#'))
            .map(|line| format!("{}\n", line.trim_start_matches(' ')))
            .collect();
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let columns = lines.next().expect("column names");
        let rows: Vec<_> = lines.collect();
        for row in &rows {
            assert_eq!(row.len(), columns.len(), "{row:?}");
        }
        Self {
            header: header.parse().expect("the header is TOML"),
            columns,
            rows,
            text,
        }
    }

    /// A column as numbers.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let index = self.columns.iter().position(|column| column == name);
        let index = index.unwrap_or_else(|| panic!("no column {name}"));
        self.rows
            .iter()
            .map(|row| row[index].parse().unwrap_or(f64::NAN))
            .collect()
    }

    /// A number of the summary in the header.
    pub fn summary(&self, key: &str) -> i64 {
        self.header["summary"][key].as_integer().expect("a count")
    }

    /// Whether the recorder marked the file as ended.
    pub fn complete(&self) -> bool {
        self.header.get("complete").and_then(toml::Value::as_bool) == Some(true)
    }
}
