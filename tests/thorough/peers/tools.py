"""Each tool is fitted to some segments of a set and simulates others. It gives rows of one table."""
import inspect
import re
import resource
import time
from dataclasses import dataclass, field

import numpy as np

import joint
import models
import motors
from recordings import read, rms

# A start of another tool is off by this factor: it is no answer.
START_OFF = 1.5


@dataclass
class Row:
    """A tool's motor: `simulate` gives the angles of a batch on its grid."""

    tool: str
    given: str
    free: int
    simulate: object
    cpu_s: float
    lines: int
    note: str = ""
    found: dict = field(default_factory=dict)
    # Errors in counts by sample: of the segments that it was fitted to, and of held-out ones.
    of_fit: object = None
    errors: object = None

    def measured(self, fitted, held):
        with np.errstate(all="ignore"):
            self.of_fit = fitted.errors(self.simulate(fitted))
            self.errors = held.errors(self.simulate(held))
        return self

    @property
    def fitted(self):
        return rms(self.of_fit)

    @property
    def held(self):
        return rms(self.errors)


class Clock:
    """Processor time of this process and of those that it started."""

    def __enter__(self):
        self.before = self.now()
        return self

    def __exit__(self, *_):
        self.cpu_s = self.now() - self.before

    @staticmethod
    def now():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.process_time() + used.ru_utime + used.ru_stime


def unit_of(path):
    """Of the command of a run file: v, nm or a."""
    return next(name.split("_")[1] for name in read(path)[1] if name.startswith("command_"))


def lines(*functions):
    """Lines that a user types who writes these functions: without blank lines, comments and descriptions."""
    count = 0
    for function in functions:
        text = re.sub(r'""".*?"""', "", inspect.getsource(function), flags=re.S)
        count += sum(bool(line.strip()) and not line.strip().startswith("#") for line in text.splitlines())
    return count


def of_model(tool, given, model, x, cpu_s, *functions):
    """A row of a model of models.py."""
    typed = lines(models.Model.simulate, models.Model.fit, *functions)
    found = {name: float(value[0, 0]) for name, value in model.values(x).items()}
    return Row(tool, given, len(model.names), lambda batch: model.simulate(x, batch)[0], cpu_s, typed, "", found)


def scipy_rows(fitted, rough, loaded):
    """First order, with friction by direction, and with a delay as well."""
    rows = []
    for by_direction, delay in ((False, False), (True, False), (True, True)):
        model = models.first_order(loaded, by_direction, delay)
        with Clock() as clock:
            x = model.fit(models.starts(model, rough or fitted), fitted, rough)
        given = "known load" if loaded else "nothing"
        rows.append(of_model(f"SciPy, {model.name}", given, model, x, clock.cpu_s, models.first_order_step, models.starts))
    return rows


def joint_row(fitted, first_order, loaded, rough=None):
    """MuJoCo's hinge, from the first-order fit's numbers times and over `START_OFF`: on a rough batch first, where there is one."""
    per = first_order.get("per_torque", 1.0)
    p = {"armature": first_order["lag"] / per, "damping": first_order["viscous"] / per, "friction": first_order["friction"] / per}
    starts = [{name: value * scale for name, value in p.items()} | {"gain": 1.0 / per} for scale in (START_OFF, 1.0 / START_OFF)]
    with Clock() as clock:
        p = joint.fit(rough or fitted, starts, loaded)
        if rough:
            p = joint.fit(fitted, [p], loaded)
    typed = lines(joint.spec, joint.modifiers, joint.fit, joint.improved) + joint.HINGE.strip().count("\n") + 1
    given = ("known load; " if loaded else "") + "two starts within 50 %"
    return Row("MuJoCo sysid, hinge", given, 3 + loaded, lambda batch: joint.simulate(p, batch), clock.cpu_s, typed, "", p)


def motorlab_rows(program, work, chosen, names, known, unit):
    """Nominal, re-identified, and with the effects of the verdict."""
    flags = chosen["diagnose"]
    given = ("a motor file" if flags else "nothing") + ("; known load" if known else "")
    # Two lines: import and diagnose.
    row = lambda shown, free, motor, cpu_s: Row(f"motorlab, {shown}", given, free, motor.simulate, cpu_s, 2)  # noqa: E731
    rows = [row("nominal", 0, motors.Motor(program, work / flags.split()[1], work, unit), 0.0)] if flags else []
    for shown, name in (("re-identified", "parameters"), ("with effects", "effects")):
        with Clock() as clock:
            document, file = motors.diagnosed(program, work, *names, flags, known, name)
        effects = document["effects"] or sorted({one["members"][0] for one in document["classes"]})
        free = len(document["base"]) + sum(len(cause["parameters"]) for cause in document["causes"] if cause["effect"] in effects)
        rows.append(row(shown, free, motors.Motor(program, file, work, unit), clock.cpu_s))
        rows[-1].note = document["verdict"] + (": " + ", ".join(effects).replace("_", " ") if effects else "") if name == "effects" else ""
    return rows


def measured(rows, fitted, held):
    return [row.measured(fitted, held) for row in rows]
