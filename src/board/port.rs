//! Exclusive serial ports.
//!
//! On Unix there are two locks: `TIOCEXCL` excludes other users, `flock` also root and a second instance of this
//! program. Windows opens a port once. After a disconnect a read returns the queued bytes and then 0 bytes, so that
//! no bytes are lost and no loop spins.

use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use serialport::SerialPort;

use super::location::SerialLine;
use super::open_error::{OpenError, READ_PATIENCE};
#[cfg(unix)]
use super::port_unix as system;
#[cfg(windows)]
use super::port_windows as system;

/// An open serial port. Reading returns 0 bytes if the device is gone, `TimedOut` if it is silent.
#[derive(Debug)]
pub struct Port {
    port: system::Native,
}

impl Port {
    /// Opens the port at `baud`, 8N1, raw, exclusively.
    pub fn open(path: &Path, baud: u32) -> Result<Self, OpenError> {
        system::refuse_no_port(path)?;
        let port = serialport::new(path.to_string_lossy(), baud)
            .timeout(READ_PATIENCE)
            .open_native()
            .map_err(|error| system::explain(path, &error))?;
        Ok(Self { port })
    }

    /// Pulses DTR, which resets an Arduino. Pseudo-terminals have no DTR: best effort.
    pub fn pulse_dtr(&mut self) -> bool {
        let low = self.port.write_data_terminal_ready(false);
        std::thread::sleep(Duration::from_millis(50));
        let high = self.port.write_data_terminal_ready(true);
        low.is_ok() && high.is_ok()
    }
}

impl SerialLine for Port {
    fn try_clone(&self) -> io::Result<Box<dyn SerialLine>> {
        Ok(Box::new(Self {
            port: self.port.try_clone_native()?,
        }))
    }
}

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.port.read(buffer) {
            Err(error) if system::is_gone(&error) => Ok(system::read_queued(&self.port, buffer)),
            other => other,
        }
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.port.write(bytes)
    }

    /// Writes are unbuffered; draining the line would wait for the baud rate.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::board::BoardSide;
    use crate::board::pty::Pty;

    #[test]
    fn a_hang_up_gives_no_bytes_and_no_error() {
        let mut pty = Pty::open().expect("a pseudo-terminal");
        let mut port = Port::open(pty.path(), 115_200).expect("openable");
        assert_eq!(pty.write_some(&[7; 100]).expect("room"), 100);
        let mut buffer = [0; 64];
        // Some kernels drop queued bytes when the near end of a pseudo-terminal is closed.
        assert_eq!(port.read(&mut buffer).expect("bytes"), 64);
        drop(pty);
        let mut rest = 0;
        let mut zeros = 0;
        while zeros < 3 {
            match port.read(&mut buffer).expect("a hang-up is no error") {
                0 => zeros += 1,
                count => rest += count,
            }
        }
        assert!(rest <= 36);
    }

    #[test]
    fn a_second_reader_of_the_same_user_is_refused() {
        let pty = Pty::open().expect("a pseudo-terminal");
        let first = Port::open(pty.path(), 115_200).expect("openable");
        let error = Port::open(pty.path(), 115_200).expect_err("locked");
        assert!(matches!(error, OpenError::Busy { .. }), "{error}");
        drop(first);
        Port::open(pty.path(), 115_200).expect("openable again");
    }

    #[test]
    fn other_files_are_not_opened_as_ports() {
        let message = |path: &str| {
            Port::open(Path::new(path), 115_200)
                .expect_err("no port")
                .to_string()
        };
        assert!(message("/dev/ttyACM77").starts_with("there is no port /dev/ttyACM77"));
        assert!(message("/dev/zero").contains("another kind of device, not a serial port"));
        assert!(message("/tmp").contains("a directory, not a serial port"));
        assert!(message("/etc/passwd").contains("a file, not a serial port"));
    }
}
