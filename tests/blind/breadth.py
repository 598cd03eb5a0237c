"""The page of a breadth set: how its verdicts were, by true cause, by protocol and by motor.

    python3 tests/blind/breadth.py SCORE.json SET SCORE.html OUT

writes OUT/README.md and OUT/reliability.svg. SCORE.json is what `motorlab blind score --json` prints, SET the folder of the cases,
SCORE.html what `--html` writes.
"""

import json
import re
import sys
from pathlib import Path

SURE = 0.9
# On an unseen run the diagnosed motor predicts worse than the nominal one beyond this.
WORSE = 1.1
WORDS = ("right", "stated tie", "partial or unknown", "missed", "wrong", "overconfident", "no answer")
NOTHING = ("no_gap", "parameters")
WANTED = {
    "no effect, but one named with 0.9 or more": 0.02,
    "overconfident": 0.03,
    "an effect that is not there named with 0.9 or more": 0.02,
    "single effects right or in a stated tie": 0.90,
    "single effects right outright on one plain step": 0.60,
    "single effects right outright on reversing runs": 0.85,
    "two or three effects, all or one of them found": 0.70,
    "outside the catalogue, verdict outside or partial": 0.85,
    "held-out run predicted worse than by the nominal motor": 0.05,
}


def judged(case):
    """How a verdict was, in the words above."""
    if case["failure"] is not None:
        return "no answer"
    truth, verdict = case["truth"], case["verdict"]
    sure = case["probability_said"] >= SURE
    there = {effect["id"] for effect in truth["effects"]}
    if truth["kind"] == "none":
        if verdict in NOTHING:
            return "right"
        if verdict == "ambiguous" and not sure:
            return "partial or unknown"
        return "overconfident" if sure else "wrong"
    if truth["kind"] == "outside":
        if verdict in ("outside_catalogue", "partial"):
            return "right"
        if verdict in NOTHING:
            return "missed"
        return "overconfident" if sure else "wrong"
    if case["bearing"] == "named":
        return "right"
    if case["bearing"] == "tied":
        return "stated tie"
    if verdict in NOTHING:
        return "overconfident" if sure and shows(case) else "missed"
    said = set(case["said"]) - {"unknown"}
    if verdict == "outside_catalogue" or (verdict == "partial" and (said & there or not said)):
        return "overconfident" if verdict == "outside_catalogue" and sure else "partial or unknown"
    return "overconfident" if sure else "wrong"


def names_false(case):
    """Whether it names with 0.9 or more an effect that is not there."""
    there = {effect["id"] for effect in case["truth"]["effects"]}
    named = set(case["said"]) - {"unknown", "none", *NOTHING}
    return case["judged"] == "overconfident" and bool(named - there)


def shows(case):
    """Whether the true cause leaves a count or more beyond re-identified parameters."""
    return (case["truth"]["beyond_refit_counts"] or 0.0) >= 1.0


def found(case):
    """Whether one at least of several effects is among those named."""
    there = {effect["id"] for effect in case["truth"]["effects"]}
    return case["bearing"] in ("named", "tied", "partly") or bool(there & set(case["said"]))


def family(counts_per_rev):
    if counts_per_rev == 720:
        return "the lab's motor"
    if counts_per_rev <= 64:
        return "small and fast, 12 to 64 counts"
    if counts_per_rev >= 4096:
        return "slow servo, 4,096 to 8,192 counts"
    return "hobby gear motor"


def of_header(folder, key):
    head = (folder / "run1.csv").read_text()[:4000]
    return re.search(rf"^# {key} = (.*)$", head, re.M).group(1).strip('"')


def share(hits, of):
    return f"{hits} of {of}" + (f", {100 * hits / of:.0f} %" if of else "")


def table(title, groups):
    lines = [f"| {title} | cases | " + " | ".join(WORDS) + " |", "| --- " * (len(WORDS) + 2) + "|"]
    for name, cases in groups:
        counts = [sum(case["judged"] == word for case in cases) for word in WORDS]
        lines.append(f"| {name} | {len(cases)} | " + " | ".join(str(count or "") for count in counts) + " |")
    return lines + [""]


def grouped(cases, key):
    names = sorted({case[key] for case in cases})
    return [(name, [case for case in cases if case[key] == name]) for name in names]


def main():
    score_file, set_folder, html, out = map(Path, sys.argv[1:])
    score = json.loads(score_file.read_text())
    cases = score["cases"]
    for case in cases:
        folder = set_folder / case["case"]
        case["judged"] = judged(case)
        case["protocol"] = of_header(folder, "profile")
        case["motor"] = family(float(of_header(folder, "counts_per_rev")))
        case["leaves"] = "2 counts and more" if (case["truth"]["beyond_refit_counts"] or 0.0) >= 2.0 else "less, or no effect"
        case["tolerances"] = "stated" if "[tolerance]" in (folder / "motor.toml").read_text() else "not stated"
        case["load"] = {None: "unknown", 0.0: "none"}.get(case["truth"]["random_load_share"], "some")
        case["steps"] = {None: "unknown", True: "one step"}.get(case["truth"]["one_step"], "more than one step")
        effects = len(case["truth"]["effects"])
        kind = case["truth"]["kind"]
        case["hides"] = {"none": "no effect", "outside": "outside the catalogue"}.get(kind) or {1: "one effect", 2: "two effects"}.get(effects, "three effects")
    singles = [case for case in cases if case["hides"] == "one effect"]
    several = [case for case in cases if case["hides"] in ("two effects", "three effects")]
    nothing = [case for case in cases if case["hides"] == "no effect"]
    outside = [case for case in cases if case["hides"] == "outside the catalogue"]
    unseen = [case["gap"] for case in cases if case.get("gap") and case["gap"].get("before_counts") is not None]

    def right(some, *words):
        return sum(case["judged"] in words for case in some)

    steps = [case for case in singles if case["protocol"] == "step"]
    reversing = [case for case in singles if case["protocol"] in ("reversing", "multi-level", "triangle", "chirp")]
    figures = [
        (right(nothing, "overconfident"), len(nothing)),
        (right(cases, "overconfident"), len(cases)),
        (sum(names_false(case) for case in cases), len(cases)),
        (right(singles, "right", "stated tie"), len(singles)),
        (right(steps, "right"), len(steps)),
        (right(reversing, "right"), len(reversing)),
        (sum(found(case) for case in several), len(several)),
        (right(outside, "right"), len(outside)),
        (sum(gap["after_counts"] > WORSE * gap["before_counts"] for gap in unseen), len(unseen)),
    ]
    made = score["set"]
    lines = (Path(__file__).parent / "breadth.md").read_text().rstrip().splitlines() + [""]
    lines += [f"{len(cases)} cases of seed {made['recipe']['seed']}; the hash of all verdicts, before the labels were opened, is `{made['head']}`.", ""]
    lines += ["| figure | reached | wanted |", "| --- | --- | --- |"]
    for (name, wanted), (hits, of) in zip(WANTED.items(), figures):
        bound = "at most" if wanted < 0.5 else "at least"
        lines.append(f"| {name} | {share(hits, of)} | {bound} {100 * wanted:.0f} % |")
    sure = score["probabilities"]["right_from_90"]
    lines.append(f"| verdicts of 90 % and more, right | {share(sure['hits'], sure['of'])} | 90 % |")
    lines.append(f"| Brier score of the verdicts | {score['probabilities']['brier']:.3f} | |")
    lines += ["", "![Reliability diagram: share of right verdicts against their probability, with 95 % intervals](reliability.svg)", ""]
    lines += table("true cause", grouped(cases, "hides"))
    lines += table("protocol", grouped(cases, "protocol"))
    lines += table("motor", grouped(cases, "motor"))
    lines += table("left beyond re-identified parameters", grouped(cases, "leaves"))
    lines += table("tolerances", grouped(cases, "tolerances"))
    lines += table("random load", grouped(cases, "load"))
    lines += table("recorded", grouped(cases, "steps"))
    blank = [case for case in singles if not shows(case)]
    unshown = [case for case in cases if case["judged"] == "missed" and case["probability_said"] >= SURE]
    lines += [
        f"Of the {len(singles)} single effects {len(blank)} leave less than a count beyond re-identified parameters. "
        f"Of these {right(blank, 'right', 'stated tie')} are right or tied, of the others {right(singles, 'right', 'stated tie') - right(blank, 'right', 'stated tie')} of {len(singles) - len(blank)}.",
        f"Missed with {100 * SURE:.0f} % and more are {len(unshown)} that leave less than that: the data show no more than a parameter mismatch.",
        "",
        "## Overconfident verdicts",
        "",
        "| case | protocol | true | named | probability |",
        "| --- | --- | --- | --- | --- |",
    ]
    for case in cases:
        if case["judged"] == "overconfident":
            there = " + ".join(effect["id"] for effect in case["truth"]["effects"]) or "no effect"
            said = " + ".join(case["said"]) or case["verdict"]
            lines.append(f"| {case['case'].removeprefix('case-')} | {case['protocol']} | {there} | {said} | {100 * case['probability_said']:.0f} % |")
    out.mkdir(exist_ok=True)
    (out / "README.md").write_text("\n".join(lines) + "\n")
    page = html.read_text()
    picture = next(svg for svg in re.findall(r"<svg.*?</svg>", page, re.S) if 'aria-label="Reliability"' in svg[:300])
    style = "".join(re.findall(r"<style>(.*?)</style>", page, re.S))
    begin = re.match(r"<svg[^>]*>", picture).end()
    paper = '<rect width="100%" height="100%" fill="var(--paper)"/>'
    (out / "reliability.svg").write_text(f"{picture[:begin]}<style><![CDATA[{style}]]></style>{paper}{picture[begin:]}")
    print("\n".join(lines))


main()
