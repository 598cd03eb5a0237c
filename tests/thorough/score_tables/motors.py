"""Imagined motors and commands for the series and the main paths."""

import math
import random

from .generated import HANDOUT


def motor(supply_v, top_rad_s, resistance_ohm, time_constant_s, dry, wet, counts_per_rev):
    """A motor from what is seen of it: `dry` is Coulomb friction as a share of the stall torque, `wet` viscous friction over Kt Kb / R."""
    kb = supply_v * (1 - dry) / top_rad_s / (1 + wet)
    kt = 0.96 * kb
    coupling = kt * kb / resistance_ohm
    return {
        "resistance_ohm": resistance_ohm,
        "back_emf_v_s_per_rad": kb,
        "torque_constant_nm_per_a": kt,
        "viscous_friction_nm_s_per_rad": wet * coupling,
        "inductance_h": 3e-4 * resistance_ohm,
        "inertia_kg_m2": time_constant_s * (1 + wet) * coupling,
        "coulomb_friction_nm": dry * kt * supply_v / resistance_ohm,
        "counts_per_rev": counts_per_rev,
        "supply_v": supply_v,
    }


MOTORS = {
    "lab": HANDOUT,
    "hobby": motor(12.0, 22.0, 4.0, 0.05, 0.06, 0.05, 2400.0),
    "fast": motor(6.0, 600.0, 2.0, 0.03, 0.05, 0.05, 48.0),
    "servo": motor(7.4, 6.0, 6.0, 0.04, 0.08, 0.08, 4096.0),
}


def believed(true, sigma, seed):
    """The motor as its owner believes it to be: every number off by so much, one sigma, but not the encoder and the supply."""
    chance = random.Random(seed)
    kept = ("counts_per_rev", "supply_v")
    return {key: value if key in kept else float(f"{value * math.exp(chance.gauss(0, sigma)):.4g}") for key, value in true.items()}


def levels(supply_v, duration_s, seed):
    """Levels of either sign for 0.2 to 1 s: a sixth 0, a quarter where a motor just breaks away; at rest for 0.2 s before."""
    chance = random.Random(seed)
    found, lasted = [[0.0, 0.2]], 0.2
    while lasted < duration_s:
        held = round(chance.uniform(0.2, 1.0), 2)
        drawn = chance.random()
        share = 0.0 if drawn < 1 / 6 else chance.uniform(0.03, 0.2) if drawn < 5 / 12 else chance.uniform(0.2, 1.0)
        found.append([round(supply_v * chance.choice((-1, 1)) * share, 3), held])
        lasted += held
    return found


def reversing(supply_v, duration_s):
    """Both directions in turn, 0.9 s each, at 0.8 and at 0.5 of the supply."""
    found = [[0.0, 0.3]]
    while sum(held for _, held in found) < duration_s:
        k = len(found) - 1
        found.append([round(supply_v * (0.8, 0.5)[k // 2 % 2] * (1, -1)[k % 2], 3), 0.9])
    return found
