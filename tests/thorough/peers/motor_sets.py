"""Sets of recordings of one motor each: SciPy, MuJoCo and motorlab on the same segments."""
import re

import page
import segments
import tools
from recordings import divided, imported, recordings

# s from restart to restart; none: whole runs. Commands of a closed loop do not answer to the error of a model, which would drift.
RESTART_S = {"ev3": None, "l298n": None, "odrive": 1.0, "sts3250": 1.0, "three_levels": None, "micromouse": None}
# Names of runs that say their load: grams on an arm of millimetres.
LOAD = re.compile(r"m(\d+)g_l(\d+)mm")
# m/s2
GRAVITY = 9.81


def load_of(name):
    """Torque at a right angle in N m and inertia in kg m2 of a point mass."""
    grams, millimetres = map(float, LOAD.search(name).groups())
    return {"torque_nm": GRAVITY * grams * millimetres * 1e-6, "inertia_kg_m2": grams * millimetres**2 * 1e-9}


class Division:
    """A set imported and divided: batches to fit and to predict, and the known loads for motorlab."""

    def __init__(self, motorlab, chosen, work, restart_s):
        self.chosen, self.restart_s = chosen, restart_s
        paths, _, _ = imported(motorlab, recordings(), chosen, work)
        self.paths = divided(paths, chosen["held"])
        self.names = [[path.name for path in of] for of in self.paths]
        self.loaded = bool(LOAD.search(paths[0].name))
        # The inertia of the load is in a motor file already.
        self.in_file = bool(chosen["diagnose"])
        self.known = []
        for name in self.names[0] + self.names[1] if self.loaded else ():
            load = load_of(name)
            self.known.append(f"{name}:gravity_torque_nm={load['torque_nm']:.6g}")
            if not self.in_file:
                self.known.append(f"{name}:inertia_added_kg_m2={load['inertia_kg_m2']:.6g}")

    def batches(self, restart_s=0.0, of_motorlab=False):
        """Segments to fit, and held-out ones."""
        found = []
        for of in self.paths:
            runs = [segments.recording(path, load_of(path.name) if self.loaded else None) for path in of]
            for run in runs:
                if of_motorlab and self.in_file:
                    run.inertia_kg_m2 = 0.0
            found.append(segments.batch(runs, self.restart_s if restart_s == 0.0 else restart_s, self.chosen["open_loop"]))
        return found


def protocol(division, held):
    whole = "Whole runs from rest" if division.chosen["open_loop"] else "Whole parts from their measured first state"
    how = f"Restarted every {division.restart_s:.3g} s from the measured state" if division.restart_s else whole
    runs = [len(names) for names in division.names]
    return f"{how}. Fitted to {runs[0]} runs; held out: {runs[1]} runs, {len(held.names)} segments, {sum(map(len, held.counts)):,} samples."


def part(motorlab, chosen, work):
    name = chosen["name"]
    division = Division(motorlab, chosen, work, RESTART_S[name])
    fitted, held = division.batches()
    # Parts that do not begin at rest: the first steps of a fit are easier on short segments.
    rough = division.batches(1.0)[0] if division.restart_s is None and not chosen["open_loop"] else None
    rows = tools.scipy_rows(fitted, rough, division.loaded)
    rows.append(tools.joint_row(fitted, rows[0].found, division.loaded, rough))
    tools.measured(rows, fitted, held)
    unit = tools.unit_of(division.paths[0][0])
    ours = tools.motorlab_rows(motorlab, work, chosen, division.names, division.known, unit)
    rows += tools.measured(ours, *division.batches(of_motorlab=True))
    text = [f"## {name}", "", f"{chosen['what'][0].upper()}{chosen['what'][1:]}. Source: {chosen['source']}. {protocol(division, held)}", ""]
    text += page.table(rows, "counts") + ["", f"![{name}: held-out errors of each tool]({name}.svg)"] + page.ahead(name, rows)
    drawing = page.picture(f"{name}: held-out position error", [(row.tool, row.held) for row in rows], "counts", page.curves(rows, held))
    return "\n".join(text), drawing, page.summary(rows, "counts")
