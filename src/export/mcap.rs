//! A run as an MCAP file for Foxglove and PlotJuggler: one JSON message per sample on the topic `/motor`.
//!
//! The log time of a message is the run's start (`started` in its header, else 0) plus the sample's device time, in
//! ns. The file contains the JSON schema, and the run's header as a metadata record.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::io::{Seek, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions};
use serde_json::{Map, Value, json};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::recording::{RUN_FORMAT, Run, difference_velocities};

/// The topic of the samples.
pub const TOPIC: &str = "/motor";

/// Writes the run.
///
/// # Errors
/// `sink` fails.
pub fn write_run(run: &Run, sink: impl Write + Seek) -> Result<(), McapError> {
    let options = WriteOptions::new().library(concat!(
        "motorlab ",
        env!("CARGO_PKG_VERSION"),
        ", written by motorlab export"
    ));
    let mut writer = options.create(sink)?;
    let schema = schema(run).to_string();
    let schema = writer.add_schema("motorlab.Sample", "jsonschema", schema.as_bytes())?;
    let channel_id = writer.add_channel(schema, TOPIC, "json", &BTreeMap::new())?;
    let header = run
        .header
        .iter()
        .map(|(key, value)| (key.clone(), value.to_string()));
    writer.write_metadata(&Metadata {
        name: RUN_FORMAT.to_owned(),
        metadata: header.collect(),
    })?;
    let start_ns = start_ns(run);
    let seq = run.seq.as_deref();
    let speeds = difference_velocities(&run.counts, seq, run.counts_per_rev, run.sample_time_s);
    for (k, speed) in speeds.into_iter().enumerate() {
        let log_time = start_ns.saturating_add((run.t_s[k] * 1e9).round() as u64);
        let message = MessageHeader {
            channel_id,
            // MCAP's sequence numbers have 32 bits and may wrap.
            sequence: seq.map_or(k as u64, |seq| seq[k]) as u32,
            log_time,
            publish_time: log_time,
        };
        let sample = sample(run, k, speed).to_string();
        writer.write_to_known_channel(&message, sample.as_bytes())?;
    }
    writer.finish()?;
    Ok(())
}

fn start_ns(run: &Run) -> u64 {
    let started = run.header.get("started").and_then(toml::Value::as_str);
    started
        .and_then(|text| OffsetDateTime::parse(text, &Rfc3339).ok())
        .and_then(|start| u64::try_from(start.unix_timestamp_nanos()).ok())
        .unwrap_or(0)
}

fn sample(run: &Run, k: usize, speed: Option<f64>) -> Value {
    let mut fields = Map::new();
    let mut put = |key: &str, value: Value| fields.insert(key.to_owned(), value);
    put("t_s", json!(run.t_s[k]));
    put(run.command_kind.column(), json!(run.command[k]));
    put("counts", json!(run.counts[k]));
    put(
        "angle_rad",
        json!(run.counts[k] as f64 * TAU / run.counts_per_rev),
    );
    if let Some(speed) = speed {
        put("velocity_rad_s", json!(speed));
    }
    if let Some(seq) = &run.seq {
        put("seq", json!(seq[k]));
    }
    if let Some(flags) = &run.flags {
        put("flags", json!(flags[k]));
    }
    let measured = [
        ("host_t_s", &run.host_t_s),
        ("supply_v", &run.measured_supply_v),
        ("current_a", &run.measured_current_a),
    ];
    for (key, column) in measured {
        if let Some(value) = column.as_ref().map(|values| values[k])
            && value.is_finite()
        {
            put(key, json!(value));
        }
    }
    Value::Object(fields)
}

fn schema(run: &Run) -> Value {
    let mut properties = Map::new();
    let mut put = |key: &str, kind: &str, what: &str| {
        properties.insert(key.to_owned(), json!({ "type": kind, "description": what }));
    };
    put("t_s", "number", "device time in s");
    put(
        run.command_kind.column(),
        "number",
        "command in force until the next sample",
    );
    put("counts", "integer", "encoder counts, unwrapped");
    put("angle_rad", "number", "counts as an angle in rad");
    put(
        "velocity_rad_s",
        "number",
        "difference of counts over the sample time in rad/s",
    );
    if run.seq.is_some() {
        put("seq", "integer", "the device's sample number");
    }
    if run.host_t_s.is_some() {
        put("host_t_s", "number", "arrival at the host in s");
    }
    if run.measured_supply_v.is_some() {
        put("supply_v", "number", "measured supply in V");
    }
    if run.measured_current_a.is_some() {
        put("current_a", "number", "measured current in A");
    }
    if run.flags.is_some() {
        let names = ["overrun", "dropped", "encoder_error", "saturated"];
        let flags: Map<String, Value> = names
            .iter()
            .map(|name| ((*name).to_owned(), json!({ "type": "boolean" })))
            .collect();
        properties.insert(
            "flags".to_owned(),
            json!({ "type": "object", "properties": flags }),
        );
    }
    json!({ "title": "motorlab.Sample", "type": "object", "properties": properties })
}
