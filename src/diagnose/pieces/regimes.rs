//! What the motor does at each sample of a run.

use super::Recording;
use crate::diagnose::report::Regime;
use crate::diagnose::settings::{BREAKAWAY_S, CHANGE_SHARE, CHANGE_SPAN_S, SLOW_SHARE};

/// The regime of each sample.
pub(crate) fn regimes(run: &Recording) -> Vec<Regime> {
    let half = ((CHANGE_SPAN_S / run.sample_time_s).round() as usize).max(1);
    let last = run.t_s.len().saturating_sub(1);
    let top = run.speed.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let mut rested_s = f64::NEG_INFINITY;
    (0..run.t_s.len())
        .map(|k| {
            if !run.moving[k] {
                rested_s = run.t_s[k];
                return Regime::Standstill;
            }
            let (from, to) = (k.saturating_sub(half), (k + half).min(last));
            let (before, after) = (run.speed[from], run.speed[to]);
            let change = after.abs() - before.abs();
            match () {
                () if before * after < 0.0 && run.moving[from] && run.moving[to] => {
                    Regime::Reversal
                }
                () if run.command[k] == 0.0 => Regime::Coasting,
                () if run.t_s[k] - rested_s < BREAKAWAY_S => Regime::Breakaway,
                () if change > CHANGE_SHARE * top => Regime::Accelerating,
                () if -change > CHANGE_SHARE * top => Regime::Braking,
                () if run.speed[k].abs() < SLOW_SHARE * top => Regime::LowSpeed,
                () => Regime::Steady,
            }
        })
        .collect()
}
