//! Input of any size and kind: a clear error or a result, in bounded memory, and never a panic.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;

use crate::support::command::{Finished, finish};
use motorlab::recording::{ReadProblem, read_run_from};

const HEADER: &str = "# format = \"motorlab-run/1\"\n# sample_time_s = 0.003\n# counts_per_rev = 720\n# supply_v = 4.5\n# complete = true\n";
const COLUMNS: &str = "t_s,command_v,counts\n";

/// Runs the command with at most 1 GB of address space (`ulimit -v`).
fn in_a_gigabyte(directory: &Path, arguments: &[&str]) -> Finished {
    let child = Command::new("sh")
        .args(["-c", "ulimit -v 1000000; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_motorlab"))
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    finish(child.expect("a shell"))
}

/// Every command that reads a file, reading this one.
fn readers(file: &str) -> Vec<Vec<&str>> {
    vec![
        vec!["compare", file],
        vec!["diagnose", file],
        vec!["export", "matlab", "--run", file, "-o", "matlab"],
        vec!["replay", file],
        vec!["replay", file, "--columns", "auto"],
        vec!["replay", file, "--pty"],
        vec!["simulate", "--motor", file],
        vec!["simulate", "--profile", file],
        vec!["capture", "virtual:", "--profile", file],
        vec!["import", "any.csv", "--map", file],
    ]
}

/// Invalid input is reported in a message of a few lines that names it.
fn is_refused(done: &Finished, arguments: &[&str], named: &str) {
    let messages = &done.messages;
    assert_eq!(done.status, Some(2), "{arguments:?}: {messages}");
    assert!(messages.contains("error: "), "{arguments:?}: {messages}");
    assert!(messages.contains(named), "{arguments:?}: {messages}");
    assert!(messages.len() < 1500, "{arguments:?}: {messages}");
    assert!(!messages.contains('\u{1b}') && !messages.contains('\0'));
}

#[test]
fn endless_files_and_one_long_line_are_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let long = directory.path().join("./long.csv");
    let line = [HEADER.as_bytes(), &vec![b'7'; 10_000_000]].concat();
    std::fs::write(&long, line).expect("a file");
    for file in ["/dev/zero", "./long.csv"] {
        for arguments in readers(file) {
            let done = in_a_gigabyte(directory.path(), &arguments);
            is_refused(&done, &arguments, file);
        }
    }
    // A device that is not a serial port.
    let arguments = ["capture", "/dev/zero"];
    let done = in_a_gigabyte(directory.path(), &arguments);
    is_refused(&done, &arguments, "not a serial port");
}

#[test]
fn other_encodings_and_other_files_are_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let text = format!("{HEADER}{COLUMNS}0,0,0\n0.003,4.5,1\n");
    let utf_16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin_1 = text.replace("4.5,1", "4.5\u{b5},1");
    let latin_1: Vec<u8> = latin_1.chars().map(|c| c as u8).collect();
    let escapes = format!("{HEADER}{COLUMNS}0,0,\u{1b}[2J\u{1b}]0;x\u{7}\n0,0,0\n");
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".repeat(500);
    for bytes in [&utf_16[..], &latin_1, escapes.as_bytes(), &png] {
        std::fs::write(directory.path().join("./run.csv"), bytes).expect("a file");
        for arguments in readers("./run.csv") {
            let done = in_a_gigabyte(directory.path(), &arguments);
            is_refused(&done, &arguments, "./run.csv");
        }
    }
}

#[test]
fn numbers_at_the_limits_of_their_format_cause_no_panic() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("run.csv");
    let rows = [
        "0,0,9223372036854775807\n1,4.5,-9223372036854775808\n2,4.5,9223372036854775807\n",
        "0,1.7e308,0\n1e-300,-1.7e308,1\n1,1.7e308,2\n",
        "-1.7e308,0,0\n0,4.5,1\n1.7e308,4.5,2\n",
        "0,0,0\n1e-9,4.5,1\n2e-9,4.5,1\n3600,4.5,2\n",
        "0,5e-324,0\n5e-324,5e-324,0\n1e-323,5e-324,0\n",
        "0,0,0\n1e15,4.5,1\n1.000000001e15,4.5,1\n",
    ];
    for rows in rows {
        for counts_per_rev in ["720", "1e-300", "1e300"] {
            let header = HEADER.replace("720", counts_per_rev);
            std::fs::write(&path, format!("{header}{COLUMNS}{rows}")).expect("a file");
            for arguments in [
                &["compare", "run.csv", "--json"][..],
                &["compare", "run.csv", "--html", "page.html"],
                &["export", "matlab", "--run", "run.csv", "-o", "matlab"],
            ] {
                let done = in_a_gigabyte(directory.path(), arguments);
                let said = &done.messages;
                assert!(
                    matches!(done.status, Some(0..=2)),
                    "{rows}{arguments:?}: {said}"
                );
                assert!(!said.contains("panicked"), "{rows}{arguments:?}: {said}");
            }
        }
    }
}

/// Makes a FIFO and writes into it until its reader has closed it.
fn a_fifo(path: &Path, mut write: impl FnMut(&mut File) -> io::Result<()> + Send + 'static) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()));
    let path = path.to_owned();
    thread::spawn(move || {
        let mut fifo = File::create(path)?;
        write(&mut fifo)
    });
}

#[test]
fn a_fifo_is_read_like_a_file() {
    let directory = tempfile::tempdir().expect("a directory");
    a_fifo(&directory.path().join("run.csv"), |fifo| {
        write!(fifo, "{HEADER}{COLUMNS}")?;
        (0..500).try_for_each(|k| writeln!(fifo, "{:.3},0,0", f64::from(k) * 0.003))
    });
    let done = in_a_gigabyte(directory.path(), &["compare", "run.csv", "--json"]);
    assert_eq!(done.status, Some(0), "{}", done.messages);
    let document: serde_json::Value = serde_json::from_str(&done.output).expect("one document");
    assert_eq!(document["runs"][0]["samples"], 500);
}

#[test]
fn a_gigabyte_of_rows_is_refused_at_five_million() {
    let directory = tempfile::tempdir().expect("a directory");
    a_fifo(&directory.path().join("run.csv"), |fifo| {
        write!(fifo, "{HEADER}{COLUMNS}")?;
        let mut block = String::new();
        for first in (0_u64..100_000_000).step_by(10_000) {
            block.clear();
            for k in first..first + 10_000 {
                block.push_str(&k.to_string());
                block.push_str(",0,0\n");
            }
            fifo.write_all(block.as_bytes())?;
        }
        Ok(())
    });
    let done = in_a_gigabyte(directory.path(), &["compare", "run.csv"]);
    is_refused(&done, &["compare"], "more than 5000000 rows");
}

/// `count` repetitions of the same bytes, without storing them.
struct Repeated {
    bytes: Vec<u8>,
    at: usize,
    count: usize,
}

impl Read for Repeated {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.count == 0 {
            return Ok(0);
        }
        let read = (&self.bytes[self.at..]).read(buffer)?;
        self.at += read;
        if self.at == self.bytes.len() {
            (self.at, self.count) = (0, self.count - 1);
        }
        Ok(read)
    }
}

#[test]
fn a_hundred_megabytes_between_quotation_marks_are_not_buffered() {
    let begin = format!("{HEADER}{COLUMNS}0,0,\"");
    let rest = Repeated {
        bytes: b"0.003,0,0\n".repeat(1000),
        at: 0,
        count: 10_000,
    };
    let error = read_run_from(begin.as_bytes().chain(rest), "run.csv").expect_err("no run");
    assert!(matches!(error.problem, ReadProblem::Io(_)));
    assert!(
        error.to_string().contains("line 7 is longer than 65536"),
        "{error}"
    );
}
