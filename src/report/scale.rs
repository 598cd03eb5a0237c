//! The range of a panel's axis, without isolated outliers.
//!
//! A finite difference of counts spikes where a sample is late or an edge is lost. Such a spike lasts a sample or two
//! and is removed by a running median of five (Tukey, 1977).

use super::figure::{Panel, Series};

/// Points in the running median: features of fewer than half of them are spikes.
const MEDIAN: usize = 5;
/// Largest share of points that are spikes; more are a property of the curve. Convention.
const RARE: f64 = 0.01;
/// Spikes are left outside if they widen the scale by more than this factor. Convention.
const WIDER: f64 = 1.5;

/// A curve's peaks exceed its running median by up to this share of its range. Convention.
const TIPS: f64 = 0.25;

/// Range of an axis, and the number of points outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisScale {
    /// Minimum and maximum.
    pub range: (f64, f64),
    /// Number of points outside.
    pub beyond: usize,
}

impl AxisScale {
    /// Note about points outside; `None` without any.
    pub fn words(&self) -> Option<String> {
        match self.beyond {
            0 => None,
            1 => Some("1 isolated point lies beyond the scale".to_owned()),
            n => Some(format!("{n} isolated points lie beyond the scale")),
        }
    }
}

impl Panel {
    /// The scale of its values; `None` without finite values.
    pub fn scale(&self) -> Option<AxisScale> {
        let range = self.y_range()?;
        let whole = AxisScale { range, beyond: 0 };
        if !self.is_robust {
            return Some(whole);
        }
        let steady = self.series.iter().flat_map(without_spikes);
        let marks = self.marks.iter().map(|mark| mark.0);
        let (low, high) = super::figure::range(steady.chain(marks))?;
        // The median cuts off the peaks of the curve.
        let tips = TIPS * (high - low);
        let is_near = |value: &f64| *value >= low - tips && *value <= high + tips;
        let values = || {
            let points = self.series.iter().flat_map(|s| &s.points);
            points.map(|p| p.1).filter(|y| y.is_finite())
        };
        let marks = self.marks.iter().map(|mark| mark.0);
        let near = super::figure::range(values().filter(is_near).chain(marks))?;
        let beyond = values().filter(|value| !is_near(value)).count();
        let is_wider = range.1 - range.0 > WIDER * (near.1 - near.0);
        let is_rare = beyond as f64 <= RARE * values().count() as f64;
        Some(if high > low && is_wider && is_rare {
            AxisScale {
                range: near,
                beyond,
            }
        } else {
            whole
        })
    }
}

fn without_spikes(series: &Series) -> Vec<f64> {
    let values: Vec<f64> = (series.points.iter().map(|p| p.1))
        .filter(|v| v.is_finite())
        .collect();
    let medians = values.windows(MEDIAN).map(|window| {
        let mut sorted = [0.0; MEDIAN];
        sorted.copy_from_slice(window);
        sorted.sort_by(f64::total_cmp);
        sorted[MEDIAN / 2]
    });
    match values.len() {
        0..MEDIAN => values,
        _ => medians.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::Stroke;

    fn panel(y: &[f64]) -> Panel {
        let x: Vec<f64> = (0..y.len()).map(|k| k as f64).collect();
        Panel::new("speed", vec![Series::new("", Stroke::Step, 0, &x, y)]).robust()
    }

    #[test]
    fn spikes_of_a_sample_or_two_do_not_set_the_scale() {
        let mut speed: Vec<f64> = (0..1000).map(|k| f64::from(k % 50)).collect();
        (speed[300], speed[301], speed[700]) = (9000.0, 8000.0, -7000.0);
        let scale = panel(&speed).scale().expect("a scale");
        let saw = AxisScale {
            range: (0.0, 49.0),
            beyond: 3,
        };
        assert_eq!(scale, saw);
        assert_eq!(
            scale.words().as_deref(),
            Some("3 isolated points lie beyond the scale")
        );
        let plain = Panel {
            is_robust: false,
            ..panel(&speed)
        };
        assert_eq!(plain.scale().map(|s| s.range), Some((-7000.0, 9000.0)));
    }

    #[test]
    fn short_moves_and_coarse_counts_are_within_the_scale() {
        let mut moved = vec![0.0; 1000];
        moved[500..504].fill(10.0);
        assert_eq!(
            panel(&moved).scale(),
            Some(AxisScale {
                range: (0.0, 10.0),
                beyond: 0
            })
        );
        let coarse: Vec<f64> = (0..1000)
            .map(|k| if k % 10 == 0 { 6.0 } else { 0.0 })
            .collect();
        assert_eq!(panel(&coarse).scale().map(|s| s.range), Some((0.0, 6.0)));
        assert_eq!(panel(&[]).scale(), None);
    }
}
