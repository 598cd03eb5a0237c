//! Whiteness of the residual: spectrum and autocorrelation over the segments of a run.

use std::f64::consts::TAU;

use super::overlay::RunWithModels;
use super::spread::segments;
use crate::report::{Figure, Panel, Series, Stroke};

const FREQUENCIES: usize = 80;
/// Most lags of the autocorrelation, also as a share of the shortest segment.
const LAGS: usize = 60;
const LAG_SHARE: f64 = 0.5;
/// Fewest samples of a segment for a spectrum.
const FEWEST: usize = 16;
/// Bounds of 95 % of a white residual's correlations, in standard deviations.
const WITHIN_95: f64 = 1.96;

/// Both figures of the last model's residual; none for short segments.
pub(super) fn figures(beside: &RunWithModels<'_>) -> Vec<Figure> {
    let model = beside.models.len() - 1;
    let residual = &beside.predicted.gap_counts[model];
    let of_segments: Vec<(&[f64], &[f64])> = segments(beside.predicted, residual.len())
        .filter(|(from, to)| to - from >= FEWEST)
        .map(|(from, to)| (&beside.run.t_s[from..to], &residual[from..to]))
        .filter(|(_, residual)| residual.iter().all(|value| value.is_finite()))
        .collect();
    if of_segments.is_empty() {
        return Vec::new();
    }
    let dt = beside.run.sample_time_s;
    vec![
        spectrum(&of_segments, dt),
        autocorrelation(&of_segments, dt),
    ]
}

/// Mean periodogram of the segments with a Hann window (Welch 1967), at logarithmically spaced frequencies.
fn spectrum(all: &[(&[f64], &[f64])], dt: f64) -> Figure {
    let longest = all
        .iter()
        .map(|(_, residual)| residual.len())
        .max()
        .unwrap_or(1);
    let (lowest, highest) = (1.0 / (longest as f64 * dt), 0.5 / dt);
    let step = (highest / lowest).ln() / (FREQUENCIES - 1) as f64;
    let frequencies: Vec<f64> = (0..FREQUENCIES)
        .map(|k| lowest * (step * k as f64).exp())
        .collect();
    let density = |frequency: &f64| -> f64 {
        let powers = all.iter().map(|(t, residual)| {
            let n = residual.len();
            let mean = residual.iter().sum::<f64>() / n as f64;
            let (mut re, mut im, mut weight) = (0.0, 0.0, 0.0);
            for (k, (t, value)) in t.iter().zip(*residual).enumerate() {
                let window = 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
                let (sin, cos) = (TAU * frequency * t).sin_cos();
                re += window * (value - mean) * cos;
                im += window * (value - mean) * sin;
                weight += window * window;
            }
            2.0 * dt * (re * re + im * im) / weight
        });
        (powers.sum::<f64>() / all.len() as f64).sqrt()
    };
    let densities: Vec<f64> = frequencies.iter().map(|f| density(f).log10()).collect();
    let decades: Vec<f64> = frequencies.iter().map(|f| f.log10()).collect();
    let series = Series::new("", Stroke::Line, COLOUR, &decades, &densities);
    Figure {
        title: "Spectrum of the residual".to_owned(),
        x_label: "log10 of the frequency in Hz".to_owned(),
        panels: vec![Panel::new("log10 of counts/\u{221a}Hz", vec![series])],
    }
}

const COLOUR: usize = 1;

fn autocorrelation(all: &[(&[f64], &[f64])], dt: f64) -> Figure {
    let shortest = all
        .iter()
        .map(|(_, residual)| residual.len())
        .min()
        .unwrap_or(0);
    let lags = LAGS.min((LAG_SHARE * shortest as f64) as usize).max(1);
    let (mut products, mut samples) = (vec![0.0; lags + 1], 0usize);
    for (_, residual) in all {
        let n = residual.len();
        samples += n;
        let mean = residual.iter().sum::<f64>() / n as f64;
        for (lag, product) in products.iter_mut().enumerate() {
            let pairs = residual.iter().zip(&residual[lag..]);
            *product += pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
        }
    }
    let power = products[0].max(f64::MIN_POSITIVE);
    let at: Vec<f64> = (0..=lags).map(|lag| lag as f64 * dt).collect();
    let correlations: Vec<f64> = products.iter().map(|product| product / power).collect();
    let within = WITHIN_95 / (samples as f64).sqrt();
    let series = Series::new("", Stroke::Line, COLOUR, &at, &correlations);
    let panel = Panel::new("autocorrelation", vec![series]);
    Figure {
        title: "Autocorrelation of the residual".to_owned(),
        x_label: "lag (s)".to_owned(),
        panels: vec![panel.marked(within, "").marked(-within, "").marked(0.0, "")],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_has_a_spectral_peak_and_a_cosine_correlation() {
        let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let tone: Vec<f64> = t.iter().map(|t| 3.0 * (TAU * 5.0 * t).sin()).collect();
        let all = [(&t[..], &tone[..])];
        let points = &spectrum(&all, 0.01).panels[0].series[0].points;
        let peak = points
            .iter()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .expect("points");
        assert!(
            (10f64.powf(peak.0) - 5.0).abs() < 0.3,
            "{}",
            10f64.powf(peak.0)
        );
        let points = &autocorrelation(&all, 0.01).panels[0].series[0].points;
        // A period of 0.2 s: opposite sign after 0.1 s.
        assert!((points[0].1 - 1.0).abs() < 1e-12 && (points[10].1 + 1.0).abs() < 0.05);
    }
}
