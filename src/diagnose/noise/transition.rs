//! State transition of the prediction error between two samples, and its covariance (Kalman 1960).

use crate::diagnose::settings::solver::LAST_DIGITS;

/// From one sample to the next.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Transition {
    pub f01: f64,
    pub f02: f64,
    pub f11: f64,
    pub f22: f64,
    pub gain: [f64; 3],
    /// Reciprocal standard deviation of the innovation; 0 for the first sample of a segment.
    pub scale: f64,
}

impl Transition {
    /// The predicted errors of angle, speed and acceleration.
    pub fn ahead(&self, [x, v, d]: [f64; 3]) -> [f64; 3] {
        [
            x + self.f01 * v + self.f02 * d,
            self.f11 * v + self.f01 * d,
            self.f22 * d,
        ]
    }
}

/// Transitions, with the exponentials reused while the sample interval stays the same.
pub(crate) struct Transitions {
    time_constant_s: f64,
    correlation_s: f64,
    dt: f64,
    moving: Transition,
}

impl Transitions {
    pub fn new(time_constant_s: f64, correlation_s: f64) -> Self {
        Self {
            time_constant_s,
            correlation_s,
            dt: f64::NAN,
            moving: Transition::default(),
        }
    }

    pub fn step(&mut self, dt: f64, is_moving: bool) -> Transition {
        let is_same = (dt - self.dt).abs() <= LAST_DIGITS * dt;
        if !is_same {
            let a = 1.0 / self.time_constant_s;
            let e = (-a * dt).exp();
            let f01 = (1.0 - e) / a;
            self.dt = dt;
            self.moving = Transition {
                f01,
                f02: (dt - f01) / a,
                f11: e,
                f22: (-dt / self.correlation_s).exp(),
                ..Transition::default()
            };
        }
        if is_moving {
            return self.moving;
        }
        Transition {
            f22: self.moving.f22,
            ..Transition::default()
        }
    }
}

/// Covariance of the errors of angle, speed and acceleration; it is symmetric.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Covariance {
    pub xx: f64,
    pub xv: f64,
    pub xd: f64,
    pub vv: f64,
    pub vd: f64,
    pub dd: f64,
}

impl Covariance {
    /// `F P F'`.
    pub fn after(&self, f: &Transition) -> Self {
        let x = [
            self.xx + f.f01 * self.xv + f.f02 * self.xd,
            self.xv + f.f01 * self.vv + f.f02 * self.vd,
            self.xd + f.f01 * self.vd + f.f02 * self.dd,
        ];
        let v = [
            f.f11 * self.vv + f.f01 * self.vd,
            f.f11 * self.vd + f.f01 * self.dd,
        ];
        Self {
            xx: x[0] + f.f01 * x[1] + f.f02 * x[2],
            xv: f.f11 * x[1] + f.f01 * x[2],
            xd: f.f22 * x[2],
            vv: f.f11 * v[0] + f.f01 * v[1],
            vd: f.f22 * v[1],
            dd: f.f22 * f.f22 * self.dd,
        }
    }

    /// Updates with a measurement of the angle whose innovation has this reciprocal variance; returns the gain.
    pub fn update(&mut self, per_variance: f64) -> [f64; 3] {
        let by = [self.xx, self.xv, self.xd];
        let gain = by.map(|p| p * per_variance);
        self.xx -= gain[0] * by[0];
        self.xv -= gain[0] * by[1];
        self.xd -= gain[0] * by[2];
        self.vv -= gain[1] * by[1];
        self.vd -= gain[1] * by[2];
        self.dd -= gain[2] * by[2];
        gain
    }
}
