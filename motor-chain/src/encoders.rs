//! Encoder readings along a motion at each sample, as an angle at the motor file's counts per revolution.

use crate::chain::Chain;
use crate::integrator::dense_output::Sample;
use crate::integrator::engine::Engine;
use crate::integrator::schedule::Reader;
use crate::reading::{MeanCounts, encoder_shaft};
use crate::scalar::Scalar;

/// The angle of an encoder before quantization.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AngleReading<S> {
    mean: MeanCounts<S>,
    rad_per_count: S,
    is_on_load: bool,
    /// Real seconds per second of the board's clock, and the lateness of a sample.
    clock_scale: S,
    late_s: S,
}

impl<S: Scalar> AngleReading<S> {
    /// For a chain whose shaft starts at this angle (rad) and speed (rad/s).
    pub fn new(chain: &Chain<S>, (angle_rad, speed_rad_s): (f64, f64)) -> Self {
        Self {
            mean: MeanCounts::new(chain.sensor, S::from(angle_rad), S::from(speed_rad_s)),
            rad_per_count: S::from(std::f64::consts::TAU) / chain.stated_counts_per_rev,
            is_on_load: chain.transmission.encoder_on_load,
            clock_scale: chain.timing.clock_scale,
            late_s: chain.timing.jitter_s * 0.5,
        }
    }

    /// Restarts at this angle and speed of the shaft.
    fn restart(&mut self, angle_rad: S, speed_rad_s: S, board_s: f64) {
        let at_s = self.clock_scale * board_s + self.late_s;
        self.mean.restart(angle_rad, speed_rad_s, at_s);
    }

    #[inline(always)]
    fn read<const N: usize>(&mut self, sample: &Sample<'_, S, N>, board_s: f64) -> S {
        // A rigid motor has one angle: its index is a constant.
        let shaft = encoder_shaft::<N>(self.is_on_load);
        let (clock_scale, late_s) = (self.clock_scale, self.late_s);
        let counts = (self.mean).read(
            sample.angle(shaft),
            || sample.speed(shaft),
            || clock_scale * board_s + late_s,
        );
        counts * self.rad_per_count
    }
}

/// Reader of one encoder: it needs the angle only, unless edges are lost.
pub(crate) struct Encoder<'a, S, E> {
    pub encoder: AngleReading<S>,
    /// Sample times from the first, on the board's clock.
    pub times_s: &'a [f64],
    /// Called with the index of the sample and the angle.
    pub emit: E,
}

impl<S: Scalar, const N: usize, E: FnMut(usize, S)> Reader<S, N> for Encoder<'_, S, E> {
    #[inline(always)]
    fn read(&mut self, k: usize, _: &Engine<S, N>, sample: &Sample<'_, S, N>) {
        (self.emit)(k, self.encoder.read(sample, self.times_s[k]));
    }

    fn restart(&mut self, k: usize, angle_rad: S, speed_rad_s: S) {
        (self.encoder).restart(angle_rad, speed_rad_s, self.times_s[k]);
    }
}
