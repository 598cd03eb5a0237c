//! Header keys of a recorded run.

use crate::board::UsbIdentity;

/// Properties of a recording that are known before it begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facts<'a> {
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Counts per revolution.
    pub counts_per_rev: f64,
    /// Driver supply in V.
    pub supply_v: f64,
    /// Name of the profile.
    pub profile: &'a str,
    /// The port, as given.
    pub port: &'a str,
    /// The USB device behind it.
    pub usb: Option<&'a UsbIdentity>,
}

/// The header of a recording that begins now; `further` keys are added unchanged.
pub(super) fn header(facts: Facts<'_>, further: toml::Table) -> toml::Table {
    let mut header = toml::Table::new();
    let mut put = |key: &str, value: toml::Value| {
        header.insert(key.to_owned(), value);
    };
    put("sample_time_s", toml::Value::Float(facts.sample_time_s));
    put("counts_per_rev", number(facts.counts_per_rev));
    put("supply_v", number(facts.supply_v));
    put("profile", facts.profile.into());
    let now = time::OffsetDateTime::now_utc();
    if let Ok(started) = now.format(&time::format_description::well_known::Rfc3339) {
        put("started", started.into());
    }
    put(
        "recorder",
        concat!("motorlab ", env!("CARGO_PKG_VERSION")).into(),
    );
    for (key, value) in further {
        put(&key, value);
    }
    let mut port = toml::Table::new();
    port.insert("name".to_owned(), facts.port.into());
    if let Some(usb) = facts.usb {
        port.insert("vid".to_owned(), i64::from(usb.vid).into());
        port.insert("pid".to_owned(), i64::from(usb.pid).into());
        if let Some(serial) = &usb.serial {
            port.insert("serial".to_owned(), serial.clone().into());
        }
    }
    put("port", port.into());
    header
}

/// An integral number as an integer.
fn number(value: f64) -> toml::Value {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        toml::Value::Integer(value as i64)
    } else {
        toml::Value::Float(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_identity_is_in_the_header() {
        let usb = UsbIdentity {
            vid: 0x2341,
            pid: 0x43,
            serial: Some("75330303".to_owned()),
            product: None,
        };
        let facts = Facts {
            sample_time_s: 0.003,
            counts_per_rev: 720.0,
            supply_v: 4.5,
            profile: "step",
            port: "/dev/ttyACM1",
            usb: Some(&usb),
        };
        let header = header(facts, toml::Table::new());
        let port = header["port"].as_table().expect("a table");
        assert_eq!(port["name"].as_str(), Some("/dev/ttyACM1"));
        assert_eq!(port["vid"].as_integer(), Some(0x2341));
        assert_eq!(port["pid"].as_integer(), Some(0x43));
        assert_eq!(port["serial"].as_str(), Some("75330303"));
    }
}
