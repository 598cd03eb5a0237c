"""Shared by the tools over the sets of sets.toml: runs of the program, run files, imports, held-out data."""
import math
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# Into how many parts a run is cut; every second one is held out.
PARTS = {"second half": 2, "every second tenth": 10}


def recordings():
    """The folder of the recordings."""
    return Path(os.environ.get("MOTORLAB_REAL", ROOT.parent / "shared" / "real"))


def sets():
    return tomllib.loads((ROOT / "tests" / "real" / "sets.toml").read_text())["set"]


def program(given):
    """The program that is asked: the given one, else a release build."""
    if given:
        # Programs run in a folder of their own.
        return Path(given).resolve()
    subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "motorlab"], cwd=ROOT, check=True)
    return ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "release" / "motorlab"


def run(program, *arguments, work, ok=(0, 1)):
    """Runs the program in the work folder, so that no path of this machine is in what it says."""
    done = subprocess.run([program, *map(str, arguments)], cwd=work, capture_output=True, text=True)
    if done.returncode not in ok:
        sys.exit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
    return done


def read(path):
    """Header lines, names and rows of a run file."""
    lines = path.read_text().splitlines()
    head = [line for line in lines if line.startswith("#")]
    names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    return head, names, rows


def parts(path, count):
    """The run as so many files of the same length."""
    head, names, rows = read(path)
    parts = []
    for k in range(count):
        parts.append(path.with_name(f"{path.stem}_part{k + 1}.csv"))
        of_part = rows[k * len(rows) // count : (k + 1) * len(rows) // count]
        text = "\n".join(head + [",".join(names)] + [",".join(row) for row in of_part])
        parts[-1].write_text(text + "\n")
    return parts


def column(path, *wanted):
    _, names, rows = read(path)
    at = next(names.index(name) for name in wanted if name in names)
    return np.array([float(row[at]) for row in rows])


def counts_per_rev(path):
    head, _, _ = read(path)
    return next(float(line.split("=")[1]) for line in head if line.startswith("# counts_per_rev"))


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def imported(motorlab, recordings, chosen, work):
    """The runs of a set, and the command line of each import."""
    (work / "tests").symlink_to(ROOT / "tests")
    folder = recordings / chosen["name"]
    runs, commands, known = [], [], []
    for log in sorted(folder.iterdir()):
        match = re.fullmatch(chosen["logs"], log.name)
        if not match:
            continue
        flags, product = chosen["import"], chosen.get("known", "")
        for k, group in enumerate(match.groups(), 1):
            flags, product = (text.replace("{%d}" % k, group) for text in (flags, product))
        name = log.name.split(".")[0] + ".csv"
        run(motorlab, "import", log, *shlex.split(flags), "-o", name, work=work)
        commands.append(f"motorlab import {chosen['name']}/{log.name} {flags} -o {name}")
        runs.append(work / name)
        if product:
            key, factors = product.split("=")
            known.append(f"{name}:{key.strip()}={math.prod(map(float, factors.split('*'))):.4g}")
    return runs, commands, known


def divided(paths, held):
    """Runs to fit, and held-out ones, by the pattern or the word of a set."""
    fitted, held_out = [], []
    for path in paths:
        if count := PARTS.get(held):
            of_run = parts(path, count)
            fitted += of_run[::2]
            held_out += of_run[1::2]
        else:
            (held_out if re.search(held, path.name) else fitted).append(path)
    return fitted, held_out
