"""Table b: benches of many kinds, by strata.

The seed is one for tuning. Whether an effect leaves 2 counts or more beyond re-identified parameters is the generator's own linear
estimate (`beyond_refit_counts`), which knows no more of a diagnosis than the truth.
"""

from .generated import breadth
from .judge import WORDS, costs, counts, judge, probabilities, reliability, share

NAME = "b"
TITLE = "benches of many kinds, tuning seed"
SEED = 60001
COUNT = 240
# Counts RMS that an effect has to leave beyond re-identified parameters to be visible.
VISIBLE_COUNTS = 2.0


def stratum(truth):
    """Kind, visible or not, random load or none, tolerances stated or not, one step or more."""
    label, bench = truth["label"], truth["bench"]
    return (
        label["kind"],
        label["beyond_refit_counts"] >= VISIBLE_COUNTS,
        bench["has_random_torque"],
        bench["is_stated"],
        bench["protocol"] == "step",
    )


def cases(asked, _):
    folder, truths = breadth(asked.seed or SEED, COUNT)
    # Neighbours in this order are of one stratum, so every tenth has its share of each.
    names = sorted(truths, key=lambda name: (*map(str, stratum(truths[name])), name))
    if asked.tenth is not None:
        names = names[asked.tenth :: 10]
    return [(f"b/{name}", lambda program, name=name: of_case(program, folder / name, truths[name])) for name in names]


def of_case(program, folder, truth):
    runs = sorted(path.name for path in folder.glob("run*.csv"))
    answer = program.diagnose(f"b/{folder.name}", folder, runs, ["--motor", "motor.toml"])
    label = truth["label"]
    case = judge(f"b/{folder.name}", [effect["id"] for effect in label["effects"]], label["kind"], answer)
    kind, visible, load, stated, step = stratum(truth)
    strata = {"visible": visible, "load": load, "stated": stated, "step": step}
    gap = (answer.document or {}).get("gap") or {}
    held = {key: gap.get(key) for key in ("before", "after_parameters", "after_effect", "floor")}
    facts = {"protocol": truth["bench"]["protocol"], "beyond_refit_counts": round(label["beyond_refit_counts"], 3), "held_out": held}
    return case, case.row() | strata | facts


RIGHT = ("right", "in class")
STRATA = (
    ("load", "random load", "no random load"),
    ("stated", "tolerances stated", "no tolerances stated"),
    ("step", "one step", "more than one step"),
)


def figures(done):
    """Aims first, then each stratum of the single effects, then words, probabilities and reliability."""
    singles = [(case, row) for case, row in done if case.kind == "single"]
    pairs = [case for case, row in done if case.kind == "pair"]
    visible_pairs = [case for case, row in done if case.kind == "pair" and row["visible"]]
    perfect = [case for case, _ in done if case.kind == "none"]
    outside = [case for case, _ in done if case.kind == "outside"]
    every = [case for case, _ in done]
    seen = [(case, row) for case, row in singles if row["visible"]]
    unseen = [(case, row) for case, row in singles if not row["visible"]]
    found = {
        "single effects of 2 counts and more: right or in class": right(seen),
        "single effects of less: right or in class": right(unseen),
        "single effects of less: right, in class or as parameters": right(unseen, (*RIGHT, "as parameters")),
        "pairs: both": share(sum(case.found == 2 for case in pairs), len(pairs)),
        "pairs: at least one": share(sum(case.found >= 1 for case in pairs), len(pairs)),
        "pairs of 2 counts and more: both": share(sum(case.found == 2 for case in visible_pairs), len(visible_pairs)),
        "pairs of 2 counts and more: at least one": share(sum(case.found >= 1 for case in visible_pairs), len(visible_pairs)),
        "perfect motors accused with 0.5 or more": share(sum(case.accused for case in perfect), len(perfect)),
        "outside the catalogue, said to be so": share(sum(case.word == "right" for case in outside), len(outside)),
        "said with 0.9 or more: quiet where 2 counts and more are left": share(
            sum(case.verdict in ("no_gap", "parameters") and case.probability >= 0.9 for case, row in done if row["visible"]),
            sum(row["visible"] for _, row in done),
        ),
    } | probabilities(every)
    for key, yes, no in STRATA:
        for value, word in ((True, yes), (False, no)):
            of_stratum = [one for one in seen if one[1][key] == value]
            found[f"2 counts and more, {word}: right or in class"] = right(of_stratum)
            within = [case for case, row in done if row[key] == value]
            found[f"all cases, {word}: wrong and sure"] = share(sum(bool(case.sure_false) for case in within), len(within))
    worse = [row["held_out"] for _, row in done if row["held_out"].get("after_parameters") and row["held_out"].get("after_effect") is not None]
    found["cross-validated error above re-identified parameters' by more than 5 %"] = share(
        sum(one["after_effect"] > 1.05 * one["after_parameters"] for one in worse), len(worse)
    )
    return found | costs(every)


def right(of, words=RIGHT):
    return share(sum(case.word in words for case, _ in of), len(of))


def words_by_kind(done):
    """Rows of the table of words: what is there, how many, and how many have which word."""
    kinds = [("nothing", lambda c, r: c.kind == "none")]
    for kind in ("single", "pair", "triple"):
        kinds.append((f"{kind}, 2 counts and more", lambda c, r, k=kind: c.kind == k and r["visible"]))
        kinds.append((f"{kind}, less", lambda c, r, k=kind: c.kind == k and not r["visible"]))
    kinds.append(("outside the catalogue", lambda c, r: c.kind == "outside"))
    rows = {}
    for name, belongs in kinds:
        of_kind = [case for case, row in done if belongs(case, row)]
        rows[name] = [len(of_kind), *(counts(of_kind).get(word, [0])[0] for word in WORDS)]
    return rows


def reliabilities(done):
    """Of effects' inclusion probabilities, and of verdicts."""
    pairs = [pair for case, _ in done for pair in case.pairs]
    verdicts = [case.verdict_pair for case, _ in done if case.verdict_pair]
    return {"inclusion probability of an effect": reliability(pairs), "probability of the verdict": reliability(verdicts)}


def line(row):
    """A case on one line."""
    there = " + ".join(row["truth"]) or "nothing"
    return f"{there} ({row['beyond_refit_counts']:.2g} counts, {row['protocol']}): {row['word']}; {row['said']}; {row['cpu_s']:.1f} s"
