//! Long work on a thread of its own: the interpreter's lock is free meanwhile, and Ctrl-C is heard.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How long a Ctrl-C may wait to be heard.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether the work has been given up; [`Given::go_on`] is where it ends then.
#[derive(Debug, Clone, Default)]
pub(crate) struct Given {
    up: Arc<AtomicBool>,
}

/// Panic that ends a thread whose work was given up.
struct GivenUp;

impl Given {
    /// Ends this thread, if its work has been given up.
    pub(crate) fn go_on(&self) {
        if self.up.load(Ordering::Relaxed) {
            resume_unwind(Box::new(GivenUp));
        }
    }
}

/// Does the work on a thread of its own and waits for it.
///
/// # Errors
/// A signal handler's, such as `KeyboardInterrupt`: the work is given up, and ends where it next looks.
pub(crate) fn apart<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Given) -> T + Send + 'static,
) -> PyResult<T> {
    let given = Given::default();
    let seen = given.clone();
    let (sender, receiver) = channel();
    let worker = thread::spawn(move || {
        // Nobody listens to what was given up.
        let _ = sender.send(work(&seen));
    });
    // `recv_timeout` of one thread's channel: the lock is taken back only to look for signals.
    let receiver = std::sync::Mutex::new(receiver);
    loop {
        let received = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(LOOK_EVERY),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match received {
            Ok(done) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if let Err(signal) = py.check_signals() {
            given.up.store(true, Ordering::Relaxed);
            return Err(signal);
        }
    }
    let said = match worker.join() {
        Err(panic) => match panic.downcast_ref::<String>() {
            Some(text) => text.clone(),
            None => "the work ended without a result".to_owned(),
        },
        Ok(()) => "the work ended without a result".to_owned(),
    };
    Err(PyRuntimeError::new_err(said))
}
