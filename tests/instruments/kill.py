"""Signals, SIGKILL among them, at random instants of a recording.

SIGKILL costs at most 50 ms of samples; the others end the file properly; a moment's suspension costs nothing. The remaining rows can be compared, and a raw log replayed.   kill.py [NUMBER]: so many recordings."""

import concurrent.futures
import os
import random
import signal
import sys
import time

from instrument import end, folder, judge, rows_of, run, stated
from middle import Middle

SIGNALS = [signal.SIGKILL, signal.SIGTERM, signal.SIGKILL, signal.SIGINT, signal.SIGHUP, signal.SIGSTOP]
NUMBER, AT_A_TIME = 12, 3
MOST_MISSING_MS = 50
# What a recorder waits for a core it cannot record: such time counts for it, in the last second before the signal; and one that
# waited for so long in all may be given up by the board.
LOOKED_BACK_S, STARVED_MS = 1, 200


def waited_ms(pid):
    """How long the threads of a process have waited for a core so far; 0 where the system does not say."""
    total = 0
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/schedstat", encoding="ascii") as file:
                total += int(file.read().split()[1])
    except (OSError, IndexError):
        pass
    return total / 1e6


def trial(number, work):
    r = random.Random(number)
    name, ts = SIGNALS[number % len(SIGNALS)], 0.003 if number % 4 < 2 else 0.03
    out, log = os.path.join(work, f"{number}.csv"), os.path.join(work, f"{number}.log")
    logged = ["--log", log] if number % 3 == 0 else []
    middle = Middle("virtual:?seed=3", ["--ts", str(ts), "--duration", "4", "-o", out, *logged])
    begun = time.monotonic()
    at, sent_at, goes_on = begun + r.uniform(0.5, 3), None, None
    waits, waited = [(begun, 0.0)], 0.0
    while middle.step(0.002) and time.monotonic() < begun + 20:
        now = time.monotonic()
        if sent_at is None and now > waits[-1][0] + 0.05:
            waits.append((now, waited_ms(middle.capture.pid)))
        if sent_at is None and now >= at and len(middle.sent) > 20:
            waited = waited_ms(middle.capture.pid)
            sent_at = now
            middle.capture.send_signal(name)
            goes_on = now + r.choice([0.1, 0.2]) if name == signal.SIGSTOP else None
        if goes_on and now > goes_on:
            middle.capture.send_signal(signal.SIGCONT)
            goes_on = None
    status, said = middle.close()
    with open(out, encoding="utf-8") as file:
        torn = not file.read().endswith("\n")
    header, rows = rows_of(out)
    rows = rows[:-1] if torn else rows
    last = int(rows[-1][0]) if rows else -1
    missing = [at for seq, _, _, _, at in middle.sent if seq > last and at <= sent_at]
    missing_ms = 1000 * (sent_at - min(missing)) if missing else 0.0
    before = max((one for one in waits if one[0] < sent_at - LOOKED_BACK_S), default=waits[0])[1]
    compared = run(["compare", out])
    replayed = run(["replay", log, "-o", log + ".csv"]) if logged else None
    readable = compared.status == 0 and compared.crash() is None
    readable = readable and (replayed is None or replayed.status in (0, 1, 3) and replayed.crash() is None)
    complete = stated(header, "complete") == "true"
    if name == signal.SIGKILL:
        good = status == -signal.SIGKILL and missing_ms <= MOST_MISSING_MS + waited - before and not complete
    elif name == signal.SIGSTOP:
        starved = status == 3 and "heard nothing" in said and waited > STARVED_MS
        good = (status == 0 and complete or starved) and len(rows) == middle.ended[0]
    else:
        good = status == 1 and middle.ended is not None and len(rows) == middle.ended[0] and not missing
    facts = {"signal": name.name, "status": status, "rows": len(rows), "missing": f"{missing_ms:.1f} ms", "waited": f"{waited - before:.0f} ms", "readable": readable}
    return good and readable, facts | ({} if good else {"said": repr(said[-160:])})


def main():
    number, work = int(sys.argv[1]) if len(sys.argv) > 1 else NUMBER, folder()
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        for k, (good, facts) in enumerate(pool.map(lambda k: trial(k, work), range(number))):
            judge(f"kill {k}", good, **facts)
    end()


if __name__ == "__main__":
    main()
