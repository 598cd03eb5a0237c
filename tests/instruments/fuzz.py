"""Mutated files of every kind through every command that reads them.

No panic, no abort, no hang (20 s of a core), no gigabyte, no failure without a word, no invalid number in a document, and nothing written over that another wrote.   fuzz.py [SECONDS [SEED]]"""

import collections
import json
import os
import random
import re
import shutil
import sys
import time

from instrument import CASES, MOTORLAB, SEEDS, folder, run

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e-?\d+)?")
NO_NUMBER = re.compile(rb"(?<![\w./-])-?(NaN|inf|Infinity)(?![\w.])")
ODD = [b"NaN", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-308", b"5e-324", b"0", b"-0", b"-1", b"1", b"9223372036854775807",
       b"9223372036854775808", b"18446744073709551615", b"-9223372036854775808", b"4294967296", b"1e18", b"1e15", b"1e9",
       b"1e6", b"1e-9", b"1e-15", b"65536", b"2147483648", b"", b'""', b"[]", b"{}", b"true", b"null", b"0x10", b"1e999",
       b"1_000", b"0.1.2", b"1970-01-01", b"'", b"[[[[[[[[[[", b"\xef\xbb\xbf", b"\xff\xfe", b"\x1b]0;x\x07", b"\x00",
       "\u202e".encode(), b"\r\n"]
# How often a number is scaled instead of exchanged for an odd one, and by what.
SCALED, FACTORS = 0.25, [-1, 1e3, 1e-3, 1e6, 1e-6, 1.01, 1e12, 2]
KEPT_OF_A_KIND = 6


def seed(name, where=SEEDS):
    with open(os.path.join(where, name), "rb") as file:
        return file.read()


class Fuzzer:
    def __init__(self, number, work):
        self.random, self.work, self.d = random.Random(number), work, os.path.join(work, "case")
        self.runs = [seed("sim30.csv", CASES), seed("rev.csv"), seed("step3.csv")]
        self.motor, self.why, self.table = seed("motor.toml"), seed("why.json"), seed("log1.csv")
        self.raw, self.plain, self.maps = seed("raw.log"), seed("plain_sketch.log"), [seed("map1.toml"), seed("map2.toml")]
        self.effects = json.loads(seed("effects.json"))
        self.set = os.path.join(work, "set")
        made = run(["blind", "make", "--cases", "2", "--seed", "3", "--kind", "singles", self.set], cwd=work)
        assert made.status == 0, made.err
        # A diagnoser that says what it is told to: whatever it says is only words to a score.
        self.diagnoser = os.path.join(work, "diagnoser")
        with open(self.diagnoser, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\n[ "$1" = --version ] && echo says 1 && exit\ncat "{self.d}/said.json"\n')
        os.chmod(self.diagnoser, 0o755)

    def mutated(self, content):
        content, r = bytearray(content), self.random
        for _ in range(r.choice([1, 1, 1, 2, 3, 6])):
            if not content:
                return b"x"
            kind, lines = r.randrange(10), bytes(content).split(b"\n")
            if kind < 4:
                found = list(NUMBER.finditer(content))
                if found and r.random() < 0.5:  # the header, half of the time
                    found = [one for one in found if one.start() < 1500] or found
                if found:
                    one = r.choice(found)
                    new = r.choice(ODD)
                    if r.random() < SCALED:
                        new = repr(float(one.group()) * r.choice(FACTORS)).encode()
                    content[one.start():one.end()] = new
            elif kind == 4:
                content[r.randrange(len(content))] = r.randrange(256)
            elif kind == 5:
                at = r.randrange(len(content))
                del content[at:at + r.choice([1, 2, 10, 100, 1000])]
            elif kind == 9:
                content = content[:r.randrange(len(content))]
            else:
                at = r.randrange(len(lines))
                if kind == 6:
                    lines.insert(r.randrange(len(lines) + 1), lines[at])
                elif kind == 7:
                    del lines[at]
                else:
                    other = r.randrange(len(lines))
                    lines[at], lines[other] = lines[other], lines[at]
                content = bytearray(b"\n".join(lines))
        return bytes(content)

    def put(self, name, content):
        path = os.path.join(self.d, name)
        with open(path, "wb") as file:
            file.write(content)
        return path

    def a_motor(self):
        r = self.random
        if r.random() < 0.3:
            return self.motor
        text = b"resistance_ohm = 5.0\n[tolerance]\nresistance_ohm = 0.1\n"
        for effect in r.sample(sorted(self.effects), r.choice([1, 1, 2, 3])):
            text += b"[effects.%s]\n" % effect.encode()
            for name, value in self.effects[effect].items():
                text += b"%s = %r\n" % (name.encode(), value * r.choice([1, 1, 0.1, 10]))
        return text

    def run_file(self):
        return self.put("r.csv", self.mutated(self.random.choice(self.runs)))

    def motor_file(self):
        return self.put("m.toml", self.mutated(self.a_motor()))

    def with_motor(self, share=0.3):
        return ["--motor", self.motor_file()] if self.random.random() < share else []

    # One method a command.
    def compare(self):
        page = ["--html", self.d + "/o.html"] if self.random.random() < 0.3 else []
        return ["compare", self.run_file(), *self.with_motor(), *page]

    def check(self):
        return ["check", self.run_file(), *self.with_motor()]

    def diagnose(self):
        if self.random.random() < 0.5:
            return ["diagnose", self.run_file()]
        return ["diagnose", os.path.join(CASES, "sim30.csv"), "--motor", self.put("m.toml", self.mutated(self.motor))]

    def simulate(self):
        r = self.random
        profile = b"t_s,command_v\n0,0\n0.3,4.5\n1,-2\n1.5,0\n"
        if r.random() < 0.25:
            return ["simulate", "--profile", self.put("p.csv", self.mutated(profile))]
        return ["simulate", "--motor", self.motor_file(), "--duration", r.choice(["2", "0.5", "10"]),
                "--ts", r.choice(["0.03", "0.003", "0.1"])]

    def replay(self):
        log = self.mutated(self.random.choice([self.raw, self.plain]))
        return ["replay", self.put("l.log", log), "-o", self.d + "/o.csv"]

    def import_(self):
        mapping = self.put("map.toml", self.mutated(self.random.choice(self.maps)))
        return ["import", self.put("i.csv", self.mutated(self.table)), "--map", mapping, "-o", self.d + "/o.csv"]

    def design(self):
        r = self.random
        if r.random() < 0.6:
            return ["design", "--diagnosis", self.put("why.json", self.mutated(self.why)), *self.with_motor()]
        return ["design", "--motor", self.motor_file(), "--ts", r.choice(["0.03", "0.003"]),
                "--duration", r.choice(["0.5", "2"])]

    def export(self):
        r = self.random
        if r.random() < 0.5:
            form = r.choice(["json", "mujoco", "urdf", "matlab"])
            return ["export", form, "--motor", self.motor_file(), "-o", self.d + "/ox"]
        if r.random() < 0.3:
            return ["export", "matlab", "--run", self.run_file(), "-o", self.d + "/oy"]
        form = r.choice(["parquet", "mcap"])
        return ["export", form, self.run_file(), "-o", self.d + "/oz"]

    def lab(self):
        return ["lab", "--no-diagnosis", "--run", self.run_file(), "-o", self.d + "/lab", *self.with_motor()]

    def virtual(self):
        words = b"virtual:?seed=7&effect=backlash&gap_rad=0.02&speed=max&clock_ppm=200&micros_start=4294000000&drop=0.001&boot_ms=10"
        spec = self.mutated(words).replace(b"\0", b"").decode("latin-1")
        return ["capture", spec if spec.startswith("virtual:") else "virtual:" + spec, "--duration", "0.2", "--patience", "1",
                "-o", self.d + "/o.csv"]

    def blind(self):
        r, copy, labels = self.random, os.path.join(self.d, "set"), os.path.join(self.d, "labels.json")
        shutil.copytree(self.set, copy)
        shutil.copy(self.set + ".labels.json", labels)
        self.put("said.json", self.mutated(self.why) if r.random() < 0.7 else self.why)
        if r.random() < 0.2:
            self.mutate_one(copy)
            return ["blind", "run", copy, "--diagnoser", self.diagnoser, "--jobs", "1"]
        judged = run(["blind", "run", copy, "--diagnoser", self.diagnoser, "--jobs", "1"], cwd=self.d)
        if judged.crash():
            return ["blind", "run", copy, "--diagnoser", self.diagnoser, "--jobs", "1"]
        if r.random() < 0.5:
            self.mutate_one(copy) if r.random() < 0.7 else self.put("labels.json", self.mutated(seed(labels, self.d)))
        outputs = ["--html", self.d + "/s.html", "--markdown", self.d + "/s.md"] if r.random() < 0.5 else []
        return ["blind", "score", copy, "--labels", labels, *outputs]

    def mutate_one(self, top):
        files = sorted(os.path.join(at, name) for at, _, names in os.walk(top) for name in names)
        path = self.random.choice(files)
        with open(path, "rb") as file:
            content = file.read()
        with open(path, "wb") as file:
            file.write(self.mutated(content))

    def motor_(self):
        written = ["-o", self.d + "/whole.toml"] if self.random.random() < 0.3 else []
        return ["motor", self.motor_file(), *written]

    def effects_(self):
        return ["effects", "--motor", self.motor_file()]

    def commands(self):
        """The commands, likelier where there is more to mutate."""
        weights = [(self.motor_, 1), (self.effects_, 1),
                   (self.compare, 3), (self.check, 3), (self.diagnose, 2), (self.simulate, 4), (self.replay, 2), (self.import_, 2),
                   (self.design, 2), (self.export, 2), (self.lab, 1), (self.virtual, 1), (self.blind, 2)]
        return [command for command, weight in weights for _ in range(weight)]

    def wrong(self, arguments, ended):
        """Error with an answer, in words; none if nothing is."""
        if crash := ended.crash():
            return crash
        if ended.status in (0, 1) and "--json" in arguments and ended.document() is None:
            return "no document"
        if ended.status in (2, 3) and "--json" in arguments and "error" not in (ended.document() or {}):
            return "no document of the failure"
        if ended.status == 0 and NO_NUMBER.search(ended.out):
            return "not a number"
        left = [name for name in os.listdir(self.d) if name.startswith(".motorlab")]
        return f"left {left[0]}" if left else None


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60
    number = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    work = folder()
    fuzzer = Fuzzer(number, work)
    kept = os.environ.get("FUZZ_KEPT")  # a folder for the inputs of what is found
    commands, statuses, found = fuzzer.commands(), collections.Counter(), collections.Counter()
    ends = time.monotonic() + seconds
    count = 0
    while time.monotonic() < ends:
        shutil.rmtree(fuzzer.d, ignore_errors=True)
        os.mkdir(fuzzer.d)
        arguments = fuzzer.random.choice(commands)()
        if fuzzer.random.random() < 0.3:
            arguments.append("--json")
        ended = run(arguments, cwd=fuzzer.d)
        count += 1
        statuses[arguments[0], ended.status] += 1
        if wrong := fuzzer.wrong(arguments, ended):
            kind = wrong.split()[0], arguments[0]
            found[kind] += 1
            if found[kind] <= KEPT_OF_A_KIND:
                print(f"WRONG {count}: {wrong}: {' '.join(arguments)}: {ended.last()}", flush=True)
                if kept:
                    name = os.path.join(kept, f"{number}_{count}_{'_'.join(kind)}")
                    shutil.copytree(fuzzer.d, name)
                    with open(os.path.join(name, "command"), "w", encoding="utf-8") as file:
                        file.write(f"{wrong}\n{' '.join(arguments)}\n")
    table = collections.defaultdict(dict)
    for (command, status), times in sorted(statuses.items()):
        table[command][status] = times
    print(f"fuzz: seed {number}, {count} calls of {os.path.basename(MOTORLAB)} in {seconds:.0f} s, "
          f"{sum(found.values())} wrong; by command and status: {dict(table)}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
