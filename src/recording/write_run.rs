//! Writer of a complete run.

use std::path::{Path, PathBuf};

use super::row::{Columns, Row, Time};
use super::{Flags, Run, RunWriter, WriteError};

/// Writes a complete run, simulated or imported, with `run.complete` as its ending. Returns the path, which is the
/// next free name if `path` exists. Header keys that are not columns or fields of the run are written unchanged; an
/// existing summary is kept.
pub fn write_run(run: &Run, path: &Path) -> Result<PathBuf, WriteError> {
    let mut header = toml::Table::new();
    header.insert("sample_time_s".to_owned(), run.sample_time_s.into());
    header.insert("counts_per_rev".to_owned(), run.counts_per_rev.into());
    if let Some(supply_v) = run.supply_v {
        header.insert("supply_v".to_owned(), supply_v.into());
    }
    for (key, value) in &run.header {
        header.entry(key.clone()).or_insert_with(|| value.clone());
    }
    let columns = Columns {
        command: run.command_kind,
        seq: run.seq.is_some(),
        host: run.host_t_s.is_some(),
        flags: run.flags.is_some(),
        supply: run.measured_supply_v.is_some(),
        current: run.measured_current_a.is_some(),
    };
    let mut writer = RunWriter::create(path, &header, columns)?;
    // A missing measured value is an empty cell.
    let at = |column: &Option<Vec<f64>>, k: usize| {
        let value = column.as_ref().map(|values| values[k]);
        value.filter(|value| !value.is_nan())
    };
    for k in 0..run.len() {
        writer.append(&Row {
            seq: run.seq.as_ref().map(|seq| seq[k]),
            time: Time::Seconds(run.t_s[k]),
            host: at(&run.host_t_s, k).map(Time::Seconds),
            command: run.command[k],
            counts: run.counts[k],
            flags: run
                .flags
                .as_ref()
                .map_or_else(Flags::default, |flags| flags[k]),
            supply_v: at(&run.measured_supply_v, k),
            current_a: at(&run.measured_current_a, k),
        })?;
    }
    let empty = toml::Table::new();
    let summary = run.header.get("summary").and_then(toml::Value::as_table);
    writer.finish(summary.unwrap_or(&empty), run.complete)
}
