//! What else is to be known beside the verdict; empty where there is nothing.

use super::{Beside, cause, size};
use crate::diagnose::conclusion::since;
use crate::diagnose::conclusion::words::rivals;
use crate::diagnose::report::{Diagnosis, Verdict};
use crate::diagnose::settings::{FEW_PIECES, SURE};

/// The note of a verdict.
pub(crate) fn note(said: &Diagnosis, beside: &Beside) -> String {
    let mut notes: Vec<String> = Vec::new();
    notes.extend(size::source(said));
    notes.extend(visible(beside));
    notes.extend(not_borne_out(said, beside));
    notes.extend(beside.since.as_ref().and_then(since::alike));
    notes.extend(cause::bent(said, beside));
    notes.extend((said.gap.wander > 0.0).then(|| size::wander(said, beside)));
    if beside.pieces < FEW_PIECES {
        let pieces = match beside.pieces {
            1 => "one piece".to_owned(),
            n => format!("{n} pieces"),
        };
        notes.push(format!(
            "The runs are {pieces}, fewer than {FEW_PIECES}: nothing is said with more than {:.0} %.",
            100.0 * SURE
        ));
    }
    if beside.pieces < beside.all_pieces {
        notes.push(format!(
            "Searched were {} of {} pieces, drawn evenly over what the motor does; the rungs are those of all.",
            beside.pieces, beside.all_pieces
        ));
    }
    if beside.is_doubtful {
        notes.push(format!(
            "Something fatal is found in the recordings: nothing is said with more than {:.0} %.",
            100.0 * SURE
        ));
    }
    notes.join(" ")
}

/// What the search kept and the pieces that were not fitted do not bear out.
fn not_borne_out(said: &Diagnosis, beside: &Beside) -> Option<String> {
    let is_dropped = said.verdict == Verdict::OutsideCatalogue && !beside.tied.is_empty();
    is_dropped.then(|| {
        format!(
            "The search kept {}. Other numbers alone predict as well, so it is not named.",
            rivals(&beside.tied)
        )
    })
}

/// What is visible below the floor.
fn visible(beside: &Beside) -> Option<String> {
    if !beside.is_by_floor {
        return None;
    }
    Some(match (beside.tied.is_empty(), beside.unknown > 0.5) {
        (true, _) => {
            "Visible below the floor is something that no named effect explains.".to_owned()
        }
        (false, true) => format!(
            "Visible below the floor is {}, and something more.",
            rivals(&beside.tied)
        ),
        (false, false) => format!("Visible below the floor is {}.", rivals(&beside.tied)),
    })
}
