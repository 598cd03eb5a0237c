//! Opening of a sealed set: every rule is checked before a label is compared with a verdict.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use time::OffsetDateTime;

use super::files::{now, read_document, sha256, sha256_of, write_document};
use super::run::{VERDICT, VerdictFile, check_file, verdict_path};
use super::{BlindError, Labels, Ledger, Manifest, Recipe, SealedCase, Truth, Verdict, commitment};
use crate::plain::shown;

/// An opened set.
#[derive(Debug, Clone, PartialEq)]
pub struct Opened {
    /// Time at which the labels were first opened.
    pub opened_at: OffsetDateTime,
    /// Head of the chain of verdicts.
    pub head: String,
    /// Whether that head was recorded before: without it, verdicts could have been changed after the labels were seen
    /// and the chain recomputed.
    pub order_proved: bool,
    /// How the cases were generated, unless they were recorded.
    pub recipe: Option<Recipe>,
    /// The cases with truth and verdict.
    pub cases: Vec<OpenedCase>,
}

/// A case with truth and verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenedCase {
    /// The published part.
    pub sealed: SealedCase,
    /// The truth.
    pub truth: Truth,
    /// Program that made the verdict.
    pub diagnoser: String,
    /// Its verdict.
    pub verdict: Verdict,
}

/// `DIR/opened.json`: written once, before the first score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Opening {
    #[serde(with = "time::serde::rfc3339")]
    opened_at: OffsetDateTime,
    /// Head of the chain at the opening.
    head: String,
    /// SHA-256 of the manifest at the opening.
    manifest_sha256: String,
}

pub(super) fn opened_path(directory: &Path) -> PathBuf {
    directory.join("opened.json")
}

/// Verifies the set against its labels and opens it. The first opening is recorded and closes the set: later verdicts
/// are refused. `written_down` is a head of the chain that was recorded earlier.
///
/// # Errors
/// [`BlindError::Refused`] if a label does not match its commitment, a file or verdict was changed, a case lacks
/// label or verdict, or a verdict is older than the seal or newer than the opening.
pub fn open(
    directory: &Path,
    labels_path: &Path,
    written_down: Option<&str>,
) -> Result<Opened, BlindError> {
    let refuse = |what: String| Err(BlindError::altered(what));
    let manifest = Manifest::read(directory)?;
    let labels = Labels::read(labels_path)?;
    let ledger = Ledger::read(directory)?;
    let known = |name: &str| manifest.cases.iter().any(|case| case.name == name);
    if let Some(stray) = labels.cases.keys().find(|name| !known(name)) {
        return Err(BlindError::refused(
            format!("the labels hold {stray}, which the manifest does not"),
            "name the labels of this set with --labels",
        ));
    }
    for (k, entry) in ledger.entries.iter().enumerate() {
        if !known(&entry.case) {
            return refuse(format!("a verdict on {}, which is no case", entry.case));
        }
        if ledger.entries[..k].iter().any(|e| e.case == entry.case) {
            return refuse(format!("{} was judged twice", entry.case));
        }
    }
    let mut cases = Vec::with_capacity(manifest.cases.len());
    for sealed in &manifest.cases {
        cases.push(open_case(directory, sealed, &labels, &ledger)?);
    }
    if let Some(head) = written_down
        && head != ledger.head()
    {
        return Err(BlindError::refused(
            format!(
                "the verdicts' hash written down is {head}, the chain ends in {}",
                ledger.head()
            ),
            "give the hash that the last `motorlab blind run` printed; if it is that one, the verdicts were changed",
        ));
    }
    let opening = note_opening(directory, &ledger)?;
    if let Some(late) = ledger
        .entries
        .iter()
        .find(|entry| entry.decided_at > opening.opened_at)
    {
        return refuse(format!(
            "the verdict on {} is newer than the opening of the labels",
            late.case
        ));
    }
    if opening.head != ledger.head() {
        return refuse("the verdicts are not those that were there at the opening".to_owned());
    }
    let path = super::seal::manifest_path(directory);
    if opening.manifest_sha256 != sha256_of(&path)? {
        return refuse("the manifest is not the one that was there at the opening".to_owned());
    }
    Ok(Opened {
        opened_at: opening.opened_at,
        head: opening.head,
        order_proved: written_down.is_some(),
        recipe: labels.recipe,
        cases,
    })
}

/// The recorded opening; recorded now if there is none.
fn note_opening(directory: &Path, ledger: &Ledger) -> Result<Opening, BlindError> {
    let path = opened_path(directory);
    if path.exists() {
        return read_document(&path);
    }
    let opening = Opening {
        opened_at: now(),
        head: ledger.head().to_owned(),
        manifest_sha256: sha256_of(&super::seal::manifest_path(directory))?,
    };
    // A clock set back, or a verdict dated ahead: nothing is opened, so that it can be corrected.
    if ledger
        .entries
        .iter()
        .all(|entry| entry.decided_at <= opening.opened_at)
    {
        write_document(&path, &opening)?;
    }
    Ok(opening)
}

fn open_case(
    directory: &Path,
    sealed: &SealedCase,
    labels: &Labels,
    ledger: &Ledger,
) -> Result<OpenedCase, BlindError> {
    let name = &sealed.name;
    let refuse = |what: String| Err(BlindError::altered(what));
    let Some(label) = labels.cases.get(name) else {
        return Err(BlindError::refused(
            format!("{name} has no label in the labels' file"),
            "name the labels of this set with --labels",
        ));
    };
    if commitment(name, label) != sealed.commitment {
        return refuse(format!(
            "the label of {name} does not match its commitment in the manifest"
        ));
    }
    for file in sealed.files() {
        check_file(directory, sealed, file)?;
    }
    let Some(entry) = ledger.of(name) else {
        return Err(BlindError::refused(
            format!("{name} has no verdict"),
            &format!("motorlab blind run {}", shown(directory)),
        ));
    };
    let path = verdict_path(directory, name);
    let bytes = fs::read(&path).map_err(BlindError::file(&path))?;
    if sha256(&bytes) != entry.sha256 {
        return refuse(format!(
            "the verdict on {name} was changed after it was written"
        ));
    }
    let file: VerdictFile =
        serde_json::from_slice(&bytes).map_err(|error| BlindError::content(&path, error))?;
    if file.format != VERDICT || file.case != *name || file.commitment != sealed.commitment {
        return refuse(format!("the verdict on {name} judges another case"));
    }
    let truth = serde_json::from_str(&label.label)
        .map_err(|error| BlindError::content(&path, format!("label of {name}: {error}")))?;
    Ok(OpenedCase {
        sealed: sealed.clone(),
        truth,
        diagnoser: file.diagnoser,
        verdict: file.verdict,
    })
}
