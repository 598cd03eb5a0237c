"""Runs cut into segments that every tool simulates: the same commands, the same initial states, the same samples."""
import math
from dataclasses import dataclass

import numpy as np

from recordings import column, counts_per_rev, read

# s: step of every simulation here. The slowest sampled set has 10 ms, the fastest motor a time constant of some 20 ms.
STEP_S = 1e-3
# s: how much of the past a segment keeps, for commands that arrive late.
PAST_S = 0.3
# The initial state of a restart is that of a parabola through the samples this near, at least so many on each side.
NEAR_S, NEAR_SAMPLES = 0.015, 4


@dataclass
class Recording:
    name: str
    t: np.ndarray
    # What reached the motor, in the unit of the command: V, A or N m.
    drive: np.ndarray
    counts: np.ndarray
    rad_per_count: float
    # Known load: its torque at a right angle in N m, and its inertia in kg m2.
    torque_nm: float = 0.0
    inertia_kg_m2: float = 0.0


@dataclass
class Batch:
    """Segments of one length on a common grid; samples lie between grid points."""

    names: list
    # Commands per step, those of the past first: shape (segments, past + steps).
    drive: np.ndarray
    angle: np.ndarray
    speed: np.ndarray
    torque_nm: np.ndarray
    inertia_kg_m2: np.ndarray
    # Per segment: times from its start, counts, and the first sample that is scored.
    times: list
    counts: list
    rad_per_count: np.ndarray
    # s: when each begins in its run.
    begins: list
    first: int = 1
    past: int = round(PAST_S / STEP_S)
    # Of a servo in closed loop, per step: its goal in rad and its supply in V; and its duty per rad of error.
    goal: np.ndarray | None = None
    supply_v: np.ndarray | None = None
    duty_per_rad: np.ndarray | None = None

    @property
    def steps(self):
        return self.drive.shape[1] - self.past

    def driven(self, n, angle):
        """What drives step n: what was recorded, or what the servo makes of its goal and the simulated angle."""
        if self.goal is None:
            return self.drive[:, self.past + n]
        return np.clip(self.duty_per_rad * (self.goal[:, n] - angle), -1.0, 1.0) * self.supply_v[:, n]

    def errors(self, angles):
        """Predicted minus measured, in counts, of angles on the grid, shape (..., segments, steps + 1): shape (..., samples)."""
        out = []
        for k, (times, counts) in enumerate(zip(self.times, self.counts)):
            at = times[self.first :] / STEP_S
            below = np.minimum(at.astype(int), angles.shape[-1] - 2)
            part = at - below
            of_segment = angles[..., k, :]
            predicted = of_segment[..., below] * (1 - part) + of_segment[..., below + 1] * part
            out.append(predicted / self.rad_per_count[k] - counts[self.first :])
        return np.concatenate(out, axis=-1)


def recording(path, known=None):
    """A run file, with the drive that the program makes of command and measured supply."""
    head, names, _ = read(path)
    t = column(path, "t_s")
    drive = column(path, "command_v", "command_nm", "command_a")
    nominal = [float(line.split("=")[1]) for line in head if line.startswith("# supply_v")]
    if "supply_v" in names and nominal and not any("command_supply" in line for line in head):
        supply = column(path, "supply_v")
        # The reading at the end of an interval has seen the interval's current.
        drive = drive * np.append(supply[1:], supply[-1]) / nominal[0]
    of_load = {key: float(value) for key, value in (known or {}).items()}
    return Recording(path.stem, t - t[0], drive, column(path, "counts"), 2 * math.pi / counts_per_rev(path), **of_load)


def measured_state(run, at, near=None):
    """Angle in rad and speed in rad/s at a sample, of a parabola through the samples near it."""
    low, high = near or (
        min(np.searchsorted(run.t, run.t[at] - NEAR_S), max(0, at - NEAR_SAMPLES)),
        max(np.searchsorted(run.t, run.t[at] + NEAR_S), at + NEAR_SAMPLES + 1),
    )
    low, high = max(0, low), min(len(run.t), high)
    fit = np.polyfit(run.t[low:high] - run.t[at], run.counts[low:high], 2)
    return fit[2] * run.rad_per_count, fit[1] * run.rad_per_count


def batch(runs, restart_s=None, at_rest=False, lead=None):
    """Segments of the runs: each begins `restart_s` after the last, or is a whole run; the rest that is shorter is left out.

    Whole runs begin at rest if `at_rest`, else from their first samples; `lead` samples are the initial state, and not scored.
    """
    found = []
    for run in runs:
        whole = run.t[-1]
        length = restart_s or whole
        for k in range(max(1, math.floor(whole / length + 1e-9))):
            a = int(np.searchsorted(run.t, k * length - 1e-9))
            b = int(np.searchsorted(run.t, min(whole, run.t[a] + length) + 1e-9))
            if b - a > 2:
                found.append((run, a, b))
    steps = max(math.ceil((run.t[b - 1] - run.t[a]) / STEP_S + 1e-6) for run, a, b in found)
    past = round(PAST_S / STEP_S)
    drive, states = [], []
    for run, a, b in found:
        grid = run.t[a] + STEP_S * (np.arange(past + steps) - past)
        held = np.searchsorted(run.t, grid + 1e-9, side="right") - 1
        # Before a run that begins at rest nothing was commanded.
        before = 0.0 if at_rest and restart_s is None else run.drive[0]
        drive.append(np.where(held < 0, before, run.drive[np.clip(held, 0, len(run.drive) - 1)]))
        if at_rest and restart_s is None:
            states.append((run.counts[a] * run.rad_per_count, 0.0))
        else:
            states.append(measured_state(run, a, (a, a + lead) if lead else None))
    angle, speed = np.array(states).T
    return Batch(
        [run.name for run, _, _ in found],
        np.array(drive),
        angle,
        speed,
        np.array([run.torque_nm for run, _, _ in found]),
        np.array([run.inertia_kg_m2 for run, _, _ in found]),
        [run.t[a:b] - run.t[a] for run, a, b in found],
        [run.counts[a:b] for run, a, b in found],
        np.array([run.rad_per_count for run, _, _ in found]),
        [run.t[a] for run, a, _ in found],
        lead or 1,
    )
