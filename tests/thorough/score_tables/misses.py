"""Why the true set of a missed case of table b is not named: the same recordings, with the true set fitted from the true parameters.

    search       the true set is not among the fitted sets with a probability, and would be within NEAR nats of the best
    fit          it is, but its fit from the true parameters scores more than NEAR nats higher, and within NEAR nats of the best
    information  both are found, and the true set is within NEAR nats of the best
    verdict      the true set is the best one, and another verdict is said
    score        the best set scores more than NEAR nats higher than the true set fitted from the true parameters
"""

import tomllib

from .breadth import RIGHT, SEED, COUNT
from .generated import breadth

# Sets within so many nats are tied.
NEAR = 2.0
REASONS = ("search", "fit", "information", "verdict", "score")


def is_miss(row):
    return bool(row["truth"]) and row["kind"] != "outside" and row["word"] not in (*RIGHT, "as parameters", "no answer")


def motor_file(label, folder):
    """A motor file with the true parameters and effects."""
    nominal = tomllib.loads((folder / "motor.toml").read_text())
    keys = {key: value for key, value in nominal.items() if not isinstance(value, dict)} | label["motor"]
    lines = [f"{key} = {value!r}" for key, value in keys.items()]
    for effect in label["effects"]:
        lines.append(f"\n[effects.{effect['id']}]")
        lines += [f"{key} = {float(value)!r}" for key, value in effect["parameters"].items()]
    path = folder / "true.toml"
    path.write_text("\n".join(lines) + "\n")
    return path.name


def score_of(document, ids):
    """Score of a set, and the score of the best one; None where the set has no probability."""
    sets = {tuple(sorted(one["effects"])): one["score"] for one in document["sets"]}
    return sets.get(tuple(sorted(ids))), max(sets.values())


def reason(program, row, asked):
    """One of REASONS, or why there is no answer."""
    folder, truths = breadth(asked.seed or SEED, COUNT)
    name = row["case"].removeprefix("b/")
    folder, label = folder / name, truths[name]["label"]
    runs = sorted(path.name for path in folder.glob("run*.csv"))
    plain = program.diagnose(row["case"], folder, runs, ["--motor", "motor.toml"]).document
    flags = ["--motor", "motor.toml", "--propose", motor_file(label, folder)]
    answer = program.diagnose(row["case"], folder, runs, flags)
    if answer.document is None:
        return answer.failure
    (found, _), (true, best) = score_of(plain, row["truth"]), score_of(answer.document, row["truth"])
    if true is None or true < best - NEAR:
        return "score"
    if found is None:
        return "search"
    if found < true - NEAR:
        return "fit"
    return "verdict" if found >= score_of(plain, row["truth"])[1] else "information"


def counted(program, rows, asked):
    """How many misses have which reason, by kind and by whether 2 counts and more are left."""
    found = {}
    for row in filter(is_miss, rows):
        key = f"{row['kind']}, {'2 counts and more' if row['visible'] else 'less'}"
        of_kind = found.setdefault(key, dict.fromkeys(REASONS, 0))
        why = reason(program, row, asked)
        of_kind[why] = of_kind.get(why, 0) + 1
    return found
