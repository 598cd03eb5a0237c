//! Sealing of cases: the published and the withheld part.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use rand::TryRng;
use rand::rngs::SysRng;
use serde::{Deserialize, Serialize};
use time::OffsetDateTime;

use super::files::{hex, now, read_document, sha256, write_document, write_whole};
use super::{BlindError, Truth};
use crate::plain::shown;

/// Format of the manifest.
const MANIFEST: &str = "motorlab-blind/1";
/// Format of the labels' file.
const LABELS: &str = "motorlab-blind-labels/1";

/// Published part of a set, `DIR/manifest.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// `motorlab-blind/1`.
    pub format: String,
    /// Time of the last addition.
    #[serde(with = "time::serde::rfc3339")]
    pub sealed_at: OffsetDateTime,
    /// The cases, in the order of their names.
    pub cases: Vec<SealedCase>,
}

/// A case as published.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SealedCase {
    /// Its name.
    pub name: String,
    /// Run files to diagnose, relative to the set.
    pub runs: Vec<String>,
    /// Nominal motor file, relative to the set.
    pub motor: String,
    /// A run withheld from the diagnosis, to measure the claimed error.
    pub unseen: Option<String>,
    /// SHA-256 of every file above.
    pub sha256: BTreeMap<String, String>,
    /// `SHA-256(salt LF name LF label)`.
    pub commitment: String,
}

/// The labels with their salts, withheld from the diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Labels {
    /// `motorlab-blind-labels/1`.
    pub format: String,
    /// How the cases were generated, unless they were recorded.
    pub recipe: Option<super::Recipe>,
    /// By case name.
    pub cases: BTreeMap<String, SealedLabel>,
}

/// A label as committed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SealedLabel {
    /// 32 random bytes in hex.
    pub salt: String,
    /// The label's JSON, byte by byte as hashed.
    pub label: String,
}

/// An unsealed case: contents of its files, and the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct NewCase {
    /// Contents of the run files.
    pub runs: Vec<String>,
    /// Content of the nominal motor file.
    pub motor: String,
    /// Content of the held-out run's file.
    pub unseen: Option<String>,
    /// The truth.
    pub truth: Truth,
}

/// The commitment to a label.
pub fn commitment(name: &str, sealed: &SealedLabel) -> String {
    sha256(format!("{}\n{name}\n{}", sealed.salt, sealed.label).as_bytes())
}

impl Manifest {
    /// Reads the manifest of a set.
    ///
    /// # Errors
    /// A missing or foreign manifest, or paths that lead out of the set.
    pub fn read(directory: &Path) -> Result<Self, BlindError> {
        let path = manifest_path(directory);
        let manifest: Self = read_document(&path)?;
        if manifest.format != MANIFEST {
            return Err(BlindError::content(
                &path,
                format!("format is '{}', expected {MANIFEST}", manifest.format),
            ));
        }
        for file in manifest.cases.iter().flat_map(SealedCase::files) {
            let inside = Path::new(file)
                .components()
                .all(|part| matches!(part, Component::Normal(_)));
            if !inside {
                return Err(BlindError::content(
                    &path,
                    format!("'{file}' leads out of the set"),
                ));
            }
        }
        Ok(manifest)
    }
}

impl SealedCase {
    pub(super) fn files(&self) -> impl Iterator<Item = &String> {
        self.runs.iter().chain([&self.motor]).chain(&self.unseen)
    }
}

impl Labels {
    /// Reads a labels' file.
    ///
    /// # Errors
    /// A missing or foreign file.
    pub fn read(path: &Path) -> Result<Self, BlindError> {
        let labels: Self = read_document(path)?;
        if labels.format != LABELS {
            return Err(BlindError::content(
                path,
                format!("format is '{}', expected {LABELS}", labels.format),
            ));
        }
        Ok(labels)
    }
}

pub(super) fn manifest_path(directory: &Path) -> PathBuf {
    directory.join("manifest.json")
}

/// Adds cases to a new or existing set, and their labels to the labels' file. Numbering continues.
///
/// # Errors
/// Files that cannot be written; an opened set; a labels' file inside the set, where a diagnosis could read it.
pub fn add_cases(
    directory: &Path,
    labels_path: &Path,
    recipe: Option<super::Recipe>,
    cases: impl IntoIterator<Item = NewCase>,
) -> Result<Manifest, BlindError> {
    fs::create_dir_all(directory).map_err(BlindError::file(directory))?;
    if is_inside(labels_path, directory) {
        return Err(BlindError::refused(
            format!(
                "the labels' file {} would lie inside the set {}",
                shown(labels_path),
                shown(directory)
            ),
            "name a file outside the set with --labels",
        ));
    }
    if super::opening::opened_path(directory).exists() {
        return Err(BlindError::refused(
            format!("{} has been opened", shown(directory)),
            "seal new cases in a new set",
        ));
    }
    let (mut manifest, mut labels) = match (manifest_path(directory).exists(), labels_path.exists())
    {
        (true, true) => (Manifest::read(directory)?, Labels::read(labels_path)?),
        (false, false) => (
            Manifest {
                format: MANIFEST.to_owned(),
                sealed_at: now(),
                cases: Vec::new(),
            },
            Labels {
                format: LABELS.to_owned(),
                recipe: None,
                cases: BTreeMap::new(),
            },
        ),
        (true, false) => {
            return Err(BlindError::refused(
                format!(
                    "{} is a set already, and its labels' file is not {}",
                    shown(directory),
                    shown(labels_path)
                ),
                "name the labels' file of this set with --labels, or name another directory",
            ));
        }
        (false, true) => {
            return Err(BlindError::refused(
                format!("{} holds the labels of another set", shown(labels_path)),
                "name another file with --labels",
            ));
        }
    };
    labels.recipe = labels.recipe.or(recipe);
    for case in cases {
        let name = format!("case-{:04}", manifest.cases.len() + 1);
        let (sealed, label) = seal(directory, &name, &case)?;
        manifest.cases.push(sealed);
        labels.cases.insert(name, label);
    }
    manifest.sealed_at = now();
    // The labels first: a commitment without its label could never be opened.
    write_document(labels_path, &labels)?;
    write_document(&manifest_path(directory), &manifest)?;
    Ok(manifest)
}

/// Whether a path is inside an existing directory.
fn is_inside(path: &Path, directory: &Path) -> bool {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), directory.canonicalize()) {
        (Ok(folder), Ok(directory)) => folder.starts_with(directory),
        _ => false,
    }
}

fn seal(
    directory: &Path,
    name: &str,
    case: &NewCase,
) -> Result<(SealedCase, SealedLabel), BlindError> {
    let mut hashes = BTreeMap::new();
    let mut put = |file: String, content: &str| -> Result<String, BlindError> {
        write_whole(&directory.join(&file), content.as_bytes())?;
        hashes.insert(file.clone(), sha256(content.as_bytes()));
        Ok(file)
    };
    let mut runs = Vec::new();
    for (k, run) in case.runs.iter().enumerate() {
        runs.push(put(format!("{name}/run{}.csv", k + 1), run)?);
    }
    let motor = put(format!("{name}/motor.toml"), &case.motor)?;
    let unseen = match &case.unseen {
        Some(run) => Some(put(format!("unseen/{name}.csv"), run)?),
        None => None,
    };
    let mut salt = [0_u8; 32];
    SysRng
        .try_fill_bytes(&mut salt)
        .map_err(|error| BlindError::content(directory, format!("no randomness: {error}")))?;
    let label = SealedLabel {
        salt: hex(&salt),
        label: serde_json::to_string(&case.truth)
            .map_err(|error| BlindError::content(directory, error))?,
    };
    let sealed = SealedCase {
        name: name.to_owned(),
        runs,
        motor,
        unseen,
        sha256: hashes,
        commitment: commitment(name, &label),
    };
    Ok((sealed, label))
}
