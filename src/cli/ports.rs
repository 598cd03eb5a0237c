//! `motorlab ports`: the serial ports, and those of possible lab boards.

use clap::Args;
use serde_json::json;

use super::{Failure, Output, Status};
use crate::board::{PortEntry, list_ports};
use crate::plain::{one_line, shown};

/// List serial ports, lab boards first.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  motorlab ports\n  motorlab capture /dev/ttyACM0 --ts 0.003")]
pub struct Ports {}

impl Ports {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let ports = list_ports();
        if output.json {
            output.document(&json!({ "ports": ports }))?;
            return Ok(Status::Done);
        }
        if ports.is_empty() {
            output.line("no serial port is connected (`capture virtual:` needs none)")?;
        }
        for port in &ports {
            output.line(&describe(port))?;
        }
        Ok(Status::Done)
    }
}

fn describe(port: &PortEntry) -> String {
    let mut text = format!("{:<16}", shown(&port.path));
    match &port.usb {
        None => text.push_str("not a USB device"),
        Some(usb) => {
            text.push_str(&format!("{:04x}:{:04x}", usb.vid, usb.pid));
            let serial = usb.serial.as_deref().unwrap_or("-");
            text.push_str(&format!("  serial {serial}"));
            if let Some(product) = &usb.product {
                text.push_str(&format!("  {}", one_line(product)));
            }
        }
    }
    if let Some(board) = port.looks_like {
        text.push_str(&format!("  <- looks like a lab board: {board}"));
    }
    text
}
