"""Raw logs with damage of every kind, replayed: an encoder of its own, damage, `replay`, and the truth beside it.

No row may differ from what was encoded, and rows and losses add up to the samples.   off.py [SECONDS]"""

import os
import random
import struct
import sys
import time

import wire
from instrument import end, folder, judge, rows_of, run, stated

SAMPLES = 1500
SECONDS = 20
KINDS = [(kind, rate) for kind in ("flip", "other", "not_zero", "drop", "double", "all", "swap") for rate in (1e-3, 1e-2, 3e-2)]
KINDS += [(kind, rate) for kind in ("frames_again", "frames_swapped", "frames_mixed") for rate in (0.01, 0.1, 0.5)]


def stream(r, ts_us, step, narrow):
    """Bytes of a recording, and the truth: time in us, counts, command in mV of each sample."""
    counts, begins_us, frames, truth = 0, r.randrange(2**32), [], []
    for k in range(SAMPLES):
        counts += r.randrange(-step, 3 * step)
        mv = 0 if k < 100 else 4500
        sent = (counts + 2**15) % 2**16 - 2**15 if narrow else counts
        frames.append(wire.data(k, begins_us + k * ts_us, sent, mv))
        truth.append((k * ts_us, counts, mv))
    return b"".join(frames), truth


def damaged(content, kind, rate, r):
    if kind.startswith("frames"):
        frames = content.split(b"\0")
        if kind == "frames_again":
            out = []
            for k, frame in enumerate(frames):
                out.append(frame)
                if r.random() < rate:
                    out += frames[max(0, k - r.randrange(1, 300)):][:r.randrange(1, 30)]
            frames = out
        for k in range(1, len(frames) - 3):
            if kind == "frames_swapped" and r.random() < rate:
                other = k + r.randrange(1, 3)
                frames[k], frames[other] = frames[other], frames[k]
            if kind == "frames_mixed" and r.random() < rate:
                at = r.randrange(1, 17)
                frames[k] = frames[k][:at] + frames[k - 1][at:]
        return b"\0".join(frames)
    out = bytearray()
    for byte in content:
        hit = lambda *kinds: kind in kinds and r.random() < rate  # noqa: E731
        if hit("drop", "all"):
            continue
        if hit("flip", "all"):
            byte ^= 1 << r.randrange(8)
        if hit("other", "all"):
            byte = r.randrange(256)
        if hit("not_zero") and byte:
            byte = r.randrange(1, 256)
        out.append(byte)
        if hit("double", "all"):
            out.append(byte)
        if hit("swap") and len(out) > 1:
            out[-1], out[-2] = out[-2], out[-1]
    return bytes(out)


def log_of(content, ts_us, fields):
    lines, at_us = ['# format = "motorlab-rawlog/1"', '# port = "x"', "# baud = 115200", '# profile = "step"'], 1000

    def said(arrow, content, later_us=700):
        nonlocal at_us
        lines.append(f"{at_us:10d} {arrow} " + " ".join(f"{byte:02x}" for byte in content))
        at_us += later_us

    def ask(kind, body, answer):
        said(">", wire.frame(kind, body))
        said("<", answer)

    profile = struct.pack("<HhHh", 100, 0, 65535, 4500)
    ask(wire.IDENTIFY, b"", wire.hello(fields=fields))
    ask(wire.CONFIGURE, struct.pack("<IB", ts_us, 0), wire.ack(wire.CONFIGURE))
    ask(wire.PROFILE, struct.pack("<HH", 2, wire.crc(profile)), wire.ack(wire.PROFILE))
    ask(wire.CHUNK, struct.pack("<H", 0) + profile, wire.ack(wire.CHUNK, 2))
    ask(wire.START, struct.pack("<I", SAMPLES), wire.ack(wire.START))
    for at in range(0, len(content), 180):
        said("<", content[at:at + 180], 10 * ts_us)
    said("<", b"\0" + wire.end(SAMPLES))
    return "\n".join(lines) + "\n"


def main():
    work, ends = folder(), time.monotonic() + float(sys.argv[1] if len(sys.argv) > 1 else SECONDS)
    log, out = os.path.join(work, "x.log"), os.path.join(work, "x.csv")
    total = {"logs": 0, "samples": 0, "rows": 0, "wrong": 0, "not_adding_up": 0}
    while time.monotonic() < ends:
        kind, rate = KINDS[total["logs"] % len(KINDS)]
        number = total["logs"]
        r = random.Random(9000 + number)
        ts_us, narrow = (3000, 30000, 1000)[number % 3], number // 3 % 2 == 1
        content, truth = stream(r, ts_us, (3, 50, 500)[number // 2 % 3], narrow)
        with open(log, "w", encoding="ascii") as file:
            file.write(log_of(damaged(content, kind, rate, r), ts_us, 4 if narrow else 0))
        if os.path.exists(out):
            os.unlink(out)
        ended = run(["replay", log, "-o", out])
        if ended.status not in (0, 1) or ended.crash():
            judge(f"off {kind} {rate}", False, status=ended.status, said=ended.last())
            break
        header, rows = rows_of(out)
        lost, wrong, last = int(stated(header, "summary.lost")), 0, -1
        if rows:
            first = int(rows[0][0])
            # A counter of 16 bits may begin anywhere.
            off = truth[first][1] - int(rows[0][4]) if narrow else 0
        for row in rows:
            seq = int(row[0])
            time_us, counts, mv = truth[seq] if seq < SAMPLES else (0, 0, 0)
            right = (last < seq < SAMPLES and round(float(row[1]) * 1e6) == time_us - truth[first][0]
                     and int(row[4]) + off == counts and round(float(row[3]) * 1000) == mv)
            wrong, last = wrong + (not right), seq
        adds_up = len(rows) + lost == SAMPLES
        if wrong or not adds_up:
            judge(f"off {kind} {rate} ({number})", False, rows=len(rows), lost=lost, wrong=wrong)
        for key, value in ("logs", 1), ("samples", SAMPLES), ("rows", len(rows)), ("wrong", wrong), ("not_adding_up", not adds_up):
            total[key] += value
    judge("off", total["logs"] >= len(KINDS), **total)
    end()


if __name__ == "__main__":
    main()
