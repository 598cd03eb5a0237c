"""Whether two programs say the same: JSON documents and run files, named as FIRST SECOND, both for the same input.

Texts must be equal. Numbers may differ by what another mathematical library makes of them, and so may what was measured
with the computer's clock.
"""

import json
import math
import pathlib
import re
import sys

# Share by which numbers may differ: other last bits of a sine came to 5e-9 in a diagnosis's figures.
SHARE = 1e-6
# Least difference that counts, in whatever unit: digits that a document does not show.
LEAST = 1e-9
# Keys whose values come from a clock.
OTHERWISE = {"elapsed_s"}


def differences(first, second, where=""):
    """Yields where two documents differ."""
    if isinstance(first, dict) and isinstance(second, dict):
        for key in sorted(first.keys() | second.keys()):
            if key in OTHERWISE:
                continue
            if key not in first or key not in second:
                yield f"{where}.{key} is in one alone"
            else:
                yield from differences(first[key], second[key], f"{where}.{key}")
    elif isinstance(first, list) and isinstance(second, list):
        if len(first) != len(second):
            yield f"{where}: {len(first)} and {len(second)} items"
        for index, pair in enumerate(zip(first, second)):
            yield from differences(*pair, f"{where}[{index}]")
    elif is_number(first) and is_number(second):
        if not math.isclose(first, second, rel_tol=SHARE, abs_tol=LEAST):
            yield f"{where}: {first} and {second}"
    elif as_typed(first) != as_typed(second):
        yield f"{where}: {first!r} and {second!r}"


def as_typed(value):
    """A text without the quotes that PowerShell alone needs, around words with a comma."""
    return re.sub(r"'([^' ]*,[^' ]*)'", r"\1", value) if isinstance(value, str) else value


def is_number(value):
    """A number and no truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def read(path):
    """A JSON document, or the lines of a run file without its clock."""
    text = pathlib.Path(path).read_bytes().decode("utf-8")
    if text.startswith("{"):
        return json.loads(text)
    return [line for line in text.split("\n") if not re.match(r"# started = ", line)]


found = list(differences(read(sys.argv[1]), read(sys.argv[2])))
for line in found[:10]:
    print(f"{sys.argv[1]} and {sys.argv[2]}{line}", file=sys.stderr)
sys.exit(1 if found else 0)
