//! Opening a serial port for this program alone, with errors that say what to do.
//!
//! The lock is double: `TIOCEXCL` keeps other users out, `flock` also keeps root and our own second
//! copy out. A read that finds the device gone gives what is still queued and then 0 bytes, so a
//! disconnect can neither lose bytes nor spin.

use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::{AsRawFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use super::port_list::{list_ports, usb_identity};
use crate::plain::shown;

/// Longest wait in one read: how late a stopped reader notices.
pub const READ_PATIENCE: Duration = Duration::from_millis(100);

/// Why a port cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// There is no such file.
    #[error("there is no port {path}{}", known_ports(known), path = shown(path))]
    NotFound {
        /// What was asked for.
        path: PathBuf,
        /// Ports that are there.
        known: Vec<PathBuf>,
    },
    /// The node's permissions keep this user out.
    #[error(
        "no permission to open {path}: it belongs to group {group} ({mode}), and this user is not in it\n  join it with:  {command}\n  and log in again", path = shown(path))]
    PermissionDenied {
        /// The port.
        path: PathBuf,
        /// Group of the node.
        group: String,
        /// Its permissions, as `ls` shows them.
        mode: String,
        /// What to type.
        command: String,
    },
    /// Another program has it.
    #[error("port {path} is in use by {holder}{advice}", path = shown(path))]
    Busy {
        /// The port.
        path: PathBuf,
        /// Who has it, as far as can be seen.
        holder: String,
        /// What to do about it.
        advice: String,
    },
    /// It is a file, a directory or another kind of device.
    #[error("{path} is {what}, not a serial port; `motorlab ports` lists those that are there", path = shown(path))]
    NotASerialPort {
        /// What was asked for.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// Anything else.
    #[error("cannot open port {path}: {description}", path = shown(path))]
    Failed {
        /// The port.
        path: PathBuf,
        /// What the operating system says.
        description: String,
    },
}

fn known_ports(known: &[PathBuf]) -> String {
    if known.is_empty() {
        return "; no serial port is connected (is the board plugged in?)".to_owned();
    }
    let names: Vec<String> = known.iter().map(shown).collect();
    format!("; there are {}", names.join(", "))
}

/// An open serial port. Reading gives 0 bytes when the device is gone, `TimedOut` when it is silent.
#[derive(Debug)]
pub struct Port {
    port: TTYPort,
}

impl Port {
    /// Opens the port at `baud`, 8N1, raw, exclusively.
    pub fn open(path: &Path, baud: u32) -> Result<Self, OpenError> {
        let kind = fs::metadata(path)
            .map_err(|error| not_openable(path, &error))?
            .file_type();
        if !kind.is_char_device() {
            return Err(OpenError::NotASerialPort {
                path: path.to_owned(),
                what: if kind.is_dir() {
                    "a directory"
                } else if kind.is_file() {
                    "a file"
                } else {
                    "no character device"
                },
            });
        }
        let port = serialport::new(path.to_string_lossy(), baud)
            .timeout(READ_PATIENCE)
            .open_native()
            .map_err(|error| explain(path, &error))?;
        Ok(Self { port })
    }

    /// A second handle on the same port, for writing.
    pub fn try_clone(&self) -> io::Result<Self> {
        Ok(Self {
            port: self.port.try_clone_native()?,
        })
    }

    /// Pulses DTR, which resets an Arduino. Pseudo-terminals have no such line: best effort.
    pub fn pulse_dtr(&mut self) -> bool {
        let low = self.port.write_data_terminal_ready(false);
        std::thread::sleep(Duration::from_millis(50));
        let high = self.port.write_data_terminal_ready(true);
        low.is_ok() && high.is_ok()
    }
}

/// What is still queued of a device that has gone away: a read that asks `poll` first does not give it.
fn read_queued(descriptor: BorrowedFd<'_>, buffer: &mut [u8]) -> usize {
    let nonblocking = rustix::fs::fcntl_getfl(descriptor).and_then(|flags| {
        rustix::fs::fcntl_setfl(descriptor, flags | rustix::fs::OFlags::NONBLOCK)
    });
    match nonblocking {
        Ok(()) => rustix::io::read(descriptor, buffer).unwrap_or(0),
        Err(_) => 0,
    }
}

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.port.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                // SAFETY: the descriptor belongs to `self.port`, which outlives the borrow.
                let descriptor = unsafe { BorrowedFd::borrow_raw(self.port.as_raw_fd()) };
                Ok(read_queued(descriptor, buffer))
            }
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

fn not_openable(path: &Path, error: &io::Error) -> OpenError {
    match error.kind() {
        io::ErrorKind::NotFound => OpenError::NotFound {
            path: path.to_owned(),
            known: list_ports().into_iter().map(|port| port.path).collect(),
        },
        _ => OpenError::Failed {
            path: path.to_owned(),
            description: error.to_string(),
        },
    }
}

fn explain(path: &Path, error: &serialport::Error) -> OpenError {
    match error.kind() {
        serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied) => permission_denied(path),
        serialport::ErrorKind::Io(kind @ io::ErrorKind::NotFound) => {
            not_openable(path, &kind.into())
        }
        serialport::ErrorKind::NoDevice => busy(path),
        _ if error.description.contains("typewriter") || error.description.contains("ioctl") => {
            OpenError::NotASerialPort {
                path: path.to_owned(),
                what: "another kind of device",
            }
        }
        _ => OpenError::Failed {
            path: path.to_owned(),
            description: error.description.clone(),
        },
    }
}

/// Names the node's real group, and the command that joins it.
fn permission_denied(path: &Path) -> OpenError {
    let metadata = fs::metadata(path).ok();
    let (gid, mode) = metadata.map_or((0, 0), |data| (data.gid(), data.mode()));
    let groups = fs::read_to_string("/etc/group").unwrap_or_default();
    let group = group_name(&groups, gid).unwrap_or_else(|| gid.to_string());
    // A group without read and write access, or root's own, is none to join.
    let command = if mode & 0o060 == 0o060 && gid != 0 {
        format!("sudo usermod -aG {group} \"$USER\"")
    } else {
        format!("sudo setfacl -m \"u:$USER:rw\" {}", shown(path))
    };
    OpenError::PermissionDenied {
        path: path.to_owned(),
        group,
        mode: mode_text(mode),
        command,
    }
}

/// Name of a group in the text of `/etc/group`.
fn group_name(groups: &str, gid: u32) -> Option<String> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, _, id) = (fields.next()?, fields.next()?, fields.next()?);
        (id.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

/// `crw-rw----`, as `ls` shows it.
fn mode_text(mode: u32) -> String {
    let bits = (0..9).rev().map(|bit| {
        if mode >> bit & 1 == 0 {
            return '-';
        }
        match bit % 3 {
            2 => 'r',
            1 => 'w',
            _ => 'x',
        }
    });
    std::iter::once('c').chain(bits).collect()
}

/// Names who holds the port; ModemManager probes every new port for some 10 s.
fn busy(path: &Path) -> OpenError {
    let holder = holder_of(path);
    let modem_manager = holder
        .as_ref()
        .is_none_or(|(_, name)| name == "ModemManager");
    let advice = if modem_manager {
        let usb = usb_identity(path);
        let (vid, pid) = usb.map_or((0x2341, 0x0043), |usb| (usb.vid, usb.pid));
        format!(
            "\n  ModemManager holds a newly plugged port for some 10 s: wait, or keep it away from the board for good with\n  echo 'ATTRS{{idVendor}}==\"{vid:04x}\", ATTRS{{idProduct}}==\"{pid:04x}\", ENV{{ID_MM_DEVICE_IGNORE}}=\"1\"' | sudo tee /etc/udev/rules.d/99-motorlab.rules\n  sudo udevadm control --reload && sudo udevadm trigger"
        )
    } else {
        "\n  two readers would steal each other's bytes: end the other program first (a serial monitor, another capture)".to_owned()
    };
    OpenError::Busy {
        path: path.to_owned(),
        holder: holder.map_or_else(
            || "another program".to_owned(),
            |(pid, name)| format!("{name} (process {pid})"),
        ),
        advice,
    }
}

/// The process that has `path` open, as far as this user may see.
fn holder_of(path: &Path) -> Option<(u32, String)> {
    let node = fs::canonicalize(path).ok()?;
    let own = std::process::id();
    let processes = fs::read_dir("/proc").ok()?.flatten();
    processes
        .filter_map(|process| {
            let pid: u32 = process.file_name().to_str()?.parse().ok()?;
            let mut open = fs::read_dir(process.path().join("fd")).ok()?.flatten();
            let has_it = open.any(|file| fs::read_link(file.path()).is_ok_and(|to| to == node));
            let name = fs::read_to_string(process.path().join("comm")).ok()?;
            (has_it && pid != own).then(|| (pid, name.trim().to_owned()))
        })
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::pty::Pty;
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixStream;

    #[test]
    fn what_is_queued_is_read_and_then_nothing_without_a_wait() {
        let (near, mut far) = UnixStream::pair().expect("a pair");
        far.write_all(&[7; 100]).expect("room");
        let mut buffer = [0; 64];
        assert_eq!(read_queued(near.as_fd(), &mut buffer), 64);
        assert_eq!(read_queued(near.as_fd(), &mut buffer), 36);
        // The far end is still there and says nothing: no wait for it either.
        assert_eq!(read_queued(near.as_fd(), &mut buffer), 0);
        drop(far);
        assert_eq!(read_queued(near.as_fd(), &mut buffer), 0);
    }

    #[test]
    fn a_hang_up_reads_as_no_bytes_for_ever_and_is_no_error() {
        let mut pty = Pty::open().expect("a pseudo-terminal");
        let mut port = Port::open(pty.path(), 115_200).expect("openable");
        assert_eq!(pty.write_some(&[7; 100]).expect("room"), 100);
        let mut buffer = [0; 64];
        // Some kernels drop what is queued when the near end of a pseudo-terminal is closed.
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
    fn a_second_reader_is_kept_out_even_of_the_same_user() {
        let pty = Pty::open().expect("a pseudo-terminal");
        let first = Port::open(pty.path(), 115_200).expect("openable");
        let error = Port::open(pty.path(), 115_200).expect_err("locked");
        assert!(matches!(error, OpenError::Busy { .. }), "{error}");
        drop(first);
        Port::open(pty.path(), 115_200).expect("openable again");
    }

    #[test]
    fn what_is_no_port_is_told_apart() {
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

    #[test]
    fn groups_and_modes_read_as_people_know_them() {
        let groups = "root:x:0:\ntty:x:5:\ndialout:x:20:ann,bob\n";
        assert_eq!(group_name(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_name(groups, 21), None);
        assert_eq!(mode_text(0o20660), "crw-rw----");
    }
}
