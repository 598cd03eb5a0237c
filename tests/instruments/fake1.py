"""Boards that lie: of their name, their encoder, the end, the time, the counts.

A sample is a row only if it is plausible; others are flagged, counted or refused, and no contradiction gives exit status 0."""

import concurrent.futures
import sys

import wire
from fake import AT_A_TIME, record
from instrument import end, folder, judge

ESCAPES = b"\x1b]0;owned\x07\x1b[2J\x1b[31m"
NAMES = {"escapes": ESCAPES, "html": b"<script>alert(1)</script>", "toml": b'x"\ncomplete = true\n#', "lines": b"a\nb,c\r\nd",
         "nul": b"a\0b", "no_utf8": b"\xff\xfe\x80", "bidi": "\u202eevil\u200b".encode(), "c1": "\u009b2J\u0085".encode(),
         "empty": b"", "image": b'"><img src=x onerror=1>'}
HARMFUL = [*map(chr, [*range(9), *range(11, 32), *range(127, 160)]), "\u200b", "\u202e"]
BACK_US, FAR_US, FAR_COUNTS = 500_000, 2_000_000_000, 2_000_000_000


def whole(run):
    """Every sample is a row, and nothing is said against it."""
    return run.status == 0 and len(run.rows) == run.sent and run.of("complete") == "true"


def flagged(flag):
    """One row has the flag, the rest is there, and the status says so."""
    return lambda run: (run.status == 1 and run.of(f"summary.{flag}s") == "1"
                        and sum(flag in row[6] for row in run.rows) == 1)


def contradicted(run):
    return run.status == 1 and "contradicts itself" in run.said and int(run.of("summary.contradictions") or 0) > 0


def refused(status, words):
    return lambda run: run.status == status and run.rows is None and words in run.said


def short(run):
    """An implausible sample is no row; the rest adds up."""
    return run.status == 1 and len(run.rows) + int(run.of("summary.lost")) == run.sent and run.of("complete") is None


def lies(start=wire.hello(), **says):
    return {"hello": start, **says}


def running(**arguments):
    return {"run": lambda board: board.samples(**{key: value(board) for key, value in arguments.items()})}


def sample(change):
    """A run in which `change(board, k)` gives what is odd in the k-th sample."""
    return {"run": lambda board: board.samples(of=lambda k: board.sample(k, **change(board, k)))}


def questions():
    h, late = wire.hello, lambda values, after=150: lambda board, k: values(board, k) if k > after else {}
    for name, said in NAMES.items():
        yield f"name_{name}", lies(h(name=said[:24])), {"duration": 0.4}, name_is_harmless
    for counts in (1, 2**31, 2**32 - 1):
        yield f"counts_per_rev_{counts}", lies(h(counts_per_rev=counts)), {"duration": 0.4}, whole
    yield "counts_per_rev_0", lies(h(counts_per_rev=0)), {}, refused(2, "counts_per_rev is 0")
    yield "supply_0", lies(h(supply_mv=0)), {}, refused(2, "supply is 0")
    yield "supply_65_v", lies(h(supply_mv=65535)), {}, refused(2, "-32.767 to 32.767 V")
    yield "sample_time_0", lies(h(ts_us=0, shortest_us=0)), {"duration": 0.4}, whole
    yield "no_segments", lies(h(segments=0)), {"duration": 0.4}, whole
    yield "version_0", lies(h(version=0)), {}, refused(3, "protocol version 0")
    yield "version_2", lies(h(version=2)), {}, refused(3, "protocol version 2")
    yield "magic", lies(h(magic=b"MLAX")), {"more": ["--patience", "1"]}, refused(3, "is not a motorlab board")
    text = b"hello \x1b[2J <script> I am a grbl 1.1\r\n"
    yield "text", lies(text), {"more": ["--patience", "1"]}, refused(3, "--columns")
    yield "start_refused", {"start": wire.nak(wire.START, 3), "run": lambda board: None}, {}, refused(2, "refused START")
    yield "start_unanswered", {"start": b"", "run": lambda board: None}, {}, refused(3, "does not answer START")
    yield "start_ack_lost", {"start": b""}, {"duration": 0.6}, whole

    yield "end_early", running(number=lambda b: 100, ending=lambda b: wire.end(100)), {}, contradicted
    yield "end_less", running(ending=lambda b: wire.end(50)), {}, contradicted
    yield "end_more", running(ending=lambda b: wire.end(2**32 - 1)), {}, contradicted
    yield "end_dropped", running(ending=lambda b: wire.end(b.asked, 2**32 - 1)), {}, contradicted
    no_end = running(ending=lambda b: wire.end(b.asked, 0, 9)) | {"heeds_stop": False}
    yield "end_for_no_reason", no_end, {}, lambda run: run.status == 3 and len(run.rows) == 333 and "fell silent" in run.said
    beyond = running(number=lambda b: b.asked + 400)
    yield "more_than_asked", beyond, {"duration": 0.6}, lambda run: contradicted(run) and len(run.rows) == 200
    endless = running(number=lambda b: 5000) | {"heeds_stop": False}
    yield "endless", endless, {"duration": 0.6}, lambda run: run.status == 3 and len(run.rows) == 200 and "cut the motor's supply" in run.said

    yield "numbers_leap", sample(late(lambda b, k: {"seq": k + 1000}, 100)), {}, lambda run: contradicted(run) and len(run.rows) == 101
    yield "time_falls", sample(late(lambda b, k: {"time_us": 1000 + k * b.ts_us - BACK_US})), {}, flagged("time_leap")
    yield "time_leaps", sample(late(lambda b, k: {"time_us": 1000 + k * b.ts_us + FAR_US})), {}, flagged("time_leap")
    once = sample(lambda b, k: {"time_us": 1000 + k * b.ts_us - BACK_US} if k == 150 else {})
    yield "time_falls_once", once, {}, lambda run: short(run) and len(run.rows) == 332
    yield "time_stands", sample(lambda b, k: {"time_us": 1000}), {}, lambda run: short(run) and len(run.rows) == 1
    yield "time_wraps", sample(lambda b, k: {"time_us": 2**32 - 1_000_000 + k * b.ts_us}), {"duration": 2}, whole
    yield "time_ten_times", sample(lambda b, k: {"time_us": 1000 + 10 * k * b.ts_us}), {}, lambda run: short(run) and len(run.rows) == 1
    yield "counts_leap", sample(late(lambda b, k: {"counts": k // 3 + FAR_COUNTS})), {}, flagged("counts_leap")
    yield "counts_wrap", sample(lambda b, k: {"counts": 2**31 - 100 + 2 * k}), {}, whole
    yield "another_command", sample(lambda b, k: {"command_mv": 1234}), {}, lambda run: short(run) and not run.rows
    yield "ten_times_as_fast", running(rate=lambda b: 10), {"duration": 3}, whole

    narrow = wire.hello(fields=4)
    again = {"run": lambda b: b.samples(of=lambda k: (narrow if k == 250 else b"") + b.sample(k, counts=(k * 200 + 2**15) % 2**16 - 2**15))}
    yield "hello_again", lies(narrow) | again, {}, lambda run: whole(run) and [int(r[4]) for r in run.rows] == [200 * k for k in range(333)]
    for name, other in ("fields", wire.hello(fields=1)), ("boot", wire.hello(boot=2)):
        another = {"run": lambda b, other=other: b.samples(of=lambda k: (other if k == 150 else b"") + b.sample(k))}
        yield f"hello_other_{name}", another, {}, lambda run: run.status == 3 and len(run.rows) == 150 and run.of("complete") is None


def name_is_harmless(run):
    """A name is a name: no line of the header, nothing that steers a terminal."""
    text = "\n".join(run.header) + run.said
    keys = [line for line in run.header if line.startswith("complete")]
    return whole(run) and not any(c in text for c in HARMFUL) and keys == ["complete = true"]


def main():
    work, asked = folder(), sys.argv[1:]
    chosen = [one for one in questions() if not asked or one[0] in asked]
    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        runs = pool.map(lambda one: record(one[0], work, one[1], **one[2]), chosen)
        for (name, _, _, right), run in zip(chosen, runs):
            judge(f"fake1 {name}", run.crash is None and right(run), **run.facts())
    end()


if __name__ == "__main__":
    main()
