"""One effect fitted with SciPy: least_squares on simulated counts, beside `cargo bench --bench diagnose`.

    pip install numpy scipy control
    python benches/diagnose_peer.py [SAMPLES]

The motor of benches/peers.py with Stribeck friction, its counts rounded; fitted are inertia, back EMF, friction,
damping and the two numbers of the effect, from 5 % off, by finite differences of solve_ivp (RK45, rtol 1e-6,
max_step = TS), as one would write it without a tool. A diagnosis fits every effect and pairs of them.
"""

from math import exp, pi, tanh
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from peers import B, HOLD, J, KB, KT, LEVELS_V, R, SAMPLE_TIME_S, TF, L

COUNTS_PER_RAD = 720 / (2 * pi)
TRUE = np.log([J, KB, TF, B, 0.02, 0.5])


def counts(logs, samples):
    j, kb, tf, b, extra, speed = np.exp(logs)
    x, out = [0.0, 0.0, 0.0], []
    for start in range(0, samples, HOLD):
        u = LEVELS_V[start // HOLD % len(LEVELS_V)]

        def rhs(_t, y):
            w, i = y[1], y[2]
            friction = (tf + extra * exp(-min((w / speed) ** 2, 50.0))) * tanh(100 * w)
            return (w, (KT * i - b * w - friction) / j, (u - R * i - kb * w) / L)

        n = min(HOLD, samples - start)
        times = SAMPLE_TIME_S * np.arange(n + 1)
        found = solve_ivp(rhs, (0.0, times[-1]), x, t_eval=times, rtol=1e-6, max_step=SAMPLE_TIME_S)
        out.append(found.y[0, :-1])
        x = found.y[:, -1]
    return np.concatenate(out) * COUNTS_PER_RAD


def main():
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 6300
    recorded = np.floor(counts(TRUE, samples))
    begin = time.perf_counter()
    fit = least_squares(lambda p: counts(p, samples) - recorded, TRUE + 0.05, diff_step=1e-4)
    took = time.perf_counter() - begin
    print(f"{samples} samples, one effect: {took:.1f} s, {fit.nfev} steps, {np.exp(fit.x[-2:])} for {np.exp(TRUE[-2:])}")


if __name__ == "__main__":
    main()
