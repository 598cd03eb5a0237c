"""The drive of benches/simulate.rs through solve_ivp, lsim and python-control, beside motorlab in the same run.

    pip install numpy scipy control
    cargo bench --bench simulate > /tmp/bench.txt
    python benches/peers.py /tmp/bench.txt

Prints samples simulated per second on one core and, with the bench's output given, motorlab's ratio to each peer.
solve_ivp is RK45 at rtol 1e-6 with max_step = TS, each command level its own call; it gets the same equations as the
effect it is compared with (sign functions smoothed by nothing: Coulomb friction by sgn(w), which chatters; the count
of samples per second is what such a simulation costs, not what it is worth).
"""

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


def stribeck(u):
    def rhs(_t, x):
        w = x[1]
        friction = np.tanh(w / 1e-3) * (TF + 0.02 * np.exp(-((w / 0.45) ** 2)))
        return (w, (KT * x[2] - B * w - friction) / J, (u - R * x[2] - KB * w) / L)
    return rhs


def cogging(u):
    def rhs(_t, x):
        w = x[1]
        return (w, (KT * x[2] - B * w - TF * np.tanh(w / 1e-3) + 0.02 * np.sin(12 * x[0])) / J, (u - R * x[2] - KB * w) / L)
    return rhs


def through_solve_ivp(model):
    u, x = command(), np.zeros(3)
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
    run()
    best = min(_timed(run) for _ in range(repeats))
    return SAMPLES / best


def _timed(run):
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def bench_medians(path):
    """Name -> samples per second, of divan's median column."""
    out, name = {}, None
    for line in open(path, encoding="utf-8"):
        cells = [c.strip() for c in line.split("│") if c.strip()]
        named = re.match(r"^[│\s]*[├╰]─\s+(\w+)", line)
        if named:
            name = named.group(1)
        rates = re.findall(r"([\d.]+) ([MKG]?)item/s", line)
        if name and len(rates) == 4 and cells:
            out[name] = float(rates[2][0]) * {"": 1, "K": 1e3, "M": 1e6, "G": 1e9}[rates[2][1]]
    return out


def main():
    ours = bench_medians(sys.argv[1]) if len(sys.argv) > 1 else {}
    print("| peer | samples/s | motorlab, the same equations | ratio |")
    print("| --- | --- | --- | --- |")
    rows = [
        ("solve_ivp, linear", lambda: through_solve_ivp(linear), 2, "linear_second_order"),
        ("solve_ivp, Coulomb", lambda: through_solve_ivp(coulomb), 1, "coulomb_second_order"),
        ("solve_ivp, Stribeck", lambda: through_solve_ivp(stribeck), 1, "stribeck"),
        ("solve_ivp, cogging", lambda: through_solve_ivp(cogging), 1, "cogging"),
        ("lsim, linear", through_lsim, 5, "linear_second_order"),
        ("control.forced_response, linear", through_control, 5, "linear_second_order"),
    ]
    linear_peer = None
    for name, run, repeats, our_name in rows:
        rate = samples_per_second(run, repeats)
        if name == "solve_ivp, linear":
            linear_peer = rate
        our = ours.get(our_name)
        beside = f"{our:.3g}" if our else ""
        ratio = f"{our / rate:.0f}" if our else ""
        print(f"| {name} | {rate:.3g} | {beside} | {ratio} |", flush=True)
    if ours and linear_peer:
        least = min((rate / linear_peer, name) for name, rate in ours.items())
        print(f"\nSlowest of the bench against solve_ivp on the linear chain: {least[1]}, {least[0]:.0f} times.")


if __name__ == "__main__":
    main()
