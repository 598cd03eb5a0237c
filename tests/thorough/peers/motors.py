"""motorlab: a diagnosis by the program, and its motors as C functions, which begin at any state."""
import ctypes
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np

from recordings import run
from segments import STEP_S

# Nothing is identified above a probability of 1: the program then writes the motor with re-identified parameters.
NOTHING_IDENTIFIED = "identified = 2.0\n"
# V s/rad: of an axis whose drive controls current or torque; its back-EMF has no part in the motion.
NO_BACK_EMF = 1e-9

PLAY = """
#include "motor.c"
/* Plays held commands from a state; a pendulum's torque is held over a step. With a goal the command is the servo's: clipped duty times supply. */
void play(int past, int steps, const double *drive, double per_drive, double angle, double speed, double torque_nm, const double *goal,
          const double *supply, double duty_per_rad, double *out)
{
    motor_state s;
    int n;
    motor_start(&s);
    s.y[0] = angle;
    s.y[1] = speed;
    for (n = 0; n < N_STATE; n++) if (n == LOAD_ANGLE) { s.y[n] = angle; s.y[n + 1] = speed; }
    for (n = 0; n < N_HISTORY; n++) s.history[n] = per_drive * drive[past - N_HISTORY + n < 0 ? 0 : past - N_HISTORY + n];
    out[0] = motor_encoder_angle(&s);
    for (n = 0; n < steps; n++) {
        double volts = drive[past + n];
        if (goal) volts = fmax(-1.0, fmin(1.0, duty_per_rad * (goal[n] - out[n]))) * supply[n];
        s.load_nm = -torque_nm * sin(motor_angle(&s));
        motor_step(&s, per_drive * volts);
        out[n + 1] = motor_encoder_angle(&s);
    }
}
"""


class Motor:
    """A motor file, compiled. Effects of the sensor and of the timing are not in it (docs/reference/export.md)."""

    def __init__(self, program, file, work, unit):
        self.program, self.file, self.work, self.unit = program, Path(file), Path(work), unit
        self.libraries = {}

    def library(self, inertia):
        """The motor with a load of that inertia: its function, and volts per unit of the drive."""
        if inertia not in self.libraries:
            folder = self.work / f"{self.file.stem}_{len(self.libraries)}"
            folder.mkdir(exist_ok=True)
            text = self.file.read_text()
            value = {key: float(found) for key, found in re.findall(r"^(\w+) = ([-\d.e]+)$", text.split("[")[0], re.M)}
            per_drive = 1.0
            text = re.sub(r"^inertia_kg_m2 = .*$", f"inertia_kg_m2 = {value['inertia_kg_m2'] + float(inertia)!r}", text, count=1, flags=re.M)
            if self.unit != "v":
                text = re.sub(r"^back_emf_v_s_per_rad = .*$", f"back_emf_v_s_per_rad = {NO_BACK_EMF}", text, count=1, flags=re.M)
                text = re.sub(r"^inductance_h = .*$", "inductance_h = 0.0", text, count=1, flags=re.M)
                per_drive = value["resistance_ohm"] / (value["torque_constant_nm_per_a"] if self.unit == "nm" else 1.0)
            (folder / "motor.toml").write_text(text)
            run(self.program, "export", "c", "--motor", "motor.toml", "--step-time", str(STEP_S), "-o", "motor.c", "--force", work=folder)
            names = re.search(r"The state: y has (.*?)\. All zeros", (folder / "motor.c").read_text()).group(1).split(", ")
            load = names.index("load_angle") if "load_angle" in names else -1
            (folder / "play.c").write_text(f"#define LOAD_ANGLE {load}\n{PLAY}")
            subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", "play.so", "play.c", "-lm"], cwd=folder, check=True)
            play = ctypes.CDLL(str(folder / "play.so")).play
            double, array = ctypes.c_double, np.ctypeslib.ndpointer(float, flags="C")
            play.argtypes = [ctypes.c_int, ctypes.c_int, array, double, double, double, double, ctypes.c_void_p, ctypes.c_void_p, double, array]
            self.libraries[inertia] = play, per_drive
        return self.libraries[inertia]

    def simulate(self, batch):
        """Angles on the grid: shape (segments, steps + 1)."""
        out = np.empty((len(batch.names), batch.steps + 1))
        for k in range(len(batch.names)):
            play, per_drive = self.library(batch.inertia_kg_m2[k])
            drive = np.ascontiguousarray(batch.drive[k])
            goal, supply, duty_per_rad = None, None, 0.0
            if batch.goal is not None:
                goal, supply, duty_per_rad = batch.goal[k].ctypes.data, batch.supply_v[k].ctypes.data, batch.duty_per_rad[k]
            play(batch.past, batch.steps, drive, per_drive, batch.angle[k], batch.speed[k], batch.torque_nm[k], goal, supply, duty_per_rad, out[k])
        return out


def diagnosed(program, work, fitted, held, flags="", known=(), name="effects"):
    """The document of a diagnosis of run files by name, and the motor of its verdict."""
    with_known = [flag for one in known for flag in ("--with", one)]
    file = f"{name}.toml"
    settings = []
    if name == "parameters":
        (Path(work) / "settings.toml").write_text(NOTHING_IDENTIFIED)
        settings = ["--settings", "settings.toml"]
    words = [*fitted, *shlex.split(flags), *with_known, *settings, "--hold-out", *held, "--model-out", file, "--force", "--json"]
    document = json.loads(run(program, "diagnose", *words, work=work).stdout)
    if "error" in document:
        sys.exit(document["error"]["message"])
    return document, Path(work) / file
