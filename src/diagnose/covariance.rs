//! What a filter does not know: the covariance of position `p`, speed `v`, wander `d` and supply `g`.
//!
//! Over a sample it becomes `T C T'` with the transition `T`; a look at `p` with variance `S` takes `C e e' C / S` away. It
//! is symmetric: one half is kept. Where the supply is surely known its row is 0, and left out (`SUPPLIED`).

use super::response::Transition;

/// The covariance, element by element.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Covariance {
    pub pp: f64,
    pub pv: f64,
    pub pd: f64,
    pub vv: f64,
    pub vd: f64,
    pub dd: f64,
    pub pg: f64,
    pub vg: f64,
    pub dg: f64,
    pub gg: f64,
}

impl Covariance {
    /// `T C T'`: at the next sample, `input` being the acceleration for each unit of `g`.
    #[inline(always)]
    pub fn propagated<const SUPPLIED: bool>(&self, t: &Transition, input: f64) -> Self {
        let c = self;
        // Of p, v, x, d and g with the whole acceleration `x = d + input g`.
        let (xp, xv, xd, xx, xg) = if SUPPLIED {
            let (xd, xg) = (c.dd + input * c.dg, c.dg + input * c.gg);
            (
                c.pd + input * c.pg,
                c.vd + input * c.vg,
                xd,
                xd + input * xg,
                xg,
            )
        } else {
            (c.pd, c.vd, c.dd, c.dd, 0.0)
        };
        let next_p = |p: f64, v: f64, x: f64| p + t.pv * v + t.pd * x;
        let next_v = |v: f64, x: f64| t.vv * v + t.pv * x;
        // Of the next p with v and x of now, of the next v with them.
        let (p_v, p_x) = (next_p(c.pv, c.vv, xv), next_p(xp, xv, xx));
        let (v_v, v_x) = (next_v(c.vv, xv), next_v(xv, xx));
        let mut next = Self {
            pp: next_p(next_p(c.pp, c.pv, xp), p_v, p_x),
            pv: next_v(p_v, p_x),
            pd: t.dd * next_p(c.pd, c.vd, xd),
            vv: next_v(v_v, v_x),
            vd: t.dd * next_v(c.vd, xd),
            dd: t.dd * t.dd * c.dd,
            ..*c
        };
        if SUPPLIED {
            next.pg = next_p(c.pg, c.vg, xg);
            next.vg = next_v(c.vg, xg);
            next.dg = t.dd * c.dg;
        }
        next
    }

    /// Learns from a look at `p` whose innovation has this variance; gains of p, v, d and g.
    #[inline(always)]
    pub fn learn<const SUPPLIED: bool>(&mut self, variance: f64) -> [f64; 4] {
        let c = *self;
        // Written out: in a build without link-time optimisation a `map` over these is a call.
        let gain = [
            c.pp / variance,
            c.pv / variance,
            c.pd / variance,
            c.pg / variance,
        ];
        self.pp -= gain[0] * c.pp;
        self.pv -= gain[0] * c.pv;
        self.pd -= gain[0] * c.pd;
        self.vv -= gain[1] * c.pv;
        self.vd -= gain[1] * c.pd;
        self.dd -= gain[2] * c.pd;
        if SUPPLIED {
            self.pg -= gain[0] * c.pg;
            self.vg -= gain[1] * c.pg;
            self.dg -= gain[2] * c.pg;
            self.gg -= gain[3] * c.pg;
        }
        gain
    }
}
