"""Boards that flood: noise, zeros, answers, texts and samples as fast as a pseudo-terminal takes them.

The recorder ends, in bounded memory, and says what it has; samples among a flood are recorded as they are.
fake2.py [long]: each flood for ten times as long."""

import os
import random
import sys
import time

import wire
from fake import Board, record
from instrument import MOST_MIB, end, folder, judge

# How long a flood lasts in s in the short form.
FLOOD_S = 2
NOISE = bytes(random.Random(1).randrange(1, 256) for _ in range(65536))


def flooding(content, seconds, after=100):
    """Some sound samples, then nothing but `content`."""
    def run(board):
        for number in range(after):
            board.write(board.sample(number))
            board.sent += 1
        ends = time.monotonic() + seconds
        while time.monotonic() < ends and not board.over:
            board.write(content)
    return {"run": run}


def text_first(seconds):
    def run(board):
        ends = time.monotonic() + seconds
        while time.monotonic() < ends and not board.over:
            board.write(wire.frame(wire.TEXT, b"\x1b[2Jhello") * 1000)
        board.started = time.monotonic()
        Board.samples(board)
    return {"run": run}


def as_fast_as_possible(board):
    """Samples of a board whose clock runs as fast as its line."""
    for first in range(0, board.asked, 500):
        if board.over:
            return
        board.write(b"".join(wire.data(k, 1000 + k * board.ts_us, k // 3, board.segments[0][1]) for k in range(first, min(first + 500, board.asked))))
        board.sent = first + 500
    board.write(wire.end(board.asked))


def noise_first(seconds):
    def first(board):
        ends = time.monotonic() + seconds
        while time.monotonic() < ends and not board.over:
            board.write(NOISE)
    return {"first": first}


def questions(seconds):
    def gone(run):
        """It ends by itself with what came before the flood, and says that the board said no more."""
        return run.status == 3 and len(run.rows) == 100 and run.of("complete") is None

    def whole(run):
        return run.status == 0 and len(run.rows) == run.sent and run.of("complete") == "true"

    def refused(run):
        return run.status == 3 and run.rows is None

    patience = {"more": ["--patience", str(int(seconds) + 20)], "duration": 0.6}
    yield "noise_before_hello", noise_first(seconds), patience, whole
    yield "noise_in_mid_run", flooding(NOISE, 4 * seconds), {"duration": 2}, gone
    yield "zeros_in_mid_run", flooding(b"\0" * 65536, 4 * seconds), {"duration": 2}, gone
    yield "answers_in_mid_run", flooding(wire.ack(wire.START) * 1000, 4 * seconds), {"duration": 2}, gone
    answers = flooding(wire.ack(0x99) * 1000, 4 * seconds, after=0) | {"start": b""}
    yield "answers_before_start", answers, {"duration": 2}, refused
    yield "texts", text_first(min(seconds, 1)), {"duration": 0.6}, whole
    hellos = {"run": lambda board: board.samples(of=lambda k: wire.hello() * 20 + board.sample(k))}
    yield "hellos", hellos, {"duration": 1}, whole
    samples = {"run": as_fast_as_possible}
    yield "samples", samples, {"duration": 60 * seconds, "more": ["--profile", "rest.csv"]}, whole


def main():
    seconds = FLOOD_S * (10 if sys.argv[1:] == ["long"] else 1)
    work = folder()
    os.chdir(work)
    with open("rest.csv", "w", encoding="utf-8") as file:
        file.write("t_s,command_v\n0,4.5\n")
    for name, says, how, right in questions(seconds):
        run = record(name, work, says, limit_s=20 * seconds, **how)
        good = run.crash is None and right(run)
        judge(f"fake2 {name}", good, memory=f"below {MOST_MIB} MiB", **run.facts())
    end()


if __name__ == "__main__":
    main()
