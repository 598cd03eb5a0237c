//! Being asked to stop: Ctrl-C, SIGTERM, SIGHUP; and the signals that must not kill a recorder.

use std::io;

use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// Linux and macOS number of SIGXFSZ, which a write beyond `ulimit -f` raises.
const SIGXFSZ: i32 = 25;

/// Becomes true when the user asks to stop.
#[derive(Debug, Clone)]
pub(super) struct StopSignal(watch::Receiver<bool>);

impl StopSignal {
    /// Watches from now on; call inside a tokio runtime. A write beyond the limit on file sizes becomes
    /// an ordinary error. (A closed pipe already is one: the Rust runtime ignores SIGPIPE.)
    pub(super) fn install() -> io::Result<Self> {
        let (sender, receiver) = watch::channel(false);
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut terminate = signal(SignalKind::terminate())?;
        let mut hang_up = signal(SignalKind::hangup())?;
        let mut too_large = signal(SignalKind::from_raw(SIGXFSZ))?;
        tokio::spawn(async move {
            loop {
                tokio::select! {
                    _ = interrupt.recv() => {}
                    _ = terminate.recv() => {}
                    _ = hang_up.recv() => {}
                    _ = too_large.recv() => continue,
                }
                if sender.send(true).is_err() {
                    return;
                }
            }
        });
        Ok(Self(receiver))
    }

    /// Resolves when the user asks to stop.
    pub(super) async fn asked(mut self) {
        if self.0.wait_for(|asked| *asked).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    /// Whether the user has asked to stop.
    pub(super) fn is_asked(&self) -> bool {
        *self.0.borrow()
    }
}
