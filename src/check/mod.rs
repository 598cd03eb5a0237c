//! What is wrong with a recording itself, before anything is concluded from it.
//!
//! [`check`] holds what a recording says against what a motor can do. Each kind of finding is a file with one
//! function, and a line in the table `KINDS`. A finding has the figures that it rests on and the remedy: the flag, the key of
//! the mapping or the wire to change. What an effect of the catalogue can model is never fatal.
//!
//! ```
//! use motorlab::check::{Kind, Severity, check};
//! use motorlab::recording::Run;
//!
//! let run = Run {
//!     t_s: vec![0.0, 0.003],
//!     command: vec![4.5, 4.5],
//!     counts: vec![0, 1],
//!     ..Run::default()
//! };
//! let findings = check(&[run], None);
//! assert_eq!(findings[0].id, Kind::TooShort);
//! assert_eq!(findings[0].severity, Severity::Fatal);
//! ```

mod finding;
mod subject;
mod too_short;

pub use finding::{Finding, Kind, Severity, is_fatal};
use subject::Subject;

use crate::motor::Motor;
use crate::recording::Run;

/// A kind of finding: everything of it in one run.
type Find = fn(&Subject<'_>) -> Vec<Finding>;

/// Every kind, in the order in which those of the same severity are listed.
const KINDS: &[Find] = &[too_short::find];

/// Everything that is wrong with these runs, what is fatal first; with the motor file where there is one.
pub fn check(runs: &[Run], motor: Option<&Motor>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        let name = match &run.path {
            Some(path) => path.display().to_string(),
            None => (k + 1).to_string(),
        };
        let subject = Subject {
            run,
            name: &name,
            motor,
        };
        findings.extend(KINDS.iter().flat_map(|find| find(&subject)));
    }
    findings.sort_by_key(|finding| finding.severity);
    findings
}
