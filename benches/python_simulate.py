"""Samples simulated per second from Python: 1,000 motors on the drive of `benches/simulate.rs`, in one call.

    python benches/python_simulate.py      # needs the package: pip install ./python

Hold it against `cargo bench --bench simulate batch_of_64_on_all_cores`, on the same computer at the same time.
"""

import time

import numpy as np

import motorlab as ml

SAMPLES = 6300
LEVELS_V = [4.5, 0.0, -4.5, 1.5, -0.6, 3.0, -3.0, 0.3, 2.0, 0.9, -1.2, -2.2]
MOTORS = 1000
TIMES = 7

t_s = np.arange(SAMPLES) * 0.003
command = np.array([LEVELS_V[k // 150 % 12] for k in range(SAMPLES)])
table = {"resistance_ohm": np.full(MOTORS, 10.0)}
took_s = []
for _ in range(TIMES):
    began = time.perf_counter()
    angles = ml.simulate(table, t_s=t_s, command=command)
    took_s.append(time.perf_counter() - began)
    assert angles.shape == (MOTORS, SAMPLES)
rate = MOTORS * SAMPLES / np.array(took_s) / 1e6
print(f"{np.median(rate):.1f} million samples/s (median of {TIMES}; {rate.min():.1f} to {rate.max():.1f})")
