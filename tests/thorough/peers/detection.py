"""Detection as fault diagnosis competitions count it, over the published breadth set: docs/blind."""
import json
import math
import sys
from pathlib import Path

import page

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


def inclusions(verdict, there):
    """Of each effect that is there, its inclusion probability."""
    causes = {cause["effect"]: cause["inclusion"] for cause in verdict["diagnosis"].get("causes", [])}
    return [(causes.get(effect, 0.0), True) for effect in there]


def benches(folder):
    """Of what tests/blind/publish --breadth wrote there."""
    cases = []
    for case in json.loads((folder / "score.json").read_text())["cases"]:
        verdict = json.loads((folder / "set" / "verdicts" / f"{case['case']}.json").read_text())
        there = [effect["id"] for effect in case["truth"]["effects"]]
        pairs = inclusions(verdict, there) if "diagnosis" in verdict else []
        cases.append({"verdict": case["verdict"], "pairs": pairs, "effects": len(there)} | {key: case["truth"][key] for key in ("kind", "beyond_refit_counts")})
    return cases


def part(_, blind, __):
    """Of the folder that `tests/blind/publish --breadth` filled."""
    if blind is None:
        sys.exit("the part detection needs the published breadth set; hint: --blind DIR, which tests/blind/publish --breadth DIR filled")
    cases = benches(Path(blind))
    perfect = [case for case in cases if case["kind"] == "none"]
    of_catalogue = [case for case in cases if case["kind"] not in ("none", "outside")]
    shows = [case for case in of_catalogue if case["beyond_refit_counts"] >= SHOWS]
    single = [case for case in shows if case["effects"] == 1]
    outside = [case for case in cases if case["kind"] == "outside"]
    text = [
        "## detection", "",
        f"The three figures of a fault diagnosis competition, over the {len(cases)} simulated benches of [docs/blind](../blind/README.md), whose seed",
        "was drawn once. An effect is detected where the verdict is neither `no_gap` nor `parameters`. The last column is the mean inclusion probability of the",
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
