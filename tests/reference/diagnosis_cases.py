"""Recordings of motors with known hidden effects, to ask `motorlab diagnose` about; README.md says by which laws.

    python diagnosis_cases.py DIR LABELS.json [--seed N] [--singles N] [--pairs N] [--triples N] [--none N]
                              [--outside N]
    python diagnosis_cases.py DIR LABELS.json [--seed N] --kinds stribeck,backlash+dead_zone,none,driver_curve
                              [--beyond-refit]

Needs numpy and scipy. Writes DIR/case-0001/{motor.toml,run1.csv,run2.csv,run3.csv} and so on, and LABELS.json, an object
by case: `kind` (none, single, pair of two or three, outside), `effects[]` (`id`, `parameters`), `strength_counts{}` (RMS over the runs of
the angle with the effect against without it, in counts), `law` (friction, Stribeck's shape, spectrum of the wander),
`motor`, and with --beyond-refit `beyond_refit_counts`: what re-tuning the motor's figures within their tolerances leaves
of the effects (linear estimate, five further simulations a case). Same seed and kinds, same cases.
"""

import argparse
from functools import partial
import json
from math import copysign, exp, pi, sin, tanh
from pathlib import Path

import numpy as np
from scipy.integrate import odeint

HANDOUT = dict(
    resistance_ohm=10.0, back_emf_v_s_per_rad=0.7, torque_constant_nm_per_a=0.7, viscous_friction_nm_s_per_rad=0.01,
    inductance_h=0.004, inertia_kg_m2=0.002, coulomb_friction_nm=0.02,
)
COUNTS_PER_REV, SUPPLY_V, TOLERANCE = 720.0, 4.5, 0.05
COUNT_RAD = 2 * pi / COUNTS_PER_REV
RUBBING_SPEED = 5e-4      # rad/s, of the smoothed sign of the speed
CURRENT_SMALL = 1e-3      # A, of the smoothed sign of the current
BEND_RAD = 0.03 * COUNT_RAD   # over which a Dahl contact that is meant to be dry gives way
LEAST_COUNTS = {"sample_jitter": 0.4}   # of the strength; 2 otherwise
NEVER = 1e9

STRIBECK_SHAPES = {
    "gauss": lambda s: exp(-min(s * s, 700.0)),
    "tustin": lambda s: exp(-min(s, 700.0)),
    "hess_soom": lambda s: 1.0 / (1.0 + s * s),
}


# ---- what is drawn ------------------------------------------------------------------------------------------------
def four_digits(value):
    return float(f"{value:.4g}")


def draw_effect(name, m, rng):
    """Parameters of an effect for the motor `m`, over the catalogue's ranges."""
    tf, r, b = m["coulomb_friction_nm"], m["resistance_ohm"], m["viscous_friction_nm_s_per_rad"]
    top = SUPPLY_V / m["back_emf_v_s_per_rad"] * 0.85
    log = lambda low, high: float(np.exp(rng.uniform(np.log(low), np.log(high))))
    phase = lambda: float(rng.uniform(0, 2 * pi))
    order = lambda: float(rng.integers(2, 31))
    sign = lambda: float(rng.choice([-1.0, 1.0]))
    side = lambda: float(rng.integers(0, 2))
    telling = lambda low, high: next(f for f in iter(partial(log, low, high), None) if abs(np.log(f)) > 3 * TOLERANCE)
    drawn = {
        "transport_delay": lambda: dict(delay_s=log(0.0006, 0.05)),
        "dead_zone": lambda: dict(threshold_v=rng.uniform(0.3, 1.5)),
        "voltage_drop": lambda: dict(drop_v=log(0.1, 1.5)),
        "supply_sag": lambda: dict(source_resistance_ohm=log(0.5, 10.0)),
        "supply_error": lambda: dict(gain=telling(0.7, 1.3)),
        "current_limit": lambda: dict(limit_a=rng.uniform(0.2, 0.8) * SUPPLY_V / r),
        "coast_at_zero": lambda: {},
        "inductance": lambda: dict(inductance_h=log(0.003, 0.03) * r),
        "winding_heating": lambda: dict(resistance_rise_per_w=log(0.1, 0.8), time_constant_s=log(1.0, 60.0)),
        "torque_ripple": lambda: dict(amplitude=log(0.01, 0.25), cycles_per_rev=order(), phase_rad=phase()),
        "coulomb_friction": lambda: dict(torque_nm=telling(0.5, 5.0) * tf),
        "viscous_friction": lambda: dict(coefficient_nm_s_per_rad=telling(1.5, 10.0) * b),
        "inertia": lambda: dict(inertia_kg_m2=telling(0.3, 4.0) * m["inertia_kg_m2"]),
        "stribeck": lambda: dict(extra_torque_nm=log(0.3, 4.0) * tf, stribeck_speed_rad_s=log(0.1, 2.0)),
        "asymmetric_friction": lambda: dict(ratio=sign() * log(0.05, 0.8)),
        "presliding": lambda: dict(break_in_angle_rad=log(0.5, 10.0) * COUNT_RAD),
        "load_friction": lambda: dict(driving_fraction=rng.uniform(0, 0.5), driven_fraction=rng.uniform(0, 0.5)),
        "quadratic_drag": lambda: dict(coefficient_nm_s2_per_rad2=log(0.2, 2.0) * b / top),
        "gravity_load": lambda: dict(torque_nm=log(0.3, 5.0) * tf, phase_rad=phase()),
        "cogging": lambda: dict(torque_nm=log(0.3, 4.0) * tf, cycles_per_rev=order(), phase_rad=phase()),
        "backlash": lambda: dict(gap_rad=np.radians(log(0.5, 10.0)), load_fraction=rng.uniform(0.05, 0.9), encoder_side=side()),
        "compliance": lambda: dict(
            frequency_hz=log(1.0, 50.0), damping_ratio=log(0.02, 0.5), load_fraction=rng.uniform(0.05, 0.9), encoder_side=side()),
        "resolution_error": lambda: dict(counts_per_rev=float(rng.choice([360, 500, 1000, 1024, 1440, 2000]))),
        "missed_counts": lambda: dict(probability=log(0.003, 0.05), max_rate_hz=0.0),
        "encoder_eccentricity": lambda: dict(amplitude_rad=log(0.5, 6.0) * COUNT_RAD, phase_rad=phase()),
        "sample_jitter": lambda: dict(spread_s=log(0.0006, 0.003)),
        "clock_error": lambda: dict(relative=sign() * log(0.002, 0.1)),
        # Not in the catalogue.
        "torsion_spring": lambda: dict(stiffness_nm_per_rad=log(0.02, 0.2) * tf),
        "driver_curve": lambda: dict(exponent=rng.uniform(0.15, 0.6)),
        "open_segment": lambda: dict(kept=rng.uniform(0.2, 0.7), width_rad=np.radians(rng.uniform(15, 50)), at_rad=phase()),
        "battery_decline": lambda: dict(relative_per_s=rng.uniform(0.006, 0.02)),
        "late_rub": lambda: dict(torque_nm=log(0.5, 3.0) * tf, from_s=rng.uniform(5.0, 11.0)),
        "eddy_brake": lambda: dict(peak_torque_nm=log(0.5, 3.0) * tf, peak_speed_rad_s=rng.uniform(0.5, 2.5)),
    }
    return {key: four_digits(value) for key, value in drawn[name]().items()}


OUTSIDE = ["torsion_spring", "driver_curve", "open_segment", "battery_decline", "late_rub", "eddy_brake"]
CATALOGUE = [
    "transport_delay", "dead_zone", "voltage_drop", "supply_sag", "supply_error", "current_limit", "coast_at_zero", "inductance",
    "winding_heating", "torque_ripple", "coulomb_friction", "viscous_friction", "inertia", "stribeck", "asymmetric_friction",
    "presliding", "load_friction", "quadratic_drag", "gravity_load", "cogging", "backlash", "compliance", "resolution_error",
    "missed_counts", "encoder_eccentricity", "sample_jitter", "clock_error",
]


def profiles(m, rng):
    """(name, sample time, command of each sample in V): two steps and a sequence of levels in both directions."""
    runs = []
    for sample_time in (0.03, 0.003):
        command = np.full(round(4.0 / sample_time), SUPPLY_V)
        command[: round(0.3 / sample_time)] = 0.0
        runs.append(("step", sample_time, command))
    runs.append(("multi-level", 0.003, levels(m, 5000, rng)))
    return runs


def levels(m, samples, rng):
    """Levels in V in both directions, some about breakaway, each held for 50 to 300 samples."""
    breakaway = m["coulomb_friction_nm"] * m["resistance_ohm"] / m["torque_constant_nm_per_a"]
    command = [0.0] * 60
    while len(command) < samples:
        kind = rng.uniform()
        level = 0.0 if kind < 0.15 else breakaway * rng.uniform(0.6, 3.0) if kind < 0.4 else SUPPLY_V * rng.uniform(0.25, 1.0)
        command += [round(float(rng.choice([-1.0, 1.0])) * min(level, SUPPLY_V), 3)] * int(rng.uniform(50, 300))
    return np.array(command[:samples])


def coloured(slope, seconds, rng):
    """Noise of unit variance with the spectrum 1/f^slope from 1/seconds to 25 Hz, every 20 ms."""
    n = int(seconds / 0.02) + 20
    frequency = np.fft.rfftfreq(n, 0.02)
    spectrum = (rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency)))
    spectrum[1:] *= frequency[1:] ** (-slope / 2)
    spectrum[0] = 0.0
    noise = np.fft.irfft(spectrum, n)
    return (noise / noise.std()).tolist()


# ---- the motor ----------------------------------------------------------------------------------------------------
def equations(m, fx, law, wander):
    """The right-hand side x' = f(t, x, u), x = (theta, w, i, heat, friction[, theta2, w2])."""
    get = lambda effect, key, default=0.0: fx.get(effect, {}).get(key, default)
    R, Kb, Kt = m["resistance_ohm"], m["back_emf_v_s_per_rad"], m["torque_constant_nm_per_a"]
    L = get("inductance", "inductance_h", m["inductance_h"])
    J = get("inertia", "inertia_kg_m2", m["inertia_kg_m2"])
    b = get("viscous_friction", "coefficient_nm_s_per_rad", m["viscous_friction_nm_s_per_rad"])
    tf = get("coulomb_friction", "torque_nm", m["coulomb_friction_nm"])
    gain, dead = get("supply_error", "gain", 1.0), get("dead_zone", "threshold_v", -1.0)
    drop, source = get("voltage_drop", "drop_v"), get("supply_sag", "source_resistance_ohm")
    limit, coasts = get("current_limit", "limit_a", NEVER), "coast_at_zero" in fx
    rise, heat_time = get("winding_heating", "resistance_rise_per_w"), get("winding_heating", "time_constant_s", 1.0)
    ripple, ripple_n, ripple_at = (get("torque_ripple", k) for k in ("amplitude", "cycles_per_rev", "phase_rad"))
    extra, slow = get("stribeck", "extra_torque_nm"), get("stribeck", "stribeck_speed_rad_s", 1.0)
    shape, ratio = STRIBECK_SHAPES[law["stribeck"]], get("asymmetric_friction", "ratio")
    driving, driven = get("load_friction", "driving_fraction"), get("load_friction", "driven_fraction")
    drag = get("quadratic_drag", "coefficient_nm_s2_per_rad2")
    gravity, gravity_at = get("gravity_load", "torque_nm"), get("gravity_load", "phase_rad")
    cogging, cogging_n, cogging_at = (get("cogging", k) for k in ("torque_nm", "cycles_per_rev", "phase_rad"))
    spring, power = get("torsion_spring", "stiffness_nm_per_rad"), get("driver_curve", "exponent")
    kept, width, segment_at = get("open_segment", "kept", None), get("open_segment", "width_rad"), get("open_segment", "at_rad")
    decline, rub, rub_from = get("battery_decline", "relative_per_s"), get("late_rub", "torque_nm"), get("late_rub", "from_s", NEVER)
    eddy, eddy_speed = get("eddy_brake", "peak_torque_nm"), get("eddy_brake", "peak_speed_rad_s", 1.0)
    bend = get("presliding", "break_in_angle_rad", BEND_RAD)
    dahl = "presliding" in fx or law["friction"] == "dahl"
    sigma, load_noise, friction_noise = wander

    def electric(t, u, theta, w, i, heat):
        """Current's and heat's derivatives, and the motor torque."""
        u = 0.0 if abs(u) <= dead else u
        k = 1.0 + ripple * sin(ripple_n * theta + ripple_at) if ripple else 1.0
        if kept is not None:
            away = (theta - segment_at + pi) % (2 * pi) - pi
            k *= 1.0 - (1.0 - kept) * 0.5 * (1.0 - tanh((abs(away) - width / 2) / 0.02))
        v = gain * u * (1.0 - decline * t)
        if power and u:
            v *= abs(u / SUPPLY_V) ** power
        v -= Kb * k * w
        if drop:
            v -= drop * tanh(i / CURRENT_SMALL)
        if abs(i) > limit:
            v -= copysign(3000.0 * (abs(i) - limit), i)
        r = R * (1.0 + rise * heat)
        if source:
            r += (u / SUPPLY_V) ** 2 * source
        if coasts and u == 0.0:
            r += 1e4
        return (v - r * i) / L, (r * i * i - heat) / heat_time, Kt * k * i

    def level(t, w, tau):
        """Dry friction at the speed `w` without its sign."""
        s = tanh(w / RUBBING_SPEED)
        f = tf * (1.0 + ratio * s)
        if extra:
            f += extra * shape(abs(w) / slow)
        if driving or driven:
            f += (driving if tau * w >= 0.0 else driven) * abs(tau)
        if t > rub_from:
            f += rub * min(1.0, 5.0 * (t - rub_from))
        if sigma:
            k = int(t * 50.0)
            f *= 1.0 + sigma * (friction_noise[k] + (t * 50.0 - k) * (friction_noise[k + 1] - friction_noise[k]))
        return f, s

    def load(t, theta, w):
        """Torques that act on the load, all but friction."""
        torque = 0.0
        if gravity:
            torque -= gravity * sin(theta + gravity_at)
        if drag:
            torque -= drag * w * abs(w)
        if spring:
            torque -= spring * theta
        if eddy:
            torque -= eddy * 2.0 * (w / eddy_speed) / (1.0 + (w / eddy_speed) ** 2)
        if sigma:
            k = int(t * 50.0)
            torque += sigma * tf * (load_noise[k] + (t * 50.0 - k) * (load_noise[k + 1] - load_noise[k]))
        return torque

    def rigid(t, x, u):
        theta, w, i, heat, bent = x.tolist()
        di, dheat, tau = electric(t, u, theta, w, i, heat)
        f, s = level(t, w, tau)
        if dahl:
            rubbing, dbent = bent, tf / bend * (w - abs(w) * bent / f)
        else:
            rubbing, dbent = f * s, 0.0
        if cogging:
            tau += cogging * sin(cogging_n * theta + cogging_at)
        return w, (tau + load(t, theta, w) - b * w - rubbing) / J, di, dheat, dbent

    link = fx.get("backlash") or fx.get("compliance")
    if link is None:
        return rigid
    part = link["load_fraction"]
    J1, J2, b1, b2 = (1 - part) * J, part * J, (1 - part) * b, part * b
    half = link.get("gap_rad", 0.0) / 2
    reduced, rate = J1 * J2 / J, 2 * pi * link.get("frequency_hz", 0.0)
    stiffness, damping = rate**2 * reduced, 2 * link.get("damping_ratio", 0.0) * rate * reduced
    # Flanks after Hunt and Crossley: 0.5 mrad deep at the stall torque.
    hard = Kt * SUPPLY_V / R / 5e-4**1.5
    restitution = law["restitution_s_per_rad"]

    def coupled(t, x, u):
        theta, w, i, heat, _, theta2, w2 = x.tolist()
        di, dheat, tau = electric(t, u, theta, w, i, heat)
        (f1, s1), (f2, s2) = level(t, w, tau), level(t, w2, tau)
        twist, rate = theta - theta2, w - w2
        if half:
            deep = abs(twist) - half
            push = 0.0
            if deep > 0.0:
                push = hard * deep**1.5 * max(0.0, 1.0 + 1.5 * restitution * copysign(rate, twist * rate))
                push = copysign(push, twist)
        else:
            push = stiffness * twist + damping * rate
        if cogging:
            tau += cogging * sin(cogging_n * theta + cogging_at)
        dw = (tau - push - b1 * w - (1 - part) * f1 * s1) / J1
        dw2 = (push + load(t, theta2, w2) - b2 * w2 - part * f2 * s2) / J2
        return w, dw, di, dheat, 0.0, w2, dw2

    return coupled


def angles(m, fx, law, wander, changes, at):
    """Angle in rad of the shaft that bears the encoder at the instants `at`; `changes`: (instant, command in V) in order."""
    f = equations(m, fx, law, wander)
    link = fx.get("backlash") or fx.get("compliance")
    x = np.zeros(5 if link is None else 7)
    shown = 5 if link and link["encoder_side"] == 1.0 else 0
    found = np.zeros(len(at))
    instants = [0.0] + [t for t, _ in changes] + [float(at[-1])]
    commands = [0.0] + [u for _, u in changes]
    for begin, end, u in zip(instants, instants[1:], commands):
        end = min(end, float(at[-1]))
        if end <= begin:
            continue
        first, last = np.searchsorted(at, [begin, end], side="right")
        inside = at[first:last]
        inside = inside[inside < end]
        times = np.concatenate(([begin], inside, [end]))
        x_of, told = odeint(f, x, times, args=(u,), tfirst=True, rtol=1e-7, atol=1e-8, hmax=0.05, mxstep=100000, full_output=True)
        if told["message"] != "Integration successful.":
            raise RuntimeError(told["message"])
        found[first : first + len(inside)] = x_of[1:-1, shown]
        found[first + len(inside) : last] = x_of[-1, shown]
        x = x_of[-1]
    return found


# ---- the board ----------------------------------------------------------------------------------------------------
def read_out(m, fx, law, profile, chances, still=False):
    """One run: unrounded counts without wander (`still`), or (device times, host times, counts)."""
    _, sample_time, command = profile
    rng = np.random.default_rng(chances)
    n = len(command)
    late = rng.gamma(2.0, 1e-6, n)
    start, host_offset = rng.uniform(), rng.uniform(0, 50)
    host_rate = 1.0 + 20e-6 * rng.standard_normal()
    delay = 0.6e-3 + rng.lognormal(np.log(3e-4), 0.5, n)
    lateness = rng.uniform(0, 1, n)
    noises = [coloured(law["wander_slope"], max(20.0, n * sample_time + 5.0), rng) for _ in range(2)]
    real = sample_time * (1.0 + fx.get("clock_error", {}).get("relative", 0.0))
    tick = np.arange(n) * real + late
    at = tick + fx.get("sample_jitter", {}).get("spread_s", 0.0) * lateness
    delay_s = fx.get("transport_delay", {}).get("delay_s", 0.0)
    steps = [k for k in range(1, n) if command[k] != command[k - 1]]
    changes = [(float(tick[k]) + delay_s, float(command[k])) for k in steps]
    wander = (0.0 if still else law["wander_relative"], *noises)
    theta = angles(m, fx, law, wander, changes, at)
    if "encoder_eccentricity" in fx:
        e = fx["encoder_eccentricity"]
        theta = theta + e["amplitude_rad"] * (np.sin(theta + e["phase_rad"]) - np.sin(e["phase_rad"]))
    position = theta * fx.get("resolution_error", {}).get("counts_per_rev", COUNTS_PER_REV) / (2 * pi)
    lost = fx.get("missed_counts", {}).get("probability", 0.0)
    if still:
        return position * (1.0 - lost)
    counts = np.floor(position + start).astype(int)
    if lost:
        edges = np.diff(counts, prepend=counts[0])
        counts = counts[0] + np.cumsum(np.sign(edges) * rng.binomial(np.abs(edges), 1.0 - lost))
    device = np.arange(n) * sample_time + late
    host = host_offset + host_rate * (at + delay)
    return device - device[0], np.maximum.accumulate(host), counts - counts[0]


def run_file(profile, device, host, counts):
    name, sample_time, command = profile
    head = ['format = "motorlab-run/1"', f"sample_time_s = {sample_time}", f"counts_per_rev = {COUNTS_PER_REV}",
            f"supply_v = {SUPPLY_V}", f'profile = "{name}"', "complete = true"]
    rows = [f"{k},{device[k]:.6f},{host[k]:.6f},{command[k]:.3f},{counts[k]}" for k in range(len(counts))]
    return "\n".join([f"# {line}" for line in head] + ["seq,t_s,host_t_s,command_v,counts"] + rows) + "\n"


def motor_file(nominal):
    lines = [f"{key} = {value}" for key, value in nominal.items()]
    lines += [f"counts_per_rev = {COUNTS_PER_REV}", f"supply_v = {SUPPLY_V}", "", "[tolerance]"]
    return "\n".join(lines + [f"{key} = {TOLERANCE}" for key in nominal]) + "\n"


# ---- a case -------------------------------------------------------------------------------------------------------
def rms(difference):
    return float(np.sqrt(np.mean(np.square(difference))))


class TooLittle(RuntimeError):
    """No sizes of the effects were drawn that show each of them."""


def make_case(seed, names, directory, with_refit):
    rng = np.random.default_rng(seed)
    m = {key: value * float(np.exp(0.1 * rng.standard_normal())) for key, value in HANDOUT.items()}
    nominal = {key: four_digits(value * (1 + TOLERANCE * rng.standard_normal())) for key, value in m.items()}
    coupled = any(name in ("backlash", "compliance") for name in names)
    law = dict(
        friction="tanh" if coupled else str(rng.choice(["tanh", "dahl"])), stribeck=str(rng.choice(list(STRIBECK_SHAPES))),
        wander_slope=float(rng.choice([1.0, 2.0])), wander_relative=float(np.exp(rng.uniform(np.log(3e-4), np.log(0.01)))),
        restitution_s_per_rad=float(rng.uniform(0.3, 1.0)),
    )
    runs = profiles(m, rng)
    chances = [int(c) for c in rng.integers(0, 2**62, 3)]
    still = lambda motor, fx: np.concatenate([read_out(motor, fx, law, *each, still=True) for each in zip(runs, chances)])
    plain = still(m, {}) if names else None
    for _ in range(40):
        fx = {name: draw_effect(name, m, rng) for name in names}
        shown = still(m, fx) if names else None
        without = {name: plain if len(names) == 1 else still(m, {n: fx[n] for n in names if n != name}) for name in names}
        strength = {name: rms(shown - without[name]) for name in names}
        if all(strength[name] >= LEAST_COUNTS.get(name, 2.0) for name in names):
            break
    else:
        raise TooLittle(f"seed {seed}: no strength of {names} moves the angle by enough")
    directory.mkdir(parents=True, exist_ok=True)
    for k, (profile, chance) in enumerate(zip(runs, chances), 1):
        (directory / f"run{k}.csv").write_text(run_file(profile, *read_out(m, fx, law, profile, chance)))
    (directory / "motor.toml").write_text(motor_file(nominal))
    kind = "none" if not names else "pair" if len(names) >= 2 else "outside" if names[0] in OUTSIDE else "single"
    label = dict(kind=kind, effects=[dict(id=name, parameters=fx[name]) for name in names], strength_counts=strength, law=law, motor=m)
    if with_refit and names:
        label["beyond_refit_counts"] = beyond_refit(m, still, plain, shown - plain)
    return label


def beyond_refit(m, still, plain, effect):
    """What Gaussian priors of one tolerance on R, K, J, b and Tf let a refit of the plain motor leave of `effect`."""
    columns = []
    for keys in (("resistance_ohm",), ("back_emf_v_s_per_rad", "torque_constant_nm_per_a"), ("inertia_kg_m2",),
                 ("viscous_friction_nm_s_per_rad",), ("coulomb_friction_nm",)):
        moved = dict(m, **{key: m[key] * 1.01 for key in keys})
        columns.append((still(moved, {}) - plain) / 0.01 * TOLERANCE)
    # A count's rounding as the noise; correlated errors would weigh the tolerances more.
    a = np.vstack([np.array(columns).T * np.sqrt(12.0), np.eye(5)])
    y = np.concatenate([effect * np.sqrt(12.0), np.zeros(5)])
    found = np.linalg.lstsq(a, y, rcond=None)[0]
    return rms(effect - np.array(columns).T @ found)


def plan(arguments, rng):
    """The names of each case."""
    if arguments.kinds:
        return [[] if kind == "none" else kind.split("+") for kind in arguments.kinds.split(",")]
    deal = lambda names, count: [str(n) for _ in range(count // len(names) + 1) for n in rng.permutation(names)][:count]
    cases = [[name] for name in deal(CATALOGUE, arguments.singles)]
    partners = deal(CATALOGUE, 8 * arguments.pairs)
    pairs = [[a, b] for a, b in zip(partners[::2], partners[1::2]) if a != b and {a, b} != {"backlash", "compliance"}]
    thirds = deal(CATALOGUE, 12 * arguments.triples)
    triples = [list(three) for three in zip(thirds[::3], thirds[1::3], thirds[2::3])
               if len({*three}) == 3 and not {"backlash", "compliance"} <= {*three}]
    several = pairs[: arguments.pairs] + triples[: arguments.triples]
    return cases + several + [[]] * arguments.none + [[name] for name in deal(OUTSIDE, arguments.outside)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("directory", type=Path)
    parser.add_argument("labels", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds")
    for kind in ("singles", "pairs", "triples", "none", "outside"):
        parser.add_argument(f"--{kind}", type=int, default=0)
    parser.add_argument("--beyond-refit", action="store_true")
    arguments = parser.parse_args()
    labels = {}
    for k, names in enumerate(plan(arguments, np.random.default_rng(arguments.seed)), 1):
        name = f"case-{k:04}"
        try:
            labels[name] = make_case([arguments.seed, k], names, arguments.directory / name, arguments.beyond_refit)
        except TooLittle as error:
            # Of three, one may hide another whatever their sizes.
            if len(names) < 3:
                raise
            print(f"{name} left out: {error}", flush=True)
            continue
        arguments.labels.write_text(json.dumps(labels, indent=1) + "\n")
        print(name, "+".join(names) or "none", {n: round(s, 2) for n, s in labels[name]["strength_counts"].items()}, flush=True)


if __name__ == "__main__":
    main()
