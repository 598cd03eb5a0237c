//! The runs that the rungs are of, over their pieces: what pictures show in the same measure as the figures.

/// One run, each piece of it predicted from its own measured start.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedRun {
    /// Its number among the runs held out, or among those that are diagnosed where none are.
    pub run: usize,
    /// Recorded less predicted position in counts, a value a sample: of the nominal model, the refitted one, the one with effects. Not a
    /// number where no piece is.
    pub gap_counts: [Vec<f64>; 3],
    /// Samples that a piece begins with.
    pub starts: Vec<usize>,
}

impl PredictedRun {
    /// Position error of a model in counts RMS over the run's pieces.
    pub fn rms(&self, model: usize) -> f64 {
        let gaps = || self.gap_counts[model].iter().filter(|gap| gap.is_finite());
        let squares: f64 = gaps().map(|gap| gap * gap).sum();
        (squares / gaps().count().max(1) as f64).sqrt()
    }
}
