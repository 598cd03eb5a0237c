"""Derivatives of the encoder's angle by every continuous parameter, as differences of the automaton's trajectories.

    python sensitivities.py        writes sensitivities/*.csv beside this file and prints how far two steps are apart
    python sensitivities.py ID...  only these

The effects, the drive and the automaton are those of `effects.py`. A column is `p dangle/dp`, the change of the angle
in rad for a change of the parameter by its own size, by the central difference of fourth order over p (1 +- h) and
p (1 +- 2 h), h = 2e-5: four trajectories at rtol 1e-12, each of which locates its own events.
"""

from pathlib import Path
import sys

import numpy as np

from effects import CASES, EVERY, SAMPLE_TIME_S, SAMPLES, drive, said
from hybrid import HANDOUT, Integrator, Motor

STEP = 2e-5
# What the angle does not depend on continuously.
DISCRETE = {"encoder_side", "into_supply", "max_rate_hz"}
# By the threshold of a dead zone the angle jumps where a level is on it, and does not change anywhere else.
FLAT = {"threshold_v"}
# What a motor may have twice: the columns are of both, named `effect.key`.
TWICE = ["cogging+cogging#2", "torque_ripple+torque_ripple#2+coast_at_zero"]
NOMINAL = ["resistance_ohm", "back_emf_v_s_per_rad", "torque_constant_nm_per_a", "viscous_friction_nm_s_per_rad",
           "inductance_h", "inertia_kg_m2", "coulomb_friction_nm"]


def angle(effects, parameters):
    """What the encoder says before it rounds, as an angle."""
    stretch = 1.0 + effects.get("clock_error", {}).get("relative", 0.0)
    delay = effects.get("transport_delay", {}).get("delay_s", 0.0) - effects.get("command_offset", {}).get("offset_s", 0.0)
    switches = [(max(k * SAMPLE_TIME_S * stretch + delay, 0.0), u) for k, u in drive()]
    instants = [k * SAMPLE_TIME_S * stretch for k in range(0, SAMPLES, EVERY)]
    motor = Motor(effects, parameters)
    trace = Integrator(motor, "DOP853", 1e-12, 1e-14).run(switches, instants)
    return np.array([said(effects, motor, x) for x in trace.rows]) * 2 * np.pi / HANDOUT["counts_per_rev"]


def column(effects, key, of_effect):
    """(p dangle/dp, how far the differences over h and 2 h are apart)."""
    def at(k):
        factor = 1.0 + k * STEP
        if of_effect is None:
            return angle(effects, {key: HANDOUT[key] * factor})
        moved = {**effects, of_effect: {**effects[of_effect], key: effects[of_effect][key] * factor}}
        return angle(moved, {})
    near = (at(1) - at(-1)) / (2 * STEP)
    far = (at(2) - at(-2)) / (4 * STEP)
    return (4 * near - far) / 3, np.abs(near - far).max()


def columns_of(effects):
    if not effects:
        return [(key, None) for key in NOMINAL]
    out = [(key, effect) for effect, values in effects.items() for key in values if key not in DISCRETE | FLAT]
    if "asymmetric_dead_zone" in effects:
        return []
    weights = [(key, effect) for key, effect in out if key == "load_friction_weight"]
    if weights:   # The other columns are those of the case without it.
        return weights
    if "supply_sag" in effects or "magnet_weakening" in effects:
        out.append(("supply_v", None))
    return out


def main(names):
    here = Path(__file__).parent / "sensitivities"
    here.mkdir(exist_ok=True)
    print("| case, parameter | largest, counts | two steps apart, counts |\n| --- | --- | --- |", flush=True)
    counts = HANDOUT["counts_per_rev"] / (2 * np.pi)
    for name in names or CASES:
        kind, effects = CASES[name]
        wanted = columns_of(effects)
        several = len(effects) > 1 and name not in TWICE
        if kind == "random" or "missed_counts" in effects or several or not wanted:
            continue
        titles = [f"{effect}.{key}" if name in TWICE else key for key, effect in wanted]
        table = []
        for title, (key, of_effect) in zip(titles, wanted):
            values, apart = column(effects, key, of_effect)
            table.append(values)
            print(f"| {name}, {title} | {np.abs(values).max() * counts:.3g} | {apart * counts:.1e} |", flush=True)
        with open(here / f"{name}.csv", "w") as f:
            f.write(f"# p dangle/dp in rad; the motor of effects/{name}.csv\n")
            f.write("sample," + ",".join(titles) + "\n")
            for row, k in enumerate(range(0, SAMPLES, EVERY)):
                f.write(f"{k}," + ",".join(f"{values[row]:.9g}" for values in table) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
