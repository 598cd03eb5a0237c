//! Statistics of the time steps of a run.

use super::Run;

/// The time steps in ascending order.
#[derive(Debug)]
pub(crate) struct Steps {
    sorted_s: Vec<f64>,
}

impl Steps {
    /// `None` for a run of fewer than two samples.
    pub fn of(run: &Run) -> Option<Self> {
        Self::of_steps(run.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect())
    }

    /// From steps in s, in any order.
    pub fn of_steps(mut steps_s: Vec<f64>) -> Option<Self> {
        steps_s.sort_by(f64::total_cmp);
        (!steps_s.is_empty()).then_some(Self { sorted_s: steps_s })
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.sorted_s.len()
    }

    /// The quantile of the steps in s at this share.
    pub fn at(&self, share: f64) -> f64 {
        let last = self.sorted_s.len() - 1;
        self.sorted_s[(last as f64 * share).round() as usize]
    }

    /// The median in s.
    pub fn median_s(&self) -> f64 {
        self.at(0.5)
    }

    /// The mean in s of the steps up to `longest_s`.
    pub fn mean_s(&self, longest_s: f64) -> f64 {
        let kept = self.sorted_s.partition_point(|&step_s| step_s <= longest_s);
        self.sorted_s[..kept].iter().sum::<f64>() / kept as f64
    }

    /// The range of the middle nine tenths in s: the usual scatter of this log.
    pub fn spread_s(&self) -> f64 {
        self.at(0.95) - self.at(0.05)
    }

    /// The longest usual step in s, beyond which there is a pause.
    pub fn longest_usual_s(&self) -> f64 {
        let median_s = self.median_s();
        (PAUSE_STEPS * median_s).max(median_s + PAUSE_SPREADS * self.spread_s())
    }
}

/// Least ratio of a pause to the median step. Irregular logs of real motors (EV3, XL-330, ODrive) have steps of up to
/// 3 medians, and one that waits for its line up to 4.3.
const PAUSE_STEPS: f64 = 5.0;
/// Least ratio of a pause to the spread of the middle nine tenths in an irregular log: a loop of 0.4 ms that prints
/// has steps of 15 ms, which are 5 to 11 spreads.
const PAUSE_SPREADS: f64 = 15.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_exceeds_the_jitter_of_the_log() {
        let of = |steps_s: &[f64]| {
            let mut run = Run::default();
            let mut t_s = 0.0;
            run.t_s.push(t_s);
            for step_s in steps_s {
                t_s += step_s;
                run.t_s.push(t_s);
            }
            Steps::of(&run).expect("steps")
        };
        let even = of(&[0.004; 100]);
        assert!((even.longest_usual_s() - 0.02).abs() < 1e-12);
        let uneven: Vec<f64> = (0..100)
            .map(|k| if k % 5 == 0 { 0.003 } else { 0.001 })
            .collect();
        assert!((of(&uneven).longest_usual_s() - 0.031).abs() < 1e-9);
        assert!((of(&uneven).mean_s(0.002) - 0.001).abs() < 1e-9);
        assert!(Steps::of(&Run::default()).is_none());
    }
}
