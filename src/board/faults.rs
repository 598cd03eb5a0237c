//! Seeded fault injection for any port: a bad cable, a full buffer, an unplugged board.
//!
//! It wraps a port and corrupts the bytes that are read: lost, flipped bits, duplicated, delayed, single bytes, cut
//! off. The same seed gives the same faults for the same bytes, independent of the reads' sizes.

use std::io::{self, Read, Write};
use std::thread;
use std::time::Duration;

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Kinds and rates of faults.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// Probability that a byte is lost.
    pub drop: f64,
    /// Probability that one bit of a byte is flipped.
    pub flip: f64,
    /// Probability that a byte arrives twice.
    pub duplicate: f64,
    /// Probability of a pause before a byte.
    pub stall: f64,
    /// Length of a pause.
    pub stall_for: Duration,
    /// Every read returns a single byte.
    pub split: bool,
    /// Number of bytes after which the line is silent.
    pub silent_after: Option<u64>,
    /// Number of bytes after which the device is gone.
    pub hang_up_after: Option<u64>,
    /// Seed of the faults.
    pub seed: u64,
}

/// Faults injected so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// Bytes that came from the port.
    pub bytes: u64,
    /// Bytes lost.
    pub dropped: u64,
    /// Bytes with a bit flipped.
    pub flipped: u64,
    /// Bytes duplicated.
    pub duplicated: u64,
    /// Pauses of the line.
    pub stalled: u64,
}

/// A port with faults in reading; writing is unaffected.
#[derive(Debug)]
pub struct FaultyPort<P> {
    port: P,
    faults: Faults,
    damage: Damage,
    random: Pcg64Mcg,
    /// Corrupted bytes that did not fit the reader's buffer.
    waiting: std::collections::VecDeque<u8>,
}

impl<P> FaultyPort<P> {
    /// Wraps `port`.
    pub fn new(port: P, faults: Faults) -> Self {
        Self {
            port,
            faults,
            damage: Damage::default(),
            random: Pcg64Mcg::seed_from_u64(faults.seed),
            waiting: std::collections::VecDeque::new(),
        }
    }

    /// Faults injected so far.
    pub fn damage(&self) -> Damage {
        self.damage
    }

    /// The wrapped port.
    pub fn into_inner(self) -> P {
        self.port
    }

    /// Whether an event of this probability occurs; always draws, so that the rates do not affect each other's
    /// sequence.
    fn happens(&mut self, probability: f64) -> bool {
        self.random.random::<f64>() < probability
    }

    fn hurt(&mut self, byte: u8) {
        let position = self.damage.bytes;
        self.damage.bytes += 1;
        let [drop, flip, duplicate, stall] = [
            self.happens(self.faults.drop),
            self.happens(self.faults.flip),
            self.happens(self.faults.duplicate),
            self.happens(self.faults.stall),
        ];
        let bit = self.random.next_u32() % 8;
        if self.faults.silent_after.is_some_and(|n| position >= n) {
            return;
        }
        if stall {
            self.damage.stalled += 1;
            thread::sleep(self.faults.stall_for);
        }
        if drop {
            self.damage.dropped += 1;
            return;
        }
        let byte = if flip {
            self.damage.flipped += 1;
            byte ^ (1 << bit)
        } else {
            byte
        };
        self.waiting.push_back(byte);
        if duplicate {
            self.damage.duplicated += 1;
            self.waiting.push_back(byte);
        }
    }

    fn hung_up(&self) -> bool {
        let after = self.faults.hang_up_after;
        after.is_some_and(|n| self.damage.bytes >= n)
    }
}

impl<P: Read> Read for FaultyPort<P> {
    /// Reads corrupted bytes. A device that is gone is `BrokenPipe`, as for a real port; if all bytes are lost it is
    /// `TimedOut`, since a read of 0 bytes means a disconnect.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        if self.waiting.is_empty() {
            if self.hung_up() {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            let mut raw = [0; 256];
            let mut limit = raw.len().min(buffer.len());
            if let Some(after) = self.faults.hang_up_after {
                let left = after.saturating_sub(self.damage.bytes);
                limit = limit.min(usize::try_from(left).unwrap_or(limit));
            }
            let count = self.port.read(&mut raw[..limit])?;
            if count == 0 {
                return Ok(0);
            }
            for &byte in &raw[..count] {
                self.hurt(byte);
            }
            if self.waiting.is_empty() {
                return Err(io::ErrorKind::TimedOut.into());
            }
        }
        let wanted = if self.faults.split { 1 } else { buffer.len() };
        let count = wanted.min(self.waiting.len());
        for (slot, byte) in buffer.iter_mut().zip(self.waiting.drain(..count)) {
            *slot = byte;
        }
        Ok(count)
    }
}

impl<P: Write> Write for FaultyPort<P> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        if self.hung_up() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        self.port.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.port.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads to the end, in blocks of `block` bytes.
    fn read_all(bytes: &[u8], faults: Faults, block: usize) -> (Vec<u8>, Damage, io::Result<()>) {
        let mut port = FaultyPort::new(bytes, faults);
        let mut out = Vec::new();
        let mut buffer = vec![0; block];
        let end = loop {
            match port.read(&mut buffer) {
                Ok(0) => break Ok(()),
                Ok(n) => out.extend_from_slice(&buffer[..n]),
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {}
                Err(error) => break Err(error),
            }
        };
        (out, port.damage(), end)
    }

    fn message() -> Vec<u8> {
        (0..20_000u32).map(|k| (k * 7 % 251) as u8).collect()
    }

    #[test]
    fn without_faults_bytes_pass_unchanged() {
        let (out, damage, end) = read_all(&message(), Faults::default(), 100);
        assert_eq!(out, message());
        assert_eq!(damage.bytes, 20_000);
        assert!(end.is_ok());
    }

    #[test]
    fn received_bytes_are_sent_minus_lost_plus_repeated() {
        let faults = Faults {
            drop: 0.01,
            duplicate: 0.02,
            flip: 0.03,
            seed: 5,
            ..Faults::default()
        };
        let (out, damage, _) = read_all(&message(), faults, 64);
        assert_eq!(
            out.len() as u64,
            damage.bytes - damage.dropped + damage.duplicated
        );
        // Five standard deviations of a binomial of 20,000 draws.
        for (count, rate) in [
            (damage.dropped, 0.01),
            (damage.duplicated, 0.02),
            (damage.flipped, 0.03),
        ] {
            let expected = 20_000.0 * rate;
            assert!((count as f64 - expected).abs() < 5.0 * expected.sqrt());
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_faults_for_any_split_of_the_reads() {
        let faults = Faults {
            drop: 0.01,
            flip: 0.01,
            duplicate: 0.01,
            seed: 11,
            ..Faults::default()
        };
        let (whole, ..) = read_all(&message(), faults, 4096);
        let split = Faults {
            split: true,
            ..faults
        };
        assert_eq!(read_all(&message(), split, 7).0, whole);
        let other = Faults { seed: 12, ..faults };
        assert_ne!(read_all(&message(), other, 7).0, whole);
    }

    #[test]
    fn a_hang_up_comes_after_exactly_that_many_bytes() {
        let faults = Faults {
            hang_up_after: Some(1234),
            ..Faults::default()
        };
        let (out, _, end) = read_all(&message(), faults, 100);
        assert_eq!(out, message()[..1234]);
        assert_eq!(end.unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }

    #[test]
    fn a_silent_line_stays_open_without_bytes() {
        let faults = Faults {
            silent_after: Some(50),
            ..Faults::default()
        };
        let (out, damage, end) = read_all(&message(), faults, 100);
        assert_eq!((out.len(), damage.bytes), (50, 20_000));
        assert!(end.is_ok());
    }
}
