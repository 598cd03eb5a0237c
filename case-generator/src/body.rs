//! One rotating body: semi-implicit in speed, trapezoidal in angle, with dry friction of the bristle model.

use crate::friction::Bristles;

/// A body with its share of the friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    pub(crate) angle: f64,
    pub(crate) speed: f64,
    pub(crate) inertia: f64,
    pub(crate) share: f64,
    pub(crate) bristles: Bristles,
    /// Whether dry friction has been broken away since it last held.
    pub(crate) slides: bool,
}

impl Body {
    /// Dry friction in N m where static friction exceeds sliding friction: fully deflected bristles slide, and hold
    /// again when the speed reverses.
    pub(crate) fn friction_level(&mut self, holding_nm: f64, sliding_nm: f64) -> f64 {
        if holding_nm <= sliding_nm {
            return sliding_nm;
        }
        let bent = self.bristles.force().abs();
        if self.slides {
            self.slides = self.speed * self.bristles.force() > 0.0;
        } else {
            self.slides = bent > 0.999 * holding_nm * self.share;
        }
        if self.slides { sliding_nm } else { holding_nm }
    }

    /// Accelerates the body by `torque` minus its friction.
    pub(crate) fn step(&mut self, torque: f64, sliding_nm: f64, viscous: f64, h: f64) {
        let dry = self.bristles.step(self.speed, sliding_nm * self.share, h);
        let per_inertia = h / self.inertia;
        let before = self.speed;
        self.speed =
            (before + per_inertia * (torque - dry)) / (1.0 + per_inertia * viscous * self.share);
        self.angle += 0.5 * h * (before + self.speed);
    }
}
