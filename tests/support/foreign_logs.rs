//! A motor with known counts, written in the formats of other programs.

use std::fmt::Write as _;
use std::fs;
use std::ops::Range;
use std::path::Path;

use super::command::{Finished, RunFile, run};

/// Of the encoder.
pub const COUNTS_PER_REV: f64 = 720.0;
const SUPPLY_V: f64 = 12.0;
/// Speed in rev/s at full drive, and the time constant in s.
const SPEED_REV_S: f64 = 4.0;
const TIME_CONSTANT_S: f64 = 0.08;

/// True events.
pub struct Truth {
    pub pwm: Vec<i64>,
    pub counts: Vec<i64>,
    sample_time_s: f64,
}

impl Truth {
    /// A first-order motor under these commands of 255, each held for a sample time: exact steps, counts from 0.
    pub fn of(sample_time_s: f64, pwm: impl IntoIterator<Item = i64>) -> Self {
        let pwm: Vec<i64> = pwm.into_iter().collect();
        let (mut speed, mut turns, mut counts) = (0.0, 0.0, Vec::new());
        let left = (-sample_time_s / TIME_CONSTANT_S).exp();
        for &command in &pwm {
            counts.push((turns * COUNTS_PER_REV).round() as i64);
            let end = (command as f64 / 255.0).clamp(-1.0, 1.0) * SPEED_REV_S;
            turns += end * sample_time_s + (speed - end) * TIME_CONSTANT_S * (1.0 - left);
            speed = end + (speed - end) * left;
        }
        Self {
            pwm,
            counts,
            sample_time_s,
        }
    }

    /// Steps of 200, -150 and 80, after a rest.
    pub fn steps(sample_time_s: f64, rows: usize) -> Self {
        let level = |k: usize| match 10 * k / rows {
            0 => 0,
            1..=3 => 200,
            4..=6 => -150,
            _ => 80,
        };
        Self::of(sample_time_s, (0..rows).map(level))
    }

    pub fn rows(&self) -> Range<usize> {
        0..self.pwm.len()
    }

    pub fn t_s(&self, k: usize) -> f64 {
        self.sample_time_s * k as f64
    }

    pub fn ms(&self, k: usize) -> u64 {
        (1000.0 * self.t_s(k)).round() as u64
    }

    pub fn turns(&self, k: usize) -> f64 {
        self.counts[k] as f64 / COUNTS_PER_REV
    }

    pub fn volts(&self, k: usize) -> f64 {
        self.pwm[k] as f64 / 255.0 * SUPPLY_V
    }

    /// As a sketch prints it: the counts since the previous row, with two digits.
    pub fn rpm(&self, k: usize) -> String {
        let counts = self.counts[k] - self.counts[k.saturating_sub(1)];
        format!(
            "{:.2}",
            counts as f64 / COUNTS_PER_REV / self.sample_time_s * 60.0
        )
    }

    pub fn times(&self) -> Vec<f64> {
        self.rows().map(|k| self.t_s(k)).collect()
    }

    pub fn commands(&self) -> Vec<f64> {
        self.rows().map(|k| self.volts(k)).collect()
    }

    /// Milliseconds, pulse width and counts.
    pub fn counts_log(&self) -> String {
        let ms = |k: usize| self.ms(k).to_string();
        let pwm = |k: usize| self.pwm[k].to_string();
        let counts = |k: usize| self.counts[k].to_string();
        log("time_ms,pwm,counts", self.rows(), &[&ms, &pwm, &counts])
    }

    /// The most common log, under these three names.
    pub fn rpm_log(&self, names: &str) -> String {
        let ms = |k: usize| self.ms(k).to_string();
        let pwm = |k: usize| self.pwm[k].to_string();
        log(names, self.rows(), &[&ms, &pwm, &|k| self.rpm(k)])
    }
}

/// A line of names and the rows, with the separator of the names.
pub fn log(names: &str, rows: Range<usize>, cells: &[&dyn Fn(usize) -> String]) -> String {
    let plain = names.chars().find(|c| matches!(c, ',' | ';' | '\t'));
    let separator = plain.unwrap_or(' ').to_string();
    let mut text = format!("{names}\n");
    for k in rows {
        let line: Vec<String> = cells.iter().map(|cell| cell(k)).collect();
        let _ = writeln!(text, "{}", line.join(&separator));
    }
    text
}

/// Imports `name` with these flags into `run.csv`.
pub fn import(directory: &Path, name: &str, log: &str, flags: &[&str]) -> Finished {
    fs::write(directory.join(name), log).expect("written");
    let mut arguments = vec!["import", name, "-o", "run.csv"];
    arguments.extend(flags);
    run(directory, &arguments)
}

/// The run of a successful import, and its messages.
pub fn imported(name: &str, log: &str, flags: &[&str]) -> (RunFile, String) {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), name, log, flags);
    assert_eq!(
        finished.status,
        Some(0),
        "{log:.200}\n{}",
        finished.messages
    );
    (
        RunFile::read(&directory.path().join("run.csv")),
        finished.messages,
    )
}

/// The error of a log that lacks facts.
pub fn asked(name: &str, log: &str, flags: &[&str]) -> String {
    let directory = tempfile::tempdir().expect("a directory");
    let finished = import(directory.path(), name, log, flags);
    assert_eq!(finished.status, Some(2), "{}", finished.messages);
    let left = fs::read_dir(directory.path()).expect("a folder").count();
    assert_eq!(left, 1, "nothing is written");
    finished.messages
}

/// The proposed command line of a message, its placeholders filled in, without `motorlab` and the log.
pub fn proposed(said: &str, filled: &[(&str, &str)]) -> Vec<String> {
    let line = said
        .lines()
        .find_map(|line| line.trim().strip_prefix("motorlab import "))
        .unwrap_or_else(|| panic!("a command line: {said}"));
    let mut words: Vec<String> = line.split(' ').skip(1).map(str::to_owned).collect();
    for (capitals, value) in filled {
        let word = words
            .iter_mut()
            .find(|word| word == capitals)
            .unwrap_or_else(|| panic!("{capitals}: {said}"));
        *word = (*value).to_owned();
    }
    words.retain(|word| word != "-o" && word != "run.csv");
    words
}

pub fn counts(file: &RunFile) -> Vec<i64> {
    file.column("counts").iter().map(|&n| n as i64).collect()
}

pub fn near(found: &[f64], wanted: &[f64], within: f64) {
    assert_eq!(found.len(), wanted.len());
    for (k, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!((a - b).abs() <= within, "row {k}: {a} for {b}");
    }
}
