//! `motorlab flash`: uploads the sketch to the board with the usual Arduino tools.
//!
//! arduino-cli compiles and uploads; avrdude uploads a compiled sketch (`--hex`).

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::{Args, ValueEnum};
use serde_json::json;

use super::firmware::write_sketch;
use super::{Failure, Output, Status};
use crate::board::usb_identity;
use crate::plain::shown;

/// Put the sketch onto a board, with arduino-cli or avrdude.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  motorlab flash /dev/ttyACM0\n  motorlab flash /dev/ttyUSB0 --board uno --hex motorlab.ino.hex"
)]
pub struct Flash {
    /// Serial port of the board.
    port: PathBuf,
    /// Which board, where the port does not tell.
    #[arg(long, value_enum)]
    board: Option<ArduinoBoard>,
    /// A sketch folder to use instead of the built-in one: yours from `motorlab firmware`, with your
    /// settings.h.
    #[arg(long, value_name = "FOLDER")]
    sketch: Option<PathBuf>,
    /// A compiled sketch (Arduino IDE: Sketch > Export Compiled Binary), uploaded with avrdude.
    #[arg(long, value_name = "FILE", conflicts_with = "sketch")]
    hex: Option<PathBuf>,
}

/// The boards that the sketch runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ArduinoBoard {
    /// Arduino Uno.
    Uno,
    /// Arduino Mega 2560.
    Mega,
}

impl ArduinoBoard {
    fn fqbn(self) -> &'static str {
        match self {
            Self::Uno => "arduino:avr:uno",
            Self::Mega => "arduino:avr:mega",
        }
    }

    /// Processor and boot loader in avrdude's names.
    fn avrdude(self) -> (&'static str, &'static str) {
        match self {
            Self::Uno => ("atmega328p", "arduino"),
            Self::Mega => ("atmega2560", "wiring"),
        }
    }

    /// The board with these USB ids: those of Arduino's own USB chips.
    fn of_usb(vid: u16, pid: u16) -> Option<Self> {
        match (vid, pid) {
            (0x2341 | 0x2A03, 0x0001 | 0x0043 | 0x0243) => Some(Self::Uno),
            (0x2341 | 0x2A03, 0x0010 | 0x0042 | 0x0242) => Some(Self::Mega),
            _ => None,
        }
    }
}

#[cfg(windows)]
const HOW_TO_INSTALL: &str = "\
arduino-cli compiles and uploads the sketch:
    winget install ArduinoSA.CLI
    arduino-cli core install arduino:avr
  avrdude uploads one that the Arduino IDE has compiled (Sketch > Export Compiled Binary):
    winget install AVRDudes.AVRDUDE
    motorlab flash PORT --hex motorlab.ino.hex
  or write the sketch with `motorlab firmware DIR` and upload it from the Arduino IDE";

#[cfg(not(windows))]
const HOW_TO_INSTALL: &str = "\
arduino-cli compiles and uploads the sketch:
    curl -fsSL https://raw.githubusercontent.com/arduino/arduino-cli/master/install.sh | sh
    arduino-cli core install arduino:avr
  avrdude uploads one that the Arduino IDE has compiled (Sketch > Export Compiled Binary):
    sudo apt install avrdude
    motorlab flash PORT --hex motorlab.ino.hex
  or write the sketch with `motorlab firmware DIR` and upload it from the Arduino IDE";

/// Command that installs avrdude.
const INSTALL_AVRDUDE: &str = if cfg!(windows) {
    "winget install AVRDudes.AVRDUDE"
} else if cfg!(target_os = "macos") {
    "brew install avrdude"
} else {
    "sudo apt install avrdude"
};

impl Flash {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let (tool, command, _built) = self.command()?;
        output.message(&format!("{command:?}"));
        let result = self.upload(command);
        result.map_err(|error| Failure::failed(format!("{tool} {error}"), advice(tool)))?;
        if output.json {
            output.document(&json!({ "port": self.port, "tool": tool }))?;
        } else {
            output.message(&format!(
                "done; try: motorlab capture {}",
                shown(&self.port)
            ));
        }
        Ok(Status::Done)
    }

    /// The tool, its command line, and the temporary folder that must outlive it.
    fn command(&self) -> Result<(&'static str, Command, Option<BuiltIn>), Failure> {
        let board = self.board()?;
        if let Some(hex) = &self.hex {
            if !hex.is_file() {
                return Err(Failure::wrong(
                    format!("there is no file {}", shown(hex)),
                    "--hex takes a compiled sketch; without it the sketch is compiled by arduino-cli",
                ));
            }
            let avrdude = on_path("avrdude")
                .ok_or_else(|| Failure::failed("avrdude is not installed", INSTALL_AVRDUDE))?;
            let (processor, loader) = board.avrdude();
            let mut flash = OsString::from("flash:w:");
            flash.push(hex);
            flash.push(":i");
            let mut command = Command::new(avrdude);
            command.args(["-p", processor, "-c", loader, "-b", "115200", "-D", "-P"]);
            command.arg(&self.port).arg("-U").arg(flash);
            return Ok(("avrdude", command, None));
        }
        let Some(arduino) = on_path("arduino-cli") else {
            let found = if on_path("avrdude").is_some() {
                "avrdude is here, but needs a compiled sketch (--hex FILE), and arduino-cli is not installed"
            } else {
                "neither arduino-cli nor avrdude is installed"
            };
            return Err(Failure::failed(found, HOW_TO_INSTALL));
        };
        let (sketch, built_in) = match &self.sketch {
            Some(sketch) => (sketch.clone(), None),
            None => {
                let built_in = BuiltIn::write()?;
                (built_in.sketch.clone(), Some(built_in))
            }
        };
        let mut command = Command::new(arduino);
        command.args(["compile", "--fqbn", board.fqbn(), "--upload", "--port"]);
        command.arg(&self.port).arg(sketch);
        Ok(("arduino-cli", command, built_in))
    }

    fn board(&self) -> Result<ArduinoBoard, Failure> {
        let by_usb = || {
            let usb = usb_identity(&self.port)?;
            ArduinoBoard::of_usb(usb.vid, usb.pid)
        };
        self.board.or_else(by_usb).ok_or_else(|| {
            Failure::wrong(
                format!("{} does not say which board it is", shown(&self.port)),
                "add --board uno or --board mega",
            )
        })
    }

    /// Runs the tool; its output goes to standard error, as all messages.
    fn upload(&self, mut command: Command) -> Result<(), String> {
        let output = command
            .stdin(Stdio::null())
            .stdout(std::io::stderr())
            .status();
        match output {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("failed ({status})")),
            Err(error) => Err(format!("cannot be started: {error}")),
        }
    }
}

fn advice(tool: &str) -> &'static str {
    if tool == "arduino-cli" {
        "its own message stands above; if it misses the platform: arduino-cli core install arduino:avr"
    } else {
        "check the board and the port (motorlab ports), and close other programs on it"
    }
}

/// The built-in sketch in a temporary folder, removed on drop.
struct BuiltIn {
    folder: PathBuf,
    sketch: PathBuf,
}

impl BuiltIn {
    fn write() -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("motorlab-sketch-{}", std::process::id()));
        let sketch = write_sketch(&folder, true)?;
        Ok(Self { folder, sketch })
    }
}

impl Drop for BuiltIn {
    fn drop(&mut self) {
        // Leftovers in the temporary folder are harmless.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Path of a program, by the PATH.
fn on_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| is_executable(file))
}

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    file.metadata()
        .is_ok_and(|data| data.is_file() && data.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    file.is_file() || file.with_extension("exe").is_file()
}
