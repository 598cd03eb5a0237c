"""Boards that print text: numbers that are none, times that fall back, lines without an end, floods.

A line is a row or is counted as none; what steers a terminal never reaches one; every recording ends."""

import concurrent.futures
import itertools
import os
import threading
import time

from fake import AT_A_TIME, Recorded, listen
from instrument import end, folder, judge

EVERY_S = 0.004


class Printer:
    """Writes lines until it is over."""

    def __init__(self, terminal, line, every_s):
        self.terminal, self.line, self.every_s = terminal, line, every_s
        self.over, self.sent = False, 0
        os.set_blocking(terminal, False)
        self.thread = threading.Thread(target=self.serve, daemon=True)

    def serve(self):
        for number in itertools.count():
            content, at = self.line(number), 0
            while at < len(content):
                if self.over:
                    return
                try:
                    at += os.write(self.terminal, content[at:at + 4000])
                except BlockingIOError:
                    time.sleep(0.001)
            self.sent += 1
            time.sleep(self.every_s)


def record(name, work, line, columns="t_us,counts,pwm", duration=1, every_s=EVERY_S, limit_s=40):
    out = os.path.join(work, f"{name}.csv")
    command = ["--columns", columns, "--duration", str(duration), "--supply", "9", "--counts-per-rev", "720",
               "--patience", "2", "-o", out]

    def printer(near):
        printer = Printer(near, line, every_s)
        printer.thread.start()
        return printer

    ended, printer = listen(command, limit_s, printer)
    return Recorded(ended, out, printer.sent)


def none(words="could be read as a sample"):
    return lambda run: run.status == 3 and run.rows is None and words in run.said


def counts(of, status=(0,)):
    """Each row has the counts that `of` gives for its time, in steps of 5 ms from the first."""
    def right(run):
        first = round(int(run.rows[0][4]) / (of(1) - of(0))) if run.rows else 0
        return run.status in status and len(run.rows) > 150 and all(
            int(row[4]) == of(first + round(float(row[1]) / 0.005)) for row in run.rows)
    return right


def questions():
    def line(counts=lambda k: 3 * k, time_us=lambda k: 5000 * k, pwm="128"):
        return lambda k: b"%d,%s,%s\r\n" % (time_us(k), str(counts(k)).encode(), pwm.encode())

    sound = line()
    yield "sound", sound, {}, counts(lambda k: 3 * k)
    yield "escapes", lambda k: b"\x1b[2J\x1b]0;x\x07" + sound(k), {}, none()
    yield "not_a_number", line(counts=lambda k: "nan"), {}, none()
    yield "beyond_64_bits", line(counts=lambda k: 10**30), {}, none()
    yield "huge_pwm", line(pwm="1e308"), {}, lambda run: run.status in (1, 3) and "beyond the 255" in run.said and not run.rows
    yield "time_falls", line(time_us=lambda k: -5000 * k), {}, lambda run: run.status == 3 and "was reset" in run.said
    again = line(time_us=lambda k: (k % 50) * 5000)
    yield "time_begins_again", again, {}, lambda run: run.status == 3 and "was reset" in run.said and len(run.rows) <= 50
    yield "time_wraps", line(time_us=lambda k: (2**32 - 500_000 + 5000 * k) % 2**32), {}, counts(lambda k: 3 * k)
    narrow = line(counts=lambda k: (300 * k + 2**15) % 2**16 - 2**15)
    yield "counts_wrap", narrow, {}, counts(lambda k: 300 * k)
    leaps = line(counts=lambda k: 3 * k + (1_000_000 if k % 50 == 49 else 0))
    # A count that leaps and comes back is skipped, and counted as lost.
    passed_over, goes_on = lambda run: int(run.of("summary.lost")) >= 3, counts(lambda k: 3 * k, (1,))  # noqa: E731
    yield "a_digit_changes", leaps, {}, lambda run: goes_on(run) and passed_over(run)
    yield "no_line_end", lambda k: b"1" * 4000, {"every_s": 0}, none("it sent")
    yield "labels_of_nothing", lambda k: b"a:b:c,,;;\x1b[31m<script>\n", {"columns": "auto"}, none()
    yield "a_hundred_columns", lambda k: b",".join(b"%d" % i for i in range(100)) + b"\n", {}, none("100 fields")
    yield "empty_lines", lambda k: b"\r\n", {}, none("on")
    flood = lambda k: b"".join(sound(100 * k + j) for j in range(100))  # noqa: E731
    yield "flood", flood, {"every_s": 0, "duration": 300}, lambda run: run.status in (0, 1) and len(run.rows) == 60_000


def main():
    work, asked = folder(), list(questions())
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        runs = pool.map(lambda one: record(one[0], work, one[1], **one[2]), asked)
        for (name, _, _, right), run in zip(asked, runs):
            judge(f"text {name}", run.crash is None and right(run), **run.facts())
    end()


if __name__ == "__main__":
    main()
