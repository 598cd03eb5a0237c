"""Shared parts of the instruments: which program, a folder of their own, and how an answer is judged.

An instrument prints a line for each question and ends with status 1 if any answer is wrong."""

import atexit
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

MOTORLAB = os.path.abspath(os.environ["MOTORLAB"]) if "/" in os.environ.get("MOTORLAB", "") else "motorlab"
HERE = os.path.dirname(os.path.abspath(__file__))
SEEDS = os.path.join(HERE, "seeds")
CASES = os.path.join(HERE, "..", "..", "fixtures", "cases", "recorder")
# Memory that a child may hold, and time of one core that it may take: bounds that end a flood and a hang.
MOST_MIB = 1024
MOST_CPU_S = 20

_wrong = []


def folder():
    """A folder that goes when the instrument ends."""
    path = tempfile.mkdtemp(prefix="instrument-")
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


def judge(name, good, **facts):
    """Prints one answer and keeps it if it is wrong."""
    said = ", ".join(f"{key} {value}" for key, value in facts.items())
    print(f"{'ok   ' if good else 'WRONG'} {name}: {said}", flush=True)
    if not good:
        _wrong.append(name)


def end():
    """Ends the instrument with the status that its answers give."""
    if _wrong:
        print(f"{len(_wrong)} wrong: {', '.join(_wrong)}")
    sys.exit(1 if _wrong else 0)


class Ended:
    """How a child ended: status (negative: a signal), what it said, and what it took."""

    def __init__(self, status, out, err, usage, wall_s, hung):
        self.status, self.out, self.err, self.hung = status, out, err, hung
        self.cpu_s = usage.ru_utime + usage.ru_stime
        self.mib = usage.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
        self.wall_s = wall_s

    def crash(self):
        """Failure that no input may cause, in a word; none if absent."""
        if self.hung or self.status == -signal.SIGXCPU:
            return "hang"
        if self.status == 101 or b"panicked" in self.err:
            return "panic"
        if self.status not in (0, 1, 2, 3):
            return f"status {self.status}"
        if self.mib > MOST_MIB:
            return f"memory {self.mib:.0f} MiB"
        if self.status in (2, 3) and not self.err.strip():
            return "silent failure"
        if self.status in (2, 3) and len(self.err) > 4000:
            return f"{len(self.err)} bytes of message"
        if any(byte < 32 and byte not in b"\t\n\r" or byte == 127 for byte in self.err):
            return "control characters"
        return None

    def document(self):
        """The JSON document on standard output; none if there is no such."""
        try:
            return json.loads(self.out)
        except ValueError:
            return None

    def last(self):
        """The last words on standard error."""
        return self.err.decode(errors="replace").strip()[-160:]


def run(arguments, cwd=None, cpu_s=MOST_CPU_S, wall_s=180, memory_mib=3072, file_bytes=None, program=None):
    """Runs the program to its end, within bounds."""
    def bounds():
        resource.setrlimit(resource.RLIMIT_AS, (memory_mib << 20, memory_mib << 20))
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 5))
        if file_bytes:
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begun = time.monotonic()
        child = subprocess.Popen([program or MOTORLAB, *arguments], stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                 cwd=cwd, preexec_fn=bounds, env=dict(os.environ, RUST_BACKTRACE="0"))
        hung = False
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - begun > wall_s and not hung:
                hung = True
                child.kill()
            time.sleep(0.002 if time.monotonic() - begun < 1 else 0.05)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Ended(child.returncode, out.read(), err.read(), usage, time.monotonic() - begun, hung)


def rows_of(path):
    """Header lines, and rows as lists of cells, of a run file."""
    header, rows = [], []
    with open(path, encoding="utf-8") as file:
        for line in file.read().split("\n"):
            if line.startswith("#"):
                header.append(line[1:].strip())
            elif line:
                rows.append(line.split(","))
    return header, rows[1:]


def stated(header, key):
    """The value of a key of a run's header, as text; none if it is not there."""
    for line in header:
        name, _, value = line.partition(" = ")
        if name == key:
            return value
    return None
