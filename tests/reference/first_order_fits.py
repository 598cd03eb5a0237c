"""Plain first-order fits by SciPy, which `tests/diagnosis/plain_fit.rs` compares motorlab's with.

    pip install numpy scipy
    python3 first_order_fits.py > fits/first_order.csv
    python3 first_order_fits.py ev3|three_levels FOLDER     # what it leaves of real steps from rest
    python3 first_order_fits.py run RUN.csv                 # of a run file of motorlab's, without friction

200 drawn motors, each with one step from rest: theta = K (u - F) (t - T (1 - exp(-t/T))), in rad, counted as
floor(theta N / 2 pi + phase). Each line has the motor, the recording and what SciPy's `least_squares` leaves of it, in
counts RMS: over the gain in rad/s/V, the time constant in s and where inside a count the shaft started, without friction,
which one level cannot tell from the gain. Starts: the slope at the end with the 63 % time, and four time constants.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

DRAWN = 200
rng = np.random.default_rng(20261126)


def log_uniform(low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def angle(gain, time_constant, volts, t):
    return gain * volts * (t + time_constant * np.expm1(-t / time_constant))


def fitted(t, volts, counts, per_rad):
    half = counts + 0.5

    def residual(p):
        gain, time_constant = np.exp(p[:2])
        return half - per_rad * angle(gain, time_constant, volts, t) - np.clip(p[2], 0.0, 1.0)

    tail = len(t) * 3 // 4
    slope = (counts[-1] - counts[tail]) / (t[-1] - t[tail])
    gain = max(slope, 1e-3) / per_rad / volts
    speed = np.gradient(counts.astype(float), t)
    rises = t[np.argmax(speed > 0.63 * slope)] if slope > 0 else t[1]
    starts = [max(rises, t[1])] + [share * t[-1] for share in (0.003, 0.02, 0.1, 0.4)]
    best = np.inf
    for time_constant in starts:
        found = least_squares(residual, [np.log(gain), np.log(time_constant), 0.5], method="lm", xtol=1e-12, ftol=1e-12)
        best = min(best, float(np.sqrt(np.mean(found.fun**2))))
    return best


def real_steps(kind, folder):
    """Steps from rest: times since the command, volts, counts, counts per rad."""
    for path in sorted(Path(folder).iterdir()):
        if kind == "ev3":
            rows = np.loadtxt(path, skiprows=1)
            yield rows[:, 0] - rows[0, 0], float(path.stem.split("_")[1]) / 100 * 7.5, rows[:, 1] - rows[0, 1], 180 / np.pi
        else:
            t, rpm = np.loadtxt(path, delimiter=",", unpack=True)
            counts = np.round(np.cumsum(rpm) * 32000 / 60 * 0.01)
            keep = t >= 1.9999
            counts = counts[keep] - counts[keep][0]
            yield t[keep] - 2.0, float(path.stem.split("_")[1][:-1]), counts, 32000 / (2 * np.pi)


def left_of_run(path):
    """Any commands, without friction: the steps of the command add up."""
    text = Path(path).read_text().splitlines()
    per_rev = next(float(line.split("=")[1]) for line in text if line.startswith("# counts_per_rev"))
    rows = [line.split(",") for line in text if not line.startswith("#")]
    at = [rows[0].index(name) for name in ("t_s", "command_v", "counts")]
    t, volts, counts = np.array([[float(row[k]) for k in at] for row in rows[1:]]).T
    steps = [(t[k], volts[k] - (volts[k - 1] if k else 0.0)) for k in range(len(t)) if volts[k] != (volts[k - 1] if k else 0.0)]

    def residual(p):
        turned = sum(angle(np.exp(p[0]), np.exp(p[1]), step, np.maximum(t - begins, 0.0)) for begins, step in steps)
        off = counts - counts[0] + 0.5 - per_rev / (2 * np.pi) * turned
        return off - np.clip(off.mean(), 0.0, 1.0)

    starts = [(gain, time_constant) for gain in (0.5, 2.0, 8.0) for time_constant in (0.02, 0.08, 0.3)]
    fits = [least_squares(residual, np.log(start), xtol=1e-12, ftol=1e-12) for start in starts]
    best = min(fits, key=lambda found: found.cost)
    print("run left_counts", np.sqrt(np.mean(best.fun**2)), "K, T", np.exp(best.x))


def left_of_real(kind, folder):
    runs = list(real_steps(kind, folder))

    def residual(p):
        gain, time_constant, friction = np.exp(p[0]), np.exp(p[1]), p[2]
        left = []
        for t, volts, counts, per_rad in runs:
            driven = np.sign(volts) * max(abs(volts) - friction, 0.0)
            off = counts + 0.5 - per_rad * angle(gain, time_constant, driven, t)
            left.append(off - np.clip(off.mean(), 0.0, 1.0))
        return np.concatenate(left)

    best = min(
        (
            least_squares(residual, [np.log(gain), np.log(time_constant), friction], method="trf", xtol=1e-12, ftol=1e-12)
            for gain in (0.5, 2.0, 8.0)
            for time_constant in (0.02, 0.08, 0.3)
            for friction in (0.0, 0.5, 2.0)
        ),
        key=lambda found: found.cost,
    )
    print(kind, "left_counts", np.sqrt(np.mean(best.fun**2)), "K, T, F", np.exp(best.x[:2]), best.x[2])


if len(sys.argv) == 3 and sys.argv[1] == "run":
    left_of_run(sys.argv[2])
    sys.exit()
if len(sys.argv) == 3:
    left_of_real(*sys.argv[1:])
    sys.exit()

print("gain_rad_s_v,time_constant_s,friction_v,command_v,counts_per_rev,phase,sample_time_s,samples,left_counts")
drawn = 0
while drawn < DRAWN:
    volts = float(rng.choice([3.0, 4.5, 6.0, 9.0, 12.0, 24.0]))
    gain = log_uniform(1.0, 60.0) * 4.5 / volts
    time_constant = log_uniform(0.008, 0.4)
    friction = float(rng.choice([0.0, log_uniform(0.01, 0.4)])) * volts
    per_rev = int(round(log_uniform(12, 8192)))
    sample_time = log_uniform(0.001, 0.03)
    samples = int(round(rng.uniform(1.0, 5.0) / sample_time))
    phase = float(rng.uniform())
    t = np.arange(samples) * sample_time
    per_rad = per_rev / (2 * np.pi)
    counts = np.floor(angle(gain, time_constant, volts - friction, t) * per_rad + phase)
    if counts[-1] < 3:
        continue
    left = fitted(t, volts, counts, per_rad)
    numbers = [gain, time_constant, friction, volts, per_rev, phase, sample_time, samples, round(left, 6)]
    print(",".join(repr(number) for number in numbers))
    drawn += 1
