//! The page of a class: a row per student, then each student's recordings.

use super::class::{Class, Recording, Student};
use super::outcome::Outcome;
use crate::report::number::{figure, probability_of, time};
use crate::report::{Cell, Page};

/// Placeholder for a missing figure.
const NONE: &str = "\u{2013}";

/// The page.
pub fn page(class: &Class) -> String {
    let mut page = Page::new("Diagnoses of a class");
    page.lead(&summary(class));
    let rows: Vec<Vec<Cell>> = class.students.iter().map(row).collect();
    page.linked_table(
        &[
            "student",
            "recorded (broad) over simulated",
            "verdict",
            "record again",
            "nominal error (counts)",
            "noise floor (counts)",
            "usable",
            "recordings",
        ],
        &rows,
    );
    page.note(
        "The picture is of the first recording that is diagnosed, else of the first that can be read: speed over the whole recording. Nominal error: held-out prediction error of the nominal model in counts RMS, over segments of the recordings from their measured initial states. Noise floor: quantization, repeatability and what is good enough. Probability: of the named effects; of no gap and parameter mismatch, that no effect is present. All usable recordings of a student together.",
    );
    unusable(&mut page, class);
    for student in &class.students {
        section(&mut page, student);
    }
    page.finish()
}

fn summary(class: &Class) -> String {
    let sound = class
        .students
        .iter()
        .filter(|student| student.is_sound())
        .count();
    let all = class.students.len();
    let of_all = match all == class.folders {
        true => String::new(),
        false => format!(
            " The work was stopped after {all} of {} folders.",
            class.folders
        ),
    };
    let rest = match all - sound {
        0 => "All that they hold is usable.".to_owned(),
        1 => "In one of them something is not usable.".to_owned(),
        several => format!("In {several} of them something is not usable."),
    };
    match all {
        0 => format!("{} holds no folder.{of_all}", class.folder),
        1 => format!("One folder in {}. {rest}{of_all}", class.folder),
        all => format!("{all} folders in {}. {rest}{of_all}", class.folder),
    }
}

fn row(student: &Student) -> Vec<Cell> {
    let outcome = student.together.as_ref();
    let or_none = |text: Option<String>| text.unwrap_or_else(|| NONE.to_owned());
    let all = student.recordings.len();
    let usable = all - student.unusable().count();
    let verdict = outcome.map_or_else(|| student.words(), Outcome::verdict_words);
    let again = student.record_again();
    let again = (!again.is_empty()).then(|| again.join("; "));
    let pictures = || student.recordings.iter();
    let diagnosed = pictures().find(|one| one.outcome.is_some() && one.picture.is_some());
    let picture = diagnosed.or_else(|| pictures().find(|one| one.picture.is_some()));
    let picture = picture.and_then(|one| one.picture.clone());
    let links = student.recordings.iter();
    let links = links.map(|one| (one.name.clone(), one.page_file.clone()));
    vec![
        Cell::Text(student.name.clone()),
        picture.map_or_else(|| Cell::Text(NONE.to_owned()), Cell::Drawing),
        Cell::Text(verdict),
        Cell::Text(or_none(again)),
        Cell::Text(or_none(
            outcome.map(|outcome| figure(outcome.gap_counts, 3)),
        )),
        Cell::Text(or_none(
            outcome.map(|outcome| figure(outcome.floor_counts, 3)),
        )),
        Cell::Text(format!("{usable} of {all}")),
        Cell::Links(links.collect()),
    ]
}

/// All unusable recordings.
fn unusable(page: &mut Page, class: &Class) {
    let mut rows = Vec::new();
    for student in &class.students {
        if let Some(why) = &student.problem {
            rows.push(vec![student.name.clone(), why.clone()]);
        }
        for recording in student.unusable() {
            let why = recording.unusable.clone().unwrap_or_default();
            rows.push(vec![format!("{}/{}", student.name, recording.name), why]);
        }
    }
    if !rows.is_empty() {
        page.section("Recordings that are not usable");
        page.table(&["recording", "reason and remedy"], &rows);
    }
}

fn section(page: &mut Page, student: &Student) {
    page.section(&student.name);
    if let Some(why) = student.problem.as_ref().or(student.undiagnosed.as_ref()) {
        page.paragraph(why);
    }
    if let Some(outcome) = &student.together {
        page.answer(&outcome.sentence);
        if let Some(next) = &outcome.next {
            page.note("Next experiment:");
            page.verbatim(next);
        }
    }
    for recording in &student.recordings {
        one(page, recording);
    }
}

fn one(page: &mut Page, recording: &Recording) {
    page.subsection(&recording.name);
    if let Some(figures) = recording.figures {
        page.note(&format!(
            "{} samples every {} s, {} in all.",
            figures.samples,
            figures.sample_time_s,
            time(figures.duration_s)
        ));
    }
    match (&recording.unusable, &recording.outcome) {
        (Some(why), _) => page.paragraph(&format!("Not usable: {why}")),
        (None, Some(outcome)) => page.paragraph(&alone_words(outcome)),
        (None, None) => {}
    }
    let findings = recording.findings.iter();
    let findings: Vec<String> = findings
        .map(|found| {
            format!(
                "{} ({}): {}",
                found.id().replace('_', " "),
                found.severity.word(),
                found.sentence()
            )
        })
        .collect();
    if !findings.is_empty() {
        page.list(&findings);
    }
}

fn alone_words(outcome: &Outcome) -> String {
    format!(
        "By itself: {} ({}), nominal error {} counts, noise floor {}. {}",
        outcome.words(),
        probability_of("", outcome.probability),
        figure(outcome.gap_counts, 3),
        figure(outcome.floor_counts, 3),
        outcome.sentence
    )
}
