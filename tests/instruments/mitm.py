"""Damage in the middle between a virtual board and the recorder.

No row may differ from what the board sent; rows and losses add up to the samples taken, and a run that lacks some
does not end with status 0.   mitm.py [long]: all kinds at all rates and both sample times."""

import concurrent.futures
import os
import random
import sys
import time

from instrument import end, folder, judge, rows_of, stated
from middle import Middle

# Kinds of damage, and their rates a byte: those of the short form, and those of the long one.
KINDS = {
    "none": ([0], [0]),
    "drop": ([1e-3], [1e-4, 1e-3, 1e-2, 5e-2]),
    "flip": ([1e-3], [1e-4, 1e-3, 1e-2, 5e-2]),
    "flip4": ([1e-2], [1e-3, 1e-2, 5e-2]),
    "double": ([1e-3], [1e-3, 1e-2]),
    "all": ([1e-3], [1e-3, 1e-2, 3e-2]),
    "reorder": ([1e-3], [1e-3, 1e-2]),
    "delay": ([1e-4], [1e-4, 1e-3]),
    "zero": ([1e-2], [1e-3, 1e-2]),
    "burst": ([1e-3], [1e-3, 5e-3]),
    "stuck": ([1e-2], [1e-3, 1e-2]),
    "replay": ([1e-3], [1e-3, 1e-2]),
}
AT_A_TIME = 4


class Damage:
    def __init__(self, kind, rate, number, after=0):
        self.kind, self.rate, self.random = kind, rate, random.Random(number)
        self.after, self.passed = after, 0  # bytes that come whole
        self.held, self.old = b"", b""

    def __call__(self, content):
        self.passed += len(content)
        return content if self.passed <= self.after else self.damaged(content)

    def damaged(self, content):
        r, hit = self.random, lambda share: self.random.random() < share
        if self.kind == "replay":  # an old block once more
            self.old = (self.old + content)[-400:]
            return content + (self.old[-r.randrange(1, 400):] if hit(self.rate * len(content)) else b"")
        if self.kind == "reorder":
            content, self.held = content + self.held, b""
            if hit(self.rate * len(content)) and len(content) > 1:
                at = r.randrange(1, len(content))
                self.held, content = content[:at], content[at:]
            return content
        if self.kind == "delay":
            if hit(self.rate * len(content)):
                time.sleep(r.random() * 0.4)
            return content
        out, skipped = bytearray(), 0
        for byte in content:
            if skipped:
                skipped -= 1
                continue
            if self.kind == "burst" and hit(self.rate):
                length = r.randrange(1, 60)
                out += r.randbytes(r.choice([0, length, length // 2]))
                skipped = length - 1
                continue
            if self.kind in ("drop", "all") and hit(self.rate):
                continue
            if self.kind in ("flip", "all") and hit(self.rate):
                byte ^= 1 << r.randrange(8)
            if self.kind in ("flip4", "all") and hit(self.rate):
                for _ in range(4):
                    byte ^= 1 << r.randrange(8)
            if self.kind == "stuck" and hit(self.rate):
                byte = r.choice([0, 255, 17, 4])
            if self.kind == "zero" and hit(self.rate):
                out.append(0)
            out.append(byte)
            if self.kind in ("double", "all") and hit(self.rate):
                out.append(byte)
        return bytes(out)


def wrong_rows(rows, sent):
    """How many rows come twice, or differ from what was sent."""
    seen, wrong = set(), 0
    for row in rows:
        seq = int(row[0])
        was = sent.get(seq & 0xFFFF)
        right = was is not None and was[0] == int(row[4]) and abs(was[1] / 1000 - float(row[3])) < 1e-9
        wrong += seq in seen or not right
        seen.add(seq)
    return wrong


def trial(name, ts, duration, kind, rate, number, both, work):
    out = os.path.join(work, f"{name}.csv")
    spec = "virtual:?seed=7&effect=backlash&gap_rad=0.02" if number % 3 else "virtual:?seed=7"
    arguments = ["--ts", str(ts), "--duration", str(duration), "-o", out,
                 "--profile", "reversing" if number % 2 else "step"]
    board = Damage(kind, rate, number, 0 if number % 4 else 150)
    host = Damage(kind, rate, number + 1) if both else lambda content: content
    middle = Middle(spec, arguments, board, host)
    by_itself = middle.to_the_end(3 * duration + 25)
    status, said = middle.close()
    if not os.path.exists(out):
        # No agreement with the board: nothing was recorded, and that is said.
        return name, by_itself and status == 3 and "error" in said, {"status": status, "said": repr(said[-80:])}
    header, rows = rows_of(out)
    wrong = min((wrong_rows(rows, sent) for sent in middle.runs()), default=len(rows))
    sent = middle.sent
    lost = int(stated(header, "summary.lost") or 0)
    taken = middle.ended[0] if middle.ended else len(sent)
    adds_up = len(rows) + lost == taken or status == 3
    status_is_right = status == (0 if len(rows) == taken and lost == 0 else 1) or status in (1, 3)
    complete = stated(header, "complete") == "true"
    good = by_itself and wrong == 0 and adds_up and status_is_right and not (complete and lost)
    return name, good, {"status": status, "sent": len(sent), "taken": taken, "rows": len(rows), "lost": lost, "wrong": wrong}


def main():
    is_long = sys.argv[1:] == ["long"]
    work, trials, number = folder(), [], 1000
    for ts, duration in ((0.003, 6), (0.03, 8)) if is_long else ((0.003, 2),):
        for kind, rates in KINDS.items():
            for rate in rates[is_long]:
                ways = (False, True) if kind in ("drop", "flip", "all") and rate <= 1e-3 else (False,)
                for both in ways:
                    number += 1
                    name = f"{kind}_{rate}_{ts}{'_both' if both else ''}"
                    trials.append((name, ts, duration, kind, rate, number, both, work))
    rows = wrong = 0
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        for name, good, facts in pool.map(lambda one: trial(*one), trials):
            judge(f"mitm {name}", good, **facts)
            rows += facts.get("rows", 0)
            wrong += facts.get("wrong", 0)
    judge("mitm", rows > 300 * len(trials) / 2, captures=len(trials), rows=rows, wrong=wrong)
    end()


if __name__ == "__main__":
    main()
