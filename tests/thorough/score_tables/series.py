"""Table c: more data, and a stronger effect, are never worse.

A recording of 30 s is cut to 4, 8, 15 and 30 s; and one effect is recorded at five strengths. Of every step the inclusion probability of
the effect is printed. A motor file beside them is 5 % (one sigma) off and says so.
"""

import json
import zlib

from .generated import chosen, cut, motor_file, recording
from .judge import costs, judge, share
from .motors import MOTORS, believed, levels, reversing
from .reading import read

NAME = "c"
TITLE = "one recording cut to four lengths, one effect at five strengths"
LENGTHS_S = (4, 8, 15, 30)
SAMPLE_TIME_S = 0.01
STRENGTH_DURATION_S = 8.0
# A probability falls where it is lower than a step before by more than this; less is the noise of one recording.
FALL = 0.05
# One sigma of the random load of every second length series, as a share of the stall torque.
LOAD_SHARE = 0.003
TOLERANCE = 0.05


def of_motor(effect, m, x=None):
    """The parameters of an effect for this motor; `x` is its strength where a series has one."""
    tf, volts, count = m["coulomb_friction_nm"], m["supply_v"], 6.2832 / m["counts_per_rev"]
    stall_a = volts / m["resistance_ohm"]
    top = volts / m["back_emf_v_s_per_rad"]
    return {
        "coulomb_friction": lambda: {"torque_nm": (x or 1.8) * tf},
        "backlash": lambda: {"gap_rad": x or 0.02, "load_fraction": 0.4, "encoder_side": 0.0},
        "stribeck": lambda: {"extra_torque_nm": (x or 1.5) * tf, "stribeck_speed_rad_s": 0.05 * top},
        "static_friction": lambda: {"torque_nm": (x or 2.5) * tf},
        "asymmetric_friction": lambda: {"ratio": x or 0.3},
        "asymmetric_gain": lambda: {"ratio": x or 0.06},
        "constant_load": lambda: {"torque_nm": (x or 0.5) * tf},
        "gravity_load": lambda: {"torque_nm": (x or 1.5) * tf, "phase_rad": 0.7},
        "cogging": lambda: {"torque_nm": (x or 1.0) * tf, "cycles_per_rev": 7.0, "phase_rad": 1.0},
        "torque_ripple": lambda: {"amplitude": x or 0.1, "cycles_per_rev": 5.0, "phase_rad": 1.0},
        "voltage_drop": lambda: {"drop_v": (x or 0.1) * volts},
        "dead_zone": lambda: {"threshold_v": (x or 0.12) * volts},
        "supply_sag": lambda: {"source_resistance_ohm": (x or 0.25) * m["resistance_ohm"]},
        "current_limit": lambda: {"limit_a": (x or 0.45) * stall_a},
        "winding_heating": lambda: {"resistance_rise_per_w": 0.8 / (volts * stall_a), "time_constant_s": 8.0},
        "transport_delay": lambda: {"delay_s": x or 0.02},
        "compliance": lambda: {"frequency_hz": 9.0, "damping_ratio": 0.1, "load_fraction": 0.5, "encoder_side": 0.0},
        "quadratic_drag": lambda: {"coefficient_nm_s2_per_rad2": 1.5 * tf / top / top * (x or 1.0)},
        "load_friction": lambda: {"driving_fraction": 0.3, "driven_fraction": 0.2},
        "encoder_eccentricity": lambda: {"amplitude_rad": (x or 4.0) * count, "phase_rad": 0.5},
        "inertia": lambda: {"inertia_kg_m2": (x or 2.0) * m["inertia_kg_m2"]},
        "coast_at_zero": lambda: {},
    }[effect]()


# Effect and motor.
LENGTH_SERIES = (
    ("backlash", "lab"),
    ("coulomb_friction", "hobby"),
    ("stribeck", "servo"),
    ("static_friction", "lab"),
    ("asymmetric_friction", "hobby"),
    ("asymmetric_gain", "servo"),
    ("gravity_load", "lab"),
    ("cogging", "hobby"),
    ("torque_ripple", "servo"),
    ("voltage_drop", "fast"),
    ("dead_zone", "lab"),
    ("supply_sag", "hobby"),
    ("current_limit", "fast"),
    ("winding_heating", "lab"),
    ("transport_delay", "hobby"),
    ("compliance", "lab"),
    ("quadratic_drag", "fast"),
    ("load_friction", "servo"),
    ("encoder_eccentricity", "hobby"),
    ("coast_at_zero", "lab"),
)
# Effect, motor, strengths in the unit of `of_motor`.
STRENGTH_SERIES = (
    ("coulomb_friction", "lab", (1.2, 1.5, 1.8, 2.1, 2.4)),
    ("backlash", "lab", (0.01, 0.02, 0.04, 0.08, 0.16)),
    ("gravity_load", "hobby", (0.3, 0.6, 1.2, 2.4, 4.8)),
    ("voltage_drop", "hobby", (0.03, 0.06, 0.1, 0.15, 0.25)),
    ("stribeck", "servo", (0.5, 1.0, 1.5, 2.0, 3.0)),
    ("supply_sag", "fast", (0.05, 0.1, 0.2, 0.4, 0.8)),
    ("transport_delay", "lab", (0.005, 0.01, 0.02, 0.04, 0.08)),
    ("asymmetric_friction", "servo", (0.1, 0.2, 0.3, 0.5, 0.7)),
    ("cogging", "lab", (0.3, 0.6, 1.2, 2.0, 3.0)),
    ("coulomb_friction", "hobby", (1.2, 1.5, 1.8, 2.1, 2.4)),
)


def seed_of(text):
    """The same number for the same series, whatever else there is; below a million, so one for tuning."""
    return zlib.crc32(text.encode()) % 900_000


def plan(tenth):
    """The series as name, effect, motor, and the steps with their recordings; of a tenth two by length and one by strength."""
    series = []
    for k, (effect, motor) in enumerate(LENGTH_SERIES):
        if tenth is None or k % 10 == tenth:
            series.append(("length", f"{effect}-{motor}", effect, motor, LENGTHS_S, k % 2 == 1))
    for k, (effect, motor, strengths) in enumerate(STRENGTH_SERIES):
        if tenth is None or k % 10 == tenth:
            series.append(("strength", f"{effect}-{motor}", effect, motor, strengths, False))
    return series


def recordings(series):
    """Descriptions of all recordings of these series, by file name."""
    found = {}
    for kind, name, effect, motor_name, steps, has_load in series:
        motor = MOTORS[motor_name]
        if kind == "length":
            command = reversing(motor["supply_v"], LENGTHS_S[-1]) if effect == "backlash" else levels(motor["supply_v"], LENGTHS_S[-1], seed_of(name))
            of_it = [(effect, of_motor(effect, motor))]
            found[f"{kind}-{name}/whole.csv"] = recording(motor, command, SAMPLE_TIME_S, seed_of(name), of_it, load_share=LOAD_SHARE * has_load)
        else:
            command = levels(motor["supply_v"], STRENGTH_DURATION_S, seed_of(name))
            for k, x in enumerate(steps, 1):
                found[f"{kind}-{name}/{k}.csv"] = recording(motor, command, SAMPLE_TIME_S, seed_of(name), [(effect, of_motor(effect, motor, x))])
    return found


def cases(asked, _):
    done = []
    folder = chosen("series", recordings(plan(None)))
    visible = json.loads((folder / "visible.json").read_text())
    for kind, name, effect, motor_name, steps, _ in plan(asked.tenth):
        of_series = folder / f"{kind}-{name}"
        (of_series / "motor.toml").write_text(motor_file(believed(MOTORS[motor_name], TOLERANCE, seed_of(name)), TOLERANCE))
        for k, step in enumerate(steps, 1):
            if kind == "length":
                cut(of_series / "whole.csv", of_series / f"{k}.csv", step)
            word = f"{step} s" if kind == "length" else f"{step:g}"
            counts = visible[f"{of_series.name}/{'whole' if kind == 'length' else k}.csv"]
            done.append((f"c/{kind}/{name}/{k}", lambda program, a=(of_series, kind, name, effect, k, word, counts): of_step(program, *a)))
    return done


def of_step(program, folder, kind, name, effect, k, word, counts):
    case_name = f"c/{kind}/{name}/{k}"
    answer = program.diagnose(case_name, folder, [f"{k}.csv"], ["--motor", "motor.toml"])
    case = judge(case_name, [effect], "single", answer)
    inclusion, of_class = 0.0, 0.0
    if answer.document is not None and answer.document["verdict"] != "bad_recording":
        reading = read(answer.document)
        inclusion, of_class = reading.of_effect(effect), reading.of_class(effect)
    of_series = {"series": f"{kind} {name}", "step": word, "beyond_refit_counts": round(counts, 3)}
    return case, case.row() | of_series | {"inclusion": round(inclusion, 4), "class_inclusion": round(of_class, 4)}


def by_series(rows):
    found = {}
    for row in rows:
        found.setdefault(row["series"], []).append(row)
    return found


def falls(rows, key):
    return any(after[key] < before[key] - FALL for before, after in zip(rows, rows[1:]))


def figures(done):
    rows = by_series([row for _, row in done])
    found = {}
    for kind in ("length", "strength"):
        of_kind = [steps for name, steps in rows.items() if name.startswith(kind)]
        found[f"series by {kind}: inclusion probability falls"] = share(sum(falls(steps, "inclusion") for steps in of_kind), len(of_kind))
        found[f"series by {kind}: of the effect or its class, falls"] = share(sum(falls(steps, "class_inclusion") for steps in of_kind), len(of_kind))
        last = [steps[-1] for steps in of_kind]
        found[f"series by {kind}: right or in class at the last step"] = share(sum(row["word"] in ("right", "in class") for row in last), len(last))
    friction = [[row["word"] for row in steps] for name, steps in rows.items() if name.startswith("strength coulomb_friction")]
    consistent = {"right", "in class", "as parameters"}
    found["friction at five strengths: named or parameters in all"] = share(sum(set(words) <= consistent for words in friction), len(friction))
    found["wrong and sure"] = share(sum(bool(case.sure_false) for case, _ in done), len(done))
    return found | costs([case for case, _ in done])


def lines(done):
    """A line a series: what re-identified parameters leave of the effect, then its probability and its class's at each step."""
    found = {}
    for name, steps in by_series([row for _, row in done]).items():
        counts = sorted({row["beyond_refit_counts"] for row in steps})
        left = " to ".join(f"{count:.2g}" for count in (counts[:1] if len(counts) == 1 else (counts[0], counts[-1])))
        at = "; ".join(f"{row['step']} {row['inclusion']:.2f} ({row['class_inclusion']:.2f}) {row['word']}" for row in steps)
        found[name] = f"{left} counts: {at}"
    return found


def line(row):
    return f"{row['step']}: P {row['inclusion']:.2f}, class {row['class_inclusion']:.2f}; {row['word']}; {row['said']}; {row['cpu_s']:.1f} s"
