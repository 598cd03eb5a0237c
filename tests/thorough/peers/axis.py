"""EMPS, the electro-mechanical positioning system, by the rule of its benchmark: open loop from 20 initial samples."""
import numpy as np

import idim
import models
import page
import segments
import tools
from motor_sets import Division
from recordings import rms

# Samples of the initial state by the rule; s between restarts of the second measure.
INITIAL, RESTART_S = 20, 0.5
# mm: travel of a count (tests/real/maps/emps.toml: 2.5 mm and 50,000 counts a revolution).
PER_COUNT_MM = 2.5 / 50_000
# Of the benchmark, on its own test file (mm RMS).
PUBLISHED = {"dynoNet": "0.45 to 2.64, as reports differ", "pNARX": "5.17", "linear state space": "5.53", "ARX": "12.6", "LSTM": "74"}


def whole(division):
    """Both halves in open loop from their first samples."""
    return [segments.batch([segments.recording(path) for path in of], None, False, INITIAL) for of in division.paths]


def idim_row(division):
    """Its parameters in the first-order model: the offset is friction that differs by direction."""
    run = segments.recording(division.paths[0][0])
    with tools.Clock() as clock:
        found, residual = idim.fit(run)
    model = models.first_order(by_direction=True)
    x = np.log([found["inertia"], found["viscous"], found["coulomb"] + found["offset"], found["coulomb"] - found["offset"]])
    row = tools.of_model("IDIM least squares", "nothing", model, x, clock.cpu_s)
    row.lines = tools.lines(idim.fit, models.Model.simulate, models.first_order_step)
    row.note = f"relative error of the force {100 * residual:.2f} %"
    return row


def part(motorlab, chosen, work):
    division = Division(motorlab, chosen, work, None)
    fitted, held = whole(division)
    rough, restarted = division.batches(RESTART_S)
    rows = tools.scipy_rows(fitted, rough, False)
    rows.append(idim_row(division))
    rows.append(tools.joint_row(fitted, rows[0].found, False, rough))
    rows += tools.motorlab_rows(motorlab, work, chosen, division.names, (), "nm")
    tools.measured(rows, fitted, held)
    second = [rms(restarted.errors(row.simulate(restarted))) * PER_COUNT_MM for row in rows]
    text = ["## emps", "", f"{chosen['what'][0].upper()}{chosen['what'][1:]}. Source: {chosen['source']}.", ""]
    text += [
        f"The rule of the benchmark: open loop from {INITIAL} initial samples. Fitted to the first half, 12.4 s; held out: the second. The benchmark's",
        "own test file (PULSES) is not at hand. SciPy and MuJoCo are fitted to half-second segments, then in open loop to the whole first half;",
        "motorlab to its own segments.", "",
    ]  # fmt: skip
    extra = (f"restarted every {RESTART_S} s (mm RMS)", [page.figure(value) for value in second])
    text += page.table(rows, "mm", PER_COUNT_MM, extra) + ["", "![emps: held-out errors of each tool](emps.svg)"] + page.ahead("emps", rows)
    text += ["", "Published of the benchmark, fitted to the whole estimation file and tested on PULSES, so not comparable figure by figure:", ""]
    text += ["| method | mm RMS |", "| --- | --- |"] + [f"| {name} | {value} |" for name, value in PUBLISHED.items()]
    bars = [(row.tool, row.held * PER_COUNT_MM) for row in rows]
    drawing = page.picture("emps: held-out position error in open loop", bars, "mm", page.curves(rows, held, PER_COUNT_MM))
    return "\n".join(text), drawing, page.summary(rows, "mm", PER_COUNT_MM)
