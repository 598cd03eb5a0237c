//! `motorlab firmware` and `motorlab flash`, with substitutes for the tools that they call.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::support::command::{Finished, motorlab, run};

/// A PATH with these programs only; each writes its arguments to `called` and exits with `status`.
fn with_tools(directory: &Path, tools: &[&str], status: i32, arguments: &[&str]) -> Finished {
    let path = directory.join("bin");
    fs::create_dir_all(&path).expect("a folder");
    for tool in tools {
        let file = path.join(tool);
        let called = directory.join("called");
        let script = format!(
            "#!/bin/sh\necho \"$0 $*\" > {}\nfor last; do :; done\n[ -d \"$last\" ] && /bin/cp -r \"$last\" {}\nexit {status}\n",
            called.display(),
            directory.join("uploaded").display()
        );
        fs::write(&file, script).expect("a script");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).expect("executable");
    }
    let output = motorlab(directory, arguments).env("PATH", &path).output();
    Finished::from(output.expect("the command starts"))
}

fn called(directory: &Path) -> String {
    fs::read_to_string(directory.join("called")).expect("the tool was called")
}

#[test]
fn the_sketch_is_written_unchanged() {
    let directory = tempfile::tempdir().expect("a folder");
    let finished = run(directory.path(), &["firmware", "here"]);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware-protocol/arduino/motorlab");
    let mut files = 0;
    for entry in fs::read_dir(source).expect("the sketch") {
        let path = entry.expect("a file").path();
        let name = path.file_name().expect("a name");
        let written = fs::read(directory.path().join("here/motorlab").join(name));
        assert_eq!(written.expect("written"), fs::read(&path).expect("a file"));
        files += 1;
    }
    assert!(files > 5);
}

#[test]
fn changed_settings_are_not_overwritten() {
    let directory = tempfile::tempdir().expect("a folder");
    run(directory.path(), &["firmware", "."]);
    let settings = directory.path().join("motorlab/settings.h");
    fs::write(&settings, "mine").expect("written");
    let finished = run(directory.path(), &["firmware", "."]);
    assert_eq!(finished.status, Some(2));
    assert!(
        finished.messages.contains("settings.h"),
        "{}",
        finished.messages
    );
    assert_eq!(fs::read_to_string(&settings).expect("a file"), "mine");
    let finished = run(directory.path(), &["firmware", ".", "--force"]);
    assert_eq!(finished.status, Some(0));
    assert_ne!(fs::read_to_string(&settings).expect("a file"), "mine");
}

#[test]
fn arduino_cli_compiles_and_uploads_the_built_in_sketch() {
    let directory = tempfile::tempdir().expect("a folder");
    let arguments = ["flash", "/dev/ttyACM7", "--board", "mega"];
    let finished = with_tools(directory.path(), &["arduino-cli"], 0, &arguments);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let called = called(directory.path());
    assert!(called.contains("compile --fqbn arduino:avr:mega --upload --port /dev/ttyACM7"));
    assert!(directory.path().join("uploaded/motorlab.ino").exists());
    let sketch = called.split_whitespace().last().expect("a folder");
    assert!(!Path::new(sketch).exists(), "the temporary sketch is gone");
}

#[test]
fn avrdude_uploads_a_compiled_sketch() {
    let directory = tempfile::tempdir().expect("a folder");
    fs::write(directory.path().join("a.hex"), ":00000001FF\n").expect("written");
    let arguments = ["flash", "/dev/ttyUSB0", "--board", "uno", "--hex", "a.hex"];
    let finished = with_tools(directory.path(), &["avrdude"], 0, &arguments);
    assert_eq!(finished.status, Some(0), "{}", finished.messages);
    let called = called(directory.path());
    assert!(
        called.contains("-p atmega328p -c arduino -b 115200 -D -P /dev/ttyUSB0 -U flash:w:a.hex:i")
    );
}

#[test]
fn missing_tools_are_named_with_their_installation() {
    let directory = tempfile::tempdir().expect("a folder");
    let arguments = ["flash", "/dev/ttyACM7", "--board", "uno"];
    let finished = with_tools(directory.path(), &[], 0, &arguments);
    assert_eq!(finished.status, Some(3));
    for wanted in [
        "neither arduino-cli nor avrdude",
        "arduino-cli core install arduino:avr",
        "apt install avrdude",
    ] {
        assert!(finished.messages.contains(wanted), "{}", finished.messages);
    }
    let finished = with_tools(directory.path(), &["avrdude"], 0, &arguments);
    assert_eq!(finished.status, Some(3));
    assert!(
        finished.messages.contains("--hex FILE"),
        "{}",
        finished.messages
    );
    let unknown = with_tools(
        directory.path(),
        &["arduino-cli"],
        0,
        &["flash", "/dev/ttyACM7"],
    );
    assert_eq!(unknown.status, Some(2));
    assert!(
        unknown.messages.contains("--board uno"),
        "{}",
        unknown.messages
    );
}

#[test]
fn a_failing_tool_is_a_device_error() {
    let directory = tempfile::tempdir().expect("a folder");
    let arguments = ["flash", "/dev/ttyACM7", "--board", "uno"];
    let finished = with_tools(directory.path(), &["arduino-cli"], 1, &arguments);
    assert_eq!(finished.status, Some(3));
    assert!(
        finished.messages.contains("arduino-cli failed"),
        "{}",
        finished.messages
    );
}
