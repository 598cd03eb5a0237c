//! Regime at each sample of a run.

use super::Recording;
use crate::diagnose::report::Regime;

use crate::diagnose::settings::conventions::SLOW;

/// The regime of each sample: changes are detected over the speed window on either side, breakaway lasts two windows.
pub(crate) fn regimes(run: &Recording) -> Vec<Regime> {
    let window_s = run.settings.speed_window_s();
    let half = ((window_s / run.sample_time_s).round() as usize).max(1);
    let last = run.t_s.len().saturating_sub(1);
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
                () if run.t_s[k] - rested_s < 2.0 * window_s => Regime::Breakaway,
                () if change > SLOW * run.top => Regime::Accelerating,
                () if -change > SLOW * run.top => Regime::Braking,
                () if run.speed[k].abs() < SLOW * run.top => Regime::LowSpeed,
                () => Regime::Steady,
            }
        })
        .collect()
}
