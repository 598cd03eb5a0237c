//! Decimation: one sample per given number of rows.
//!
//! The command of a sample is the time-weighted mean over the rows until the next one, so that volt-seconds are
//! conserved also where the command steps between two samples.

use super::convert::Sample;

/// A decimator.
#[derive(Debug)]
pub(super) struct Thin {
    every: u64,
    kept: Option<(u64, Sample)>,
    last: Option<Sample>,
    /// Command times time since the kept row.
    sum: f64,
}

impl Thin {
    pub fn new(every: u64) -> Self {
        Self {
            every,
            kept: None,
            last: None,
            sum: 0.0,
        }
    }

    /// Adds a row from this line; returns the sample that it completes.
    pub fn push(&mut self, line: u64, sample: Sample) -> Option<(u64, Sample)> {
        if self.every == 1 {
            return Some((line, sample));
        }
        if let Some(last) = self.last.replace(sample) {
            self.sum += last.command * (sample.t_s - last.t_s);
        }
        if !sample.seq.is_multiple_of(self.every) {
            return None;
        }
        let ended = self.take(sample.t_s);
        self.kept = Some((line, sample));
        self.sum = 0.0;
        ended
    }

    /// The last sample.
    pub fn finish(&mut self) -> Option<(u64, Sample)> {
        let end_s = self.last?.t_s;
        self.take(end_s)
    }

    fn take(&mut self, end_s: f64) -> Option<(u64, Sample)> {
        let (line, mut sample) = self.kept.take()?;
        if end_s > sample.t_s {
            sample.command = self.sum / (end_s - sample.t_s);
        }
        sample.seq /= self.every;
        Some((line, sample))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_volt_seconds() {
        // 0 V, and 6 V from the fifth row on: 3 of 4 intervals of the second sample.
        let rows = (0..12_u64).map(|seq| Sample {
            seq,
            t_s: 0.01 * seq as f64,
            command: if seq < 5 { 0.0 } else { 6.0 },
            counts: 10 * seq as i64,
            speed_counts_s: None,
            current_a: None,
            supply_v: None,
            beyond_full: None,
        });
        let mut thin = Thin::new(4);
        let mut kept: Vec<Sample> = rows
            .filter_map(|row| thin.push(row.seq + 2, row))
            .map(|(_, sample)| sample)
            .collect();
        kept.extend(thin.finish().map(|(_, sample)| sample));
        let of = |kept: &[Sample]| -> Vec<(u64, i64)> {
            kept.iter()
                .map(|sample| (sample.seq, sample.counts))
                .collect()
        };
        assert_eq!(of(&kept), [(0, 0), (1, 40), (2, 80)]);
        for (sample, command) in kept.iter().zip([0.0, 4.5, 6.0]) {
            assert!((sample.command - command).abs() < 1e-12, "{sample:?}");
        }
    }
}
