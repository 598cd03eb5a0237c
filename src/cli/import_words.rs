//! Text output of `motorlab import`.

use std::path::Path;

use super::Output;
use crate::import::{Imported, Understood};
use crate::plain::{one_line, shown};

/// The interpretation of the log's columns.
pub(super) fn print_understood(
    output: &Output,
    name: &str,
    understood: &[Understood],
    notes: &[String],
) {
    if !understood.is_empty() {
        output.message(&format!("{name}: understood as"));
    }
    for one in understood {
        let what = match one.what {
            "counts_per_rev" => "encoder",
            what => what,
        };
        output.message(&format!("  {what:<9} {}", one_line(&one.words)));
    }
    for note in notes {
        output.message(&format!("{name}: {}", one_line(note)));
    }
}

/// The result of the import.
pub(super) fn say(output: &Output, name: &str, imported: &Imported) {
    for run in &imported.runs {
        let (shortest_s, longest_s) = run.steps_s;
        output.message(&format!(
            "wrote {}: {} samples in {:.3} s, sample time {} s (steps {shortest_s} to {longest_s} s)",
            shown(&run.path),
            run.samples,
            run.duration_s,
            run.sample_time_s,
        ));
    }
    print_rows(output, name, imported, imported.rejected.as_deref());
}

/// The rows of the result. The rejected ones are in the file `rejected`, if it is kept.
pub(super) fn print_rows(
    output: &Output,
    name: &str,
    imported: &Imported,
    rejected: Option<&Path>,
) {
    if imported.rows_without_position > 0 {
        output.message(&format!(
            "{name}: {} of {} rows have no position and only set what is held",
            imported.rows_without_position, imported.rows
        ));
    }
    if let Some(most) = imported.most_full_drives {
        output.message(&format!(
            "{name}: {} of {} rows command more than full drive, up to {most:.3} of it, and are taken as full drive; \
             is another number full drive (--pwm-full)?",
            imported.beyond_full_drive, imported.rows
        ));
    }
    if imported.unended {
        output.message(&format!(
            "{name}: the last line has no line end; if the log was cut off there, its last number may be short"
        ));
    }
    if imported.bad_rows == 0 {
        return;
    }
    let kept = match rejected {
        Some(rejected) => format!("all of them are in {}", shown(rejected)),
        None => "motorlab import keeps them all in a file".to_owned(),
    };
    output.message(&format!(
        "{name}: {} of {} rows cannot be used and count as lost; {kept}:",
        imported.bad_rows, imported.rows,
    ));
    for row in &imported.first_bad {
        output.message(&format!("  {row}"));
    }
    let listed = imported.first_bad.len() as u64;
    if imported.bad_rows > listed {
        output.message(&format!("  and {} more", imported.bad_rows - listed));
    }
}
