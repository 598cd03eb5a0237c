"""A board on a pseudo-terminal that says what it is told to say, and a recorder that listens to it."""

import os
import pty
import select
import struct
import subprocess
import threading
import time
import tty

import wire
from instrument import MOTORLAB, MOST_MIB, Ended, rows_of, stated


# Boards at a time: they wait, most of the time.
AT_A_TIME = 3


class Board:
    """Answers as PROTOCOL.md says, but where `says` has something else: bytes for `hello` and `start`, functions
    of the board for `first` (before anything) and `run` (instead of the samples); `heeds_stop`."""

    def __init__(self, terminal, says):
        self.terminal, self.says = terminal, says
        self.over, self.sent, self.asked, self.ts_us, self.started = False, 0, 0, 3000, 0.0
        self.segments, self.stopped = [], False
        self.thread = threading.Thread(target=self.serve, daemon=True)

    def write(self, content):
        at = 0
        while at < len(content) and not self.over:
            if select.select([], [self.terminal], [], 0.2)[1]:
                try:
                    at += os.write(self.terminal, content[at:at + 4096])
                except OSError:
                    return

    def serve(self):
        decoder = wire.Decoder()
        if "first" in self.says:
            self.says["first"](self)
        while not self.over:
            if not select.select([self.terminal], [], [], 0.01)[0]:
                continue
            try:
                content = os.read(self.terminal, 4096)
            except OSError:
                time.sleep(0.01)
                continue
            for kind, body in decoder.push(content):
                self.answer(kind, body)

    def answer(self, kind, body):
        if kind == wire.IDENTIFY:
            self.write(self.says.get("hello", wire.hello()))
        elif kind == wire.CONFIGURE:
            self.ts_us = struct.unpack("<I", body[:4])[0]
            self.write(wire.ack(kind))
        elif kind == wire.PROFILE:
            self.segments = []
            self.write(wire.ack(kind))
        elif kind == wire.CHUNK:
            index = struct.unpack("<H", body[:2])[0]
            del self.segments[index:]
            self.segments += struct.iter_unpack("<Hh", body[2:])
            self.write(wire.ack(kind, len(self.segments)))
        elif kind == wire.START:
            self.asked = struct.unpack("<I", body[:4])[0]
            self.write(self.says.get("start", wire.ack(kind)))
            if not self.started:
                self.started = time.monotonic()
                self.says.get("run", Board.samples)(self)
        elif kind == wire.STOP and self.says.get("heeds_stop", True):
            self.write(wire.end(self.sent, 0, 1))

    def command_mv(self, number):
        """Command of the received profile for a sample."""
        for samples, mv in self.segments:
            if number < samples:
                return mv
            number -= samples
        return self.segments[-1][1] if self.segments else 0

    def counts(self, number):
        """A shaft that follows its command slowly."""
        moving = next((k for k in range(number + 1) if self.command_mv(k)), number) if number < 2000 else 0
        return (number - moving) // 3

    def sample(self, number, **other):
        """DATA of a sound board, but for what is given: seq, time_us, counts, command_mv."""
        facts = {"seq": number, "time_us": 1000 + number * self.ts_us, "counts": self.counts(number),
                 "command_mv": self.command_mv(number)} | other
        return wire.data(**facts)

    def samples(self, of=None, number=None, ending=None, rate=1):
        """Sends samples in time; `of(k)` gives the bytes of the k-th, `ending` those of END."""
        number = self.asked if number is None else number
        for k in range(number):
            while not self.over and time.monotonic() < self.started + k * self.ts_us * 1e-6 / rate:
                time.sleep(0.001)
            if self.over or select.select([self.terminal], [], [], 0)[0] and self.hears_stop():
                break
            self.write(of(k) if of else self.sample(k))
            self.sent += 1
        self.write(wire.end(self.sent) if ending is None else ending)

    def hears_stop(self):
        """Whether STOP has come during the run, to a board that heeds it."""
        try:
            frames = wire.Decoder().push(os.read(self.terminal, 4096))
        except OSError:
            return True
        return self.says.get("heeds_stop", True) and any(kind == wire.STOP for kind, _ in frames)


class Recorded:
    """Result of a recording."""

    def __init__(self, ended, path, board_sent):
        self.status, self.crash, self.said = ended.status, ended.crash(), (ended.err + ended.out).decode(errors="replace")
        self.wall_s, self.sent = ended.wall_s, board_sent
        self.header, self.rows = rows_of(path) if os.path.exists(path) else ([], None)

    def of(self, key):
        return stated(self.header, key)

    def facts(self):
        rows = None if self.rows is None else len(self.rows)
        return {"status": self.status, "rows": rows, "lost": self.of("summary.lost"), "crash": self.crash,
                "wall": f"{self.wall_s:.1f} s", "said": repr(self.said[:110])}


def listen(command, limit_s, terminal_of):
    """Runs a recorder to its end; `terminal_of(near)` begins what writes, and gives what ends it."""
    near, far = pty.openpty()
    tty.setraw(far)
    begun = time.monotonic()
    with open(command[-1] + ".said", "w+b") as said:
        child = subprocess.Popen([MOTORLAB, "capture", os.ttyname(far), *command], stdin=subprocess.DEVNULL, stdout=said,
                                 stderr=subprocess.STDOUT, env=dict(os.environ, RUST_BACKTRACE="0"))
        writer = terminal_of(near)
        hung = False
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - begun > limit_s and not hung:
                hung = True
                child.kill()
            time.sleep(0.02)
        child.returncode = os.waitstatus_to_exitcode(status)
        writer.over = True
        writer.thread.join(3)
        os.close(far)
        os.close(near)
        said.seek(0)
        return Ended(child.returncode, b"", said.read(), usage, time.monotonic() - begun, hung), writer


def record(name, work, says, ts=0.003, duration=1, more=(), limit_s=40):
    """Records from a board that says what it is told to."""
    out = os.path.join(work, f"{name}.csv")
    command = ["--ts", str(ts), "--duration", str(duration), *more, "-o", out]

    def board(near):
        board = Board(near, says)
        board.thread.start()
        return board

    ended, board = listen(command, limit_s, board)
    assert ended.mib < MOST_MIB
    return Recorded(ended, out, board.sent)
