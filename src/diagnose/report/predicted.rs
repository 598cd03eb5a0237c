//! Residuals by sample: the data behind the figures of the budget.

/// One run, each segment predicted from its measured initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedRun {
    /// Its index among the held-out runs, or among the diagnosed runs if none are held out.
    pub run: usize,
    /// Measured minus predicted position in counts by sample: nominal model, re-identified parameters, with effects.
    /// NaN outside segments.
    pub gap_counts: [Vec<f64>; 3],
    /// First samples of segments.
    pub starts: Vec<usize>,
}

impl PredictedRun {
    /// RMS error of a model in counts over the run.
    pub fn rms(&self, model: usize) -> f64 {
        let gaps = || self.gap_counts[model].iter().filter(|gap| gap.is_finite());
        let squares: f64 = gaps().map(|gap| gap * gap).sum();
        (squares / gaps().count().max(1) as f64).sqrt()
    }
}
