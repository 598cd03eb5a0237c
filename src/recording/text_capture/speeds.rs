//! Integration of a board's speeds. While lines come, each speed is taken as the mean since the row before. At the end the
//! rule is decided as for a log, by which leaves less of a first-order motor, and the counts of the run are replaced where it
//! is another.

use std::path::Path;

use super::super::speed_rule::{Row, rule};
use super::super::{Integration, Run, read_run_from, write_run};
use crate::board::text_lines::{Column, SpeedUnit};
use crate::platform::files::{File, remove_file, rename};

/// Rows that decide the rule: a minute at 3 ms.
const ROWS: usize = 20_000;

/// The speeds of the rows of a run.
#[derive(Debug)]
pub(super) struct Speeds {
    column: Column,
    /// Counts per second of one unit.
    counts_s: f64,
    speeds: Vec<f64>,
}

impl Speeds {
    /// For a column of speeds.
    pub fn of(column: Column, counts_per_rev: f64) -> Option<Self> {
        let Column::Speed(unit) = column else {
            return None;
        };
        let counts_s = unit.in_turns().map_or(1.0, |turns| turns * counts_per_rev);
        Some(Self {
            column,
            counts_s,
            speeds: Vec::new(),
        })
    }

    /// Adds the speed of a row.
    pub fn push(&mut self, speed: f64) {
        self.speeds.push(speed);
    }

    /// Counts since the previous row, for now.
    pub fn counts_in(&self, speed: f64, passed_s: f64) -> f64 {
        speed * self.counts_s * passed_s
    }

    fn unit(&self) -> &'static str {
        match self.column {
            Column::Speed(SpeedUnit::Unsaid) => "rpm",
            column => column.name(),
        }
    }

    /// Decides the rule of a finished run, unless one is given, and writes the counts by it. Returns what it is and why.
    pub fn integrate(&self, path: &Path, given: Option<Integration>) -> Option<String> {
        let file = File::open(path).ok()?;
        let (run, _) = read_run_from(&file, "").ok()?;
        if run.len() != self.speeds.len() {
            return None;
        }
        let row = |k: usize| Row {
            t_s: run.t_s[k],
            command: run.command[k],
            speed: self.speeds[k],
        };
        let rows: Vec<Row> = (0..run.len().min(ROWS)).map(row).collect();
        let found = rule(&rows);
        let is_given = |rule: &Integration| given.is_none_or(|given| given == *rule);
        let curve_s = (found.filter(|found| is_given(&found.integration())))
            .and_then(|found| found.curve_s());
        let words = match given {
            Some(given) => format!("by the rule {} that is given", given.name()),
            None => found.as_ref()?.words(self.unit()),
        };
        let integration = given.or(found.map(|found| found.integration()))?;
        let words = match integration {
            Integration::Backward => words,
            other => match self.rewrite(run, path, other, curve_s) {
                Ok(()) => words,
                Err(error) => format!("{words}; the counts stay those of backward: {error}"),
            },
        };
        Some(words)
    }

    /// Writes the run with counts by this rule beside it, and puts it into its place.
    fn rewrite(
        &self,
        mut run: Run,
        path: &Path,
        integration: Integration,
        curve_s: Option<f64>,
    ) -> Result<(), String> {
        let mut position = 0.0;
        for k in 1..run.len() {
            let step_s = run.t_s[k] - run.t_s[k - 1];
            let both = (self.speeds[k - 1], self.speeds[k]);
            position += self.counts_in(integration.mean_between(both, step_s, curve_s), step_s);
            run.counts[k] = position.round() as i64;
        }
        let how = format!(
            "integrated from {}, {}",
            self.column.name(),
            integration.name()
        );
        run.header.insert("text_position".to_owned(), how.into());
        if let Some(curve_s) = curve_s {
            (run.header).insert("speed_time_constant_s".to_owned(), curve_s.into());
        }
        let beside = path.with_extension("integrated.csv");
        let written = write_run(&run, &beside).map_err(|error| error.to_string())?;
        rename(&written, path).map_err(|error| {
            // The recording itself is whole.
            let _ = remove_file(&written);
            error.to_string()
        })
    }
}
