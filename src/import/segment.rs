//! Writer of one run: the first rows determine its sample time, then row by row.

use std::path::{Path, PathBuf};

use super::ImportProblem;
use super::clock::Counts;
use super::convert::Sample;
use super::map::{CommandSource, Map, NumberFrom, PositionSource, TimeSource};
use super::thin::Thin;
use crate::check::{KeptSpeed, SPEED_KEPT, SPEED_ZERO, SpeedRow, ZeroSpeeds};
use crate::motor::plausible;
use crate::platform::files::remove_file;
use crate::recording::{
    Columns, Flags, Integration, MAX_ROWS, Row, RunWriter, SPEED_RESOLUTION, Steps, Time,
};

/// Rows that determine the sample time.
pub(super) const LOOK_AHEAD: usize = 4096;

/// Rows between two checks whether the waiting rows are due: reading the clock for each would take as long as reading
/// the row.
const ROWS_TO_FLUSH: u64 = 64;

/// A written run.
#[derive(Debug, Clone, serde::Serialize)]
pub struct ImportedRun {
    /// Path of its file.
    pub path: PathBuf,
    /// Number of samples.
    pub samples: u64,
    /// Duration in s.
    pub duration_s: f64,
    /// Nominal sample time in s.
    pub sample_time_s: f64,
    /// Shortest and longest step of time in s.
    pub steps_s: (f64, f64),
}

/// A run under construction.
#[derive(Debug)]
pub(super) struct Segment<'a> {
    map: &'a Map,
    source: &'a str,
    path: PathBuf,
    waiting: Vec<Sample>,
    writer: Option<RunWriter>,
    sample_time_s: f64,
    before: Option<(u64, f64)>,
    thin: Thin,
    /// Rows whose command was clamped to full drive.
    beyond_full: u64,
    /// A speed that is 0 between edges, in the first rows.
    zero_speeds: Option<ZeroSpeeds>,
    /// A speed that is kept when no edge comes, in the first rows.
    kept_speed: Option<KeptSpeed>,
    /// Samples missing in pauses so far.
    lost: u64,
    /// Least step of a pause in s.
    pause_s: f64,
    shortest_s: f64,
    longest_s: f64,
}

impl<'a> Segment<'a> {
    /// For a run from the log `source` into `path` or the next free name.
    pub fn new(map: &'a Map, source: &'a str, path: &Path) -> Self {
        Self {
            map,
            source,
            path: path.to_owned(),
            waiting: Vec::new(),
            writer: None,
            sample_time_s: f64::NAN,
            before: None,
            thin: Thin::new(map.every),
            beyond_full: 0,
            zero_speeds: None,
            kept_speed: None,
            lost: 0,
            pause_s: f64::INFINITY,
            shortest_s: f64::INFINITY,
            longest_s: 0.0,
        }
    }

    /// Adds a sample from this line of the log.
    ///
    /// # Errors
    /// It cannot be written, or the run could not be read back; the partial file is then removed.
    pub fn push(&mut self, line: u64, sample: Sample) -> Result<(), ImportProblem> {
        self.beyond_full += u64::from(sample.beyond_full.is_some());
        match self.thin.push(line, sample) {
            Some((line, sample)) => self.take(line, sample),
            None => Ok(()),
        }
    }

    fn take(&mut self, line: u64, sample: Sample) -> Result<(), ImportProblem> {
        if let Some(problem) = self.unreadable(line, &sample) {
            self.discard();
            return Err(problem);
        }
        if let Some((seq, t_s)) = self.before
            && sample.seq == seq + 1
        {
            self.shortest_s = self.shortest_s.min(sample.t_s - t_s);
            self.longest_s = self.longest_s.max(sample.t_s - t_s);
        }
        let before = self.before.replace((sample.seq, sample.t_s));
        match &mut self.writer {
            Some(_) => {
                self.append(before, sample)?;
                if let Some(writer) = &mut self.writer
                    && sample.seq.is_multiple_of(ROWS_TO_FLUSH)
                {
                    writer.flush_if_due()?;
                }
                Ok(())
            }
            None => {
                self.waiting.push(sample);
                if self.waiting.len() == LOOK_AHEAD {
                    self.begin()?;
                }
                Ok(())
            }
        }
    }

    /// Creates the file and writes the waiting rows.
    fn begin(&mut self) -> Result<(), ImportProblem> {
        let every = self.map.every as f64;
        self.sample_time_s = match self.map.sample_time_s {
            Some(sample_time_s) => sample_time_s * every,
            None => median_step_s(&self.waiting),
        };
        if !plausible::SAMPLE_TIME_S.holds(self.sample_time_s) {
            return Err(ImportProblem::SampleTime {
                sample_time_s: self.sample_time_s,
                range: plausible::SAMPLE_TIME_S.to_string(),
            });
        }
        if let Some(usual) = Steps::of_steps(steps_s(&self.waiting)) {
            self.pause_s = usual.longest_usual_s();
        }
        let row = |sample: &Sample| {
            Some(SpeedRow {
                t_s: sample.t_s,
                command: sample.command,
                counts_s: sample.speed_counts_s?,
            })
        };
        let rows: Vec<SpeedRow> = self.waiting.iter().filter_map(row).collect();
        let speeds: Vec<f64> = rows.iter().map(|row| row.counts_s).collect();
        self.zero_speeds = ZeroSpeeds::of(&speeds);
        self.kept_speed = KeptSpeed::of(&rows);
        let columns = Columns {
            command: self.map.command_kind,
            seq: true,
            host: false,
            flags: false,
            supply: self.map.supply.is_some(),
            current: self.map.current.is_some(),
        };
        self.writer = Some(RunWriter::create(&self.path, &self.header(), columns)?);
        let mut before = None;
        for sample in std::mem::take(&mut self.waiting) {
            self.append(before.replace((sample.seq, sample.t_s)), sample)?;
        }
        Ok(())
    }

    /// Writes a sample. Samples missing in a pause before it are counted in its number.
    fn append(&mut self, before: Option<(u64, f64)>, sample: Sample) -> Result<(), ImportProblem> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        if let Some((seq, t_s)) = before
            && sample.t_s - t_s > self.pause_s
        {
            let elapsed = ((sample.t_s - t_s) / self.sample_time_s).round() as u64;
            self.lost += elapsed.saturating_sub(sample.seq - seq);
        }
        writer.append(&Row {
            seq: Some(sample.seq + self.lost),
            time: Time::Seconds(sample.t_s),
            host: None,
            command: sample.command,
            counts: sample.counts,
            flags: Flags::default(),
            supply_v: sample.supply_v,
            current_a: sample.current_a,
        })?;
        Ok(())
    }

    /// Why a run with this sample could not be read back.
    fn unreadable(&self, line: u64, sample: &Sample) -> Option<ImportProblem> {
        let (_, before) = self.before?;
        if sample.t_s - before > plausible::GAP_S.hi {
            return Some(ImportProblem::TimeJumps {
                line,
                before,
                after: sample.t_s,
            });
        }
        let rows = MAX_ROWS as u64;
        let written = self.writer.as_ref().map_or(0, RunWriter::rows);
        (written >= rows).then_some(ImportProblem::TooLong { line, rows })
    }

    /// Removes the partial file.
    pub fn discard(&mut self) {
        if let Some(writer) = self.writer.take() {
            let path = writer.path().to_owned();
            drop(writer);
            // It is this run's file, and the following error is reported.
            let _ = remove_file(&path);
        }
    }

    fn header(&self) -> toml::Table {
        let map = self.map;
        let mut header = toml::Table::new();
        header.insert("sample_time_s".into(), self.sample_time_s.into());
        header.insert("counts_per_rev".into(), map.counts_per_rev.into());
        if let Some(supply_v) = map.supply_v {
            header.insert("supply_v".into(), supply_v.into());
        }
        for (key, value) in &map.header {
            header.entry(key.clone()).or_insert_with(|| value.clone());
        }
        let mut imported = toml::Table::new();
        imported.insert("source".into(), self.source.into());
        imported.insert("time".into(), time_words(map).into());
        imported.insert("command".into(), command_words(map).into());
        imported.insert("position".into(), position_words(map).into());
        // Ambiguity of an unwrapped counter over a pause: see `check`.
        if let PositionSource::Column(field) = &map.position
            && let Some(wrap) = field.wrap
        {
            imported.insert("wrap_counts".into(), (wrap * field.scale.abs()).into());
        }
        if let PositionSource::Speed {
            curve, resolution, ..
        } = map.position
        {
            let figures = [
                ("speed_time_constant_s", curve),
                (SPEED_RESOLUTION, resolution),
            ];
            for (key, figure) in figures {
                if let Some(figure) = figure {
                    imported.insert(key.into(), figure.into());
                }
            }
        }
        // Not visible after rounding to counts.
        if let Some(zero) = &self.zero_speeds {
            let figures = [
                ("share", zero.share),
                ("turning_rows", zero.turning as f64),
                ("speed_at_edges_counts_s", zero.at_edges),
            ];
            imported.insert(SPEED_ZERO.into(), table_of(figures));
        }
        if let Some(kept) = &self.kept_speed {
            let figures = [
                ("from_s", kept.from_s),
                ("to_s", kept.to_s),
                ("counts_s", kept.counts_s),
            ];
            imported.insert(SPEED_KEPT.into(), table_of(figures));
        }
        if map.every > 1 {
            imported.insert("every".into(), (map.every as i64).into());
        }
        if map.unsigned {
            imported.insert("sign".into(), "the command's".into());
        }
        if matches!(&map.command, CommandSource::Number(number) if number.of_measured_supply) {
            imported.insert("command_supply".into(), "measured".into());
        }
        header.insert("imported".into(), imported.into());
        header
    }

    /// Ends the file. `None` if the run has no sample.
    pub fn finish(mut self, bad_rows: u64) -> Result<Option<ImportedRun>, ImportProblem> {
        if let Some((line, sample)) = self.thin.finish() {
            self.take(line, sample)?;
        }
        if self.writer.is_none() && !self.waiting.is_empty() {
            self.begin()?;
        }
        let Some(writer) = self.writer.take() else {
            return Ok(None);
        };
        let samples = writer.rows();
        let duration_s = self.before.map_or(0.0, |(_, t_s)| t_s);
        let mut summary = toml::Table::new();
        let mut put = |key: &str, value: toml::Value| summary.insert(key.to_owned(), value);
        put("samples", (samples as i64).into());
        put("bad_rows", (bad_rows as i64).into());
        if self.lost > 0 {
            put("lost_in_pauses", (self.lost as i64).into());
        }
        if self.beyond_full > 0 {
            put("beyond_full_drive", (self.beyond_full as i64).into());
        }
        put("duration_s", duration_s.into());
        if self.shortest_s.is_finite() {
            put("shortest_step_s", rounded(self.shortest_s).into());
            put("longest_step_s", rounded(self.longest_s).into());
        } else {
            self.shortest_s = 0.0;
        }
        let path = writer.finish(&summary, true)?;
        Ok(Some(ImportedRun {
            path,
            samples,
            duration_s,
            sample_time_s: self.sample_time_s,
            steps_s: (rounded(self.shortest_s), rounded(self.longest_s)),
        }))
    }
}

fn table_of(figures: [(&str, f64); 3]) -> toml::Value {
    let figures = figures.map(|(key, figure)| (key.to_owned(), figure.into()));
    toml::Table::from_iter(figures).into()
}

/// The median of the steps between neighbours; 1 s for a run of a single sample.
fn median_step_s(samples: &[Sample]) -> f64 {
    let mut steps = steps_s(samples);
    if steps.is_empty() {
        return 1.0;
    }
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    rounded(*median)
}

/// Steps of time between neighbours, in s.
fn steps_s(samples: &[Sample]) -> Vec<f64> {
    samples
        .windows(2)
        .filter(|pair| pair[1].seq == pair[0].seq + 1)
        .map(|pair| pair[1].t_s - pair[0].t_s)
        .collect()
}

/// To whole nanoseconds.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e9
}

fn time_words(map: &Map) -> &'static str {
    match map.time {
        TimeSource::Column { counts, .. } => match counts {
            Counts::SinceOrigin => "column",
            Counts::SinceRowBefore => "time since the row before, summed up",
            Counts::Coarsely { .. } => "coarse clock, rows spread",
        },
        TimeSource::RowNumber => "made from the row number",
    }
}

fn command_words(map: &Map) -> &'static str {
    match &map.command {
        CommandSource::Number(number) if number.of_measured_supply => match number.from {
            NumberFrom::Column(_) => "column, share of the measured supply",
            NumberFrom::Sum { .. } => "sum of columns, share of the measured supply",
            NumberFrom::Comment(_) => "comment lines, share of the measured supply",
        },
        CommandSource::Number(number) => match number.from {
            NumberFrom::Column(_) => "column",
            NumberFrom::Sum { .. } => "sum of columns",
            NumberFrom::Comment(_) => "comment lines",
        },
        CommandSource::Profile { .. } => "profile from the mapping",
        CommandSource::NotRecorded => "not recorded",
    }
}

fn position_words(map: &Map) -> &'static str {
    match map.position {
        PositionSource::Column(_) => "column",
        PositionSource::Increments(_) => "increments, summed up",
        PositionSource::Speed {
            rule: Integration::Trapezoid,
            ..
        } => "integrated from speed, trapezoid",
        PositionSource::Speed {
            rule: Integration::Backward,
            ..
        } => "integrated from speed, backward",
        PositionSource::Speed {
            rule: Integration::Forward,
            ..
        } => "integrated from speed, forward",
        PositionSource::NotRecorded => "not recorded",
    }
}
