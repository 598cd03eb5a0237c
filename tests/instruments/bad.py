"""Some 200 bad files: each ends within 20 s of a core and a gigabyte, with an answer or with what is wrong and where.

bad.py [long]: also files of hundreds of megabytes and a recording of ten hours."""

import gzip
import os
import sys

from instrument import SEEDS, end, folder, judge, run

HEADER = "# format = \"motorlab-run/1\"\n# sample_time_s = {ts}\n# counts_per_rev = {cpr}\n# supply_v = 4.5\nseq,t_s,command_v,counts\n"
ANSWER, REFUSED, EITHER = (0, 1), (2,), (0, 1, 2)

MOTORS = {
    "no_resistance": "resistance_ohm = 0", "negative_resistance": "resistance_ohm = -1", "no_inertia": "inertia_kg_m2 = 0",
    "inertia_1e-300": "inertia_kg_m2 = 1e-300", "inertia_1e-12": "inertia_kg_m2 = 1e-12", "inertia_1e300": "inertia_kg_m2 = 1e300",
    "no_inductance": "inductance_h = 0", "inductance_1e-300": "inductance_h = 1e-300", "inductance_1e300": "inductance_h = 1e300",
    "constants_1e150": "torque_constant_nm_per_a = 1e150\nback_emf_v_s_per_rad = 1e150", "resistance_1e-9": "resistance_ohm = 1e-9",
    "friction_1e300": "coulomb_friction_nm = 1e300", "negative_friction": "coulomb_friction_nm = -1",
    "no_viscous": "viscous_friction_nm_s_per_rad = 0", "viscous_1e300": "viscous_friction_nm_s_per_rad = 1e300",
    "supply_1e300": "supply_v = 1e300", "no_supply": "supply_v = 0",
    "cogging_fine": "[effects.cogging]\ntorque_nm = 0.05\ncycles_per_rev = 1000000",
    "cogging_strong": "[effects.cogging]\ntorque_nm = 1e6\ncycles_per_rev = 24",
    "ripple_fine": "[effects.torque_ripple]\namplitude = 0.99\ncycles_per_rev = 100000\nphase_rad = 0",
    "backlash_small": "[effects.backlash]\ngap_rad = 1e-12\nload_fraction = 0.5",
    "backlash_all_load": "[effects.backlash]\ngap_rad = 1e-6\nload_fraction = 0.999999",
    "compliance_stiff": "[effects.compliance]\nfrequency_hz = 1e6\ndamping_ratio = 1e-9\nload_fraction = 0.5",
    "compliance_1e12": "[effects.compliance]\nfrequency_hz = 1e12\ndamping_ratio = 0\nload_fraction = 1e-9",
    "presliding_1e-12": "[effects.presliding]\nbreak_in_angle_rad = 1e-12", "gravity_1e9": "[effects.gravity_load]\ntorque_nm = 1e9\nphase_rad = 0",
    "delay_1e9": "[effects.transport_delay]\ndelay_s = 1e9", "jitter_1e9": "[effects.sample_jitter]\nspread_s = 1e9",
    "clock_stands": "[effects.clock_error]\nrelative = -0.999999999", "clock_1e12": "[effects.clock_error]\nrelative = 1e12",
    "all_counts_missed": "[effects.missed_counts]\nprobability = 1\nmax_rate_hz = 1e-9",
    "stribeck_1e-12": "[effects.stribeck]\nextra_torque_nm = 10\nstribeck_speed_rad_s = 1e-12",
    "drag_1e12": "[effects.quadratic_drag]\ncoefficient_nm_s2_per_rad2 = 1e12",
    "heating_1e12": "[effects.winding_heating]\nresistance_rise_per_w = 1e12\ntime_constant_s = 1e-12",
    "many_effects": "[effects]\n" + "".join(f"{effect} = true\n" for effect in (
        "cogging torque_ripple backlash presliding stribeck winding_heating gravity_load quadratic_drag current_limit "
        "voltage_drop dead_zone transport_delay supply_sag compliance").split()),
}

TOML = {
    "deep": "a=" + "[" * 400000 + "]" * 400000, "deep_tables": "a=" + "{a=" * 100000 + "1" + "}" * 100000,
    "dots": ".".join(["a"] * 400000) + "=1", "many_tables": "".join(f"[a.b{k}]\n" for k in range(70000)),
    "long_number": "resistance_ohm = " + "1" * 1000000, "long_text": 'resistance_ohm = "' + "x" * 1000000 + '"',
    "arrays_of_tables": "[[effects.backlash]]\n" * 40000,
}


class Bad:
    def __init__(self):
        self.work, self.number = folder(), 0

    def go(self, name, *arguments, statuses=EITHER):
        ended = run(list(arguments), cwd=self.work)
        self.number += 1
        crash = ended.crash()
        good = crash is None and ended.status in statuses
        judge(f"bad {name} {arguments[0]}", good, status=ended.status, crash=crash, cpu=f"{ended.cpu_s:.1f} s",
              memory=f"{ended.mib:.0f} MiB", said=repr(ended.last()[-90:]))

    def put(self, name, content):
        with open(os.path.join(self.work, name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return name

    def run_file(self, name, rows, ts="0.03", cpr="720"):
        return self.put(name + ".csv", HEADER.format(ts=ts, cpr=cpr) + "".join(rows))

    def readers(self, name, file, statuses=EITHER):
        for command in "compare", "check", "diagnose":
            self.go(name, command, file, statuses=statuses)

    def runs(self):
        def rows(number=100, t_s=lambda k: f"{k * 0.03:.3f}", command="4.5", counts=lambda k: k, seq=lambda k: k):
            return [f"{seq(k)},{t_s(k)},{command},{counts(k)}\n" for k in range(number)]

        sound = [f"{k},{k * 0.03:.3f},{0 if k < 10 else 4.5},{max(0, k - 10) * 15}\n" for k in range(100)]
        for number in (0, 1, 2, 3):
            self.readers(f"{number} rows", self.run_file(f"rows{number}", sound[:number]))
        for key, values in ("cpr", ("-720", "1e308", "1e-308", "nan")), ("ts", ("1e-9", "0", "1e-300", "1e300")):
            for value in values:
                self.readers(f"{key} {value}", self.run_file("header", sound, **{key: value}), REFUSED)
        self.readers("times fall", self.run_file("fall", sound[:50] + sound[20:]), REFUSED)
        self.readers("times stand", self.run_file("stand", rows(t_s=lambda k: "0.0")), REFUSED)
        self.readers("counts to 9e18", self.run_file("large", rows(counts=lambda k: k * 92233720368547758)))
        self.readers("counts alternate", self.run_file("alternate", rows(counts=lambda k: (-1) ** k * (2**63 - 1))))
        self.readers("command 1e308", self.run_file("command", rows(command="1e308")), REFUSED)
        self.readers("command 1e9", self.run_file("command", rows(command="1e9")), REFUSED)
        self.readers("numbers leap", self.run_file("seq", rows(90, seq=lambda k: k * 10**17)))
        self.readers("a number leaps", self.run_file("seq", rows(90, seq=lambda k: k if k < 50 else k + 10**12)))
        self.readers("time 1e15", self.run_file("time", rows(90, t_s=lambda k: f"{1e15 + k * 0.03:.3f}")), REFUSED)
        self.readers("rows an hour apart", self.run_file("hours", rows(300, t_s=lambda k: k * 3500)))
        twice = HEADER.replace("command_v,counts", "t_s,command_v,counts,counts")
        self.put("twice.csv", twice.format(ts="0.03", cpr="720") + "".join(f"{k},{k * 0.03},1,4.5,{k},5\n" for k in range(60)))
        self.readers("a column twice", "twice.csv", REFUSED)
        self.put("lacks.csv", HEADER.replace("command_v,", "").format(ts="0.03", cpr="720") + "".join(f"{k},{k * 0.03},{k}\n" for k in range(60)))
        self.readers("a column lacks", "lacks.csv", REFUSED)
        self.readers("UTF-16", self.put("utf16.csv", (HEADER.format(ts="0.03", cpr="720") + "".join(sound)).encode("utf-16")), REFUSED)
        self.readers("empty", self.put("empty.csv", ""), REFUSED)
        self.readers("zeros", self.put("zeros.csv", b"\0" * 100000), REFUSED)
        for name in (".", "none", "/dev/null", "/dev/urandom"):
            self.readers(name, name, REFUSED)
        columns = HEADER.split("seq")[0].format(ts="0.03", cpr="720")
        self.readers("a million columns", self.put("columns.csv", columns + ",".join(f"c{k}" for k in range(10**6)) + "\n"), REFUSED)
        self.readers("wide rows", self.put("wide.csv", HEADER.format(ts="0.03", cpr="720") + ("1" + ",1" * 30000 + "\n") * 50), REFUSED)
        for name, header in {
            "many keys": "".join(f"# k{k} = {k}\n" for k in range(100000)), "deep": "# a = " + "[" * 60000 + "]" * 60000 + "\n",
            "less deep": "# a = " + "[" * 200 + "]" * 200 + "\n", "dots": "# " + ".".join(["a"] * 20000) + " = 1\n",
        }.items():
            self.readers(f"header {name}", self.put("header.csv", header + HEADER.format(ts="0.03", cpr="720") + "".join(sound)))

    def documents(self):
        log, map1 = os.path.join(SEEDS, "log1.csv"), os.path.join(SEEDS, "map1.toml")
        for name, text in TOML.items():
            file = self.put(name + ".toml", text[:1 << 20])
            self.go(name, "simulate", "--motor", file, statuses=REFUSED)
            self.go(name, "import", log, "--map", file, statuses=REFUSED)
        self.go("deep", "design", "--diagnosis", self.put("deep.json", "[" * 10**6 + "]" * 10**6), statuses=REFUSED)
        for arguments in (["design", "--diagnosis"], ["simulate", "--motor"], ["simulate", "--profile"], ["import", log, "--map"],
                          ["import", "--map", map1], ["replay"], ["blind", "score", ".", "--labels"], ["compare"], ["check"]):
            self.go("/dev/zero", *arguments, "/dev/zero", statuses=REFUSED)

    def logs(self):
        map1, map2 = (os.path.join(SEEDS, name) for name in ("map1.toml", "map2.toml"))
        names = b"millis,pwm,angle_deg,ma\n"
        bomb = gzip.compress(names + b"0" * (1 << 26), 1)
        self.go("a line of 64 MiB", "import", self.put("bomb.csv.gz", bomb), "--map", map1, statuses=REFUSED)
        bomb = gzip.compress(names + b"x,255,1,1\n" * 10**6, 1)
        self.go("a million bad rows", "import", self.put("bad.csv.gz", bomb), "--map", map1, statuses=REFUSED)
        members = gzip.compress(names + b"0,0,0,0\n") + gzip.compress(b"3,0,0,0\n6,0,0,0\n") + b"garbage"
        self.go("garbage behind", "import", self.put("members.gz", members), "--map", map1)
        with open(os.path.join(SEEDS, "log1.csv"), "rb") as file:
            cut = gzip.compress(file.read())[:-20]
        self.go("cut off", "import", self.put("cut.gz", cut), "--map", map1)
        far = "millis,pwm,angle_deg,ma\n" + "".join(f"{3 * k},255,{1e300 * (-1) ** k},1\n" for k in range(100))
        self.go("angles of 1e300", "import", self.put("far.csv", far), "--map", map1, statuses=REFUSED)
        paths = "".join(f"{k},1,2,../../../../OUT{k}\n{k}.5,1,2,../../../../OUT{k}\n" for k in range(3))
        self.go("names that are paths", "import", self.put("paths.csv", paths), "--map", map2, "-o", "inside.csv")
        outside = [name for top in (self.work, "/") for name in os.listdir(top) if "OUT" in name and not name.startswith("inside")]
        judge("bad names that are paths stay inside", not outside, outside=outside)
        many = "".join(f"{k},1,2,v{k}\n" for k in range(3000))
        os.mkdir(os.path.join(self.work, "many"))
        self.go("3000 runs", "import", self.put("many.csv", many), "--map", map2, "-o", "many/s.csv")

    def motors(self):
        for name, text in MOTORS.items():
            file = self.put(f"m_{name}.toml", text + "\n")
            self.go(name, "simulate", "--motor", file, "--profile", "reversing", "--duration", "10", "--ts", "0.003")
            self.go(name, "check", os.path.join(SEEDS, "rev.csv"), "--motor", file)
        for name in "cogging_fine", "compliance_stiff", "many_effects", "constants_1e150":
            self.go(name, "design", "--motor", f"m_{name}.toml")

    def profiles_and_options(self):
        steps = "t_s,command_v\n" + "".join(f"{k * 1e-9:.9f},{k % 2}\n" for k in range(200000))
        for name, text in {"steps of 1 ns": steps, "1e300 s": "t_s,command_v\n0,1\n1e300,2\n", "1e300 V": "t_s,command_v\n0,1e300\n",
                           "before 0": "t_s,command_v\n-5,1\n0,2\n", "one time": "t_s,command_v\n0,1\n0,2\n0,3\n"}.items():
            self.go(f"profile {name}", "simulate", "--profile", self.put("p.csv", text), "--duration", "2")
        for options in (["--ts", "1e-12"], ["--duration", "1e12", "--ts", "0.003"], ["--profile", "crawl@1e300,1e300s"],
                        ["--profile", "crawl@nan,nans"], ["--profile", "crawl@0.25,100000000s"], ["--seed", "-1"]):
            self.go(" ".join(options), "simulate", *options, statuses=REFUSED)
        for key in ("gap_rad=1e300&effect=backlash", "speed=-1", "speed=nan", "drop=2&flip=-1", "seed=99999999999999999999", "motor=/dev/zero"):
            self.go(key, "capture", f"virtual:?{key}", "--duration", "0.3", "-o", "v.csv", statuses=REFUSED)
        for options in (["--baud", "0"], ["--counts-per-rev", "1e308"], ["--supply", "1e308"], ["--patience", "1e30"], ["--ts", "61"]):
            self.go(" ".join(options), "capture", "virtual:", *options, "--duration", "0.2", "-o", "v.csv", statuses=(0, 1, 2, 3))
        self.go("boots for ever", "capture", "virtual:?boot_ms=1e7", "--patience", "1", "-o", "v.csv", statuses=(2, 3))

    def large(self):
        for name, content in ("text.json", '{"a":"' + "x" * 200_000_000 + '"}'), ("numbers.json", "[" + "0," * 50_000_000 + "0]"):
            self.go(name, "design", "--diagnosis", self.put(name, content), statuses=REFUSED)
            os.unlink(os.path.join(self.work, name))
        bomb = gzip.compress(b"millis,pwm,angle_deg,ma\n" + b"".join(b"%d,255,%d,1\n" % (3 * k, k % 360) for k in range(2 * 10**7)), 1)
        self.go("2e7 rows", "import", self.put("rows.csv.gz", bomb), "--map", os.path.join(SEEDS, "map1.toml"))
        hours = HEADER.format(ts="0.03", cpr="720") + "".join(
            f"{k},{k * 0.03:.3f},{4.5 if k // 100 % 2 else -4.5},{k % 200 * 15 if k // 100 % 2 else 3000 - k % 200 * 15}\n" for k in range(1_200_000))
        self.put("hours.csv", hours)
        self.go("ten hours", "compare", "hours.csv", "--html", "hours.html")
        size = os.path.getsize(os.path.join(self.work, "hours.html"))
        judge("bad ten hours make a page of some megabytes", size < 20 << 20, bytes=size)


def main():
    bad = Bad()
    bad.runs()
    bad.documents()
    bad.logs()
    bad.motors()
    bad.profiles_and_options()
    if sys.argv[1:] == ["long"]:
        bad.large()
    print(f"bad: {bad.number} calls")
    end()


if __name__ == "__main__":
    main()
