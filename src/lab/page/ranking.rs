//! What would explain the gap: the diagnosis, and the causes that it weighed.

use crate::diagnose::Diagnosis;
use crate::lab::missing::{cause_numbers, cause_words};
use crate::report::Page;
use crate::report::demo::two_measures;
use crate::report::diagnosis::PARTS;
use crate::report::number::percent;

/// How many causes the report lists.
const LISTED: usize = 8;

/// The section of the page.
pub(super) fn section(page: &mut Page, diagnosis: &Diagnosis) {
    page.subsection("What would explain the gap");
    let said = diagnosis.parts.iter().map(String::as_str);
    page.note(&two_measures(diagnosis));
    page.parts(&PARTS.into_iter().zip(said).collect::<Vec<_>>());
    let rows: Vec<Vec<String>> = diagnosis
        .causes
        .iter()
        .take(LISTED)
        .map(|cause| {
            vec![
                cause_words(cause).to_owned(),
                percent(cause.probability),
                cause_numbers(cause),
                cause.indistinguishable_from.join(", "),
            ]
        })
        .collect();
    page.table(
        &[
            "cause",
            "probability",
            "numbers [95\u{a0}% interval]",
            "fits as well",
        ],
        &rows,
    );
    page.note(
        "Every effect of the catalogue, none and something unknown, weighed on all recordings together, as motorlab diagnose does. Steps of one voltage tell few causes apart; a reversing profile tells more.",
    );
}
