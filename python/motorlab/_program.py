"""The program's commands that read or write devices and files, each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

from ._motorlab import MotorlabError

# Above this exit status the device or the file system failed; 1 is an answer that fell short.
_FELL_SHORT = 1


def document(*words: object) -> dict[str, Any]:
    """The JSON document of a command. Its messages stay on standard error; Ctrl-C reaches it, and it leaves whole files."""
    command = [sys.executable, "-m", "motorlab", *(str(word) for word in words), "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        printed, _ = process.communicate()
    except KeyboardInterrupt:
        # The program has heard it, too: it ends the recording properly.
        printed, _ = process.communicate()
        if not printed.strip():
            raise
    try:
        found = json.loads(printed)
    except ValueError:
        raise MotorlabError(f"the program ended with status {process.returncode} and printed no document") from None
    if process.returncode > _FELL_SHORT or "error" in found:
        raise _raised(found.get("error", {}))
    return found


def _raised(told: dict[str, Any]) -> MotorlabError:
    error = MotorlabError(told.get("message", "the program failed"))
    for key in ("kind", "file", "row", "remedy"):
        setattr(error, key, told.get(key))
    return error


def flags(**given: Any) -> list[str]:
    """Flags of the program: ``counts_per_rev=720`` is ``--counts-per-rev=720``; ``True`` is a flag alone, ``None`` and ``False`` none."""
    words = []
    for name, value in given.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(flag)
        elif value is not None and value is not False:
            words.append(f"{flag}={value}")
    return words
