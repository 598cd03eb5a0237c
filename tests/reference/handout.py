"""Reference trajectories of the lab handout's motor models.

The handout's figure: a step of 4.5 V at t = 0 from rest, 0 .. 0.3 s, printed every 0.0001 s.

    first order    J w' = Kt (u - Kb w) / R - b w - Tf sgn(w)
    second order   L i' = u - R i - Kb w,   J w' = Kt i - b w

and one run the handout does not have: the first order with Coulomb friction through steps that stop,
stick, fail to break away and reverse.

Every curve is computed twice: from its closed form in 50-digit arithmetic (mpmath), which is what is
written, and with scipy's solve_ivp at tight tolerances, which must agree. The largest difference
between the two is printed; the script fails when it exceeds 1e-9.

    python handout.py        writes handout/*.csv beside this file
"""

from pathlib import Path
import sys

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp

mp.mp.dps = 50

HANDOUT = dict(R=10.0, Kb=0.7, Kt=0.7, b=0.01, L=0.004, J=0.002, Tf=0.02)
FRICTIONLESS = dict(HANDOUT, b=0.0, Tf=0.0)
STEP_V = 4.5
AGREEMENT = 1e-9

# (from_s, volts): coast down and stick, reverse, brake into a stop below breakaway (0.2857 V),
# just below breakaway, just above it, full reversal without a stop in between, stop.
REVERSING = [
    (0.0, 4.5), (0.2, 0.0), (0.35, -3.0), (0.5, 0.2), (0.6, 0.28), (0.7, 0.35),
    (0.85, 4.5), (0.95, -4.5), (1.05, 0.0),
]
REVERSING_END_S = 1.2


def first_order_closed(p, u, w0, friction, t):
    """Speed and angle gained after `t` of w' = g u - a w - friction, started at w0."""
    R, Kb, Kt, b, J = (mp.mpf(p[k]) for k in ("R", "Kb", "Kt", "b", "J"))
    a = (b + Kt * Kb / R) / J
    rest = (Kt / R * mp.mpf(u) - friction) / (a * J)
    decay = mp.exp(-a * t)
    return rest + (w0 - rest) * decay, rest * t - (w0 - rest) * mp.expm1(-a * t) / a, rest, a


def first_order_step(p, times, friction_nm=0.0):
    out = []
    for t in times:
        w, th, _, _ = first_order_closed(p, STEP_V, mp.mpf(0), mp.mpf(friction_nm), mp.mpf(t))
        out.append((w, th))
    return out


def second_order_step(p, times):
    """Two real modes; the particular solution is the steady speed and current."""
    R, Kb, Kt, b, L, J = (mp.mpf(p[k]) for k in ("R", "Kb", "Kt", "b", "L", "J"))
    # x = (i, w);  x' = A x + B u.  A's eigenvalues s1, s2; w(0) = 0, w'(0) = 0.
    trace, det = -(R / L + b / J), (R * b + Kt * Kb) / (L * J)
    root = mp.sqrt(trace * trace - 4 * det)
    s1, s2 = (trace + root) / 2, (trace - root) / 2
    steady = Kt * mp.mpf(STEP_V) / (R * b + Kt * Kb)
    # w = steady + c1 e^(s1 t) + c2 e^(s2 t) with w(0) = w'(0) = 0
    c1, c2 = steady * s2 / (s1 - s2), -steady * s1 / (s1 - s2)
    out = []
    for t in times:
        t = mp.mpf(t)
        w = steady + c1 * mp.exp(s1 * t) + c2 * mp.exp(s2 * t)
        th = steady * t + c1 * mp.expm1(s1 * t) / s1 + c2 * mp.expm1(s2 * t) / s2
        out.append((w, th))
    return out


def reversing_closed(p, times):
    """First order with Coulomb friction, exactly: each arc is an exponential, and its stop is a logarithm."""
    R, Kt, Tf = mp.mpf(p["R"]), mp.mpf(p["Kt"]), mp.mpf(p["Tf"])
    arcs = []  # (start, end, u, w0, theta0, direction)
    w, th = mp.mpf(0), mp.mpf(0)
    ends = [mp.mpf(s) for s, _ in REVERSING[1:]] + [mp.mpf(REVERSING_END_S) + 1]
    stops = []
    for (start, u), end in zip(REVERSING, ends):
        t = mp.mpf(start)
        while t < end:
            drive = Kt / R * mp.mpf(u)
            if w == 0:
                direction = 0 if abs(drive) <= Tf else int(mp.sign(drive))
            else:
                direction = int(mp.sign(w))
            if direction == 0:
                arcs.append((t, end, u, mp.mpf(0), th, 0))
                break
            _, _, rest, a = first_order_closed(p, u, w, direction * Tf, mp.mpf(0))
            stop = mp.inf
            if w != 0 and mp.sign(rest) != direction:
                stop = t + mp.log((rest - w) / rest) / a
            leave = min(stop, end)
            arcs.append((t, leave, u, w, th, direction))
            w, gained, _, _ = first_order_closed(p, u, w, direction * Tf, leave - t)
            th += gained
            if stop <= end:
                w = mp.mpf(0)
                stops.append(stop)
            t = leave
    out, k = [], 0
    for t in times:
        t = mp.mpf(t)
        while k + 1 < len(arcs) and arcs[k + 1][0] <= t:
            k += 1
        start, _, u, w0, th0, direction = arcs[k]
        if direction == 0:
            out.append((mp.mpf(0), th0))
        else:
            w, gained, _, _ = first_order_closed(p, u, w0, direction * Tf, t - start)
            out.append((w, th0 + gained))
    return out, stops


def integrate_step(p, times, order, friction_nm):
    """The same step by solve_ivp; a step from rest never reverses, so sgn(w) = 1 throughout."""
    def first(_, x):
        return [x[1], (p["Kt"] * (STEP_V - p["Kb"] * x[1]) / p["R"] - p["b"] * x[1] - friction_nm) / p["J"]]

    def second(_, x):
        return [x[1], (p["Kt"] * x[2] - p["b"] * x[1]) / p["J"], (STEP_V - p["R"] * x[2] - p["Kb"] * x[1]) / p["L"]]

    rhs, x0 = (first, [0.0, 0.0]) if order == 1 else (second, [0.0, 0.0, 0.0])
    sol = solve_ivp(rhs, (0.0, times[-1]), x0, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-14, max_step=1e-3)
    assert sol.success, sol.message
    return sol.y[1], sol.y[0]


def integrate_reversing(p, times):
    """The reversing run by solve_ivp, its stops located as events."""
    level = p["Tf"] * p["R"] / p["Kt"]
    speed, angle = np.zeros(len(times)), np.zeros(len(times))
    x, t = [0.0, 0.0], 0.0
    ends = [s for s, _ in REVERSING[1:]] + [REVERSING_END_S + 1e-6]
    for (start, u), end in zip(REVERSING, ends):
        t = start
        while t < end:
            inside = (times >= t) & (times < end)
            if x[1] == 0.0 and abs(u) <= level:
                speed[inside], angle[inside] = 0.0, x[0]
                break
            direction = np.sign(x[1]) if x[1] != 0.0 else np.sign(u)

            def rhs(_, x):
                return [x[1], (p["Kt"] * (u - p["Kb"] * x[1]) / p["R"] - p["b"] * x[1] - p["Tf"] * direction) / p["J"]]

            def stop(_, x):
                return x[1]
            stop.terminal, stop.direction = True, -direction
            sol = solve_ivp(rhs, (t, end), x, method="DOP853", dense_output=True, events=stop,
                            rtol=1e-12, atol=1e-14, max_step=2e-3)
            inside &= times <= sol.t[-1]
            y = sol.sol(times[inside]) if inside.any() else np.zeros((2, 0))
            angle[inside], speed[inside] = y
            x = list(sol.y[:, -1])
            t = sol.t[-1]
            if sol.status == 1:
                x[1] = 0.0
    return speed, angle


def write(path, title, p, times, values, commands=None):
    with open(path, "w") as f:
        f.write(f"# {title}\n")
        for key, name in (("R", "resistance_ohm"), ("Kb", "back_emf_v_s_per_rad"), ("Kt", "torque_constant_nm_per_a"),
                          ("b", "viscous_friction_nm_s_per_rad"), ("L", "inductance_h"), ("J", "inertia_kg_m2"),
                          ("Tf", "coulomb_friction_nm")):
            f.write(f"# {name} = {p[key]}\n")
        f.write("t_s,speed_rad_s,angle_rad" + (",command_v" if commands else "") + "\n")
        for k, (t, (w, th)) in enumerate(zip(times, values)):
            row = f"{float(t)!r},{mp.nstr(w, 17)},{mp.nstr(th, 17)}"
            f.write(row + (f",{commands[k]}" if commands else "") + "\n")


def main():
    here = Path(__file__).parent / "handout"
    here.mkdir(exist_ok=True)
    times = np.arange(3001) / 10000
    worst = 0.0

    def check(name, closed, numeric):
        nonlocal worst
        dw = max(abs(float(c[0]) - n) for c, n in zip(closed, numeric[0]))
        dth = max(abs(float(c[1]) - n) for c, n in zip(closed, numeric[1]))
        worst = max(worst, dw, dth)
        print(f"{name:38s} closed form - solve_ivp: speed {dw:.1e} rad/s, angle {dth:.1e} rad")

    curves = [
        ("first_order_viscous", HANDOUT, 1, 0.0, "first order, viscous friction only"),
        ("second_order_viscous", HANDOUT, 2, 0.0, "second order, viscous friction only"),
        ("first_order_coulomb", HANDOUT, 1, HANDOUT["Tf"], "first order, viscous and Coulomb friction"),
        ("first_order_frictionless", FRICTIONLESS, 1, 0.0, "first order, no friction of any kind"),
        ("second_order_frictionless", FRICTIONLESS, 2, 0.0, "second order, no friction of any kind"),
    ]
    for name, p, order, friction, title in curves:
        used = dict(p, Tf=friction)
        if order == 1:
            used["L"] = 0.0
            closed = first_order_step(p, times, friction)
        else:
            closed = second_order_step(p, times)
        check(name, closed, integrate_step(p, times, order, friction))
        write(here / f"{name}.csv", f"{title}; step of {STEP_V} V at t = 0 from rest", used, times, closed)

    times = np.arange(1201) / 1000
    closed, stops = reversing_closed(HANDOUT, times)
    check("first_order_coulomb_reversing", closed, integrate_reversing(HANDOUT, times))
    print("  stops at", ", ".join(mp.nstr(s, 12) for s in stops))
    k, commands = 0, []
    for t in times:
        while k + 1 < len(REVERSING) and REVERSING[k + 1][0] <= t:
            k += 1
        commands.append(REVERSING[k][1])
    write(here / "first_order_coulomb_reversing.csv", "first order, viscous and Coulomb friction that sticks; command_v is in force from its row on",
          dict(HANDOUT, L=0.0), times, closed, commands)
    print(f"worst difference {worst:.1e} (allowed {AGREEMENT:.0e})")
    return 0 if worst < AGREEMENT else 1


if __name__ == "__main__":
    sys.exit(main())
