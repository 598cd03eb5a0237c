//! The board's clock: its rate fitted against the host's.
//!
//! Device time is the time base of a run. The host's arrival times have non-negative delays (USB polling,
//! scheduling), so that a least-squares line is biased by every burst. The fit is the line below all arrivals with
//! the smallest mean distance, `minimise sum(h_k - a - b d_k) subject to h_k >= a + b d_k`: the edge of the lower
//! convex hull that spans the mean of `d` (Moon, Skelly and Towsley, "Estimation and removal of clock skew from
//! network delay measurements", INFOCOM 1999). The hull is updated with each sample, so that memory does not grow
//! with the recording.

use serde::Serialize;

/// Most points of the lower hull. Noise needs some tens; only a clock of steadily changing rate needs more, and then
/// the oldest edges are coarsened.
const MOST_HULL_POINTS: usize = 4096;

/// Running fit of host time against device time.
#[derive(Debug, Clone, Default)]
pub struct ClockFitter {
    /// Lower hull: device time and host minus device time, both in microseconds.
    hull: Vec<(i64, i64)>,
    first: Option<(i64, i64)>,
    /// The last sample of the current read.
    latest: Option<(i64, i64)>,
    count: u64,
    mean_device: f64,
    mean_late: f64,
    moment_device: f64,
    moment_late: f64,
    moment_both: f64,
}

/// The board's clock relative to the host's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClockFit {
    /// Rate error of the board's clock relative to the host's, in parts per million; positive if it is fast.
    pub device_fast_ppm: f64,
    /// Upper bound of its uncertainty: the scatter of arrival times over the span, in parts per million.
    pub sigma_ppm: f64,
    /// Mean delay of the arrivals relative to the fitted line in s.
    pub mean_delay_s: f64,
    /// RMS residual of the arrivals about their mean delay in s.
    pub residual_rms_s: f64,
    /// Device time spanned by the fit in s.
    pub span_s: f64,
}

impl ClockFitter {
    /// Adds one sample: unwrapped device time and the host's monotonic arrival time.
    pub fn add(&mut self, device_us: i64, host_us: i64) {
        if let Some((device_before, host_before)) = self.latest.replace((device_us, host_us))
            && host_before != host_us
        {
            self.add_pair(device_before, host_before);
        }
    }

    fn add_pair(&mut self, device_us: i64, host_us: i64) {
        let (first_device, first_host) = *self.first.get_or_insert((device_us, host_us));
        let device = device_us - first_device;
        let late = (host_us - first_host) - device;
        self.add_moments(device as f64, late as f64);
        self.add_to_hull(device, late);
    }

    /// Welford's update of means and second moments.
    fn add_moments(&mut self, device: f64, late: f64) {
        self.count += 1;
        let n = self.count as f64;
        let device_before = device - self.mean_device;
        let late_before = late - self.mean_late;
        self.mean_device += device_before / n;
        self.mean_late += late_before / n;
        self.moment_device += device_before * (device - self.mean_device);
        self.moment_late += late_before * (late - self.mean_late);
        self.moment_both += device_before * (late - self.mean_late);
    }

    fn add_to_hull(&mut self, device: i64, late: i64) {
        if let Some(&(last_device, last_late)) = self.hull.last() {
            if device < last_device {
                return;
            }
            if device == last_device {
                if late >= last_late {
                    return;
                }
                self.hull.pop();
            }
        }
        while let [.., a, b] = self.hull[..] {
            let turns_left = i128::from(b.0 - a.0) * i128::from(late - a.1)
                - i128::from(b.1 - a.1) * i128::from(device - a.0);
            if turns_left > 0 {
                break;
            }
            self.hull.pop();
        }
        self.hull.push((device, late));
        if self.hull.len() > MOST_HULL_POINTS {
            let mut index = 0;
            let last = self.hull.len() - 1;
            self.hull.retain(|_| {
                index += 1;
                (index - 1) % 2 == 0 || index - 1 == last
            });
        }
    }

    /// The fit so far; `None` until the samples span at least a tenth of a second.
    pub fn fit(&self) -> Option<ClockFit> {
        let mut whole = self.clone();
        if let Some((device_us, host_us)) = whole.latest.take() {
            whole.add_pair(device_us, host_us);
        }
        whole.fit_of_points()
    }

    fn fit_of_points(&self) -> Option<ClockFit> {
        let span_us = self.hull.last()?.0 - self.hull.first()?.0;
        if span_us < 100_000 {
            return None;
        }
        let right = self
            .hull
            .iter()
            .position(|&(device, _)| device as f64 > self.mean_device)?
            .max(1);
        let (a, b) = (self.hull[right - 1], self.hull[right]);
        let slope = (b.1 - a.1) as f64 / (b.0 - a.0) as f64;
        let offset = a.1 as f64 - slope * a.0 as f64;
        let n = self.count as f64;
        let mean_delay_us = self.mean_late - (offset + slope * self.mean_device);
        let variance = (self.moment_late - 2.0 * slope * self.moment_both
            + slope * slope * self.moment_device)
            / n;
        // Crystals and resonators agree within a percent; a virtual board that runs faster than real time has no rate
        // to fit.
        if slope.abs() > 0.1 {
            return None;
        }
        let rms_us = variance.max(0.0).sqrt();
        Some(ClockFit {
            // For a fast device, host minus device time decreases: rate = 1 / (1 + slope).
            device_fast_ppm: -slope / (1.0 + slope) * 1e6,
            sigma_ppm: rms_us.max(1.0) / span_us as f64 * 1e6,
            mean_delay_s: mean_delay_us * 1e-6,
            residual_rms_s: rms_us * 1e-6,
            span_s: span_us as f64 * 1e-6,
        })
    }

    /// Number of points kept: bounded for any length.
    pub fn kept_points(&self) -> usize {
        self.hull.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// An hour at 333 Hz of a board with this rate error, with the delays of a USB serial chip: at least 0.3 ms,
    /// uniform up to 4.4 ms, occasionally a burst that is 40 ms late.
    fn an_hour(ppm: f64, seed: u64) -> ClockFitter {
        let mut noise = Pcg64::seed_from_u64(seed);
        let mut fitter = ClockFitter::default();
        let mut late_until = 0.0;
        for k in 0..1_200_000_u32 {
            let true_us = f64::from(k) * 3000.0;
            let device_us = (true_us * (1.0 + ppm * 1e-6)).floor() as i64;
            let mut host_us: f64 = true_us + noise.random_range(300.0..4400.0);
            if noise.random_bool(0.001) {
                late_until = true_us + 40_000.0;
            }
            host_us = host_us.max(late_until);
            fitter.add(device_us, host_us as i64);
        }
        fitter
    }

    #[test]
    fn drift_is_fitted_to_within_a_part_per_million() {
        for (ppm, seed) in [(200.0, 1), (-200.0, 2), (0.0, 3), (37.5, 4)] {
            let fitter = an_hour(ppm, seed);
            let fit = fitter.fit().expect("an hour is enough");
            let error = fit.device_fast_ppm - ppm;
            assert!(error.abs() < 1.0, "{ppm} fitted as {fit:?}");
            assert!(fit.residual_rms_s > 0.5e-3 && fit.residual_rms_s < 10e-3);
            assert!(fitter.kept_points() < 200, "{}", fitter.kept_points());
        }
    }
}
