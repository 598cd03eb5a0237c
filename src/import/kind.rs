//! Distinguishes damaged run files from logs of other programs.

use super::Form;

/// Columns of a run file without a header.
const OWN_COLUMNS: [&str; 2] = ["t_s", "counts"];

/// Kind of a file that cannot be read as a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// A damaged run file.
    Run,
    /// A log of another program.
    Log,
    /// Neither, with its description.
    NoLog(String),
}

impl Kind {
    /// The kind from the beginning of a file and its name.
    #[must_use]
    pub fn of(head: &[u8], name: &str) -> Self {
        if head.is_empty() {
            return Self::NoLog("it is empty\nhint: record again, or name another file".to_owned());
        }
        match Form::of(head).or_else(|| Form::of_name(name)) {
            Some(form @ Form::NotRead(..)) => {
                let why = form.read(&[]).err().map(|error| error.to_string());
                return Self::NoLog(why.unwrap_or_default());
            }
            Some(_) => return Self::Log,
            None => {}
        }
        let text = String::from_utf8_lossy(head);
        let is_of_a_run = |line: &str| {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            OWN_COLUMNS.iter().all(|name| cells.contains(name))
        };
        match text.contains("motorlab-run/") || text.lines().any(is_of_a_run) {
            true => Self::Run,
            false => Self::Log,
        }
    }
}
