//! Dry friction as a bristle model (LuGre; Canudas de Wit et al. 1995).
//!
//! `dz/dt = w - s0 |w| z / g`, `F = s0 z + s1(w) dz/dt`, with the torque `g` of steady sliding. `s1` decreases with
//! speed, which keeps the model passive. With a deflection of a hundredth of a count this is dry friction within the
//! encoder's resolution; with a larger one it is presliding.

/// One friction contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bristles {
    /// Stiffness s0 in N m/rad.
    stiffness: f64,
    /// Damping s1 at rest in N m s/rad.
    damping: f64,
    /// Mean deflection z in rad.
    deflection: f64,
}

/// Speed in rad/s at which the bristles' damping is halved.
const DAMPING_SPEED: f64 = 0.05;

impl Bristles {
    /// Bristles that slide at `torque_nm` after deflecting by `bend_rad`, with this damping ratio for `inertia`.
    pub(crate) fn new(torque_nm: f64, bend_rad: f64, inertia: f64, damping_ratio: f64) -> Self {
        let stiffness = torque_nm / bend_rad;
        Self {
            stiffness,
            damping: 2.0 * damping_ratio * (stiffness * inertia).sqrt(),
            deflection: 0.0,
        }
    }

    /// Torque of the deflected bristles, without their damping.
    pub(crate) fn force(&self) -> f64 {
        self.stiffness * self.deflection
    }

    /// Friction torque against the speed `w` after a step of `h` seconds; `sliding_nm` is g. Implicit in the
    /// deflection: stable for any speed.
    pub(crate) fn step(&mut self, w: f64, sliding_nm: f64, h: f64) -> f64 {
        if sliding_nm <= 0.0 {
            self.deflection = 0.0;
            return 0.0;
        }
        let next = (self.deflection + h * w) / (1.0 + h * self.stiffness * w.abs() / sliding_nm);
        let rate = (next - self.deflection) / h;
        self.deflection = next;
        let slowed = w / DAMPING_SPEED;
        self.stiffness * next + self.damping / (1.0 + slowed * slowed) * rate
    }
}
