"""One effect fitted with SciPy's least_squares, beside a whole diagnosis of the same counts in the same run.

    pip install numpy scipy
    cargo build --release
    python benches/diagnose_peer.py [SAMPLES] [MOTORLAB]

The motor of benches/peers.py with Stribeck friction, its counts rounded down; fitted are inertia, back EMF, friction,
damping and the two numbers of the effect, from 5 % off, by finite differences of solve_ivp (RK45, rtol 1e-6,
max_step = TS), as one would write it without a tool. With MOTORLAB, the program, it then gets the same counts and the
motor that the fit started from, and is not told the effect: it tries every effect and sets of them. Times are wall and
CPU; where the machine does something else as well, the ratio of CPU times is the one to trust.
"""

from math import exp, pi, tanh
import json
from pathlib import Path
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from peers import B, HOLD, J, KB, KT, LEVELS_V, R, SAMPLE_TIME_S, TF, L

COUNTS_PER_RAD = 720 / (2 * pi)
TRUE = np.log([J, KB, TF, B, 0.02, 0.5])
START = TRUE + 0.05


def levels(samples):
    return [LEVELS_V[k // HOLD % len(LEVELS_V)] for k in range(samples)]


def counts(logs, samples):
    """Unrounded counts of the motor with these six numbers (logarithms), from rest."""
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


def timed(who, work):
    """The result of `work`, its wall and its CPU time in s; `who` of resource.getrusage."""
    cpu = lambda: sum(resource.getrusage(who)[:2])
    begin, cpu_begin = time.perf_counter(), cpu()
    result = work()
    return result, time.perf_counter() - begin, cpu() - cpu_begin


def diagnose(program, recorded):
    """The diagnosis of these counts."""
    j, kb, tf, b, _, _ = np.exp(START)
    with tempfile.TemporaryDirectory() as directory:
        run, motor = Path(directory) / "run.csv", Path(directory) / "motor.toml"
        motor.write_text(
            f"resistance_ohm = {R}\nback_emf_v_s_per_rad = {kb}\ntorque_constant_nm_per_a = {KT}\n"
            f"viscous_friction_nm_s_per_rad = {b}\ninductance_h = {L}\ninertia_kg_m2 = {j}\n"
            f"coulomb_friction_nm = {tf}\ncounts_per_rev = 720\nsupply_v = 4.5\n")
        rows = [f"{k * SAMPLE_TIME_S:.6f},{u},{int(n)}" for k, (u, n) in enumerate(zip(levels(len(recorded)), recorded))]
        head = f'# format = "motorlab-run/1"\n# sample_time_s = {SAMPLE_TIME_S}\n# counts_per_rev = 720\n# complete = true\n'
        run.write_text(head + "t_s,command_v,counts\n" + "\n".join(rows) + "\n")
        command = [program, "diagnose", str(run), "--motor", str(motor), "--json"]
        return json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


def main():
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 6300
    recorded = np.floor(counts(TRUE, samples))
    # Rounding down leaves half a count on average.
    residual = lambda logs: counts(logs, samples) - 0.5 - recorded
    fit, wall, cpu = timed(resource.RUSAGE_SELF, lambda: least_squares(residual, START, diff_step=1e-4))
    print(f"{samples} samples, one effect fitted: {wall:.1f} s, CPU {cpu:.1f} s; {fit.nfev} steps, "
          f"{fit.nfev + fit.njev * len(START)} simulations, {np.exp(fit.x[-2:])} for {np.exp(TRUE[-2:])}")
    if len(sys.argv) > 2:
        found, wall_all, cpu_all = timed(resource.RUSAGE_CHILDREN, lambda: diagnose(sys.argv[2], recorded))
        print(f"all effects diagnosed: {wall_all:.1f} s, CPU {cpu_all:.1f} s; {found['verdict']} {found['effects']}")
        print(f"the one fit took {wall / wall_all:.1f} times as long, {cpu / cpu_all:.1f} times the CPU time")


if __name__ == "__main__":
    main()
