//! Summary of a recording, accumulated per sample in bounded memory.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Flags;
use crate::board::{ClockFit, ClockFitter};
use crate::units::{rad_per_count, rpm_from_rad_s};

/// Most distinct intervals; beyond that they are counted in coarser steps.
const MOST_INTERVALS: usize = 4096;

/// Shortest duration of one command in s for a steady speed.
const STEADY_AFTER_S: f64 = 0.2;

/// Most points kept of the interval of one command.
const MOST_INTERVAL_POINTS: usize = 256;

/// Shortest, median and longest interval between samples in microseconds of device time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Intervals {
    /// Shortest.
    pub min_us: i64,
    /// Median (exact to the microsecond for fewer than 4096 distinct intervals).
    pub median_us: i64,
    /// Longest, without losses and discontinuities.
    pub max_us: i64,
}

/// Summary of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistics {
    /// Samples recorded.
    pub samples: u64,
    /// Samples taken by the device that are not in the file.
    pub lost: u64,
    /// Samples that the device took late.
    pub overruns: u64,
    /// Samples after which the device reports dropped frames.
    pub dropped: u64,
    /// Samples with an illegal encoder transition since the previous one.
    pub encoder_errors: u64,
    /// Samples whose command was limited by the supply.
    pub saturated: u64,
    /// Samples at which the device's time fell back or jumped.
    pub time_leaps: u64,
    /// Samples at which the counts changed faster than any motor can.
    pub counts_leaps: u64,
    /// Device time from the first to the last sample in s.
    pub duration_s: f64,
    /// Intervals between successive samples.
    pub device_dt: Option<Intervals>,
    /// Device clock relative to the host's.
    pub clock: Option<ClockFit>,
    /// Mean speed in RPM over the second half of the last long interval of a non-zero command.
    pub steady_rpm: Option<f64>,
}

/// One sample as input of the statistics.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// The device's sample number, unwrapped, if there is one.
    pub seq: Option<u64>,
    /// Device time in microseconds.
    pub device_us: i64,
    /// Arrival time in microseconds, if the device has its own clock.
    pub host_us: Option<i64>,
    /// Command.
    pub command: f64,
    /// Counts.
    pub counts: i64,
    /// Device time and counts.
    pub flags: Flags,
}

/// Accumulates [`Statistics`].
#[derive(Debug, Clone)]
pub struct StatisticsGatherer {
    counts_per_rev: f64,
    samples: u64,
    lost: u64,
    flagged: [u64; 6],
    first_us: i64,
    last: Option<Observation>,
    intervals: IntervalCounts,
    clock: ClockFitter,
    command_interval: CommandInterval,
    steady_rpm: Option<f64>,
}

impl StatisticsGatherer {
    /// For an encoder of `counts_per_rev`.
    pub fn new(counts_per_rev: f64) -> Self {
        Self {
            counts_per_rev,
            samples: 0,
            lost: 0,
            flagged: [0; 6],
            first_us: 0,
            last: None,
            intervals: IntervalCounts::default(),
            clock: ClockFitter::default(),
            command_interval: CommandInterval::default(),
            steady_rpm: None,
        }
    }

    /// Takes in one sample.
    pub fn add(&mut self, sample: Observation) {
        self.samples += 1;
        let flags = sample.flags;
        let set = [
            flags.overrun,
            flags.dropped,
            flags.encoder_error,
            flags.saturated,
            flags.time_leap,
            flags.counts_leap,
        ];
        for (count, set) in self.flagged.iter_mut().zip(set) {
            *count += u64::from(set);
        }
        if let Some(host_us) = sample.host_us {
            self.clock.add(sample.device_us, host_us);
        }
        match self.last {
            None => self.first_us = sample.device_us,
            Some(last) => {
                let missing = match (last.seq, sample.seq) {
                    (Some(before), Some(seq)) => seq.saturating_sub(before).saturating_sub(1),
                    _ => 0,
                };
                self.lost = self.lost.saturating_add(missing);
                if missing == 0 && !flags.time_leap {
                    self.intervals.add(sample.device_us - last.device_us);
                }
                if last.command != sample.command {
                    self.end_interval();
                }
            }
        }
        self.command_interval.add(sample.device_us, sample.counts);
        self.last = Some(sample);
    }

    /// Adds losses without an effect on sample numbers: before the first sample, or after the last.
    pub fn add_lost(&mut self, samples: u64) {
        self.lost = self.lost.saturating_add(samples);
    }

    fn end_interval(&mut self) {
        let command_interval = std::mem::take(&mut self.command_interval);
        if let Some(rpm) = self.steady_of(&command_interval) {
            self.steady_rpm = Some(rpm);
        }
    }

    fn steady_of(&self, command_interval: &CommandInterval) -> Option<f64> {
        let command = self.last?.command;
        let counts_per_s = command_interval.counts_per_s_of_second_half()?;
        (command != 0.0).then(|| rpm_from_rad_s(counts_per_s * rad_per_count(self.counts_per_rev)))
    }

    /// Samples, losses and overruns so far.
    pub fn counters(&self) -> (u64, u64, u64) {
        (self.samples, self.lost, self.flagged[0])
    }

    /// Samples so far after which the device reports dropped frames.
    pub fn dropped(&self) -> u64 {
        self.flagged[1]
    }

    /// The figures so far.
    pub fn statistics(&self) -> Statistics {
        let [
            overruns,
            dropped,
            encoder_errors,
            saturated,
            time_leaps,
            counts_leaps,
        ] = self.flagged;
        let last_us = self.last.map_or(self.first_us, |last| last.device_us);
        Statistics {
            samples: self.samples,
            lost: self.lost,
            overruns,
            dropped,
            encoder_errors,
            saturated,
            time_leaps,
            counts_leaps,
            duration_s: (last_us - self.first_us) as f64 * 1e-6,
            device_dt: self.intervals.intervals(),
            clock: self.clock.fit(),
            steady_rpm: self.steady_of(&self.command_interval).or(self.steady_rpm),
        }
    }
}

/// How often each interval occurred.
#[derive(Debug, Clone)]
struct IntervalCounts {
    step_us: i64,
    counts: BTreeMap<i64, u64>,
    min_us: i64,
    max_us: i64,
}

impl Default for IntervalCounts {
    fn default() -> Self {
        Self {
            step_us: 1,
            counts: BTreeMap::new(),
            min_us: i64::MAX,
            max_us: i64::MIN,
        }
    }
}

impl IntervalCounts {
    fn add(&mut self, interval_us: i64) {
        self.min_us = self.min_us.min(interval_us);
        self.max_us = self.max_us.max(interval_us);
        *self
            .counts
            .entry(interval_us.div_euclid(self.step_us))
            .or_default() += 1;
        while self.counts.len() > MOST_INTERVALS {
            self.step_us *= 2;
            let finer = std::mem::take(&mut self.counts);
            for (index, count) in finer {
                *self.counts.entry(index.div_euclid(2)).or_default() += count;
            }
        }
    }

    fn intervals(&self) -> Option<Intervals> {
        let total: u64 = self.counts.values().sum();
        let mut below = 0;
        let (index, _) = self.counts.iter().find(|(_, count)| {
            below += **count;
            2 * below >= total
        })?;
        Some(Intervals {
            min_us: self.min_us,
            median_us: index * self.step_us + self.step_us / 2,
            max_us: self.max_us,
        })
    }
}

/// Uniformly thinned points of the interval of one command.
#[derive(Debug, Clone)]
struct CommandInterval {
    points: Vec<(i64, i64)>,
    keep_every: u64,
    seen: u64,
    last: (i64, i64),
}

impl Default for CommandInterval {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            keep_every: 1,
            seen: 0,
            last: (0, 0),
        }
    }
}

impl CommandInterval {
    fn add(&mut self, device_us: i64, counts: i64) {
        self.last = (device_us, counts);
        if self.seen.is_multiple_of(self.keep_every) {
            self.points.push(self.last);
        }
        self.seen += 1;
        if self.points.len() > MOST_INTERVAL_POINTS {
            let mut index = 0_usize;
            self.points.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.keep_every *= 2;
        }
    }

    fn counts_per_s_of_second_half(&self) -> Option<f64> {
        let (end_us, end_counts) = self.last;
        let (start_us, _) = *self.points.first()?;
        if ((end_us - start_us) as f64) < STEADY_AFTER_S * 1e6 {
            return None;
        }
        let middle_us = start_us + (end_us - start_us) / 2;
        let (from_us, from_counts) = *self.points.iter().find(|(at, _)| *at >= middle_us)?;
        let elapsed_s = (end_us - from_us) as f64 * 1e-6;
        (elapsed_s > 0.0).then(|| (end_counts - from_counts) as f64 / elapsed_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(seq: u64, command: f64, counts: i64) -> Observation {
        Observation {
            seq: Some(seq),
            device_us: seq as i64 * 3000,
            host_us: Some(seq as i64 * 3000 + 500),
            command,
            counts,
            flags: Flags {
                overrun: seq == 7,
                ..Flags::default()
            },
        }
    }

    #[test]
    fn losses_flags_and_the_steady_speed_are_counted() {
        let mut gatherer = StatisticsGatherer::new(720.0);
        // 720 counts/s is one revolution per second: 60 RPM, after a rest, with samples 500 to 502 lost.
        for seq in (0..1000).filter(|seq| !(500..503).contains(seq)) {
            let driven_s = (seq as f64 - 100.0).max(0.0) * 0.003;
            let command = if seq < 100 { 0.0 } else { 4.5 };
            gatherer.add(sample(seq, command, (720.0 * driven_s).floor() as i64));
        }
        gatherer.add(sample(1000, 0.0, 1944));
        gatherer.add_lost(2);
        let statistics = gatherer.statistics();
        assert_eq!((statistics.samples, statistics.lost), (998, 5));
        assert_eq!(statistics.overruns, 1);
        assert!((statistics.duration_s - 3.0).abs() < 1e-9);
        let dt = statistics.device_dt.expect("intervals");
        assert_eq!((dt.min_us, dt.median_us, dt.max_us), (3000, 3000, 3000));
        let rpm = statistics.steady_rpm.expect("a steady interval");
        assert!((rpm - 60.0).abs() < 0.1, "{rpm}");
        let clock = statistics.clock.expect("a fit");
        assert!(clock.device_fast_ppm.abs() < 1e-6);
    }

    #[test]
    fn a_million_samples_need_no_more_memory_than_a_thousand() {
        let mut gatherer = StatisticsGatherer::new(720.0);
        let mut device_us = 0;
        for seq in 0..1_000_000_u64 {
            device_us += 3000 + (seq as i64 * 7919) % 50_000;
            gatherer.add(Observation {
                device_us,
                ..sample(seq, 4.5, seq as i64)
            });
        }
        assert!(gatherer.intervals.counts.len() <= MOST_INTERVALS);
        assert!(gatherer.command_interval.points.len() <= MOST_INTERVAL_POINTS);
        let dt = gatherer.statistics().device_dt.expect("intervals");
        assert!((dt.median_us - 28_000).abs() < 50, "{dt:?}");
    }
}
