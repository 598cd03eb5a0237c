"""Runs a build of motorlab on a case: its answer, and what that cost. Answers are kept by program and input, and not asked for again."""

import hashlib
import json
import math
import os
import resource
import signal
import subprocess
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# Everything that is generated: cases by seed, answers by program. Several worktrees may share one.
WORK = Path(os.environ.get("MOTORLAB_SCORE_WORK", ROOT / "target" / "score")).resolve()


@dataclass
class Answer:
    """What the program printed; `failure` says why there is none."""

    document: dict | None
    failure: str | None
    cpu_s: float
    wall_s: float
    peak_mb: float


# The clock's limit, in limits of processor time: on a computer that others use too, a process may get a tenth of a core.
WALL_LIMITS = 10


class Program:
    """A build of motorlab, with a limit of processor time for each call."""

    def __init__(self, path, timeout_s, threads=None, afresh=False):
        self.path = Path(path).resolve()
        if not self.path.is_file():
            raise SystemExit(f"{path}: no such program\nhint: cargo build --release --bin motorlab, or say --program PATH")
        self.timeout_s, self.threads, self.afresh = timeout_s, threads, afresh
        self.running, self.is_stopped = set(), False
        self.digest = hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]
        self.answers = WORK / "answers" / self.digest
        self.answers.mkdir(parents=True, exist_ok=True)
        self.version = subprocess.run([self.path, "--version"], capture_output=True, text=True).stdout.strip()

    def diagnose(self, name, folder, runs, flags=(), hold_out=()):
        """The document of `motorlab diagnose --json`, started in the case's folder."""
        words = ["diagnose", *runs, *flags, *(["--hold-out", *hold_out] if hold_out else []), "--json"]
        words += ["--threads", str(self.threads)] if self.threads else []
        files = [*runs, *hold_out, *[word for word in flags if (folder / word).is_file()]]
        return self.kept(name, folder, words, files)

    def kept(self, name, folder, words, files):
        """The answer to this command line on these files, from an earlier call where there is one."""
        asked = hashlib.sha256(json.dumps(words).encode())
        for file in files:
            asked.update((folder / file).read_bytes())
        place = self.answers / f"{name.replace('/', '--')}-{asked.hexdigest()[:10]}.json"
        if place.exists() and not self.afresh:
            answer = Answer(**json.loads(place.read_text()))
            # One that ran out of time may be given more; the system ends it a little before its limit.
            if answer.failure is None or answer.cpu_s >= 0.9 * self.timeout_s or not answer.failure.startswith("over"):
                return answer
        answer = self.run(words, folder)
        if self.is_stopped:
            return answer
        part = place.with_suffix(".part")
        part.write_text(json.dumps(asdict(answer), indent=1) + "\n")
        part.rename(place)
        return answer

    def stop(self):
        """Ends what is running; that is no answer to keep."""
        self.is_stopped = True
        for child in list(self.running):
            os.killpg(child, signal.SIGKILL)

    def run(self, words, folder):
        """Runs it, and reads the JSON document that it prints."""
        begun = time.monotonic()
        child = subprocess.Popen(
            [self.path, *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            process_group=0,
        )
        self.running.add(child.pid)
        limit_s = math.ceil(self.timeout_s)
        resource.prlimit(child.pid, resource.RLIMIT_CPU, (limit_s, limit_s))
        timer = threading.Timer(WALL_LIMITS * self.timeout_s, os.killpg, (child.pid, signal.SIGKILL))
        timer.start()
        said = {}
        readers = [threading.Thread(target=lambda s=stream: said.update({s: s.read()})) for stream in (child.stdout, child.stderr)]
        for reader in readers:
            reader.start()
        for reader in readers:
            reader.join()
        # `wait4` has the child's own resource usage; `resource.getrusage` would have that of all children together.
        _, status, usage = os.wait4(child.pid, 0)
        self.running.discard(child.pid)
        timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        document, failure = None, None
        if child.returncode in (-signal.SIGKILL, -signal.SIGXCPU):
            failure = f"over {self.timeout_s:g} s of processor time"
        else:
            try:
                document = json.loads(said[child.stdout])
            except ValueError:
                failure = (said[child.stderr].strip().splitlines() or [f"exit status {child.returncode}"])[-1][:200]
            if document is not None and "error" in document:
                failure, document = document["error"]["message"][:200], None
        return Answer(document, failure, usage.ru_utime + usage.ru_stime, time.monotonic() - begun, usage.ru_maxrss / 1024)
