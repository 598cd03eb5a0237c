"""Makes docs/peers: motorlab and other tools on the same files.

    tests/thorough/peers/run [--only PART]... [--bin MOTORLAB] [--blind DIR]

The recordings are looked for in ../shared/real beside the working copy, or where MOTORLAB_REAL says. `--only` measures parts again, such as
a set; the others stay as they were.
"""
import argparse
import os
import sys
import tempfile
from pathlib import Path

# One thread: processor times are those of the work.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"
sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "real"))

import axis  # noqa: E402
import detection  # noqa: E402
import motor_sets  # noqa: E402
import page  # noqa: E402
import servo  # noqa: E402
import simulation  # noqa: E402
from recordings import ROOT, program, recordings, sets  # noqa: E402

OUT = ROOT / "docs" / "peers"
# In the order of the page; each returns its text, its picture, and its row in the table of all sets.
PARTS = {"emps": axis.part, "xl330": servo.part} | {name: motor_sets.part for name in motor_sets.RESTART_S}
PARTS |= {"detection": detection.part, "simulation": simulation.part}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append")
    parser.add_argument("--bin")
    parser.add_argument("--blind", metavar="DIR", help="the folder that tests/blind/publish --breadth filled, for the part detection")
    given = parser.parse_args()
    every = {one["name"]: one for one in sets()}
    if unknown := set(given.only or ()) - set(PARTS):
        sys.exit(f"no part is called {unknown.pop()}; hint: one of " + ", ".join(PARTS))
    if not recordings().is_dir():
        sys.exit(f"there are no recordings in {recordings()}; hint: MOTORLAB_REAL names their folder")
    motorlab = program(given.bin)
    OUT.mkdir(exist_ok=True)
    for part in given.only or PARTS:
        with tempfile.TemporaryDirectory() as work:
            text, *rest = PARTS[part](motorlab, given.blind if part == "detection" else every.get(part), Path(work))
        page.keep(OUT, part, text, *rest)
        print(text, flush=True)
    page.write(OUT, PARTS)


main()
