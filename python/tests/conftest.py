"""Shared parts of the tests: the program beside the package, and runs that it made."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")

PROGRAM = Path(sys.executable).parent / "motorlab"
FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"


def program(*arguments: object) -> subprocess.CompletedProcess[str]:
    """The program that the package brings."""
    words = [str(PROGRAM), *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)


def document(*arguments: object) -> dict:
    """Its JSON document."""
    return json.loads(program(*arguments, "--json").stdout)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that the firmware recorded on an emulated board that turned the lab handout's motor."""
    path = tmp_path_factory.mktemp("recorded") / "reversing3.csv"
    done = program("replay", FIXTURES / "uno_reversing3.log", "-o", path)
    assert path.exists(), done.stderr
    return path


@pytest.fixture(autouse=True)
def ctrl_c():
    """Ctrl-C as at a terminal: a shell has what it starts in the background ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
