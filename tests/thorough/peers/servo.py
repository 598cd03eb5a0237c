"""XL-330, a servo that lifts a known pendulum: the published friction models M1 to M6 beside the other tools, restarted and in closed loop."""
import re

import numpy as np

import models
import page
import segments
import tools
from motor_sets import Division, protocol
from recordings import recordings, rms

RESTART_S = 1.0
# Of the servo's position loop: the duty is the gain in the name of a run times this for each rad of error, of full drive 885. It is the
# slope of the logged duty over the logged error: 2.52 to 2.55 in eight runs.
DUTY_PER_RAD = 2.54 / 885
# V: the mapping's nominal supply (tests/real/maps/xl330.toml).
SUPPLY_V = 7.4
# With the parameters that the authors publish, which they fitted to their own division of the same logs (mrad in closed loop, mean absolute;
# counts restarted every second, all eight runs).
PUBLISHED = {"M1": (67, 208), "M2": (67, 209), "M3": (53, 140), "M4": (53, 177), "M5": (58, 152), "M6": (57, 157)}


def log(name):
    """Columns of the log of a run."""
    path = recordings() / "xl330" / f"{name}.csv"
    return np.genfromtxt(path, delimiter=",", names=True)


def on_grid(batch, k, of, name):
    """A column of the log, held, on the grid of a segment; `of` is when the segment begins in s."""
    rows = log(name)
    t = rows["t_s"] - rows["t_s"][0]
    grid = of + segments.STEP_S * np.arange(batch.steps)
    return {column: rows[column][np.clip(np.searchsorted(t, grid + 1e-9, side="right") - 1, 0, len(t) - 1)] for column in ("goal_rad", "torque_enable", "vin_V")}


def switched_off(batch):
    """Steps in which the bridge is off, by the log: shape (segments, steps)."""
    return np.array([on_grid(batch, k, batch.begins[k], name)["torque_enable"] == 0 for k, name in enumerate(batch.names)])


def kept(batch, which):
    """The segments of a batch that are to be kept."""
    found = segments.Batch(**vars(batch))
    for name in ("drive", "angle", "speed", "torque_nm", "inertia_kg_m2", "rad_per_count"):
        setattr(found, name, getattr(batch, name)[which])
    for name in ("names", "times", "counts", "begins"):
        setattr(found, name, [one for one, wanted in zip(getattr(batch, name), which) if wanted])
    return found


def closed(batch):
    """A batch of whole runs whose drive follows from the goal and the simulated angle by the servo's law."""
    columns = [on_grid(batch, k, 0.0, name) for k, name in enumerate(batch.names)]
    gains = [float(re.search(r"kp(\d+)", name).group(1)) * DUTY_PER_RAD for name in batch.names]
    batch.goal = np.array([one["goal_rad"] for one in columns])
    batch.duty_per_rad = np.array(gains)
    batch.supply_v = np.array([one["vin_V"] for one in columns])
    return batch


def servo_rows(fitted):
    """M1 to M6; each begins at what a simpler one found."""
    rows, before = [], {}
    for which, simpler in (("M1", None), ("M2", "M1"), ("M3", "M1"), ("M4", "M3"), ("M5", "M4"), ("M6", "M5")):
        model = models.servo(which)
        with tools.Clock() as clock:
            x = model.fit(models.servo_starts(model, before.get(simpler)), fitted)
        row = tools.of_model(which, "known load; when the bridge is off", model, x, clock.cpu_s, models.servo, models.servo_starts)
        before[which] = dict(row.found)
        if which == "M4":
            # M5 has the load of M4 on both sides.
            before[which] |= {"motor": row.found["load"], "external": row.found["load"]}
            before[which] |= {"stribeck_motor": row.found["stribeck_load"], "stribeck_external": row.found["stribeck_load"]}
        rows.append(row)
    return rows


def part(motorlab, chosen, work):
    division = Division(motorlab, chosen, work, RESTART_S)
    fitted, held = division.batches()
    off = switched_off(fitted)
    powered = kept(fitted, ~off.any(axis=1))
    told = segments.Batch(**vars(fitted))
    told.drive = fitted.drive.copy()
    told.drive[:, told.past :][off] = np.nan
    rows = tools.measured(servo_rows(told), told, held)
    of_scipy = tools.scipy_rows(powered, None, True)
    rows += tools.measured(of_scipy + [tools.joint_row(powered, of_scipy[0].found, True)], powered, held)
    ours = tools.motorlab_rows(motorlab, work, chosen, division.names, division.known, "v")
    fitted_ours, held_ours = division.batches(of_motorlab=True)
    rows += tools.measured(ours, fitted_ours, held_ours)
    loops = []
    for row in rows:
        of_loop = closed(division.batches(None, of_motorlab=row in ours)[1])
        errors = of_loop.errors(row.simulate(of_loop)) * of_loop.rad_per_count[0]
        loops.append(page.figure(1e3 * float(np.mean(np.abs(errors)))))
    per_count = 1e3 * held.rad_per_count[0]
    text = ["## xl330", "", f"{chosen['what'][0].upper()}{chosen['what'][1:]}. Source: {chosen['source']}. {protocol(division, held)}", ""]
    text += [
        "M1 to M6 are the friction models of Duclusaud, Passault, Padois and Ly (2024), by their formulas, fitted here; they get the log's column",
        "`torque_enable`, which is 0 where the bridge is off. SciPy and MuJoCo are fitted to the segments in which it is 1. motorlab gets the whole runs: its import has no such",
        f"column. In no held-out run is the bridge off. A count is {per_count:.2f} mrad. Closed loop: whole held-out runs from the logged goal, with the",
        "servo's law (duty = 2.54 x gain x error in rad, of 885).", "",
    ]  # fmt: skip
    text += page.table(rows, "counts", 1.0, ("closed loop (mrad, mean absolute)", loops))
    text += ["", "![xl330: held-out errors of each tool](xl330.svg)"] + page.ahead("xl330", rows)
    text += ["", "With the published parameters, which their authors fitted to logs that include these, over all eight runs:", ""]
    text += ["| model | closed loop (mrad, mean absolute) | restarted every second (counts RMS) |", "| --- | --- | --- |"]
    text += [f"| {name} | {loop} | {counts} |" for name, (loop, counts) in PUBLISHED.items()]
    bars = [(row.tool, rms(row.errors)) for row in rows]
    drawing = page.picture("xl330: held-out position error, restarted every second", bars, "counts", page.curves(rows, held))
    return "\n".join(text), drawing, page.summary(rows, "counts")
