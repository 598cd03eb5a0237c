//! `capture --live`: its display on a terminal, and no lost samples on a blocked terminal.
#![cfg(unix)]

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::support::command::{RunFile, motorlab};
use motorlab::board::BoardSide;
use motorlab::board::pty::Pty;
use rustix::fs::OFlags;

/// Opens the terminal for writing; with `patient`, writing blocks.
fn open(path: &Path, patient: bool) -> File {
    let mut flags = OFlags::NOCTTY;
    if !patient {
        flags |= OFlags::NONBLOCK;
    }
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    options.custom_flags(flags.bits() as i32);
    options.open(path).expect("the terminal's far end")
}

/// Starts a live capture of 1.5 s with this terminal as standard error.
fn capture_on(terminal: &Pty, directory: &Path) -> Child {
    let arguments = ["capture", "virtual:", "--live", "--duration", "1.5"];
    motorlab(directory, &arguments)
        .stderr(Stdio::from(open(terminal.path(), true)))
        .spawn()
        .expect("the command starts")
}

/// Waits for the end, calling `meanwhile` in between; a command that does not end is killed.
fn status_of(mut child: Child, mut meanwhile: impl FnMut()) -> Option<i32> {
    let until = Instant::now() + Duration::from_secs(60);
    while Instant::now() < until {
        meanwhile();
        if let Some(status) = child.try_wait().expect("a child") {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("it runs");
    child.wait().expect("a child").code()
}

#[test]
fn a_blocking_terminal_loses_no_sample() {
    let mut terminal = Pty::open().expect("a pseudo-terminal");
    // Filled completely: the first byte of the display blocks.
    let mut full = open(terminal.path(), false);
    // The kernel passes bytes on in the background, which frees room a few times more.
    let mut refusals = 0;
    while refusals < 20 {
        match full.write(b".") {
            Ok(_) => refusals = 0,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                refusals += 1;
                std::thread::sleep(Duration::from_millis(10));
            }
            Err(error) => panic!("{error}"),
        }
    }
    let directory = tempfile::tempdir().expect("a directory");
    let child = capture_on(&terminal, directory.path());
    assert_eq!(status_of(child, || {}), Some(0));
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!((file.rows.len(), file.complete()), (500, true));
    assert_eq!(file.summary("lost"), 0);
    // Nothing was drawn, as nothing was read.
    let mut seen = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(count @ 1..) = terminal.read_some(&mut buffer) {
        seen.extend_from_slice(&buffer[..count]);
    }
    assert!(seen.iter().all(|&byte| byte == b'.'));
}

#[test]
fn the_view_draws_the_recording_and_restores_the_terminal() {
    let mut terminal = Pty::open().expect("a pseudo-terminal");
    let directory = tempfile::tempdir().expect("a directory");
    let child = capture_on(&terminal, directory.path());
    let mut seen = Vec::new();
    let status = status_of(child, || {
        let mut buffer = [0; 4096];
        while let Ok(count @ 1..) = terminal.read_some(&mut buffer) {
            seen.extend_from_slice(&buffer[..count]);
        }
    });
    assert_eq!(status, Some(0));
    let seen = String::from_utf8_lossy(&seen);
    for word in ["RPM", "simulated", "difference"] {
        assert!(seen.contains(word), "{word}");
    }
    // Into the alternate screen once, and out of it at the end.
    assert_eq!(seen.matches("\x1b[?1049h").count(), 1);
    assert!(seen.ends_with("\x1b[?1049l\x1b[?25h"), "{seen:?}");
    let file = RunFile::read(&directory.path().join("run.csv"));
    assert_eq!((file.rows.len(), file.summary("lost")), (500, 0));
}
