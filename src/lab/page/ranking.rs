//! The diagnosis of Part 3: its sentence and the most probable causes.

use crate::diagnose::Diagnosis;
use crate::lab::missing::cause_numbers;
use crate::report::Page;
use crate::report::demo::two_measures;
use crate::report::diagnosis::named_parts;
use crate::report::number::probability;

/// Most causes listed.
const LISTED: usize = 8;

pub(super) fn section(page: &mut Page, diagnosis: &Diagnosis) {
    page.subsection("Causes of the gap");
    page.note(&two_measures(diagnosis));
    page.parts(&named_parts(diagnosis));
    let rows: Vec<Vec<String>> = diagnosis
        .causes
        .iter()
        .take(LISTED)
        .map(|cause| {
            vec![
                cause.effect.to_owned(),
                probability(cause.inclusion),
                cause_numbers(cause),
                cause.class.unwrap_or("\u{2013}").to_owned(),
            ]
        })
        .collect();
    page.table(
        &[
            "effect",
            "inclusion probability",
            "parameters [95\u{a0}% interval]",
            "class",
        ],
        &rows,
    );
    page.note(
        "Inclusion probability: the sum over all sets of effects that contain it, from all recordings together, as motorlab diagnose computes it. Class: effects that these recordings do not separate. Steps of one voltage separate few effects; a reversing profile separates more.",
    );
}
