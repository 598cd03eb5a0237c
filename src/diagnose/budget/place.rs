//! Location of the error: time intervals of one regime with their shares of the squared error above the noise floor.

use std::collections::BTreeMap;

use crate::diagnose::report::{Regime, Region};
use crate::diagnose::segments::{Segments, regimes};
use crate::diagnose::settings::conventions::{LEAST_REGION, MOST_REGIONS};

/// The share of each regime, whose sum is 1, and the intervals with the largest shares. `floor` in counts RMS. Samples
/// outside segments are in none.
pub(crate) fn located(
    segments: &Segments,
    name: &dyn Fn(usize) -> String,
    residual: &[f64],
    floor: f64,
) -> (BTreeMap<Regime, f64>, Vec<Region>) {
    let mut found = Vec::new();
    for (number, run) in segments.runs.iter().enumerate() {
        let regimes = regimes(run);
        let own = segments.segments.iter().filter(|own| own.run == number);
        let errors: Vec<(usize, f64)> = own
            .flat_map(|own| (own.from..own.to).zip(residual[own.range()].iter().copied()))
            .collect();
        let continues =
            |a: &(usize, f64), b: &(usize, f64)| b.0 == a.0 + 1 && regimes[b.0] == regimes[a.0];
        for interval in errors.chunk_by(continues) {
            let (from, to) = (interval[0].0, interval[interval.len() - 1].0);
            let squares: f64 = interval.iter().map(|(_, r)| r * r).sum();
            found.push(Region {
                run: name(number),
                from_s: run.t_s[from],
                to_s: run.t_s[to],
                regime: regimes[from],
                share: (squares - floor * floor * interval.len() as f64).max(0.0),
            });
        }
    }
    let total: f64 = found.iter().map(|region| region.share).sum();
    if total <= 0.0 {
        return Default::default();
    }
    let mut of_regime = BTreeMap::new();
    for region in &mut found {
        region.share /= total;
        *of_regime.entry(region.regime).or_insert(0.0) += region.share;
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.retain(|region| region.share >= LEAST_REGION);
    found.truncate(MOST_REGIONS);
    (of_regime, found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::recording;
    use crate::diagnose::settings::Settings;
    use crate::motor::Motor;

    /// Shares are those of the squares above the floor, and their sum is 1.
    #[test]
    fn shares_are_those_of_the_squared_residuals() {
        let run = recording(&Motor::default(), 500);
        let segments =
            Segments::new(&[run], &Motor::default(), &Settings::default()).expect("a run");
        let of_sample = regimes(&segments.runs[0]);
        let of = |residual: &[f64], floor: f64| {
            located(&segments, &|run| format!("run {run}"), residual, floor)
        };
        // Steady motion at 4.5 V, and rest at 0 V.
        assert_eq!(of_sample[40], Regime::Steady);
        assert_eq!(of_sample[90], Regime::Standstill);
        let mut residual = vec![0.0; 500];
        (residual[40], residual[90]) = (3.0, 3.0_f64.sqrt());
        let (of_regime, found) = of(&residual, 0.0);
        assert_eq!(found.len(), 2);
        assert_eq!(
            (found[0].regime, found[1].regime),
            (Regime::Steady, Regime::Standstill)
        );
        assert!((found[0].share - 0.75).abs() < 1e-9 && (found[1].share - 0.25).abs() < 1e-9);
        assert!((of_regime[&Regime::Steady] - 0.75).abs() < 1e-9);
        assert_eq!(found[0].run, "run 0");
        assert!(found[0].from_s < 0.4 && found[0].to_s >= 0.4);
        assert!(of(&residual, 5.0).1.is_empty());
        let (of_regime, even) = of(&vec![1.0; 500], 0.0);
        // For equal errors an interval's share is that of its samples, and short ones are not listed.
        for region in &even {
            let samples = 1.0 + ((region.to_s - region.from_s) / 0.01).round();
            assert!((region.share - samples / 500.0).abs() < 1e-9, "{region:?}");
        }
        let sum: f64 = even.iter().map(|region| region.share).sum();
        assert!(sum > 0.5 && sum < 1.0 - 1e-9, "{sum}");
        let sum: f64 = of_regime.values().sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}
