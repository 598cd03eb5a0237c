//! Serial ports on Unix: device nodes with an owner, a group and a mode.

use std::fs;
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;

use super::open_error::OpenError;
use super::port_list::usb_identity;
use crate::plain::shown;

pub(super) type Native = serialport::TTYPort;

/// Refuses missing paths, and paths that are no character device.
pub(super) fn refuse_no_port(path: &Path) -> Result<(), OpenError> {
    let kind = match fs::metadata(path) {
        Ok(found) => found.file_type(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(OpenError::not_found(path));
        }
        Err(error) => return Err(OpenError::failed(path, error)),
    };
    let what = match kind {
        _ if kind.is_char_device() => return Ok(()),
        _ if kind.is_dir() => "a directory",
        _ if kind.is_file() => "a file",
        _ => "no character device",
    };
    Err(OpenError::NotASerialPort {
        path: path.to_owned(),
        what,
    })
}

/// Whether an I/O error means that the device is gone.
pub(super) fn is_gone(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}

/// Reads the bytes still queued for a device that is gone.
pub(super) fn read_queued(port: &Native, buffer: &mut [u8]) -> usize {
    // SAFETY: the descriptor belongs to `port`, which outlives the borrow.
    queued(unsafe { BorrowedFd::borrow_raw(port.as_raw_fd()) }, buffer)
}

/// Does not call `poll` first, which would report a hang-up only.
fn queued(descriptor: BorrowedFd<'_>, buffer: &mut [u8]) -> usize {
    let nonblocking = rustix::fs::fcntl_getfl(descriptor).and_then(|flags| {
        rustix::fs::fcntl_setfl(descriptor, flags | rustix::fs::OFlags::NONBLOCK)
    });
    match nonblocking {
        Ok(()) => rustix::io::read(descriptor, buffer).unwrap_or(0),
        Err(_) => 0,
    }
}

pub(super) fn explain(path: &Path, error: &serialport::Error) -> OpenError {
    match error.kind() {
        serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied) => permission_denied(path),
        serialport::ErrorKind::Io(io::ErrorKind::NotFound) => OpenError::not_found(path),
        serialport::ErrorKind::NoDevice => busy(path),
        _ if error.description.contains("typewriter") || error.description.contains("ioctl") => {
            OpenError::NotASerialPort {
                path: path.to_owned(),
                what: "another kind of device",
            }
        }
        _ => OpenError::failed(path, &error.description),
    }
}

/// Names the node's group and the command that joins it.
fn permission_denied(path: &Path) -> OpenError {
    let metadata = fs::metadata(path).ok();
    let (gid, mode) = metadata.map_or((0, 0), |data| (data.gid(), data.mode()));
    let groups = fs::read_to_string("/etc/group").unwrap_or_default();
    let group = group_name(&groups, gid).unwrap_or_else(|| gid.to_string());
    // A group without access, or root's, is not worth joining.
    let command = if cfg!(target_os = "macos") {
        format!("sudo chmod a+rw {}", shown(path))
    } else if mode & 0o060 == 0o060 && gid != 0 {
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

/// Name of a group in `/etc/group`.
fn group_name(groups: &str, gid: u32) -> Option<String> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, _, id) = (fields.next()?, fields.next()?, fields.next()?);
        (id.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

/// `crw-rw----`, as `ls` prints it.
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

/// Names the process that has the port; ModemManager probes every new port for some 10 s.
fn busy(path: &Path) -> OpenError {
    let holder = holder_of(path);
    let modem_manager = cfg!(target_os = "linux")
        && holder
            .as_ref()
            .is_none_or(|(_, name)| name == "ModemManager");
    let advice = if modem_manager {
        let usb = usb_identity(path);
        let (vid, pid) = usb.map_or((0x2341, 0x0043), |usb| (usb.vid, usb.pid));
        format!(
            "ModemManager holds a newly plugged port for some 10 s: wait, or keep it away from the board for good with\n  echo 'ATTRS{{idVendor}}==\"{vid:04x}\", ATTRS{{idProduct}}==\"{pid:04x}\", ENV{{ID_MM_DEVICE_IGNORE}}=\"1\"' | sudo tee /etc/udev/rules.d/99-motorlab.rules\n  sudo udevadm control --reload && sudo udevadm trigger"
        )
    } else {
        "two readers would lose bytes to each other: end the other program first (a serial monitor, another capture)".to_owned()
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

/// The process that has `path` open, as far as this user can see.
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
    use std::io::Write;
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixStream;

    #[test]
    fn queued_bytes_are_read_without_blocking() {
        let (near, mut far) = UnixStream::pair().expect("a pair");
        far.write_all(&[7; 100]).expect("room");
        let mut buffer = [0; 64];
        assert_eq!(queued(near.as_fd(), &mut buffer), 64);
        assert_eq!(queued(near.as_fd(), &mut buffer), 36);
        // The far end is open and silent: this must not wait either.
        assert_eq!(queued(near.as_fd(), &mut buffer), 0);
        drop(far);
        assert_eq!(queued(near.as_fd(), &mut buffer), 0);
    }

    #[test]
    fn group_names_and_mode_bits_are_decoded() {
        let groups = "root:x:0:\ntty:x:5:\ndialout:x:20:ann,bob\n";
        assert_eq!(group_name(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_name(groups, 21), None);
        assert_eq!(mode_text(0o20660), "crw-rw----");
    }
}
