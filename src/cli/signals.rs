//! Termination requests (Ctrl-C and others), and signals that must not kill a recorder.

use std::io;

use tokio::sync::watch;

/// Becomes true on a termination request.
#[derive(Debug, Clone)]
pub(super) struct StopSignal(watch::Receiver<bool>);

impl StopSignal {
    /// Watches from now on; call inside a tokio runtime. A write beyond the limit on file sizes becomes an ordinary
    /// error. (The Rust runtime already ignores SIGPIPE.)
    pub(super) fn install() -> io::Result<Self> {
        let (sender, receiver) = watch::channel(false);
        let mut asked = StopSource::install()?;
        tokio::spawn(async move {
            loop {
                asked.once().await;
                if sender.send(true).is_err() {
                    return;
                }
            }
        });
        Ok(Self(receiver))
    }

    /// Resolves on a termination request.
    pub(super) async fn asked(mut self) {
        if self.0.wait_for(|asked| *asked).await.is_err() {
            std::future::pending::<()>().await;
        }
    }

    pub(super) fn is_asked(&self) -> bool {
        *self.0.borrow()
    }
}

#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Linux and macOS number of SIGXFSZ, which a write beyond `ulimit -f` raises.
#[cfg(unix)]
const SIGXFSZ: i32 = 25;

/// Ctrl-C, SIGTERM and SIGHUP.
#[cfg(unix)]
struct StopSource {
    interrupt: Signal,
    terminate: Signal,
    hang_up: Signal,
    too_large: Signal,
}

#[cfg(unix)]
impl StopSource {
    fn install() -> io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up: signal(SignalKind::hangup())?,
            too_large: signal(SignalKind::from_raw(SIGXFSZ))?,
        })
    }

    async fn once(&mut self) {
        loop {
            tokio::select! {
                _ = self.interrupt.recv() => return,
                _ = self.terminate.recv() => return,
                _ = self.hang_up.recv() => return,
                _ = self.too_large.recv() => {}
            }
        }
    }
}

#[cfg(windows)]
use tokio::signal::windows::{
    CtrlBreak, CtrlC, CtrlClose, CtrlShutdown, ctrl_break, ctrl_c, ctrl_close, ctrl_shutdown,
};

/// Ctrl-C, Ctrl-Break, closing of the window and shutdown; Windows allows 5 s for the last two.
#[cfg(windows)]
struct StopSource {
    interrupt: CtrlC,
    terminate: CtrlBreak,
    closed: CtrlClose,
    shut_down: CtrlShutdown,
}

#[cfg(windows)]
impl StopSource {
    fn install() -> io::Result<Self> {
        Ok(Self {
            interrupt: ctrl_c()?,
            terminate: ctrl_break()?,
            closed: ctrl_close()?,
            shut_down: ctrl_shutdown()?,
        })
    }

    async fn once(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
            _ = self.closed.recv() => {}
            _ = self.shut_down.recv() => {}
        }
    }
}
