//! Files of the operating system, or in memory where there is none.

#[cfg(not(target_family = "wasm"))]
pub(crate) use std::fs::{File, OpenOptions, remove_file, rename};

#[cfg(target_family = "wasm")]
pub(crate) use super::memory::{File, OpenOptions, remove_file, rename};

use std::io;
use std::path::Path;

/// Whether an open file was deleted.
#[cfg(unix)]
pub(crate) fn has_vanished(file: &File, _: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|metadata| metadata.nlink() == 0)
}

#[cfg(windows)]
pub(crate) fn has_vanished(_: &File, path: &Path) -> bool {
    // The name is all that can be examined: a renamed file counts as deleted.
    path.symlink_metadata().is_err()
}

#[cfg(target_family = "wasm")]
pub(crate) fn has_vanished(_: &File, _: &Path) -> bool {
    false
}

#[cfg(unix)]
pub(crate) fn write_at(file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    use std::os::unix::fs::FileExt;
    file.write_all_at(bytes, at)
}

#[cfg(not(unix))]
pub(crate) fn write_at(mut file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    use std::io::{Seek, Write};
    file.seek(io::SeekFrom::Start(at))?;
    file.write_all(bytes)
}
