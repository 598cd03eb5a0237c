"""How far LuGre's bristles and Dahl's are apart in counts, over the drive of `effects.py`.

    python lugre.py        prints the table behind the decision on LuGre damping (docs/decisions), about 1 min

LuGre (Canudas de Wit, Olsson, Astrom, Lischinsky 1995): z' = w - s0 |w| z / g(w), F = s0 z + s1 z'. With s1 = 0 it is Dahl's law with
the friction g of steady sliding, which the catalogue has (`presliding`, with `stribeck` where g falls with speed). What is left is s1, the
bristles' damping, given here as the damping ratio of the inertia on them: s1 = 2 zeta sqrt(s0 J). All motors are integrated at once by
Runge and Kutta's rule of order 4 in steps of 0.2 ms; the last line says what half the step changes. What a refit leaves: R, Tf and the break-in
angle of Dahl's law fitted to LuGre's angle by Gauss and Newton.
"""

import numpy as np

from effects import SAMPLE_TIME_S, SAMPLES, drive
from hybrid import HANDOUT

SUBSTEPS = 15
COUNT_RAD = 2 * np.pi / HANDOUT["counts_per_rev"]
ROUNDING = 1 / np.sqrt(12)


def angles(bend_counts, damping_ratio, extra, resistance=1.0, friction=1.0, substeps=SUBSTEPS):
    """Angle in counts at every sample, a row a motor; `extra` is Stribeck's torque over Tf, at 0.5 rad/s."""
    p = HANDOUT
    shape = np.broadcast(bend_counts, damping_ratio, extra, resistance, friction).shape
    full = lambda x: np.broadcast_to(np.asarray(x, float), shape)
    r, tf = p["resistance_ohm"] * full(resistance), p["coulomb_friction_nm"] * full(friction)
    s0 = tf / (full(bend_counts) * COUNT_RAD)
    j = p["inertia_kg_m2"]
    s1 = 2 * full(damping_ratio) * np.sqrt(s0 * j)
    more = full(extra) * tf
    stribeck = bool(np.any(more > 0))
    kt, kb, b, l = (p[k] for k in ("torque_constant_nm_per_a", "back_emf_v_s_per_rad", "viscous_friction_nm_s_per_rad", "inductance_h"))

    def rate(x, u):
        _, w, i, z = x
        g = tf + more * np.exp(-((w / 0.5) ** 2)) if stribeck else tf
        dz = w - s0 * np.abs(w) * z / g
        return np.stack([w, (kt * i - b * w - s0 * z - s1 * dz) / j, (u - r * i - kb * w) / l, dz])

    command = np.zeros(SAMPLES)
    for k, u in drive():
        command[k:] = u
    h = SAMPLE_TIME_S / substeps
    x = np.zeros((4, *shape))
    out = np.empty((SAMPLES, *shape))
    for k in range(SAMPLES):
        out[k] = x[0]
        for _ in range(substeps):
            u = command[k]
            a = rate(x, u)
            c = rate(x + 0.5 * h * a, u)
            d = rate(x + 0.5 * h * c, u)
            e = rate(x + h * d, u)
            x = x + h / 6 * (a + 2 * (c + d) + e)
    return np.moveaxis(out, 0, -1) / COUNT_RAD


def main():
    bends, ratios, extras = (0.5, 2.0, 10.0), (0.1, 0.3, 1.0), (0.0, 1.5)
    cases = np.array([(z, zeta, e) for e in extras for z in bends for zeta in ratios])
    z, zeta, e = cases.T
    true = angles(z, zeta, e)
    plain = angles(z, 0.0, e)
    # Gauss and Newton in the logarithms of R, Tf and the break-in angle, all cases at once.
    p, step = np.zeros((3, len(cases))), 0.01
    for _ in range(2):
        shifts = np.concatenate([np.zeros((1, 3)), step * np.eye(3), -step * np.eye(3)])
        at = np.exp(p[None] + shifts[:, :, None])
        model = angles(z * at[:, 2], 0.0, e, at[:, 0], at[:, 1])
        for k in range(len(cases)):
            slopes = ((model[1:4, k] - model[4:7, k]) / (2 * step)).T
            by, *_ = np.linalg.lstsq(slopes, true[k] - model[0, k], rcond=None)
            p[:, k] += np.clip(by, -0.5, 0.5)
    at = np.exp(p)
    fitted = angles(z * at[2], 0.0, e, at[0], at[1])
    print("| break-in angle, counts | damping ratio | Stribeck, Tf | LuGre against Dahl, RMS | largest | after a refit, RMS | largest | break-in angle then |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    rms = lambda a: np.sqrt(np.mean(a**2))
    for k in range(len(cases)):
        before, after = true[k] - plain[k], true[k] - fitted[k]
        print(f"| {z[k]:g} | {zeta[k]:g} | {e[k]:g} | {rms(before):.3f} | {abs(before).max():.2f} | {rms(after):.3f} | {abs(after).max():.2f} | {z[k] * at[2, k]:.2f} |")
    finer = angles(z[:3], zeta[:3], e[:3], substeps=2 * SUBSTEPS)
    print(f"half the step changes {abs(finer - true[:3]).max():.1e} counts in the first three; rounding leaves {ROUNDING:.3f} RMS")


if __name__ == "__main__":
    main()
