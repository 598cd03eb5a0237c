//! Free file names: no existing file is overwritten.

use std::io;
use std::path::{Path, PathBuf};

use super::WriteError;
use crate::platform::files::{File, OpenOptions};

/// Refuses paths that cannot be a new file: a folder, a device, a pipe, or a path without a name.
///
/// # Errors
/// Its kind.
pub fn refuse_no_file(path: &Path) -> Result<(), WriteError> {
    let what = match path.metadata() {
        _ if path.file_name().is_none() => "names no file",
        Ok(found) if found.is_dir() => "is a folder",
        Ok(found) if !found.is_file() => "is a device or a pipe",
        _ => return Ok(()),
    };
    Err(WriteError::NoFile {
        path: path.to_owned(),
        what,
    })
}

/// The first of `run.csv`, `run-2.csv`, `run-3.csv` ... that does not exist.
pub fn next_free_name(path: &Path) -> PathBuf {
    names_from(path)
        .find(|candidate| candidate.symlink_metadata().is_err())
        .unwrap_or_else(|| path.to_owned())
}

/// `run.csv`, `run-2.csv`, `run-3.csv` ...
fn names_from(path: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_os_string();
    let extension = path.extension().map(std::ffi::OsStr::to_os_string);
    let numbered = (2..1_000_000_u32).map({
        let path = path.to_owned();
        move |number| {
            let mut name = stem.clone();
            name.push(format!("-{number}"));
            if let Some(extension) = &extension {
                name.push(".");
                name.push(extension);
            }
            path.with_file_name(name)
        }
    });
    std::iter::once(path.to_owned()).chain(numbered)
}

/// Creates `path` or the next free name, atomically.
pub(super) fn create_free(path: &Path) -> Result<(File, PathBuf), WriteError> {
    refuse_no_file(path)?;
    for candidate in names_from(path) {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&candidate);
        match file {
            Ok(file) => return Ok((file, candidate)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(source) => {
                return Err(WriteError::Create {
                    path: candidate,
                    source,
                });
            }
        }
    }
    Err(WriteError::Create {
        path: path.to_owned(),
        source: io::ErrorKind::AlreadyExists.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_that_is_no_regular_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).expect("a folder");
        for path in [&inner, &inner.join(".."), Path::new("/")] {
            let error = create_free(path).expect_err("no file");
            assert!(error.to_string().contains("name a file"), "{error}");
        }
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("a folder").count(),
            1
        );
        #[cfg(unix)]
        assert!(create_free(Path::new("/dev/null")).is_err());
    }
}
