"""One long recording for the question how the time of a diagnosis grows with the samples.

    python long_runs.py DIR SECONDS...

The handout's motor by the equations of diagnosis_cases.py, levels in both directions at 3 ms with wander, rounded down:
for every SECONDS DIR/none-SECONDS.csv and DIR/stribeck-SECONDS.csv, and DIR/motor.toml, the motor without the effect and 3 %
off. An hour, 1,200,000 samples, takes minutes to make and some 60 MB. Then, on one thread, with its CPU time and memory:

    RAYON_NUM_THREADS=1 /usr/bin/time -v motorlab diagnose DIR/stribeck-3600.csv --motor DIR/motor.toml
"""

from pathlib import Path
import sys

import numpy as np

from diagnosis_cases import HANDOUT, four_digits, levels, motor_file, read_out, run_file

LAW = dict(friction="tanh", stribeck="gauss", wander_slope=1.0, wander_relative=0.002, restitution_s_per_rad=0.5)
EFFECTS = {
    "none": {},
    "stribeck": {"stribeck": dict(extra_torque_nm=four_digits(1.5 * HANDOUT["coulomb_friction_nm"]), stribeck_speed_rad_s=0.5)},
}


def main():
    directory = Path(sys.argv[1])
    directory.mkdir(parents=True, exist_ok=True)
    nominal = {key: four_digits(value * (1.03 if k % 2 else 0.97)) for k, (key, value) in enumerate(HANDOUT.items())}
    (directory / "motor.toml").write_text(motor_file(nominal))
    for seconds in map(float, sys.argv[2:]):
        profile = ("multi-level", 0.003, levels(HANDOUT, round(seconds / 0.003), np.random.default_rng(7)))
        for name, effects in EFFECTS.items():
            run = run_file(profile, *read_out(HANDOUT, effects, LAW, profile, 7))
            (directory / f"{name}-{seconds:g}.csv").write_text(run)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main()
