//! Runs a program with limits on output and time: command line in, output and exit status out.

use std::io::{self, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Polling period for the end of the program: less than any reported time.
const POLL_EVERY: Duration = Duration::from_millis(2);

/// How long output may arrive after the end: children may hold the pipe.
const READ_TIMEOUT: Duration = Duration::from_secs(1);

/// Windows' flag for a program that does not receive this console's Ctrl-C.
#[cfg(windows)]
const CREATE_NEW_PROCESS_GROUP: u32 = 0x200;

#[derive(Debug)]
pub(super) struct ProgramOutput {
    /// Exit status; `None` after a timeout.
    pub status: Option<ExitStatus>,
    /// The beginning of its standard output.
    pub output: Vec<u8>,
    /// The beginning of its standard error.
    pub messages: Vec<u8>,
}

/// Runs a program with empty standard input. At most `most_bytes` of each output are kept, after which its pipe is
/// closed; after `longest` it is ended with its children.
///
/// # Errors
/// The program does not start.
pub(super) fn run_bounded(
    command: &mut Command,
    most_bytes: u64,
    longest: Option<Duration>,
) -> io::Result<ProgramOutput> {
    // Ctrl-C ends the run of a set after the current cases, which must not receive it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(command, CREATE_NEW_PROCESS_GROUP);
    let begun = Instant::now();
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let output = gather(child.stdout.take(), most_bytes);
    let messages = gather(child.stderr.take(), most_bytes);
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status);
        }
        if longest.is_some_and(|longest| begun.elapsed() > longest) {
            break None;
        }
        thread::sleep(POLL_EVERY);
    };
    if status.is_none() {
        end(&mut child);
    }
    let finished = |from: Receiver<Vec<u8>>| from.recv_timeout(READ_TIMEOUT).unwrap_or_default();
    Ok(ProgramOutput {
        status,
        output: finished(output),
        messages: finished(messages),
    })
}

/// Reads in a separate thread, so that neither pipe blocks the other.
fn gather(pipe: Option<impl Read + Send + 'static>, most_bytes: u64) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut finished = Vec::new();
        if let Some(pipe) = pipe {
            // Output before an error is kept.
            let _ = pipe.take(most_bytes).read_to_end(&mut finished);
        }
        let _ = sender.send(finished);
    });
    receiver
}

/// Ends a program that exceeds its time, with its children in the same process group.
fn end(child: &mut Child) {
    #[cfg(unix)]
    if let Some(group) = rustix::process::Pid::from_raw(child.id() as i32) {
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    // A process that cannot be ended with its children is ended alone.
    #[cfg(windows)]
    let _ = Command::new("taskkill")
        .args(["/T", "/F", "/PID", &child.id().to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn output_is_read_up_to_its_limits_and_child_processes_are_ended() {
        let finished = run_bounded(&mut shell("echo out; echo err >&2; exit 3"), 100, None)
            .expect("it starts");
        assert_eq!(finished.status.and_then(|status| status.code()), Some(3));
        assert_eq!(
            (&finished.output[..], &finished.messages[..]),
            (&b"out\n"[..], &b"err\n"[..])
        );
        let endless = run_bounded(&mut shell("yes"), 1000, None).expect("it starts");
        assert_eq!(endless.output.len(), 1000);
        let begun = Instant::now();
        let limit = Duration::from_millis(100);
        let hung = run_bounded(
            &mut shell("echo out; sleep 1000 & sleep 1000"),
            100,
            Some(limit),
        );
        let hung = hung.expect("it starts");
        assert!(hung.status.is_none() && hung.output == b"out\n");
        assert!(begun.elapsed() < Duration::from_secs(30));
    }
}
