//! Logged speeds that are kept when no edge comes, from the log's own values before they are rounded to counts.
//!
//! While nothing is commanded, such a speed falls from edge to edge, and at the last one it stays as it is, to the last
//! digit, until the next command. On a disc of few slots it adds less than the rounding of counts hides.

/// Header key under which the import states it.
pub(crate) const SPEED_KEPT: &str = "speed_kept";

/// Shortest kept speed in rows.
pub(super) const KEPT_ROWS: usize = 30;
/// Largest kept speed as a share of the largest speed: a shaft without friction keeps all of it.
pub(super) const KEPT_SHARE: f64 = 0.5;
/// It stays this many times as long as the speed before it: while edges come, the rows between them grow slowly.
const TIMES_AS_LONG: usize = 2;

/// One row of a log of speeds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpeedRow {
    pub t_s: f64,
    pub command: f64,
    pub counts_s: f64,
}

/// A speed that is kept, and from when to when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KeptSpeed {
    pub from_s: f64,
    pub to_s: f64,
    pub counts_s: f64,
}

impl KeptSpeed {
    /// The first one.
    pub(crate) fn of(rows: &[SpeedRow]) -> Option<Self> {
        let top = rows
            .iter()
            .fold(0.0, |top, row| f64::max(top, row.counts_s.abs()));
        let changes = rows
            .windows(2)
            .map(|two| (two[1].counts_s - two[0].counts_s).abs());
        // A rounded speed that coasts falls by one digit at a time.
        let digit = changes
            .filter(|change| *change > 0.0)
            .fold(f64::INFINITY, f64::min);
        let mut was_commanded = false;
        rows.chunk_by(|a, b| (a.command == 0.0) == (b.command == 0.0))
            .find_map(|block| {
                let is_off = block[0].command == 0.0 && was_commanded;
                was_commanded |= block[0].command != 0.0;
                let mut levels = block.chunk_by(|a, b| a.counts_s == b.counts_s).rev();
                let (last, before) = (levels.next()?, levels.next()?);
                let kept = last[0].counts_s;
                let fell = (before[0].counts_s - kept).abs();
                let is_long = last.len() >= KEPT_ROWS.max(TIMES_AS_LONG * before.len());
                let is_kept = kept != 0.0 && kept.abs() <= KEPT_SHARE * top && fell > digit;
                (is_off && is_long && is_kept).then(|| Self {
                    from_s: last[0].t_s,
                    to_s: last[last.len() - 1].t_s,
                    counts_s: kept,
                })
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of 10 ms under a command of 1 s, whose speed is `of` the seconds since its end.
    fn rows(of: impl Fn(f64) -> f64) -> Vec<SpeedRow> {
        (0..400)
            .map(|k| SpeedRow {
                t_s: 0.01 * f64::from(k),
                command: if k < 100 { 6.0 } else { 0.0 },
                counts_s: if k < 100 {
                    80.0
                } else {
                    of(0.01 * f64::from(k - 100))
                },
            })
            .collect()
    }

    #[test]
    fn a_speed_that_stays_at_its_last_value_is_kept() {
        // The slots of a coasting disc, timed edge to edge.
        let edges = [0.02, 0.05, 0.09, 0.14, 0.21, 0.31, 0.5];
        let timed = |t_s: f64| {
            let past = edges.iter().take_while(|edge| **edge <= t_s).count();
            match past {
                0 => 80.0,
                1 => 50.0,
                past => (edges[past - 1] - edges[past - 2]).recip(),
            }
        };
        let found = KeptSpeed::of(&rows(timed)).expect("kept");
        assert!((found.counts_s - 1.0 / 0.19).abs() < 1e-9, "{found:?}");
        assert!(
            (found.from_s - 1.5).abs() < 0.011 && found.to_s > 3.98,
            "{found:?}"
        );
        let ended = |t_s: f64| if t_s > 0.9 { 0.0 } else { timed(t_s) };
        assert_eq!(KeptSpeed::of(&rows(ended)), None);
    }

    #[test]
    fn a_shaft_that_coasts_keeps_no_speed() {
        let coasts = |t_s: f64| 80.0 * (-t_s / 1.0).exp();
        assert_eq!(KeptSpeed::of(&rows(coasts)), None);
        // Rounded to whole numbers, it stays long at the last ones.
        assert_eq!(KeptSpeed::of(&rows(|t_s| coasts(t_s).round())), None);
        assert_eq!(KeptSpeed::of(&rows(|_| 80.0)), None);
        // Edges still come when the log ends.
        let edges = |t_s: f64| 20.0 / (1.0 + (t_s * 3.0).floor());
        assert_eq!(KeptSpeed::of(&rows(edges)), None);
    }
}
