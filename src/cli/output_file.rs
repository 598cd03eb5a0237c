//! Output files: written completely or not at all, and never over foreign files.
//!
//! Content goes to a temporary file in the same folder, is synced, and renamed. An existing file is replaced only if
//! the same subcommand wrote it, which a comment in the file's format states, or with `--force`.

use std::fs::{self, File, Metadata};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Output, config};
use crate::hint::of_system;
use crate::plain::shown;

/// Bytes at the head of a file that are searched for the mark: more than any format's header.
const HEAD_BYTES: u64 = 4096;
/// Bytes at the end that are searched: more than a Parquet file's footer.
const TAIL_BYTES: u64 = 65_536;

/// `--force`, shared by every subcommand that writes such files.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Force {
    /// Replace output files that this command did not write (inputs and links never).
    #[arg(long)]
    force: bool,
}

/// Comment syntax for the mark of the writing command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// HTML, SVG, XML and Markdown.
    Markup,
    /// TOML and Python.
    Toml,
    /// C.
    C,
    /// MATLAB.
    Matlab,
    /// A manual page.
    Roff,
    /// One JSON object: a key `written_by`.
    Json,
}

/// The output files of one call.
#[derive(Debug)]
pub(super) struct Outputs {
    mark: String,
    force: bool,
    inputs: Vec<PathBuf>,
}

/// Mark of the command that wrote a file.
pub(super) fn mark(command: &str) -> String {
    format!("written by motorlab {command}")
}

impl Force {
    pub(super) fn is_given(self) -> bool {
        self.force
    }

    pub(super) fn outputs<'a>(
        self,
        command: &str,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Outputs {
        Outputs {
            mark: mark(command),
            force: self.force,
            inputs: inputs.into_iter().cloned().collect(),
        }
    }
}

impl Outputs {
    /// Refuses, before the work, outputs that could not be written after it.
    ///
    /// # Errors
    /// A file that must not be replaced, a missing or read-only folder, or one name for two files.
    pub(super) fn check<'a>(
        &self,
        paths: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<(), Failure> {
        let mut seen: Vec<&PathBuf> = Vec::new();
        for path in paths {
            if seen.contains(&path) {
                return Err(refused(path, "is named for two outputs", "name two files"));
            }
            self.may_replace(path, None)?;
            part_of(path).map_err(|error| cannot(path, &error))?;
            seen.push(path);
        }
        Ok(())
    }

    /// Refuses to replace a file that is not an earlier output. `witness` is a file of the same folder that carries
    /// the mark for a format without comments.
    pub(super) fn may_replace(&self, path: &Path, witness: Option<&Path>) -> Result<(), Failure> {
        if path.file_name().is_some_and(|name| name == config::NAME) {
            return Err(refused(
                path,
                "is the name of the configuration file",
                "name another file",
            ));
        }
        let found = match fs::symlink_metadata(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(cannot(path, &error)),
            Ok(found) => found,
        };
        if found.is_symlink() {
            return Err(refused(
                path,
                "is a link, and nothing is written through one",
                "name a file",
            ));
        }
        if !found.is_file() {
            return Err(refused(
                path,
                "is no ordinary file and cannot be replaced by one",
                "name a file",
            ));
        }
        if (self.inputs.iter()).any(|input| is_same(input, path, &found)) {
            return Err(refused(
                path,
                "is an input of this call and stays as it is",
                "name another file",
            ));
        }
        let bears = |path: &Path| has_mark(path, self.mark.as_bytes());
        if self.force || bears(path).map_err(|error| cannot(path, &error))? {
            return Ok(());
        }
        if witness.is_some_and(|witness| bears(witness).unwrap_or(false)) {
            return Ok(());
        }
        let why = format!("exists and does not say that it was {}", self.mark);
        Err(refused(
            path,
            &why,
            "name another file, or --force replaces it",
        ))
    }

    /// Writes a file with its mark, and reports it.
    pub(super) fn write(
        &self,
        path: &Path,
        content: &str,
        form: Form,
        output: &Output,
    ) -> Result<(), Failure> {
        self.write_silently(path, content, form)?;
        output.message(&format!("wrote {}", shown(path)));
        Ok(())
    }

    /// Writes a file with its mark.
    pub(super) fn write_silently(
        &self,
        path: &Path,
        content: &str,
        form: Form,
    ) -> Result<(), Failure> {
        self.write_bytes(path, self.marked(content, form)?.as_bytes(), None)
    }

    /// Writes a file that already contains the mark, or has a `witness`.
    pub(super) fn write_bytes(
        &self,
        path: &Path,
        content: &[u8],
        witness: Option<&Path>,
    ) -> Result<(), Failure> {
        self.may_replace(path, witness)?;
        whole(path, content).map_err(|error| cannot(path, &error))
    }

    fn marked(&self, content: &str, form: Form) -> Result<String, Failure> {
        let body = content.trim_end();
        let mark = &self.mark;
        Ok(match form {
            Form::Markup => format!("{body}\n<!-- {mark} -->\n"),
            Form::Toml => format!("{body}\n# {mark}\n"),
            Form::C => format!("{body}\n/* {mark} */\n"),
            Form::Matlab => format!("{body}\n% {mark}\n"),
            Form::Roff => format!("{body}\n.\\\" {mark}\n"),
            Form::Json => {
                let mut document: serde_json::Value =
                    serde_json::from_str(content).map_err(Failure::input)?;
                if let Some(object) = document.as_object_mut() {
                    object.insert("written_by".to_owned(), mark.clone().into());
                }
                serde_json::to_string_pretty(&document).map_err(Failure::input)? + "\n"
            }
        })
    }
}

/// Replaces a file atomically: the old one stays until the new one is on disk.
pub(super) fn whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut part = part_of(path)?;
    part.write_all(content)?;
    part.as_file().sync_all()?;
    part.persist(path)?;
    Ok(())
}

/// Prefix of a temporary file's name, before the final name.
const PART: &str = ".motorlab-";
/// Characters of the final name in it: a name has room for 255 bytes.
const NAMED: usize = 40;

/// A temporary file in the folder of `path`. A leftover of a killed process is removed by the next writer of the same
/// file, if its lock is free.
fn part_of(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let name: String = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .chars()
        .take(NAMED)
        .collect();
    let prefix = format!("{PART}{name}-");
    remove_abandoned(folder_of(path), &prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // As for any new file: the process's umask restricts the permissions.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let part = builder.tempfile_in(folder_of(path))?;
    // Without file locks nothing is considered abandoned.
    let _ = part.as_file().try_lock();
    Ok(part)
}

/// Removes temporary files whose writers died. A file that cannot be read stays.
fn remove_abandoned(folder: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let is_part = entry
            .file_name()
            .to_string_lossy()
            .strip_prefix(prefix)
            .is_some_and(is_drawn);
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_part && is_file && File::open(entry.path()).is_ok_and(|part| part.try_lock().is_ok())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether this is the random end of a temporary file's name: six letters and digits.
fn is_drawn(end: &str) -> bool {
    end.len() == 6 && end.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Whether both names refer to one file, by a link or another spelling of its path.
fn is_same(input: &Path, path: &Path, found: &Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let _ = path;
        fs::metadata(input)
            .is_ok_and(|input| (input.dev(), input.ino()) == (found.dev(), found.ino()))
    }
    #[cfg(not(unix))]
    {
        let _ = found;
        matches!((input.canonicalize(), path.canonicalize()), (Ok(a), Ok(b)) if a == b)
    }
}

/// Whether the mark is at the head or at the end of a file.
fn has_mark(path: &Path, mark: &[u8]) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    (&mut file).take(HEAD_BYTES).read_to_end(&mut bytes)?;
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL_BYTES)))?;
    file.take(TAIL_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes.windows(mark.len()).any(|window| window == mark))
}

fn refused(path: &Path, why: &str, hint: &str) -> Failure {
    Failure::wrong(format!("{} {why}", shown(path)), hint)
        .of_kind("output_refused")
        .at(path)
}

fn cannot(path: &Path, error: &io::Error) -> Failure {
    Failure::failed(
        format!("cannot write {}: {error}", shown(path)),
        of_system(error).unwrap_or("name a file in a folder that exists and that you may write to"),
    )
    .of_kind("cannot_write")
    .at(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_killed_writer_are_removed_and_locked_ones_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        for name in [
            ".motorlab-x.html-Ab12Cd",
            ".motorlab-x.html-notes",
            ".motorlab-y.html-Ab12Cd",
        ] {
            fs::write(at(name), "half").expect("a file");
        }
        let held = part_of(&at("x.html")).expect("a part");
        whole(&at("x.html"), b"whole").expect("written");
        assert!(!at(".motorlab-x.html-Ab12Cd").exists());
        assert!(at(".motorlab-x.html-notes").exists() && at(".motorlab-y.html-Ab12Cd").exists());
        assert!(held.path().exists());
        assert_eq!(fs::read(at("x.html")).expect("a file"), b"whole");
    }
}
