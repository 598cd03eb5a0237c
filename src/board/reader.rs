//! The reader thread: one blocking read after the other, each stamped right after it returns.
//!
//! Bytes go through a bounded channel to whoever awaits them. Nothing else happens on this thread, so
//! neither a slow disk nor a blocked terminal makes it late; a consumer that stays away for longer than
//! the channel holds makes it wait, the kernel's buffer fills, and the sequence numbers tell.

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use tokio::sync::mpsc;

/// Reads that may wait in the channel: at 333 samples/s some 24 s.
const CHANNEL_READS: usize = 8192;

/// Most bytes of one read.
const READ_BYTES: usize = 4096;

/// What came over the line.
#[derive(Debug)]
pub enum Arrival {
    /// Bytes, and when the read that gave them returned.
    Bytes {
        /// Monotonic time since the reader's origin.
        host_us: u64,
        /// The bytes.
        bytes: Box<[u8]>,
    },
    /// The device went away; nothing follows.
    HungUp {
        /// Monotonic time since the reader's origin.
        host_us: u64,
    },
    /// Reading failed; nothing follows.
    Failed(io::Error),
}

/// The receiving end of a reader thread. Dropping it ends the thread.
#[derive(Debug)]
pub struct LineReader {
    arrivals: mpsc::Receiver<Arrival>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    origin: Instant,
}

impl LineReader {
    /// Starts reading `port`, whose reads should time out now and then. A read of 0 bytes or
    /// `BrokenPipe` means that the device is gone. Times count from `origin`.
    pub fn spawn(port: impl Read + Send + 'static, origin: Instant) -> io::Result<Self> {
        let (sender, arrivals) = mpsc::channel(CHANNEL_READS);
        let stop = Arc::new(AtomicBool::new(false));
        let thread = thread::Builder::new()
            .name("serial-reader".to_owned())
            .spawn({
                let stop = Arc::clone(&stop);
                move || read_until_gone(port, origin, &sender, &stop)
            })?;
        Ok(Self {
            arrivals,
            stop,
            thread: Some(thread),
            origin,
        })
    }

    /// The next arrival; `None` after a hang-up, a failure or a stop.
    pub async fn next(&mut self) -> Option<Arrival> {
        self.arrivals.recv().await
    }

    /// The next arrival if it is there already.
    pub fn try_next(&mut self) -> Option<Arrival> {
        self.arrivals.try_recv().ok()
    }

    /// Host time now, on the arrivals' scale.
    pub fn now_us(&self) -> u64 {
        self.origin.elapsed().as_micros() as u64
    }
}

impl Drop for LineReader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.arrivals.close();
        // The port is free again once the thread has ended, a read's patience later at most.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn read_until_gone(
    mut port: impl Read,
    origin: Instant,
    sender: &mpsc::Sender<Arrival>,
    stop: &AtomicBool,
) {
    let mut buffer = [0; READ_BYTES];
    while !stop.load(Ordering::Relaxed) {
        let read = port.read(&mut buffer);
        let host_us = origin.elapsed().as_micros() as u64;
        let (arrival, last) = match read {
            Ok(0) => (Arrival::HungUp { host_us }, true),
            Ok(count) => {
                let bytes = buffer[..count].into();
                (Arrival::Bytes { host_us, bytes }, false)
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::Interrupted
                | io::ErrorKind::WouldBlock => continue,
                io::ErrorKind::BrokenPipe => (Arrival::HungUp { host_us }, true),
                _ => (Arrival::Failed(error), true),
            },
        };
        if sender.blocking_send(arrival).is_err() || last {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// A device that is gone: every read gives 0 bytes at once.
    struct Gone(Arc<AtomicUsize>);

    impl Read for Gone {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Ok(0)
        }
    }

    #[tokio::test]
    async fn a_hang_up_ends_the_thread_after_one_read() {
        let reads = Arc::new(AtomicUsize::new(0));
        let mut reader =
            LineReader::spawn(Gone(Arc::clone(&reads)), Instant::now()).expect("a thread");
        assert!(matches!(reader.next().await, Some(Arrival::HungUp { .. })));
        assert!(reader.next().await.is_none());
        drop(reader);
        assert_eq!(reads.load(Ordering::Relaxed), 1);
    }

    #[tokio::test]
    async fn arrivals_keep_their_order_and_their_times_rise() {
        let bytes: Vec<u8> = (0..100_000_u32).map(|k| (k % 251) as u8).collect();
        let mut reader =
            LineReader::spawn(io::Cursor::new(bytes.clone()), Instant::now()).expect("a thread");
        let (mut got, mut last_us) = (Vec::new(), 0);
        while let Some(Arrival::Bytes { host_us, bytes }) = reader.next().await {
            assert!(host_us >= last_us);
            last_us = host_us;
            got.extend_from_slice(&bytes);
        }
        assert_eq!(got, bytes);
    }
}
