//! Ports that cannot be opened, or have another device than a board: the message names it and a remedy, the exit
//! status distinguishes input from device errors.
#![cfg(unix)]

use std::fs::{File, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::support;
use crate::support::command::{Finished, finish, run, start};
use motorlab::board::pty::Pty;
use motorlab::board::{BoardSide, IdealBench, Port, VirtualBoard, VirtualBoardOptions};

fn capture_from(port: &str) -> Finished {
    let directory = tempfile::tempdir().expect("a directory");
    let done = run(directory.path(), &["capture", port, "--patience", "1"]);
    // No run, no file.
    assert!(!directory.path().join("run.csv").exists());
    done
}

#[test]
fn a_missing_port_is_an_error() {
    let done = capture_from("/dev/ttyACM77");
    assert_eq!(done.status, Some(2));
    assert!(
        done.messages
            .starts_with("error: there is no port /dev/ttyACM77")
    );
}

#[test]
fn a_device_that_is_no_serial_port_is_an_error() {
    for (path, what) in [
        ("/dev/zero", "another kind of device"),
        ("/tmp", "a directory"),
    ] {
        let done = capture_from(path);
        assert_eq!(done.status, Some(2), "{}", done.messages);
        assert!(done.messages.contains(what), "{}", done.messages);
    }
}

/// Captures from a line on which another device sends `bytes` every 10 ms.
fn capture_from_something_that_sends(bytes: &[u8]) -> Finished {
    let mut pty = Pty::open().expect("a pseudo-terminal");
    let port = pty.path().display().to_string();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                if pty
                    .wait(Duration::ZERO, false)
                    .is_ok_and(|ready| ready.connected)
                {
                    pty.write_some(bytes).expect("room");
                }
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        let done = capture_from(&port);
        over.store(true, Ordering::Relaxed);
        done
    })
}

#[test]
fn bytes_of_a_foreign_board_are_shown() {
    let done = capture_from_something_that_sends(b"T=21.5 C\x1b[2J\r\n");
    assert_eq!(done.status, Some(3));
    assert!(
        done.messages.contains("is not a motorlab board: it sent"),
        "{}",
        done.messages
    );
    assert!(done.messages.contains("T=21.5 C"));
    assert!(
        !done.messages.contains('\x1b'),
        "nothing of it reaches the terminal as it is"
    );
    let done = capture_from_something_that_sends(b"t_us:123,counts:4\r\n");
    assert!(done.messages.contains("--columns"), "{}", done.messages);
}

#[test]
fn a_silent_line_is_reported() {
    let done = capture_from_something_that_sends(b"");
    assert_eq!(done.status, Some(3));
    assert!(
        done.messages.contains("it sent nothing in 1 s"),
        "{}",
        done.messages
    );
}

#[test]
fn a_second_reader_is_refused_and_the_first_is_named() {
    let board = VirtualBoard::spawn(IdealBench::new(100.0), VirtualBoardOptions::default())
        .expect("a virtual board");
    let directory = tempfile::tempdir().expect("a directory");
    let port = board.path().display().to_string();
    let arguments = ["capture", &port, "--duration", "3", "--json"];
    let first = start(directory.path(), &arguments);
    std::thread::sleep(Duration::from_millis(800));
    let second = capture_from(&port);
    assert_eq!(second.status, Some(3), "{}", second.messages);
    let holder = format!("is in use by motorlab (process {})", first.id());
    assert!(second.messages.contains(&holder), "{}", second.messages);
    // The second one took no bytes.
    let first = finish(first);
    assert_eq!(first.status, Some(0), "{}", first.messages);
    assert!(first.output.contains("\"lost\": 0"));
}

/// Runs `capture PORT` as the user nobody; `None` if that is not possible.
fn capture_as_nobody(port: &str) -> Option<Finished> {
    let directory = tempfile::tempdir().expect("a directory");
    let open = Permissions::from_mode(0o777);
    std::fs::set_permissions(directory.path(), open).expect("own directory");
    let copy = directory.path().join("motorlab");
    std::fs::copy(env!("CARGO_BIN_EXE_motorlab"), &copy).expect("a copy");
    let output = Command::new("setpriv")
        .args(["--reuid=65534", "--regid=65534", "--clear-groups"])
        .arg(&copy)
        .args(["capture", port, "--patience", "1"])
        .current_dir(directory.path())
        .stdin(Stdio::null())
        .output()
        .ok()?;
    let done = Finished::from(output);
    (!done.messages.starts_with("setpriv")).then_some(done)
}

/// `(group's name, group's number)` of a node.
fn group_of(path: &Path) -> (String, u32) {
    use std::os::unix::fs::MetadataExt;
    let gid = std::fs::metadata(path).expect("a node").gid();
    let groups = std::fs::read_to_string("/etc/group").expect("groups");
    let line = groups
        .lines()
        .find(|line| line.split(':').nth(2) == Some(&gid.to_string()));
    let name = line.and_then(|line| line.split(':').next()).unwrap_or("?");
    (name.to_owned(), gid)
}

#[test]
fn permission_denied_names_the_group_and_the_command() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let group = Permissions::from_mode(0o660);
    if std::fs::set_permissions(pty.path(), group).is_err() {
        return support::skip("permission_denied_names_the_group", "not root");
    }
    let Some(done) = capture_as_nobody(&pty.path().display().to_string()) else {
        return support::skip(
            "permission_denied_names_the_group",
            "cannot run as another user",
        );
    };
    let (group, gid) = group_of(pty.path());
    assert_eq!(done.status, Some(3), "{}", done.messages);
    let belongs = format!("it belongs to group {group} (crw-rw----)");
    assert!(done.messages.contains(&belongs), "{}", done.messages);
    if gid != 0 {
        let command = format!("sudo usermod -aG {group} \"$USER\"");
        assert!(done.messages.contains(&command), "{}", done.messages);
    }
}

#[test]
fn the_lock_refuses_another_user() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let everybody = Permissions::from_mode(0o666);
    if std::fs::set_permissions(pty.path(), everybody).is_err() {
        return support::skip("the_lock_refuses_another_user", "not root");
    }
    let _first = Port::open(pty.path(), 115_200).expect("openable");
    let Some(done) = capture_as_nobody(&pty.path().display().to_string()) else {
        return support::skip(
            "the_lock_refuses_another_user",
            "cannot run as another user",
        );
    };
    assert_eq!(done.status, Some(3), "{}", done.messages);
    assert!(done.messages.contains("is in use by"), "{}", done.messages);
    // A user who cannot see the holder gets the hint about ModemManager, with the rule that excludes it.
    for part in ["ModemManager", "ID_MM_DEVICE_IGNORE", "/etc/udev/rules.d/"] {
        assert!(done.messages.contains(part), "{}", done.messages);
    }
}

#[test]
fn unknown_names_in_a_virtual_board_suggest_the_nearest() {
    for (port, hint) in [
        ("virtual:?efect=backlash", "did you mean 'effect'?"),
        ("virtual:?effect=backlsh", "did you mean 'backlash'?"),
        (
            "virtual:?effect=backlash&gap=0.1",
            "did you mean 'gap_rad'?",
        ),
        ("virtual:?seed=x", "expected a whole number"),
        ("virtual:?seed", "no `key=value`"),
    ] {
        let done = capture_from(port);
        assert_eq!(done.status, Some(2));
        assert!(done.messages.contains(hint), "{}", done.messages);
    }
}

#[test]
fn ports_are_listed_as_text_and_as_json() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = run(directory.path(), &["ports"]);
    assert_eq!(text.status, Some(0));
    let json = run(directory.path(), &["ports", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.output).expect("one document");
    for port in json["ports"].as_array().expect("a list") {
        let path = port["path"].as_str().expect("a path");
        assert!(text.output.contains(path));
        assert!(File::open(path).is_ok() || Path::new(path).exists());
    }
}
