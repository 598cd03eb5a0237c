"""Throughput of diagnoses on two cores, and what one diagnosis needs of memory.

    cargo build --release
    python benches/fleet.py MOTORLAB [TURNS]

Eight recordings of fixtures/ are diagnosed over and over: by two workers with one thread each, and by one worker with two threads. Both go
on at the same time until each has been through all of them, so that whatever else the machine does takes as much from both. The figure is
the ratio of their times, the median of all turns. Memory is the most that a process held (ru_maxrss), over recordings of 15 s at both
sample times of the lab handout.
"""

import itertools
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

FIXTURES = Path(__file__).resolve().parents[1] / "fixtures"
LOGS = ["step30", "step3", "reversing3", "faults", "plain_sketch", "uno_step3", "mega_step30", "uno_reversing3"]
EFFECTS = {"nothing to explain": "", "backlash": "[effects.backlash]\ngap_rad = 0.03\n", "stribeck": "[effects.stribeck]\n"}


def motorlab(*words):
    """Starts the program, without its words."""
    words = [PROGRAM, *map(str, words)]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def answered(process):
    """Waits until the program has given an answer; what it took of memory in MB and of processor time in s."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode in (0, 1), process.args
    return usage.ru_maxrss / 1000, usage.ru_utime + usage.ru_stime


class Way:
    """So many workers with so many threads each, which take the next recording until all ways have been through all of them."""

    def __init__(self, workers, threads):
        self.workers, self.threads = workers, threads
        self.began, self.ended = time.perf_counter(), []
        self.next = itertools.count()

    def work(self, runs, ways):
        while any(len(way.ended) < len(runs) for way in ways):
            run = runs[next(self.next) % len(runs)]
            assert motorlab("diagnose", run, "--threads", self.threads, "--json").wait() in (0, 1), run
            self.ended.append(time.perf_counter() - self.began)


def throughput(folder, turns):
    runs = [folder / f"{name}.csv" for name in LOGS]
    for name, run in zip(LOGS, runs):
        motorlab("replay", FIXTURES / f"{name}.log", "-o", run).wait()
    ratios = []
    for _ in range(turns):
        ways = [Way(2, 1), Way(1, 2)]
        workers = [threading.Thread(target=way.work, args=(runs, ways)) for way in ways for _ in range(way.workers)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        took = [way.ended[len(runs) - 1] for way in ways]
        ratios.append(took[0] / took[1])
        print(f"two workers of one thread {took[0]:.2f} s, one of two threads {took[1]:.2f} s: {ratios[-1]:.3f}", flush=True)
    print(f"throughput with two threads, over that of two single threads: {statistics.median(ratios):.3f}")


def memory(folder):
    for sample_time in ("0.003", "0.03"):
        for name, motor in EFFECTS.items():
            run = folder / f"{name.split()[0]}_{sample_time}.csv"
            (folder / "motor.toml").write_text(motor)
            words = ("--ts", sample_time, "--duration", 15, "--profile", "reversing", "--motor", folder / "motor.toml")
            assert motorlab("simulate", *words, "-o", run).wait() == 0
            held_mb, seconds = answered(motorlab("diagnose", run, "--threads", 1, "--json"))
            print(f"15 s at {sample_time} s, {name}: {held_mb:.0f} MB, {seconds:.1f} s of processor time")


if __name__ == "__main__":
    PROGRAM = sys.argv[1]
    with tempfile.TemporaryDirectory() as work:
        throughput(Path(work), int(sys.argv[2]) if len(sys.argv) > 2 else 9)
        memory(Path(work))
