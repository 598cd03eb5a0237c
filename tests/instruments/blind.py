"""Two cheats at a blind set: a diagnoser that looks for the labels where it is started, and verdicts changed after the
labels were seen, with their chain made anew.

The first finds nothing, asked for its version or for a verdict. The second is refused by the head that was written down;
without one the score says that the order is not proved."""

import hashlib
import json
import os

from instrument import MOTORLAB, end, folder, judge, run

# Leaves a copy of whatever labels it sees, and then diagnoses properly.
THIEF = """#!/bin/sh
for labels in *labels.json ../*labels.json "$OLDPWD"/*labels.json; do
    [ -f "$labels" ] && cp "$labels" '{stolen}'
done
exec '{motorlab}' "$@"
"""


def sha256(content):
    return hashlib.sha256(content).hexdigest()


def forged(work, change):
    """Every verdict changed, and the chain made anew as if it had always been so."""
    ledger, head = [], "start"
    with open(os.path.join(work, "set", "verdicts.log"), encoding="utf-8") as file:
        entries = [json.loads(line) for line in file]
    for entry in entries:
        path = os.path.join(work, "set", "verdicts", f"{entry['case']}.json")
        with open(path, encoding="utf-8") as file:
            verdict = json.load(file)
        change(verdict["diagnosis"])
        content = json.dumps(verdict, indent=1).encode()
        with open(path, "wb") as file:
            file.write(content)
        head = sha256(f"{head}\n{entry['case']}\n{sha256(content)}\n{entry['decided_at']}".encode())
        ledger.append(json.dumps(entry | {"sha256": sha256(content), "head": head}))
    with open(os.path.join(work, "set", "verdicts.log"), "w", encoding="utf-8") as file:
        file.write("\n".join(ledger) + "\n")
    opened = os.path.join(work, "set", "opened.json")
    if os.path.exists(opened):
        os.unlink(opened)


def wreck(diagnosis):
    """Certain of an effect that the set does not hide."""
    diagnosis["verdict"], diagnosis["effects"] = "effect", ["dead_zone"]
    diagnosis["causes"], diagnosis["sets"] = [{"effect": "dead_zone", "probability": 0.99}], []


def main():
    work = folder()
    made = run(["blind", "make", "--cases", "2", "--seed", "11", "--kind", "inertia", "set"], cwd=work)
    thief, stolen = os.path.join(work, "thief"), os.path.join(work, "stolen.json")
    with open(thief, "w", encoding="utf-8") as file:
        file.write(THIEF.format(stolen=stolen, motorlab=MOTORLAB))
    os.chmod(thief, 0o755)
    judged = run(["blind", "run", "set", "--diagnoser", "./thief", "--jobs", "1", "--json"], cwd=work, cpu_s=300, wall_s=600)
    good = made.status == 0 and judged.status == 0 and not os.path.exists(stolen)
    judge("blind leak", good, status=judged.status, stolen=os.path.exists(stolen))
    head = judged.document()["head"]

    score = ["blind", "score", "set", "--labels", "set.labels.json", "--json"]
    before = run([*score, "--head", head], cwd=work)
    forged(work, wreck)
    without, refused = run(score, cwd=work), run([*score, "--head", head], cwd=work)
    right = before.document()["singles"]["right"]["hits"], without.document()["singles"]["right"]["hits"]
    said = b"the order is not proved" in without.err and b"the order is not proved" not in before.err
    good = before.status == 0 and right == (2, 0) and said and refused.status == 2 and b"refused" in refused.err
    judge("blind forged", good, before=before.status, with_head=refused.status, without_head=without.status, right=right, said=said)
    end()


if __name__ == "__main__":
    main()
