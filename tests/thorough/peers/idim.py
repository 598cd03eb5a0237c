"""Identification of inertial and friction parameters with the inverse dynamic model and least squares.

After Gautier (1997), and Janot, Gautier, Brunot (2019): position filtered forward and backward by a low-pass, derivatives by central
differences, drive and regressors decimated, parameters by linear least squares.
"""
import numpy as np
from scipy.signal import butter, decimate, filtfilt

# Hz: of the low-pass on the position, well above the some 20 Hz of the axis' loop; its order; and a ratio of decimation that leaves 20 Hz.
CUTOFF_HZ, ORDER, RATIO = 100.0, 4, 25


def fit(run):
    """Inertia, viscous friction, Coulomb friction and offset in units of the drive, with the relative error of the drive."""
    step = float(np.median(np.diff(run.t)))
    b, a = butter(ORDER, CUTOFF_HZ * 2 * step)
    angle = filtfilt(b, a, run.counts * run.rad_per_count)
    speed = np.gradient(angle, step)
    acceleration = np.gradient(speed, step)
    # A few periods of the filter's edge are left out.
    inside = slice(100, -100)
    columns = np.column_stack([acceleration, speed, np.sign(speed), np.ones_like(speed)])[inside]
    columns = np.column_stack([decimate(column, RATIO, zero_phase=True) for column in columns.T])
    drive = decimate(run.drive[inside], RATIO, zero_phase=True)
    found, *_ = np.linalg.lstsq(columns, drive, rcond=None)
    error = np.linalg.norm(drive - columns @ found) / np.linalg.norm(drive)
    return dict(zip(("inertia", "viscous", "coulomb", "offset"), map(float, found))), float(error)
