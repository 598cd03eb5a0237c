"""Table a: recordings of real motors in ../shared/real, each with a documented cause, parts of them held out.

tests/real/sets.toml says how a set is imported, which part is held out, and which causes are documented; ALSO_DOCUMENTED adds what its
README or its source states beside them, which is neither right nor wrong to name.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from .judge import SURE, costs, judge, mean, share
from .program import ROOT, WORK
from .reading import family_of, read

NAME = "a"
TITLE = "real motors, documented cause, parts held out"
PARTS = {"second half": 2, "every second tenth": 10}
ALSO_DOCUMENTED = {
    # A time constant that grows with amplitude reduces the held-out error from 2.33 to 1.22 counts.
    "ev3": ["supply_sag", "current_limit"],
    # Dead time at the start, sag of the battery, a concave curve of speed over duty.
    "micromouse": ["transport_delay", "supply_sag"],
    # The supply moves between 5.7 and 9.2 V, and the motor warms from 27 to 40 degrees.
    "xl330": ["supply_sag", "winding_heating"],
}
# Documented in diagnosis.md of the project's notes as the cause of the largest part: right to name first.
FIRST_TOO = {"micromouse": ["transport_delay"]}


def recordings():
    """Beside the working copy, or beside the one that a worktree belongs to."""
    if "MOTORLAB_REAL" in os.environ:
        return Path(os.environ["MOTORLAB_REAL"])
    shared = subprocess.check_output(["git", "rev-parse", "--path-format=absolute", "--git-common-dir"], cwd=ROOT, text=True).strip()
    places = [root.parent / "shared" / "real" for root in (ROOT, Path(shared).parent)]
    return next((place for place in places if place.is_dir()), places[0])


def sets(tenth):
    """The sets; of a tenth a third of them, so that each tenth has quick and slow ones."""
    listed = tomllib.loads((ROOT / "tests" / "real" / "sets.toml").read_text())["set"]
    found = [one for one in listed if (recordings() / one["name"]).is_dir()]
    for one in listed:
        if one not in found:
            print(f"{one['name']}: skipped, not in {recordings()}", file=sys.stderr)
    return found if tenth is None else [one for k, one in enumerate(found) if k % 3 == tenth % 3]


def parts(path, count):
    """The run as so many files of the same length."""
    lines = path.read_text().splitlines(keepends=True)
    begin = next(k for k, line in enumerate(lines) if not line.startswith("#")) + 1
    rows = lines[begin:]
    written = []
    for k in range(count):
        part = path.with_name(f"{path.stem}_part{k + 1}.csv")
        part.write_text("".join(lines[:begin] + rows[k * len(rows) // count : (k + 1) * len(rows) // count]))
        written.append(part.name)
    return written


def imported(program, chosen):
    """Folder of the set's runs, names of those to diagnose and of those held out."""
    folder = WORK / "real" / program.digest / chosen["name"]
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "tests").symlink_to(ROOT / "tests")
    runs, held = [], []
    for log in sorted((recordings() / chosen["name"]).iterdir()):
        match = re.fullmatch(chosen["logs"], log.name)
        if not match:
            continue
        flags = chosen["import"]
        for k, group in enumerate(match.groups(), 1):
            flags = flags.replace("{%d}" % k, group)
        name = log.name.split(".")[0] + ".csv"
        answer = program.run(["import", log, *shlex.split(flags), "-o", name, "--json"], folder)
        if answer.failure:
            raise RuntimeError(f"import of {log.name}: {answer.failure}")
        if count := PARTS.get(chosen["held"]):
            of_run = parts(folder / name, count)
            runs += of_run[::2]
            held += of_run[1::2]
        else:
            (held if re.search(chosen["held"], name) else runs).append(name)
    return folder, runs, held


def cases(asked, _):
    """What is to be done: a function of the program each."""
    return [(f"a/{one['name']}", lambda program, one=one: of_set(program, one)) for one in sets(asked.tenth)]


def of_set(program, chosen):
    name = f"a/{chosen['name']}"
    folder, runs, held = imported(program, chosen)
    answer = program.diagnose(name, folder, runs, shlex.split(chosen["diagnose"]), held)
    first = set(chosen["causes"]) | set(FIRST_TOO.get(chosen["name"], []))
    wide = frozenset().union(*map(family_of, first)) if first else frozenset()
    plausible = wide | frozenset().union(*map(family_of, ALSO_DOCUMENTED.get(chosen["name"], ["none"])))
    case = judge(name, first, "real" if first else "none", answer, plausible)
    row = case.row() | {"documented": sorted(first), "pairs": []}
    if answer.document is None or answer.document["verdict"] == "bad_recording":
        return case, row
    reading = read(answer.document)
    leading = reading.first()
    claimed = [claim for claim in reading.claims if claim.members & wide]
    row["first"] = leading
    row["first_inclusion"] = reading.of_effect(leading) if leading else None
    row["right"], row["named"] = reading.is_quiet(), reading.is_quiet()
    if first:
        row["right"] = leading in wide or bool(reading.claims and reading.claims[0].members & wide)
        row["named"] = bool(claimed)
    row["sure_false"] = case.sure_false
    row["sure_undocumented_causes"] = sorted(e for e, p in reading.inclusion.items() if p >= SURE and e not in plausible)
    row["held_out"] = {key: reading.gap.get(key) for key in ("before", "after_parameters", "after_effect", "floor")}
    return case, row


def figures(done):
    """Figures of the table, by name."""
    rows = [row for _, row in done]
    with_cause = [row for row in rows if row["documented"]]
    without = [row for row in rows if not row["documented"]]
    errors = [row["held_out"] for row in rows if row.get("held_out") and row["held_out"]["after_parameters"]]
    ratios = [error["after_effect"] / error["after_parameters"] for error in errors if error["after_effect"] is not None]
    return {
        "documented cause first or in its class": share(sum(bool(row.get("right")) for row in with_cause), len(with_cause)),
        "documented cause named in the verdict": share(sum(bool(row.get("named")) for row in with_cause), len(with_cause)),
        "wrong and sure: named with 0.9 or more and undocumented": share(sum(bool(row["sure_false"]) for row in rows), len(rows)),
        "causes[] has an undocumented one with 0.9 or more": share(sum(bool(row.get("sure_undocumented_causes")) for row in rows), len(rows)),
        "no cause documented, and something named": share(sum(not row.get("right") for row in without), len(without)),
        "held-out error above re-identified parameters' by more than 5 %": share(sum(ratio > 1.05 for ratio in ratios), len(ratios)),
        "held-out error over re-identified parameters', mean": mean(ratios),
    } | costs([case for case, _ in done])


def line(row):
    """A case on one line, for the comparison with the committed one."""
    if "held_out" not in row:
        return f"{row['said']}"
    errors = [row["held_out"][key] for key in ("before", "after_parameters", "after_effect")]
    held = " > ".join("-" if error is None else f"{error:.4g}" for error in errors)
    right = "right" if row["right"] else "not right"
    return f"{right}; {row['said']}; first {row['first']} {row['first_inclusion'] or 0:.2f}; held out {held}; {row['cpu_s']:.1f} s"
