//! The reader thread: blocking reads, each with a time stamp on its return.
//!
//! Bytes go through a bounded channel to the consumer. Nothing else runs on this thread, so that neither a slow disk
//! nor a blocked terminal delays it; if the consumer is blocked for longer than the channel holds, the kernel's
//! buffer fills, and gaps in the sequence numbers show the loss. The channel is bounded in reads and in bytes, so
//! that memory is constant for long recordings and fast devices (a virtual board, a replayed log).
//!
//! Waking up costs more than processing a sample. Where samples have device times and arrive faster than they are
//! needed, bytes are therefore left to accumulate in the kernel ([`LineReader::gather`]).

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
#[cfg(not(target_family = "wasm"))]
use std::thread;
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::mpsc;

use crate::platform::time::Instant;
#[cfg(target_family = "wasm")]
use crate::platform::time::{sleep, spawn};

/// Capacity of the channel in reads: some 24 s at 333 samples/s.
const CHANNEL_READS: usize = 8192;

/// Capacity of the channel in bytes, plus one read: some 22 s at 115200 baud.
const CHANNEL_BYTES: usize = 256 * 1024;

/// Size of one read in bytes.
const READ_BYTES: usize = 4096;

/// How long a reader waits before it checks again for room in the channel.
const ROOM: Duration = Duration::from_millis(1);

/// Longest time that bytes accumulate in the kernel: two fifths of the 50 ms that a crash may lose.
pub const LONGEST_GATHER: Duration = Duration::from_millis(20);

/// Initial accumulation time.
const FIRST_GATHER: Duration = Duration::from_millis(1);

/// A read of this many bytes leaves no time to accumulate: a quarter of a Linux terminal's buffer (4096).
const CROWDED_BYTES: usize = 1024;

/// How long bytes may accumulate for samples every `sample_time` over a line of `baud` (10 bits a byte):
/// [`LONGEST_GATHER`], or until a quarter of the kernel's buffer is full; 0 if fewer than two samples would
/// accumulate.
pub fn longest_gather(baud: u32, sample_time: Duration) -> Duration {
    if 2 * sample_time > LONGEST_GATHER {
        return Duration::ZERO;
    }
    let full = Duration::from_secs(10 * CROWDED_BYTES as u64) / baud.max(1);
    full.min(LONGEST_GATHER)
}

/// Bytes from the line.
#[derive(Debug)]
pub enum Arrival {
    /// Bytes with the time at which the read returned.
    Bytes {
        /// Monotonic time since the reader's origin.
        host_us: u64,
        /// The bytes.
        bytes: Box<[u8]>,
    },
    /// The device was unplugged; the last arrival.
    HungUp {
        /// Monotonic time since the reader's origin.
        host_us: u64,
    },
    /// Reading failed; the last arrival.
    Failed(io::Error),
}

/// The receiving end of a reader thread. Dropping it ends the thread.
#[derive(Debug)]
pub struct LineReader {
    arrivals: mpsc::Receiver<Arrival>,
    /// Bytes in the channel.
    waiting: Arc<AtomicUsize>,
    stop: Arc<AtomicBool>,
    /// Accumulation time in microseconds.
    gather_us: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
    origin: Instant,
}

impl LineReader {
    /// Reads `port` in turns of the page's event loop.
    #[cfg(target_family = "wasm")]
    pub fn spawn(mut port: impl Read + Send + 'static, origin: Instant) -> io::Result<Self> {
        let (reading, reader) = Self::unread(origin);
        spawn(async move {
            let mut buffer = [0; READ_BYTES];
            let mut pause = Duration::ZERO;
            while !reading.stop.load(Ordering::Relaxed) {
                if reading.waiting.load(Ordering::Relaxed) >= CHANNEL_BYTES {
                    sleep(ROOM).await;
                    continue;
                }
                if let Some((arrival, last)) = reading.read(&mut port, &mut buffer) {
                    if let Arrival::Bytes { bytes, .. } = &arrival {
                        pause = reading.next_pause(pause, bytes.len());
                    }
                    if reading.sender.send(arrival).await.is_err() || last {
                        return;
                    }
                }
                sleep(pause).await;
            }
        });
        Ok(reader)
    }

    /// Starts reading `port`, whose reads must have a timeout. A read of 0 bytes or `BrokenPipe` means that the
    /// device is gone. Times are relative to `origin`.
    #[cfg(not(target_family = "wasm"))]
    pub fn spawn(port: impl Read + Send + 'static, origin: Instant) -> io::Result<Self> {
        let (reading, mut reader) = Self::unread(origin);
        let thread = thread::Builder::new()
            .name("serial-reader".to_owned())
            .spawn(move || reading.until_gone(port))?;
        reader.thread = Some(thread);
        Ok(reader)
    }

    /// Both ends, before the first read.
    fn unread(origin: Instant) -> (Reading, Self) {
        let (sender, arrivals) = mpsc::channel(CHANNEL_READS);
        let reader = Self {
            arrivals,
            waiting: Arc::default(),
            stop: Arc::default(),
            gather_us: Arc::default(),
            thread: None,
            origin,
        };
        let reading = Reading {
            origin,
            sender,
            waiting: Arc::clone(&reader.waiting),
            stop: Arc::clone(&reader.stop),
            gather_us: Arc::clone(&reader.gather_us),
        };
        (reading, reader)
    }

    /// From now on lets bytes accumulate for this time after each read; not at all with [`Duration::ZERO`], as
    /// initially. The time is increased over several reads, and a large read ends it for the next ones, so that the
    /// bytes never exceed the kernel's buffer.
    pub fn gather(&self, longest: Duration) {
        let us = longest.min(LONGEST_GATHER).as_micros() as u64;
        self.gather_us.store(us, Ordering::Relaxed);
    }

    /// The next arrival; `None` after a hang-up, a failure or a stop.
    pub async fn next(&mut self) -> Option<Arrival> {
        let arrival = self.arrivals.recv().await?;
        Some(self.taken(arrival))
    }

    /// The next arrival, without waiting.
    pub fn try_next(&mut self) -> Option<Arrival> {
        let arrival = self.arrivals.try_recv().ok()?;
        Some(self.taken(arrival))
    }

    /// Frees the arrival's bytes in the channel.
    fn taken(&self, arrival: Arrival) -> Arrival {
        if let Arrival::Bytes { bytes, .. } = &arrival {
            self.waiting.fetch_sub(bytes.len(), Ordering::Relaxed);
        }
        arrival
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
        // The port is free once the thread has ended, after one read timeout at most.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The thread's side of a [`LineReader`].
struct Reading {
    origin: Instant,
    sender: mpsc::Sender<Arrival>,
    waiting: Arc<AtomicUsize>,
    stop: Arc<AtomicBool>,
    gather_us: Arc<AtomicU64>,
}

impl Reading {
    #[cfg(not(target_family = "wasm"))]
    fn until_gone(&self, mut port: impl Read) {
        let mut buffer = [0; READ_BYTES];
        let mut pause = Duration::ZERO;
        let mut gathered = false;
        while !self.stop.load(Ordering::Relaxed) {
            if self.waiting.load(Ordering::Relaxed) >= CHANNEL_BYTES {
                thread::sleep(ROOM);
                continue;
            }
            let Some((arrival, last)) = self.read(&mut port, &mut buffer) else {
                continue;
            };
            if let Arrival::Bytes { bytes, .. } = &arrival {
                pause = self.next_pause(pause, bytes.len());
            }
            if self.sender.blocking_send(arrival).is_err() || last {
                return;
            }
            // Accumulated bytes are read at once, later ones as they arrive, each with its time: the clocks are
            // compared by these.
            gathered = !gathered && !pause.is_zero();
            if gathered {
                thread::sleep(pause);
            }
        }
    }

    /// One read, and whether it is the last; `None` without bytes.
    fn read(&self, port: &mut impl Read, buffer: &mut [u8]) -> Option<(Arrival, bool)> {
        let read = port.read(buffer);
        let host_us = self.origin.elapsed().as_micros() as u64;
        Some(match read {
            Ok(0) => (Arrival::HungUp { host_us }, true),
            Ok(count) => {
                let bytes = buffer[..count].into();
                self.waiting.fetch_add(count, Ordering::Relaxed);
                (Arrival::Bytes { host_us, bytes }, false)
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::Interrupted
                | io::ErrorKind::WouldBlock => return None,
                io::ErrorKind::BrokenPipe => (Arrival::HungUp { host_us }, true),
                _ => (Arrival::Failed(error), true),
            },
        })
    }

    /// Accumulation time after a read of `count` bytes, given the previous one.
    fn next_pause(&self, before: Duration, count: usize) -> Duration {
        let longest = Duration::from_micros(self.gather_us.load(Ordering::Relaxed));
        if count >= CROWDED_BYTES {
            return Duration::ZERO;
        }
        (2 * before).max(FIRST_GATHER).min(longest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// A device that is gone: every read returns 0 bytes.
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

    /// A device that always has bytes, and counts them.
    struct Endless(Arc<AtomicUsize>);

    impl Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.fetch_add(buffer.len(), Ordering::Relaxed);
            Ok(buffer.len())
        }
    }

    #[tokio::test]
    async fn a_device_in_a_hurry_gets_no_further_ahead_than_the_channel_holds() {
        let sent = Arc::new(AtomicUsize::new(0));
        let port = Endless(Arc::clone(&sent));
        let mut reader = LineReader::spawn(port, Instant::now()).expect("a thread");
        let mut taken = 0;
        // Twice the capacity of the channel, so that it was full and emptied again.
        while taken < 2 * CHANNEL_BYTES {
            let Some(Arrival::Bytes { bytes, .. }) = reader.next().await else {
                panic!("it never ends");
            };
            taken += bytes.len();
            // One read is in transit, and one may have begun before the channel was full.
            let ahead = sent.load(Ordering::Relaxed) - taken;
            assert!(ahead <= CHANNEL_BYTES + 2 * READ_BYTES, "{ahead}");
            if taken == READ_BYTES {
                thread::sleep(20 * ROOM);
            }
        }
    }

    #[tokio::test]
    async fn arrivals_keep_their_order_and_their_times_rise() {
        for gather in [Duration::ZERO, LONGEST_GATHER] {
            let bytes: Vec<u8> = (0..100_000_u32).map(|k| (k % 251) as u8).collect();
            let mut reader = LineReader::spawn(io::Cursor::new(bytes.clone()), Instant::now())
                .expect("a thread");
            reader.gather(gather);
            let (mut got, mut last_us) = (Vec::new(), 0);
            while let Some(Arrival::Bytes { host_us, bytes }) = reader.next().await {
                assert!(host_us >= last_us);
                last_us = host_us;
                got.extend_from_slice(&bytes);
            }
            assert_eq!(got, bytes);
        }
    }

    #[test]
    fn gathered_bytes_fit_a_quarter_of_the_kernel_buffer() {
        let every = Duration::from_micros(100);
        for baud in [
            300, 9600, 115_200, 250_000, 500_000, 1_000_000, 2_000_000, 4_000_000,
        ] {
            let gather = longest_gather(baud, every);
            assert!(gather <= LONGEST_GATHER, "{baud}: {gather:?}");
            let bytes = f64::from(baud) / 10.0 * gather.as_secs_f64();
            assert!(bytes <= 1024.0, "{baud}: {bytes}");
        }
        assert_eq!(longest_gather(115_200, every), LONGEST_GATHER);
        // Samples that arrive one at a time are read as they arrive.
        assert_eq!(
            longest_gather(115_200, Duration::from_millis(30)),
            Duration::ZERO
        );
    }

    #[test]
    fn the_wait_grows_until_a_read_has_many_bytes() {
        let (sender, _arrivals) = mpsc::channel(1);
        let reading = Reading {
            origin: Instant::now(),
            sender,
            waiting: Arc::default(),
            stop: Arc::default(),
            gather_us: Arc::new(AtomicU64::new(10_000)),
        };
        let mut pause = Duration::ZERO;
        let mut pauses_ms = Vec::new();
        for count in [18, 18, 36, 90, 180, 180, 1023, 1024, 4096, 18, 18] {
            pause = reading.next_pause(pause, count);
            pauses_ms.push(pause.as_millis());
        }
        assert_eq!(pauses_ms, [1, 2, 4, 8, 10, 10, 10, 0, 0, 1, 2]);
        reading.gather_us.store(0, Ordering::Relaxed);
        assert_eq!(reading.next_pause(pause, 18), Duration::ZERO);
    }
}
