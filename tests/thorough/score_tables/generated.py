"""Recordings of the independent generator, made once and kept under target/score by seed."""

import hashlib
import json
import shutil
import subprocess
from pathlib import Path

from .program import ROOT, WORK

# The lab handout's motor, from which others are drawn here.
HANDOUT = {
    "resistance_ohm": 10.0,
    "back_emf_v_s_per_rad": 0.7,
    "torque_constant_nm_per_a": 0.7,
    "viscous_friction_nm_s_per_rad": 0.01,
    "inductance_h": 0.004,
    "inertia_kg_m2": 0.002,
    "coulomb_friction_nm": 0.02,
    "counts_per_rev": 720.0,
    "supply_v": 4.5,
}


def generator():
    """The generator's program, built where it is not yet."""
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "case-generator", "--example", "benches"], cwd=ROOT, check=True)
    metadata = subprocess.check_output(["cargo", "metadata", "--format-version", "1", "--no-deps"], cwd=ROOT)
    return Path(json.loads(metadata)["target_directory"]) / "release" / "examples" / "benches"


def breadth(seed, count):
    """Folder and truth of the cases of `motorlab blind make --breadth` of that seed and count."""
    folder = WORK / f"breadth-{seed}-{count}"
    if not (folder / "truth.json").exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run([generator(), "breadth", "--seed", str(seed), "--count", str(count), folder], check=True)
    return folder, json.loads((folder / "truth.json").read_text())


def chosen(name, recordings):
    """Folder with the recordings, by file name; each is described as `case_generator::Chosen` is.

    visible.json in it has what re-identified parameters leave of each one's effects, in counts.
    """
    spec = json.dumps(recordings, indent=1, sort_keys=True) + "\n"
    folder = WORK / f"{name}-{hashlib.sha256(spec.encode()).hexdigest()[:10]}"
    if not (folder / "spec.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        part = folder / "spec.part"
        part.write_text(spec)
        subprocess.run([generator(), "chosen", part, folder], check=True)
        part.rename(folder / "spec.json")
    return folder


def recording(motor, levels, sample_time_s, seed, effects=(), protocol="reversing", load_share=0.0):
    """One entry for `chosen`: levels are pairs of V and s, effects pairs of id and parameters."""
    return {
        "motor": motor,
        "effects": [{"id": effect, "parameters": parameters} for effect, parameters in effects],
        "protocol": protocol,
        "sample_time_s": sample_time_s,
        "levels": levels,
        "load_share": load_share,
        "load_time_s": 0.5,
        "seed": seed,
    }


def motor_file(motor, tolerance=None):
    """A motor file's text; the tolerance is that of every number that a maker's sheet gives with an error."""
    lines = [f"{key} = {value!r}" for key, value in motor.items()]
    if tolerance is not None:
        lines += ["", "[tolerance]"] + [f"{key} = {tolerance!r}" for key in motor if key not in ("counts_per_rev", "supply_v")]
    return "\n".join(lines) + "\n"


def cut(source, target, until_s):
    """The first so many seconds of a run file."""
    lines = source.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    column = lines[at].strip().split(",").index("t_s")
    kept = [line for line in lines[at + 1 :] if float(line.split(",")[column]) < until_s]
    target.write_text("".join(lines[: at + 1] + kept))
