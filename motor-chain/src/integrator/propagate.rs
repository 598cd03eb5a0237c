//! One step of the equations in a mode.
//!
//! For affine equations `y(h) = E y + h phi1 n` is exact; else Krogstad's scheme of order 4. Products omit the
//! structural zeros and ones: nothing in the linear part of a rigid motor depends on its angle, the angle's row has
//! no `n`, and nonlinear torques are in the rows of speeds only, the back EMF in that of the current. The
//! contribution of the constant part of `n` is computed once per mode; stages within a step have only the states that
//! nonlinear terms depend on.
//!
//! Krogstad, Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005).

use crate::integrator::dynamics::{CUR, ONE_BODY, TH1, W1};
use crate::integrator::engine::Engine;
use crate::integrator::step_table::{Matrix, add, apply};
use crate::scalar::Scalar;

/// `E y`.
#[inline(always)]
pub(crate) fn advance<S: Scalar, const N: usize>(e: &Matrix<S, N>, y: &[S; N]) -> [S; N] {
    let mut out = *y;
    for (row, slot) in out.iter_mut().enumerate() {
        *slot = onto(y, row, moved(e, y, row));
    }
    out
}

/// `P n`.
#[inline(always)]
pub(crate) fn push<S: Scalar, const N: usize>(p: &Matrix<S, N>, n: &[S; N]) -> [S; N] {
    if N > ONE_BODY {
        return apply(p, n);
    }
    let mut out = [S::zero(); N];
    for (row, slot) in out.iter_mut().enumerate() {
        let mut sum = p[row][W1] * n[W1];
        for column in W1 + 1..N {
            sum += p[row][column] * n[column];
        }
        *slot = sum;
    }
    out
}

/// `A y` of a machine without a torque that depends on its angle.
#[inline(always)]
pub(crate) fn linear<S: Scalar, const N: usize>(a: &Matrix<S, N>, y: &[S; N]) -> [S; N] {
    if N > ONE_BODY {
        return apply(a, y);
    }
    push(a, y)
}

impl<S: Scalar, const N: usize> Engine<S, N> {
    /// Derivative of the present state, `A y + n`, and the state-dependent part of `n`.
    #[inline(always)]
    pub(crate) fn rate_in_parts(&self) -> ([S; N], [S; N]) {
        let a = &self.step_tables.in_force().a;
        let straight = add(linear(a, &self.y), &self.constant);
        if self.straight {
            return (straight, [S::zero(); N]);
        }
        let curved = self.machine.curved(&self.mode, a, &self.y);
        (add(straight, &curved), curved)
    }

    /// Contribution of the constant part of `n` to a step with `l` halvings, computed once for each mode.
    #[inline(always)]
    pub(crate) fn forced(&mut self, l: usize) -> &[S; N] {
        let (step_table, constant) = (self.step_tables.in_force(), &self.constant);
        self.forced[l].get_or_insert_with(|| push(&step_table.matrices(l).p1, constant))
    }

    /// The state after a step with `l` halvings, and an estimate of its error.
    #[inline(always)]
    pub(crate) fn propagate(&mut self, l: usize) -> ([S; N], f64) {
        if !self.straight {
            return self.propagate_curved(l);
        }
        let forced = *self.forced(l);
        let matrices = self.step_tables.in_force().matrices(l);
        (add(advance(&matrices.e, &self.y), &forced), 0.0)
    }

    /// The same for nonlinear equations, with nonlinear terms in these rows.
    #[inline(never)]
    fn propagate_curved(&mut self, l: usize) -> ([S; N], f64) {
        let load = N - 1;
        match (N, self.machine.bends_current) {
            (3, false) => self.curve(l, &[W1]),
            (3, true) => self.curve(l, &[W1, CUR]),
            (5, false) => self.curve(l, &[W1, load]),
            (5, true) => self.curve(l, &[W1, CUR, load]),
            (4, _) => self.curve(l, &[1, 2, 3]),
            _ => self.curve(l, &[1, 2, 3, 4, 5]),
        }
    }

    #[inline(always)]
    fn curve(&mut self, l: usize, bends: &[usize]) -> ([S; N], f64) {
        let half_forced = *self.forced(l + 1);
        let forced = *self.forced(l);
        let step_table = self.step_tables.in_force();
        let curved = |y: &[S; N]| self.machine.curved(&self.mode, &step_table.a, y);
        let (matrices, half) = (step_table.matrices(l), step_table.matrices(l + 1));
        let y = &self.y;
        let n0 = match self.end_rate_now() {
            Some(end) => &end.curved,
            None => &curved(y),
        };
        // Stages need only the states that nonlinear terms depend on.
        let read = self.machine.bends_by;
        let mut stage = *y;
        for (row, stage) in stage.iter_mut().enumerate().filter(|(row, _)| *row < read) {
            let by = along(&half.p1, n0, row, bends);
            *stage = onto(y, row, moved(&half.e, y, row) + half_forced[row] + by);
        }
        let n2 = curved(&stage);
        let mut d = [S::zero(); N];
        for &k in bends {
            d[k] = (n2[k] - n0[k]) * 2.0;
        }
        for (row, stage) in stage.iter_mut().enumerate().filter(|(row, _)| *row < read) {
            *stage += along(&half.p2, &d, row, bends);
        }
        let n3 = curved(&stage);
        for &k in bends {
            d[k] = (n3[k] - n0[k]) * 2.0;
        }
        let mut next = *y;
        for (row, next) in next.iter_mut().enumerate() {
            *next = moved(&matrices.e, y, row) + forced[row] + along(&matrices.p1, n0, row, bends);
            if row < read {
                stage[row] = onto(y, row, *next + along(&matrices.p2, &d, row, bends));
            }
        }
        let n4 = curved(&stage);
        let mut bend = [S::zero(); N];
        for &k in bends {
            let middle = n2[k] + n3[k];
            d[k] = middle * 2.0 - n0[k] * 3.0 - n4[k];
            bend[k] = (n0[k] - middle + n4[k]) * 4.0;
        }
        let mut error = 0.0_f64;
        for (row, next) in next.iter_mut().enumerate() {
            let curved = along(&matrices.p3, &bend, row, bends);
            *next = onto(
                y,
                row,
                *next + (along(&matrices.p2, &d, row, bends) + curved),
            );
            if row >= W1 {
                let mut gap = 0.0;
                for &k in bends {
                    gap += matrices.p2[row][k].value() * (n3[k].value() - n2[k].value());
                }
                error = error.max(curved.value().abs()).max(gap.abs());
            }
        }
        (next, error)
    }
}

/// A row of `E y`; for a rigid motor's angle only the increment, so that small terms are summed first.
#[inline(always)]
fn moved<S: Scalar, const N: usize>(e: &Matrix<S, N>, y: &[S; N], row: usize) -> S {
    let first = if N > ONE_BODY { TH1 } else { W1 };
    let mut sum = e[row][first] * y[first];
    for column in first + 1..N {
        sum += e[row][column] * y[column];
    }
    sum
}

/// The value of this row from the result of [`moved`] and what is added to it.
#[inline(always)]
fn onto<S: Scalar, const N: usize>(y: &[S; N], row: usize, sum: S) -> S {
    if N <= ONE_BODY && row == TH1 {
        y[TH1] + sum
    } else {
        sum
    }
}

/// A row of `P d` for a `d` with these rows only.
#[inline(always)]
fn along<S: Scalar, const N: usize>(
    p: &Matrix<S, N>,
    d: &[S; N],
    row: usize,
    numbers: &[usize],
) -> S {
    let (first, others) = (numbers[0], &numbers[1..]);
    let mut sum = p[row][first] * d[first];
    for &column in others {
        sum += p[row][column] * d[column];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::catalogue;
    use crate::chain::Chain;
    use crate::integrator::dynamics::Machine;
    use crate::integrator::engine::TICKS;
    use crate::scalar::Dual;
    use crate::{ActiveEffect, CommandKind, Model, Motor};

    /// The scheme with full matrix products and `n(y) = y' - A y`.
    fn plain<const N: usize>(engine: &Engine<Dual<4>, N>, l: usize) -> [Dual<4>; N] {
        let step_table = engine.step_tables.in_force();
        let (matrices, half) = (step_table.matrices(l), step_table.matrices(l + 1));
        let sum =
            |a: [Dual<4>; N], by: f64, b: [Dual<4>; N]| std::array::from_fn(|k| a[k] + b[k] * by);
        let n = |y: &[Dual<4>; N]| {
            let rate = engine.machine.rate(&engine.mode, y);
            sum(rate, -1.0, apply(&step_table.a, y))
        };
        let y = &engine.y;
        let n0 = n(y);
        let u2 = sum(apply(&half.e, y), 1.0, apply(&half.p1, &n0));
        let n2 = n(&u2);
        let n3 = n(&sum(u2, 2.0, apply(&half.p2, &sum(n2, -1.0, n0))));
        let base = sum(apply(&matrices.e, y), 1.0, apply(&matrices.p1, &n0));
        let n4 = n(&sum(base, 2.0, apply(&matrices.p2, &sum(n3, -1.0, n0))));
        let middle = sum(n2, 1.0, n3);
        let d = sum(sum(n0, -2.0 / 3.0, middle), 1.0 / 3.0, n4);
        let bend = sum(sum(n0, -1.0, middle), 1.0, n4);
        let next = sum(base, -3.0, apply(&matrices.p2, &d));
        sum(next, 4.0, apply(&matrices.p3, &bend))
    }

    /// The largest difference of a step in values and derivatives, and the number of nonlinear steps.
    fn apart<const N: usize>(machine: Machine<Dual<4>>) -> (f64, usize) {
        let mut engine = Engine::<Dual<4>, N>::new(machine, 0.006);
        let (mut largest, mut curved) = (0.0_f64, 0);
        for (n, level) in [4.5, -1.0, 0.1, -4.0].into_iter().enumerate() {
            engine.command(level, Dual::from(0.0));
            for k in 1..=30 {
                engine.go_to((30 * n as u64 + k) * TICKS);
                curved += usize::from(!engine.straight);
                if engine.straight {
                    continue;
                }
                let expected = plain(&engine, 2);
                for (found, expected) in engine.propagate(2).0.into_iter().zip(expected) {
                    let relative = |a: f64, b: f64| (a - b).abs() / b.abs().max(1.0);
                    largest = largest.max(relative(found.v, expected.v));
                    for (a, b) in found.d.into_iter().zip(expected.d) {
                        largest = largest.max(relative(a, b));
                    }
                }
            }
        }
        (largest, curved)
    }

    #[test]
    fn terms_skipped_by_a_step_are_zero() {
        let mut curved = 0;
        let sets = catalogue().iter().flat_map(|kind| {
            ["cogging", "backlash", "load_friction", "torque_ripple"].map(|other| [kind.id, other])
        });
        for set in sets {
            let mut motor = Motor::default();
            for id in set {
                let effect = ActiveEffect::from_keys(id, [], &motor.parameters).unwrap();
                motor.effects.set(effect);
            }
            let mut number = 0;
            let (model, kind) = (Model::SecondOrder, CommandKind::Voltage);
            let chain = Chain::new(&motor.parameters, &motor.effects, model, kind, |x| {
                number += 1;
                match number {
                    1..=4 => Dual::parameter(x, number - 1),
                    _ => Dual::from(x),
                }
            });
            let machine = Machine::new(chain);
            let (largest, steps) = match (machine.two, machine.warms()) {
                (false, false) => apart::<3>(machine),
                (false, true) => apart::<4>(machine),
                (true, false) => apart::<5>(machine),
                (true, true) => apart::<6>(machine),
            };
            assert!(largest < 1e-10, "{set:?}: {largest}");
            curved += steps;
        }
        assert!(curved > 1000, "{curved} steps");
    }
}
