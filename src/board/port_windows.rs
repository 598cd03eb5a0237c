//! Serial ports on Windows: names such as `COM7`, each opened once.

use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use super::open_error::OpenError;
use crate::plain::shown;

pub(super) type Native = serialport::COMPort;

/// Windows error codes of an unplugged device: access denied, bad command, device failure, no such device, aborted
/// read, device not connected.
const GONE: [i32; 6] = [5, 22, 31, 433, 995, 1167];

/// Refuses paths that cannot be ports.
pub(super) fn refuse_no_port(path: &Path) -> Result<(), OpenError> {
    // A bare name may be a port's, which Windows also shows as a file.
    let is_bare = path.components().count() == 1;
    let what = match path {
        _ if path.to_string_lossy().starts_with(r"\\.\") => return Ok(()),
        _ if path.is_dir() => "a directory",
        _ if path.is_file() && !is_bare => "a file",
        _ => return Ok(()),
    };
    Err(OpenError::NotASerialPort {
        path: path.to_owned(),
        what,
    })
}

/// Whether an I/O error means that the device is gone.
pub(super) fn is_gone(error: &io::Error) -> bool {
    error
        .raw_os_error()
        .is_some_and(|code| GONE.contains(&code))
}

/// Windows keeps no queued bytes of a device that is gone.
pub(super) fn read_queued(_: &Native, _: &mut [u8]) -> usize {
    0
}

/// Why a port could not be opened. The error does not distinguish a missing port from one in use: a second attempt
/// does.
pub(super) fn explain(path: &Path, error: &serialport::Error) -> OpenError {
    let again = OpenOptions::new().read(true).write(true).open(device(path));
    match again.map_err(|again| again.kind()) {
        Err(io::ErrorKind::NotFound) => OpenError::not_found(path),
        Err(io::ErrorKind::PermissionDenied) => OpenError::Busy {
            path: path.to_owned(),
            holder: "another program".to_owned(),
            advice: advice(path),
        },
        _ => OpenError::failed(path, &error.description),
    }
}

/// The name under which Windows opens a port, also above COM9.
fn device(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(r"\\.\");
    name.push(path);
    name.into()
}

fn advice(path: &Path) -> String {
    format!(
        "two readers would lose bytes to each other: end the other program first (a serial monitor, the Arduino IDE, another capture)\n  which one it is: `Get-ItemProperty HKLM:\\HARDWARE\\DEVICEMAP\\SERIALCOMM` names the device of {}, and Process Explorer finds its handle (Find > Find Handle)",
        shown(path)
    )
}
