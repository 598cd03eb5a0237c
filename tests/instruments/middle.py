"""A pseudo-terminal in the middle of `motorlab virtual` and `motorlab capture`."""

import os
import pty
import select
import signal
import struct
import subprocess
import time
import tty

import wire
from instrument import MOTORLAB


class Middle:
    """Channel from board to recorder; `board` and `host` may change it on its way."""

    def __init__(self, spec, arguments, board=lambda content: content, host=lambda content: content):
        self.board, self.host = board, host
        self.sent, self.ended, self.hello = [], None, None  # samples that the board sent, in order, and its END
        self.plugged = subprocess.Popen([MOTORLAB, "virtual", spec], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.far = os.open(self.plugged.stdout.readline().decode().split()[-1], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.far)
        self.near, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.capture = subprocess.Popen([MOTORLAB, "capture", os.ttyname(self.slave), *arguments],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.decoder = wire.Decoder()

    def runs(self):
        """Counts and commands by sample number, of each run of the board: to a recorder that got no core for half a second
        the board says that the link is lost, and a START that is said again begins a run anew."""
        runs, last = [], None
        for seq, _, counts, mv, _ in self.sent:
            if last is None or seq <= last:
                runs.append({})
            runs[-1][seq] = counts, mv
            last = seq
        return runs

    def step(self, wait_s=0.01):
        """Passes on the available bytes; returns whether the recorder still runs."""
        ready, _, _ = select.select([self.far, self.near], [], [], wait_s)
        if self.far in ready:
            content = os.read(self.far, 4096)
            now = time.monotonic()
            for kind, body in self.decoder.push(content):
                if kind == wire.DATA:
                    seq, time_us, counts, mv, _ = struct.unpack("<HIihB", body[:13])
                    self.sent.append((seq, time_us, counts, mv, now))
                elif kind == wire.END:
                    self.ended = struct.unpack("<IIB", body)
                elif kind == wire.HELLO and self.hello is None:
                    self.hello = wire.frame(kind, body)
            os.write(self.near, self.board(content))
        if self.near in ready:
            try:
                os.write(self.far, self.host(os.read(self.near, 4096)))
            except OSError:  # the recorder has closed its side
                pass
        return self.capture.poll() is None

    def to_the_end(self, most_s):
        """Passes on until the recorder ends; whether it did by itself."""
        ends = time.monotonic() + most_s
        while self.step():
            if time.monotonic() > ends:
                self.capture.kill()
                return False
        return True

    def close(self):
        """Status and messages of the recorder."""
        try:
            _, said = self.capture.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            self.capture.kill()
            _, said = self.capture.communicate()
        self.plugged.send_signal(signal.SIGTERM)
        self.plugged.wait()
        for descriptor in (self.far, self.near, self.slave):
            os.close(descriptor)
        return self.capture.returncode, said.decode(errors="replace")
