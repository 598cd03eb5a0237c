//! How the position of a run answers to an acceleration, from sample to sample.
//!
//! In counts, with a speed error that dies away at the rate `a` and an acceleration `d` held from one sample to the next:
//!
//! `p' = v,  v' = -a v + d`
//!
//! While the shaft rests, friction holds it: `p` stays and `v` is nought. It is the same for every level of the noise, so
//! that the filters of all levels share it.

use std::sync::Arc;

use super::data::RunData;
use super::noise::WANDER_S;

/// From one sample to the next: `p += pv v + pd d`, `v = vv v + pv d`; a wander forgets by the factor `dd`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transition {
    pub pv: f64,
    pub pd: f64,
    pub vv: f64,
    pub dd: f64,
}

impl Transition {
    fn new(dt_s: f64, damping: f64, moving: bool) -> Self {
        let dd = (-dt_s / WANDER_S).exp();
        if !moving {
            return Self {
                pv: 0.0,
                pd: 0.0,
                vv: 0.0,
                dd,
            };
        }
        let a = damping.max(1e-3);
        let pv = -(-a * dt_s).exp_m1() / a;
        Self {
            pv,
            pd: (dt_s - pv) / a,
            vv: (-a * dt_s).exp(),
            dd,
        }
    }
}

/// How the position of a run answers to an acceleration: the columns of effects that are linear in their magnitude.
#[derive(Debug, Clone)]
pub(super) struct Response {
    /// To each sample from the one before; to the first in no time.
    transitions: Arc<[Transition]>,
}

impl Response {
    /// Of a run, speed errors dying away at the rate `damping` in 1/s.
    pub fn of(run: &RunData, damping: f64) -> Self {
        let transition = |k: usize| {
            let before_s = run.t_s[k.saturating_sub(1)];
            Transition::new(run.t_s[k] - before_s, damping, run.moving[k])
        };
        Self {
            transitions: (0..run.len()).map(transition).collect(),
        }
    }

    /// To each sample from the one before.
    pub fn transitions(&self) -> &[Transition] {
        &self.transitions
    }

    /// Positions in counts under an acceleration in counts/s^2 that is in force from each sample to the next.
    pub fn to(&self, acceleration: &[f64]) -> Vec<f64> {
        let (mut p, mut v) = (0.0, 0.0);
        let mut out = Vec::with_capacity(acceleration.len());
        out.push(p);
        for (t, d) in self.transitions.iter().skip(1).zip(acceleration) {
            (p, v) = (p + t.pv * v + t.pd * d, t.vv * v + t.pv * d);
            out.push(p);
        }
        out
    }
}
