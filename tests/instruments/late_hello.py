"""A copy of HELLO comes late, during the run, from a board whose counter has 16 bits.

Every row must hold the counts that the board sent, unwrapped: no row may differ from the sum of the steps."""

import os

from instrument import end, folder, judge, rows_of
from middle import Middle

BOARD = "virtual:?counter_bits=16&counts_per_rev=200000"
SAMPLES = 1000  # 3 s at 3 ms: 65,536 counts pass several times
LATE_AFTER = 600  # samples


def main():
    out = os.path.join(folder(), "run.csv")
    injected = False

    def board(content):
        nonlocal injected
        if injected or middle.hello is None or len(middle.sent) <= LATE_AFTER:
            return content
        at, injected = content.rfind(b"\0") + 1, True
        return content[:at] + b"\0" + middle.hello + content[at:]

    middle = Middle(BOARD, ["--ts", "0.003", "--duration", "3", "-o", out], board)
    middle.to_the_end(30)
    status, _ = middle.close()
    sent = [sample[2] for sample in middle.sent]
    truth = sent[:1]
    for before, now in zip(sent, sent[1:]):
        truth.append(truth[-1] + (now - before + 32768) % 65536 - 32768)
    counts = [int(row[4]) for row in rows_of(out)[1]]
    wrong = sum(a != b for a, b in zip(counts, truth))
    wraps = (max(truth) - min(truth)) // 65536
    good = status == 0 and len(counts) == SAMPLES == len(truth) and wrong == 0 and injected and wraps > 1
    judge("late_hello", good, status=status, rows=len(counts), wrong=wrong, injected=injected, wraps=wraps)
    end()


if __name__ == "__main__":
    main()
