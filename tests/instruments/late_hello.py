"""A copy of HELLO comes late, in mid-run, from a board whose counter has 16 bits.

Every row must hold the counts that the board sent, unwrapped: no row may differ from the sum of the steps."""

import os
import pty
import select
import struct
import subprocess
import sys
import tempfile
import tty

from wire import Dec, frame

MOTORLAB = os.environ.get("MOTORLAB", "motorlab")
BOARD = "virtual:?counter_bits=16&counts_per_rev=200000"
SAMPLES = 1000  # 3 s at 3 ms: 65,536 counts pass several times
LATE_AFTER = 600  # samples


def main():
    out = os.path.join(tempfile.mkdtemp(), "run.csv")
    board = subprocess.Popen([MOTORLAB, "virtual", BOARD], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    port = os.open(board.stdout.readline().decode().split()[-1], os.O_RDWR | os.O_NOCTTY)
    tty.setraw(port)
    near, far = pty.openpty()
    tty.setraw(far)
    capture = subprocess.Popen(
        [MOTORLAB, "capture", os.ttyname(far), "--ts", "0.003", "--duration", "3", "-o", out],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    decoder, hello, injected, sent = Dec(), None, False, []
    while capture.poll() is None:
        ready, _, _ = select.select([port, near], [], [], 0.01)
        if port in ready:
            data = os.read(port, 4096)
            if not injected and hello and len(sent) > LATE_AFTER:
                at = data.rfind(b"\0") + 1
                data, injected = data[:at] + hello + data[at:], True
            for kind, body in decoder.push(data):
                if kind == 1 and hello is None:
                    hello = b"\0" + frame(1, body)
                if kind == 4:
                    sent.append(struct.unpack("<i", body[6:10])[0])
            os.write(near, data)
        if near in ready:
            os.write(port, os.read(near, 4096))
    board.terminate()
    board.wait()
    truth = sent[:1]
    for before, now in zip(sent, sent[1:]):
        truth.append(truth[-1] + (now - before + 32768) % 65536 - 32768)
    with open(out) as file:
        rows = [line.split(",") for line in file if not line.startswith("#")][1:]
    counts = [int(row[4]) for row in rows]
    wrong = sum(a != b for a, b in zip(counts, truth))
    print(f"late_hello: status {capture.returncode}, {len(rows)} rows, {wrong} wrong, injected {injected}, "
          f"{(max(truth) - min(truth)) // 65536} wraps")
    good = capture.returncode == 0 and len(rows) == SAMPLES == len(truth) and wrong == 0 and injected
    return 0 if good and max(truth) - min(truth) > 65536 else 1


if __name__ == "__main__":
    sys.exit(main())
