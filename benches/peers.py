"""The drive of benches/simulate.rs through solve_ivp, lsim and python-control, beside motorlab in the same run.

    pip install numpy scipy control
    cargo bench --bench simulate > bench.txt
    python benches/peers.py bench.txt

Prints samples simulated per second on one core and, with the bench's output given, motorlab's ratio to each peer:
the best of a few runs on either side, the peers' by processor time, so that what else the machine does disturbs little.
solve_ivp is RK45 at rtol 1e-6 with max_step = TS, each command level a call of its own. For each effect it gets that
effect's equations with every sign smoothed to tanh(w / 0.01 rad/s) and every contact to a stiff spring, which is
easier than the switching that motorlab locates; the linear and the Coulomb row have theirs as they stand.
"""

from math import exp, log, pi, sin, tanh
import re
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lsim

SAMPLE_TIME_S = 0.003
SAMPLES = 6300
LEVELS_V = [4.5, 0.0, -4.5, 1.5, -0.6, 3.0, -3.0, 0.3, 2.0, 0.9, -1.2, -2.2]
HOLD = 150
R, KB, KT, B, L, J, TF = 10.0, 0.7, 0.7, 0.01, 0.004, 0.002, 0.02


def command():
    return np.array([LEVELS_V[k // HOLD % len(LEVELS_V)] for k in range(SAMPLES)])


def linear(u):
    def rhs(_t, x):
        return (x[1], (KT * x[2] - B * x[1]) / J, (u - R * x[2] - KB * x[1]) / L)
    return rhs


def coulomb(u):
    def rhs(_t, x):
        w = x[1]
        net = KT * x[2] - B * w
        friction = TF * np.sign(w) if w != 0.0 else max(-TF, min(TF, net))
        return (w, (net - friction) / J, (u - R * x[2] - KB * w) / L)
    return rhs


def smooth(r=R, b=B, l=L, j=J, tf=TF, cut=0.0, gain=1.0):
    """The motor with Coulomb friction and other parameters."""
    def model(u):
        v = gain * u if abs(u) > cut else 0.0

        def rhs(_t, x):
            _, w, i = x
            return (w, (KT * i - b * w - tf * tanh(100 * w)) / j, (v - r * i - KB * w) / l)
        return rhs
    return model


def with_torque(torque):
    """`torque(angle, speed, current, sign)` beside everything."""
    def model(u):
        def rhs(_t, x):
            a, w, i = x
            s = tanh(100 * w)
            return (w, (KT * i - B * w - TF * s + torque(a, w, i, s)) / J, (u - R * i - KB * w) / L)
        return rhs
    return model


def with_current(rate):
    """`rate(u, speed, current)` instead of the winding's."""
    def model(u):
        def rhs(_t, x):
            _, w, i = x
            return (w, (KT * i - B * w - TF * tanh(100 * w)) / J, rate(u, w, i))
        return rhs
    return model


def limited(u, w, i):
    rate = (u - R * i - KB * w) / L
    return 0.0 if abs(i) >= 0.225 and rate * i > 0.0 else rate


def coasting(u, w, i):
    return (u - R * i - KB * w) / L if u else -i / 1e-4


def heating(u):
    def rhs(_t, x):
        _, w, i, p = x
        return (w, (KT * i - B * w - TF * tanh(100 * w)) / J, (u - R * (1 + 0.3 * p) * i - KB * w) / L,
                (i * i * R - p) / 11.0)
    return rhs


def ripple(u):
    def rhs(_t, x):
        a, w, i = x
        f = 1 + 0.05 * sin(12 * a)
        return (w, (KT * f * i - B * w - TF * tanh(100 * w)) / J, (u - R * i - KB * f * w) / L)
    return rhs


def presliding(u):
    def rhs(_t, x):
        _, w, i, f = x
        return (w, (KT * i - B * w - f) / J, (u - R * i - KB * w) / L, TF / 0.0195 * (w - abs(w) * f / TF))
    return rhs


def two_bodies(torque):
    j1 = j2 = J / 2

    def model(u):
        def rhs(_t, x):
            a1, w1, i, a2, w2 = x
            t = torque(a1 - a2, w1 - w2)
            return (w1, (KT * i - (B * w1 + TF * tanh(100 * w1)) / 2 - t) / j1, (u - R * i - KB * w1) / L,
                    w2, (t - (B * w2 + TF * tanh(100 * w2)) / 2) / j2)
        return rhs
    return model


def flanks(twist, rate):
    over = max(abs(twist) - 0.0195, 0.0)
    return (300.0 * over + 0.05 * abs(rate)) * (1 if twist > 0 else -1) if over else 0.0


def weakening(u):
    def rhs(_t, x):
        _, w, i, p = x
        f = 1 - 0.11 * p * R / 4.5 ** 2
        return (w, (KT * f * i - B * w - TF * tanh(100 * w)) / J, (u - R * i - KB * f * w) / L, (i * i * R - p) / 11.0)
    return rhs


def freewheeling(u):
    """The mean current of a pulse period in closed form, as in the catalogue; the winding has no state of its own then."""
    duty, period, sign = abs(u) / 4.5, 1.414, np.sign(u)

    def rhs(_t, x):
        _, w = x
        if not duty:
            return (w, (-B * w - TF * tanh(100 * w)) / J)
        on, off = (4.5 - KB * w * sign) / R, (-4.5 - KB * w * sign) / R
        until = log(max(1 - on * (1 - exp(-duty * period)) / off, 1e-9)) if off < 0 < on else 1.0
        lasts = until < (1 - duty) * period
        mean = duty * on + off * (until / period if lasts else 1 - duty)
        return (w, (KT * mean * sign - B * w - TF * tanh(100 * w)) / J)
    return rhs


def behind_the_encoder(rate):
    """A fourth number that the log follows: `rate(speed, number)`."""
    def model(u):
        def rhs(_t, x):
            _, w, i, y = x
            return (w, (KT * i - B * w - TF * tanh(100 * w)) / J, (u - R * i - KB * w) / L, rate(w, y))
        return rhs
    return model


SPRING = (2 * pi * 7.0) ** 2 * J / 4
DAMPER = 2 * 0.05 * 2 * pi * 7.0 * J / 4
# What only changes command, sensor or timing leaves the equations of Coulomb friction.
OUTSIDE = ["transport_delay", "resolution_error", "missed_counts", "encoder_eccentricity", "sample_jitter", "clock_error", "command_offset"]
EFFECTS = {
    "dead_zone": smooth(cut=0.85),
    "voltage_drop": with_current(lambda u, w, i: (u - 0.4 * tanh(1000 * i) - R * i - KB * w) / L),
    "supply_sag": lambda u: smooth(r=R + (u / 4.5) ** 2 * 2.2)(u),
    "supply_error": smooth(gain=0.9),
    "current_limit": with_current(limited),
    "coast_at_zero": with_current(coasting),
    "inductance": smooth(l=0.055),
    "winding_heating": heating,
    "torque_ripple": ripple,
    "coulomb_friction": smooth(tf=0.03),
    "viscous_friction": smooth(b=0.03),
    "inertia": smooth(j=0.0022),
    "stribeck": with_torque(lambda a, w, i, s: -0.022 * exp(-((w / 0.45) ** 2)) * s),
    "asymmetric_friction": with_torque(lambda a, w, i, s: -0.2 * TF),
    "presliding": presliding,
    "load_friction": with_torque(lambda a, w, i, s: -0.25 * abs(KT * i) * s),
    "quadratic_drag": with_torque(lambda a, w, i, s: -0.0014 * w * abs(w)),
    "gravity_load": with_torque(lambda a, w, i, s: -0.025 * sin(a)),
    "cogging": with_torque(lambda a, w, i, s: 0.022 * sin(12 * a)),
    "asymmetric_dead_zone": lambda u: smooth()(0.0 if -1.1 <= u <= 0.45 else u),
    "asymmetric_voltage_drop": with_current(
        lambda u, w, i: (u - 0.45 * tanh(1000 * i) + 0.225 * tanh(1000 * i) ** 2 - R * i - KB * w) / L),
    "asymmetric_gain": lambda u: smooth(gain=1 + 0.1 * np.sign(u))(u),
    "asymmetric_viscous": with_torque(lambda a, w, i, s: -0.3 * B * w * s),
    "magnet_weakening": weakening,
    "pwm_freewheel": freewheeling,
    "static_friction": with_torque(lambda a, w, i, s: -0.022 * exp(-((w / 0.01) ** 2)) * s),
    "constant_load": with_torque(lambda a, w, i, s: -0.01),
    "edge_rate_loss": behind_the_encoder(lambda w, y: w / (1 + (abs(w) * 720 / (2 * pi) / 755) ** 8.94)),
    "speed_filter": behind_the_encoder(lambda w, y: (w - y) / 0.0141),
    "slipping_clutch": two_bodies(lambda twist, rate: 0.1417 * tanh(100 * rate)),
    "backlash": two_bodies(flanks),
    "compliance": two_bodies(lambda twist, rate: SPRING * twist + DAMPER * rate),
} | {name: smooth() for name in OUTSIDE}


def three_effects(u):
    def rhs(_t, x):
        a, w, i = x
        friction = tanh(100 * w) * (TF + 0.022 * exp(-((w / 0.45) ** 2)))
        return (w, (KT * i - B * w - friction + 0.022 * sin(12 * a)) / J, (u - 0.4 * tanh(1000 * i) - R * i - KB * w) / L)
    return rhs


STATES = {"winding_heating": 4, "presliding": 4, "magnet_weakening": 4, "edge_rate_loss": 4, "speed_filter": 4,
          "pwm_freewheel": 2, "slipping_clutch": 5, "backlash": 5, "compliance": 5}


def through_solve_ivp(model, states=3):
    u, x = command(), np.zeros(states)
    for k in range(0, SAMPLES, HOLD):
        times = SAMPLE_TIME_S * np.arange(0, HOLD + 1)
        solution = solve_ivp(model(u[k]), (0.0, times[-1]), x, t_eval=times, rtol=1e-6, max_step=SAMPLE_TIME_S)
        x = solution.y[:, -1]


def state_space():
    a = [[0, 1, 0], [0, -B / J, KT / J], [0, -KB / L, -R / L]]
    return np.array(a), np.array([[0], [0], [1 / L]]), np.array([[1.0, 0, 0]]), np.array([[0.0]])


def through_lsim():
    lsim(state_space(), command(), SAMPLE_TIME_S * np.arange(SAMPLES), interp=False)


def through_control():
    import control
    control.forced_response(control.ss(*state_space()), SAMPLE_TIME_S * np.arange(SAMPLES), command())


def samples_per_second(run, repeats):
    return SAMPLES / min(_timed(run) for _ in range(repeats))


def _timed(run):
    start = time.process_time()
    run()
    return time.process_time() - start


def bench_rates(path):
    """Name -> samples per second of the fastest run, in divan's first column."""
    out, name = {}, None
    for line in open(path, encoding="utf-8"):
        named = re.match(r"^[│\s]*[├╰]─\s+(\w+)", line)
        if named:
            name = named.group(1)
        rates = re.findall(r"([\d.]+) ([MKG]?)item/s", line)
        if name and len(rates) == 4:
            out[name] = float(rates[0][0]) * {"": 1, "K": 1e3, "M": 1e6, "G": 1e9}[rates[0][1]]
    return out


def main():
    ours = bench_rates(sys.argv[1]) if len(sys.argv) > 1 else {}
    print("| peer, equations | samples/s | motorlab, the same | ratio |")
    print("| --- | --- | --- | --- |")
    rows = [
        ("lsim, linear", through_lsim, 5, "linear_second_order"),
        ("control.forced_response, linear", through_control, 5, "linear_second_order"),
        ("solve_ivp, linear", lambda: through_solve_ivp(linear), 3, "linear_second_order"),
        ("solve_ivp, Coulomb", lambda: through_solve_ivp(coulomb), 3, "coulomb_second_order"),
    ]
    for name, model in EFFECTS.items():
        run = lambda model=model, name=name: through_solve_ivp(model, STATES.get(name, 3))
        rows.append((f"solve_ivp, {name}", run, 2, name))
    rows.append(("solve_ivp, voltage_drop + stribeck + cogging", lambda: through_solve_ivp(three_effects), 2, "three_effects"))
    least = None
    for name, run, repeats, our_name in rows:
        rate = samples_per_second(run, repeats)
        our = ours.get(our_name)
        print(f"| {name} | {rate:.3g} | {f'{our:.3g}' if our else ''} | {f'{our / rate:.0f}' if our else ''} |", flush=True)
        if our and name.startswith("solve_ivp") and (least is None or our / rate < least[0]):
            least = (our / rate, name)
    if least:
        print(f"\nLeast of the ratios to solve_ivp: {least[0]:.0f}, {least[1]}.")


if __name__ == "__main__":
    main()
