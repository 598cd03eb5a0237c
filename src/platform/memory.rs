//! Files in memory, by path, in place of a disk in the web page.
//!
//! The part of `std::fs` that the library uses, under the same names.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

type Content = Arc<Mutex<Vec<u8>>>;

static FILES: Mutex<BTreeMap<PathBuf, Content>> = Mutex::new(BTreeMap::new());

fn files() -> MutexGuard<'static, BTreeMap<PathBuf, Content>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn held(content: &Content) -> MutexGuard<'_, Vec<u8>> {
    content.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes a file and returns its bytes; `None` if there is none of this name.
pub fn take(path: &Path) -> Option<Vec<u8>> {
    let content = files().remove(path)?;
    let bytes = std::mem::take(&mut *held(&content));
    Some(bytes)
}

/// Removes a file; open handles keep its bytes.
pub(crate) fn remove_file(path: &Path) -> io::Result<()> {
    match files().remove(path) {
        Some(_) => Ok(()),
        None => Err(io::ErrorKind::NotFound.into()),
    }
}

/// Gives a file another name, in place of one that has it.
pub(crate) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    let mut files = files();
    let content = files.remove(from).ok_or(io::ErrorKind::NotFound)?;
    files.insert(to.to_owned(), content);
    Ok(())
}

/// An open file.
#[derive(Debug)]
pub struct File {
    content: Content,
    at: AtomicU64,
}

/// Size of a file.
#[derive(Debug, Clone, Copy)]
pub struct Metadata(u64);

impl Metadata {
    pub(crate) fn len(self) -> u64 {
        self.0
    }
}

impl File {
    pub(crate) fn create_new(path: impl AsRef<Path>) -> io::Result<Self> {
        let content = Content::default();
        let mut files = files();
        if files.contains_key(path.as_ref()) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        files.insert(path.as_ref().to_owned(), Arc::clone(&content));
        Ok(Self {
            content,
            at: AtomicU64::new(0),
        })
    }

    pub(crate) fn open(path: impl AsRef<Path>) -> io::Result<Self> {
        let files = files();
        let content = files.get(path.as_ref()).ok_or(io::ErrorKind::NotFound)?;
        Ok(Self {
            content: Arc::clone(content),
            at: AtomicU64::new(0),
        })
    }

    pub(crate) fn metadata(&self) -> io::Result<Metadata> {
        Ok(Metadata(held(&self.content).len() as u64))
    }

    pub(crate) fn set_len(&self, bytes: u64) -> io::Result<()> {
        held(&self.content).resize(bytes as usize, 0);
        Ok(())
    }

    /// There is nothing to write back in memory.
    pub(crate) fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for &File {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let content = held(&self.content);
        let at = self.at.load(Ordering::Relaxed);
        let count = content.get(at as usize..).unwrap_or(&[]).read(buffer)?;
        self.at.store(at + count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

impl Write for &File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut content = held(&self.content);
        let at = self.at.load(Ordering::Relaxed) as usize;
        let end = at + bytes.len();
        if content.len() < end {
            content.resize(end, 0);
        }
        content[at..end].copy_from_slice(bytes);
        self.at.store(end as u64, Ordering::Relaxed);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for &File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let from = |base: u64, by: i64| {
            let at = base.checked_add_signed(by);
            at.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))
        };
        let at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::End(by) => from(held(&self.content).len() as u64, by)?,
            SeekFrom::Current(by) => from(self.at.load(Ordering::Relaxed), by)?,
        };
        self.at.store(at, Ordering::Relaxed);
        Ok(at)
    }
}

impl Read for File {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        (&*self).read(buffer)
    }
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (&*self).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        (&*self).seek(to)
    }
}

/// Options of opening a file. In memory every file is readable and writable; only new files are opened by name.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OpenOptions;

impl OpenOptions {
    pub(crate) fn new() -> Self {
        Self
    }

    pub(crate) fn read(&mut self, _: bool) -> &mut Self {
        self
    }

    pub(crate) fn write(&mut self, _: bool) -> &mut Self {
        self
    }

    pub(crate) fn create_new(&mut self, _: bool) -> &mut Self {
        self
    }

    pub(crate) fn open(&self, path: impl AsRef<Path>) -> io::Result<File> {
        File::create_new(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_in_memory_is_written_overwritten_and_taken() {
        let path = Path::new("memory/of/a/test.csv");
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(path)
            .expect("new");
        let twice = File::create_new(path).expect_err("it is there");
        assert_eq!(twice.kind(), io::ErrorKind::AlreadyExists);
        file.write_all(b"head body").expect("written");
        file.seek(SeekFrom::Start(0)).expect("there");
        file.write_all(b"HEAD").expect("written");
        let mut rest = String::new();
        file.read_to_string(&mut rest).expect("text");
        assert_eq!(rest, " body");
        file.seek(SeekFrom::End(-4)).expect("there");
        assert!(file.seek(SeekFrom::Current(-9)).is_err());
        file.set_len(8).expect("cut");
        file.sync_data().expect("kept");
        assert_eq!(file.metadata().expect("a file").len(), 8);
        let other = Path::new("memory/of/another/test.csv");
        rename(path, other).expect("there");
        assert!(File::open(path).is_err() && rename(path, other).is_err());
        rename(other, path).expect("there");
        let mut text = String::new();
        let mut again = File::open(path).expect("there");
        again.read_to_string(&mut text).expect("text");
        assert_eq!(text, "HEAD bod");
        assert_eq!(take(path).expect("a file"), b"HEAD bod");
        assert!(take(path).is_none());
        assert!(remove_file(path).is_err());
    }
}
