//! Serial ports, their USB devices, and known lab boards.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Identity of a USB device, which is independent of the port's name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsbIdentity {
    /// Vendor id.
    pub vid: u16,
    /// Product id.
    pub pid: u16,
    /// Serial number, if the device has one.
    pub serial: Option<String>,
    /// Product name, if the device reports it.
    pub product: Option<String>,
}

impl UsbIdentity {
    /// Whether this is the same device: vendor, product and, if both have one, serial number.
    pub fn same_device(&self, other: &Self) -> bool {
        let serials_differ = self.serial.is_some() && self.serial != other.serial;
        (self.vid, self.pid) == (other.vid, other.pid) && !serials_differ
    }
}

/// One serial port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PortEntry {
    /// Path to open.
    pub path: PathBuf,
    /// Its USB device.
    pub usb: Option<UsbIdentity>,
    /// Name of a known lab board or USB serial chip.
    pub looks_like: Option<&'static str>,
}

/// Common boards and USB serial chips by vendor and product id (0: any product).
const LAB_BOARDS: [(u16, u16, &str); 17] = [
    (0x2341, 0x0043, "Arduino Uno"),
    (0x2341, 0x0001, "Arduino Uno"),
    (0x2341, 0x0010, "Arduino Mega 2560"),
    (0x2341, 0x0042, "Arduino Mega 2560"),
    (0x2341, 0x0000, "Arduino"),
    (0x2a03, 0x0000, "Arduino"),
    (0x1a86, 0x7523, "CH340 (Arduino clones)"),
    (0x1a86, 0x0000, "WCH USB serial (Arduino clones)"),
    (0x0403, 0x6001, "FTDI FT232 (latency timer 16 ms)"),
    (0x0403, 0x0000, "FTDI (latency timer 16 ms)"),
    (0x10c4, 0xea60, "CP210x (ESP32 boards)"),
    (0x16c0, 0x0483, "Teensy"),
    (0x2e8a, 0x0000, "Raspberry Pi Pico"),
    (0x0483, 0x374b, "ST-Link (Nucleo)"),
    (0x239a, 0x0000, "Adafruit board"),
    (0x303a, 0x0000, "Espressif board"),
    (0x1b4f, 0x0000, "SparkFun board"),
];

/// Name of the known lab board with these ids.
pub fn known_board(vid: u16, pid: u16) -> Option<&'static str> {
    LAB_BOARDS
        .iter()
        .find(|(v, p, _)| *v == vid && (*p == pid || *p == 0))
        .map(|(_, _, name)| *name)
}

/// The serial ports of this machine, lab boards first, then by name.
#[cfg(target_os = "linux")]
pub fn list_ports() -> Vec<PortEntry> {
    list_ports_of(Path::new("/sys/class/tty"), Path::new("/dev"))
}

/// The serial ports of this machine, lab boards first, then by name.
#[cfg(not(any(target_os = "linux", target_family = "wasm")))]
pub fn list_ports() -> Vec<PortEntry> {
    let ports = serialport::available_ports().unwrap_or_default();
    let mut entries: Vec<PortEntry> = ports
        .into_iter()
        // On macOS opening `tty.*` waits for a carrier; `cu.*` is the same port without the wait.
        .filter(|port| !port.port_name.starts_with("/dev/tty."))
        .map(|port| {
            let usb = match port.port_type {
                serialport::SerialPortType::UsbPort(info) => Some(UsbIdentity {
                    vid: info.vid,
                    pid: info.pid,
                    serial: info.serial_number,
                    product: info.product,
                }),
                _ => None,
            };
            entry(PathBuf::from(port.port_name), usb)
        })
        .collect();
    sort(&mut entries);
    entries
}

/// None: in a browser the user selects the port.
#[cfg(target_family = "wasm")]
pub fn list_ports() -> Vec<PortEntry> {
    Vec::new()
}

/// The ports of a sysfs tree (`/sys/class/tty`) whose nodes are in `devices` (`/dev`).
pub fn list_ports_of(sysfs: &Path, devices: &Path) -> Vec<PortEntry> {
    let Ok(names) = fs::read_dir(sysfs) else {
        return Vec::new();
    };
    let mut entries: Vec<PortEntry> = names
        .flatten()
        .filter_map(|name| {
            let class = name.path();
            let device = fs::canonicalize(class.join("device")).ok()?;
            let node = devices.join(name.file_name());
            // An 8250 port of type 0 has no hardware.
            let no_hardware = read_text(&class.join("type")).as_deref() == Some("0");
            (node.exists() && !no_hardware).then(|| entry(node, usb_of(&device, sysfs)))
        })
        .collect();
    sort(&mut entries);
    entries
}

/// The USB device behind the port at `path` (a node, or a link such as `/dev/serial/by-id/...`).
pub fn usb_identity(path: &Path) -> Option<UsbIdentity> {
    let node = fs::canonicalize(path).ok()?;
    let port = list_ports().into_iter().find(|port| port.path == node)?;
    port.usb
}

fn entry(path: PathBuf, usb: Option<UsbIdentity>) -> PortEntry {
    let looks_like = usb.as_ref().and_then(|usb| known_board(usb.vid, usb.pid));
    PortEntry {
        path,
        usb,
        looks_like,
    }
}

fn sort(entries: &mut [PortEntry]) {
    entries.sort_by(|a, b| {
        (a.looks_like.is_none(), a.usb.is_none(), &a.path).cmp(&(
            b.looks_like.is_none(),
            b.usb.is_none(),
            &b.path,
        ))
    });
}

/// Searches `idVendor` in the device's directory and its parents.
fn usb_of(device: &Path, sysfs: &Path) -> Option<UsbIdentity> {
    let directory = device
        .ancestors()
        .take_while(|directory| !sysfs.starts_with(directory))
        .find(|directory| directory.join("idVendor").exists())?;
    let id = |name| u16::from_str_radix(&read_text(&directory.join(name))?, 16).ok();
    Some(UsbIdentity {
        vid: id("idVendor")?,
        pid: id("idProduct")?,
        serial: read_text(&directory.join("serial")),
        product: read_text(&directory.join("product")),
    })
}

fn read_text(path: &Path) -> Option<String> {
    let text = fs::read(path).ok()?;
    Some(String::from_utf8_lossy(&text).trim().to_owned())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A sysfs tree of Linux: an Uno, a port without hardware, an on-board port, a pty.
    fn a_machine(root: &Path) -> (PathBuf, PathBuf) {
        let (sysfs, devices) = (root.join("sys/class/tty"), root.join("dev"));
        let usb = root.join("sys/devices/usb1/1-2");
        for directory in [&sysfs, &devices, &usb.join("1-2:1.0/tty/ttyACM1")] {
            fs::create_dir_all(directory).expect("a directory");
        }
        for (name, text) in [
            ("idVendor", "2341\n"),
            ("idProduct", "0043\n"),
            ("serial", "7533\n"),
            ("product", "Arduino Uno\n"),
        ] {
            fs::write(usb.join(name), text).expect("a file");
        }
        symlink(usb.join("1-2:1.0"), usb.join("1-2:1.0/tty/ttyACM1/device")).expect("a link");
        symlink(usb.join("1-2:1.0/tty/ttyACM1"), sysfs.join("ttyACM1")).expect("a link");
        let on_board = root.join("sys/devices/platform/serial8250");
        fs::create_dir_all(&on_board).expect("a directory");
        for (name, kind) in [("ttyS0", "4"), ("ttyS1", "0")] {
            fs::create_dir_all(sysfs.join(name)).expect("a directory");
            symlink(&on_board, sysfs.join(name).join("device")).expect("a link");
            fs::write(sysfs.join(name).join("type"), kind).expect("a file");
        }
        fs::create_dir_all(sysfs.join("ptmx")).expect("a directory");
        for name in ["ttyACM1", "ttyS0", "ttyS1", "ptmx"] {
            fs::write(devices.join(name), "").expect("a file");
        }
        (sysfs, devices)
    }

    #[test]
    fn a_board_comes_first_and_names_without_hardware_are_left_out() {
        let root = tempfile::tempdir().expect("a directory");
        let (sysfs, devices) = a_machine(root.path());
        let ports = list_ports_of(&sysfs, &devices);
        let names: Vec<_> = ports
            .iter()
            .filter_map(|port| port.path.file_name()?.to_str())
            .collect();
        assert_eq!(names, ["ttyACM1", "ttyS0"]);
        let usb = ports[0].usb.clone().expect("a USB device");
        assert_eq!((usb.vid, usb.pid), (0x2341, 0x0043));
        assert_eq!(usb.serial.as_deref(), Some("7533"));
        assert_eq!(ports[0].looks_like, Some("Arduino Uno"));
        assert_eq!(ports[1].usb, None);
    }

    #[test]
    fn a_machine_without_sysfs_has_no_ports() {
        assert_eq!(
            list_ports_of(Path::new("/nowhere"), Path::new("/dev")),
            Vec::new()
        );
    }

    #[test]
    fn another_serial_number_is_another_board() {
        let board = |serial: Option<&str>| UsbIdentity {
            vid: 0x2341,
            pid: 0x43,
            serial: serial.map(str::to_owned),
            product: None,
        };
        assert!(board(Some("1")).same_device(&board(Some("1"))));
        assert!(!board(Some("1")).same_device(&board(Some("2"))));
        assert!(!board(Some("1")).same_device(&board(None)));
        assert!(board(None).same_device(&board(None)));
    }
}
