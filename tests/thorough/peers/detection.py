"""Detection as fault diagnosis competitions count it, over the benches of tests/thorough/score, table b."""
import json
import math
import subprocess
import sys
from pathlib import Path

import page
from recordings import ROOT

QUIET = ("no_gap", "parameters", "none")
# Counts that an effect leaves beyond re-identified parameters, from which it is said to show.
SHOWS = 2.0


def interval(hits, of):
    """95 % interval of a share (Wilson), in percent."""
    if not of:
        return ""
    z, p = 1.96, hits / of
    middle, half = p + z * z / (2 * of), z * math.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    low, high = (max(0.0, (middle + sign * half) / (1 + z * z / of)) for sign in (-1, 1))
    return f"{100 * hits / of:.0f} % (95 % {100 * low:.0f} to {100 * high:.0f})"


def figures(cases):
    """The three figures of a group: how often an effect is said to be present, and the inclusion probability of the true ones then."""
    detected = [case for case in cases if case["verdict"] not in QUIET]
    of_truth = [p for case in detected for p, is_there in case["pairs"] if is_there]
    mean = f"{100 * sum(of_truth) / len(of_truth):.0f} %" if of_truth else ""
    return len(detected), len(cases), mean


def part(motorlab, scored, work):
    """Of a document that `tests/thorough/score --json` wrote, else of one that is made here."""
    out = Path(scored) if scored else work / "score.json"
    if not scored:
        asked = [sys.executable, ROOT / "tests" / "thorough" / "score", "--program", motorlab, "--table", "b", "--jobs", "1", "--json", out]
        subprocess.run(asked, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    cases = json.loads(out.read_text())["cases"]["b"]
    perfect = [case for case in cases if case["kind"] == "none"]
    of_catalogue = [case for case in cases if case["kind"] not in ("none", "outside")]
    shows = [case for case in of_catalogue if case["beyond_refit_counts"] >= SHOWS]
    single = [case for case in shows if case["kind"] == "single"]
    outside = [case for case in cases if case["kind"] == "outside"]
    text = [
        "## detection", "",
        f"The three figures of a fault diagnosis competition, over {len(cases)} simulated benches of many kinds (`tests/thorough/score`, table b; a tuning",
        "seed). An effect is detected where the verdict is neither `no_gap` nor `parameters`. The last column is the mean inclusion probability of the",
        f"true effects once something is detected. An effect shows where it leaves {SHOWS:.0f} counts or more beyond re-identified parameters.", "",
        "| benches | detected | share | mean probability of the true effects once detected |", "| --- | --- | --- | --- |",
    ]  # fmt: skip
    bars = []
    groups = (("one effect that shows", single), ("effects that show", shows), ("all with effects", of_catalogue), ("outside the catalogue", outside))
    for name, group in (*groups, ("no effect: false alarms", perfect)):
        hits, of, mean = figures(group)
        text.append(f"| {name} | {hits} of {of} | {interval(hits, of)} | {'' if group is perfect or group is outside else mean} |")
        bars.append((f"motorlab, {name}", 100 * hits / of))
    text += [
        "", "Published of the DX 2025 competition, with four faults: detection 87 to 100 %, false alarms 0 %, mean probability of the true fault once",
        "detected 66 to 74 %. Not comparable figure by figure: here are 39 effects, on motors of four families, with parameters within or outside",
        "their tolerances.", "", "![detection: share of benches in which an effect is detected](detection.svg)",
    ]  # fmt: skip
    return "\n".join(text), page.picture("Benches in which an effect is said to be present", bars, "%", [], shares=True)
