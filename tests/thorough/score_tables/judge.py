"""One answer against the truth, and figures of many."""

import math
from dataclasses import asdict, dataclass

from .reading import family_of, read

# Named with so much and false is "wrong and sure".
SURE = 0.9
# A perfect motor is accused where something is said to be present with so much.
ACCUSED = 0.5
# A probability of 0 would make the log score infinite; the documents list no sets below about this.
LEAST_PROBABILITY = 1e-3
# Effects that change a number that is re-identified anyway: "parameters" is no wrong answer to them.
OF_PARAMETERS = {"coulomb_friction", "viscous_friction", "inertia", "inductance", "supply_error", "resolution_error"}
# In the order of the table's columns.
WORDS = ("right", "in class", "as parameters", "neighbour", "with a false one", "part", "part, false one", "unknown", "missed", "wrong", "no answer")


@dataclass
class Judged:
    """One case."""

    case: str
    truth: list
    kind: str
    word: str
    said: str
    verdict: str
    probability: float
    found: int
    sure_false: list
    accused: bool
    log_score_set: float | None
    log_score_effects: float | None
    brier: float | None
    pairs: list
    verdict_pair: list | None
    cpu_s: float
    wall_s: float
    peak_mb: float
    note: str = ""

    def row(self):
        return asdict(self)


def judge(case, truth, kind, answer, plausible=()):
    """`truth` are the ids that are there, `plausible` further ones that are not held against whoever names them."""
    truth = set(truth)
    costs = {"cpu_s": round(answer.cpu_s, 3), "wall_s": round(answer.wall_s, 3), "peak_mb": round(answer.peak_mb, 1)}
    head = {"case": case, "truth": sorted(truth), "kind": kind}
    document = answer.document
    if document is None or document["verdict"] == "bad_recording":
        why = answer.failure
        if document is not None:
            why = "bad_recording: " + ", ".join(sorted({one["id"] for one in document["data"] if one["severity"] == "fatal"}))
        empty = {"found": 0, "sure_false": [], "accused": False, "log_score_set": None, "log_score_effects": None, "brier": None, "pairs": []}
        return Judged(**head, word="no answer", said=why, verdict="none", probability=0.0, verdict_pair=None, **empty, **costs)
    reading = read(document)
    of_catalogue = set() if kind == "outside" else truth
    covered = {effect for effect in of_catalogue if any(effect in claim.members for claim in reading.claims)}
    false = [claim for claim in reading.claims if not claim.members & (of_catalogue | set(plausible))]
    pairs = [[p, effect in of_catalogue] for effect, p in sorted(reading.inclusion.items())]
    pairs += [[0.0, True] for effect in of_catalogue if effect not in reading.inclusion]
    return Judged(
        **head,
        word=word_of(reading, of_catalogue, kind, covered, false),
        said=reading.words(),
        verdict=reading.verdict,
        probability=round(reading.probability, 4),
        found=len(covered),
        sure_false=[claim.words() for claim in false if claim.probability >= SURE],
        accused=bool(kind == "none" and not reading.is_quiet() and reading.probability >= ACCUSED),
        log_score_set=None if kind == "outside" else log(reading.of_set(of_catalogue)),
        log_score_effects=sum(log(reading.of_effect(effect)) for effect in of_catalogue) / len(of_catalogue) if of_catalogue else None,
        brier=sum((p - is_there) ** 2 for p, is_there in pairs),
        pairs=[[round(p, 4), bool(is_there)] for p, is_there in pairs],
        verdict_pair=verdict_pair(reading, of_catalogue, kind),
        **costs,
    )


def log(probability):
    return math.log(max(probability, LEAST_PROBABILITY))


def word_of(reading, truth, kind, covered, false):
    """How the answer was, in one of WORDS."""
    if kind == "none":
        return "right" if reading.is_quiet() else "wrong" if reading.claims else "unknown"
    if kind == "outside":
        if reading.verdict in ("outside_catalogue", "partial"):
            return "right"
        return "missed" if reading.is_quiet() else "wrong" if reading.claims else "unknown"
    if covered == truth:
        if false:
            return "with a false one"
        return "right" if all(len(claim.members) == 1 for claim in reading.claims) else "in class"
    if not reading.claims:
        if not reading.is_quiet():
            return "unknown"
        return "as parameters" if truth <= OF_PARAMETERS and reading.verdict == "parameters" else "missed"
    wide = [frozenset().union(*map(family_of, claim.members)) for claim in reading.claims]
    if all(any(effect in one for one in wide) for effect in truth) and all(one & truth for one in wide):
        return "neighbour"
    if covered:
        return "part, false one" if false else "part"
    return "wrong"


def verdict_pair(reading, truth, kind):
    """The verdict's probability, and whether what it says is so."""
    if reading.is_quiet():
        is_so = kind == "none" or (reading.verdict == "parameters" and kind != "outside" and truth <= OF_PARAMETERS)
    elif reading.claims:
        is_so = all(claim.members & truth for claim in reading.claims)
    elif reading.verdict == "ambiguous":
        is_so = bool(truth)
    else:
        is_so = kind == "outside"
    return [round(reading.probability, 4), bool(is_so)]


def share(hits, of):
    """Of so many, as a figure."""
    return [int(hits), int(of)]


def counts(cases):
    """How many cases have which word."""
    return {word: share(sum(case.word == word for case in cases), len(cases)) for word in WORDS if any(case.word == word for case in cases)}


def probabilities(cases):
    """Log scores, Brier scores, and shares that were wrong and sure."""
    answered = [case for case in cases if case.brier is not None]
    pairs = [case.verdict_pair for case in answered if case.verdict_pair]
    return {
        "wrong and sure": share(sum(bool(case.sure_false) for case in cases), len(cases)),
        "log score of the true set": mean([case.log_score_set for case in answered if case.log_score_set is not None]),
        "log score of each true effect": mean([case.log_score_effects for case in answered if case.log_score_effects is not None]),
        "Brier score, all effects of a case": mean([case.brier for case in answered]),
        "Brier score of the verdict": mean([(p - is_so) ** 2 for p, is_so in pairs]),
    }


def mean(values):
    return sum(values) / len(values) if values else None


def reliability(pairs):
    """By tenths of probability: how many, their mean probability, and the share that is so."""
    rows = {}
    for k in range(10):
        inside = [(p, is_so) for p, is_so in pairs if min(9, int(p * 10)) == k]
        if inside:
            rows[f"{k / 10:.1f} to {(k + 1) / 10:.1f}"] = [len(inside), mean([p for p, _ in inside]), mean([float(is_so) for _, is_so in inside])]
    return rows


def costs(cases):
    """Processor time in s: sum, mean, largest, and which case that is; largest memory in MB."""
    if not cases:
        return {}
    slowest = max(cases, key=lambda case: case.cpu_s)
    return {
        "processor time, all cases (s)": sum(case.cpu_s for case in cases),
        "processor time, mean of a case (s)": mean([case.cpu_s for case in cases]),
        "processor time, slowest case (s)": slowest.cpu_s,
        "slowest case": slowest.case,
        "largest memory (MB)": max(case.peak_mb for case in cases),
        "over the time limit or failed": share(sum(case.word == "no answer" for case in cases), len(cases)),
    }
