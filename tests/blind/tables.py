"""Two tables of a score that its own text does not have: every miss in a row, and how long each kind took.

    python3 tests/blind/tables.py SCORE.json DIR

writes DIR/misses.md and DIR/times.md; SCORE.json is what `motorlab blind score --json` prints.
"""

import json
import sys
from pathlib import Path

WANTED_S = 2.0
RIGHT = ("named", "tied")
KINDS = {
    "none": "nothing there",
    "single": "single effects",
    "pair": "pairs",
    "outside": "outside the catalogue",
}


def there(truth):
    """True causes, each effect with its strength in counts RMS."""
    strengths = truth["strength_counts"]
    words = [
        f"{effect['id']}: {strengths[effect['id']]:.1f}" if effect["id"] in strengths else effect["id"]
        for effect in truth["effects"]
    ]
    return ("outside: " if truth["kind"] == "outside" else "") + (", ".join(words) or "none")


def said(case):
    """Verdict, with its probability."""
    if case["failure"] is not None:
        return f"failed: {case['failure']}"
    if case["verdict"] in ("no_gap", "parameters"):
        words = "none"
    elif case["verdict"] == "ambiguous":
        words = ", or ".join(name for name, _ in case["likeliest"][: case["standing"]])
    else:
        words = "+".join(case["said"])
    return f"{words} ({case['probability_said']:.3f})"


def of_truth(case):
    """The probability of the truth, and its place."""
    place = case["rank_of_truth"]
    if place is None:
        return "not among the sets weighed"
    return f"{case['probability_truth']:.2e}, place {place}"


def misses(cases):
    yield "| case | what was there, counts | beyond a refit | what was said | probability of the truth |"
    yield "| --- | --- | --- | --- | --- |"
    for case in cases:
        if case["bearing"] not in RIGHT:
            number = case["case"].removeprefix("case-")
            beyond = case["truth"]["beyond_refit_counts"]
            beyond = "" if beyond is None else f"{beyond:.2f}"
            yield f"| {number} | {there(case['truth'])} | {beyond} | {said(case)} | {of_truth(case)} |"


def times(cases):
    yield f"| time in s | cases | median | nine in ten within | longest | at most {WANTED_S:g} s |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for kind, words in KINDS.items():
        taken = sorted(case["wall_s"] for case in cases if case["truth"]["kind"] == kind)
        if taken:
            n = len(taken)
            most = taken[(9 * n + 9) // 10 - 1]
            within = sum(t <= WANTED_S for t in taken)
            yield f"| {words} | {n} | {taken[n // 2]:.2f} | {most:.2f} | {taken[-1]:.2f} | {within} |"


score, into = json.loads(Path(sys.argv[1]).read_text()), Path(sys.argv[2])
for name, rows in (("misses", misses), ("times", times)):
    (into / f"{name}.md").write_text("\n".join(rows(score["cases"])) + "\n")
