"""Reference trajectories of every effect of the signal chain, and of a few combinations.

    python effects.py             writes effects/*.csv beside this file and prints the convergence table
    python effects.py ID...       only these
    python effects.py --check     recomputes and compares with what is there; writes nothing

Each case is integrated with DOP853 at rtol 1e-12, again at rtol 1e-9, and with Radau at rtol 1e-9; the differences are
the convergence table. `hybrid.py` holds the equations and the automaton, README.md says what they mean.
"""

from math import floor, pi
from pathlib import Path
import sys
import time

import numpy as np
from scipy.optimize import brentq

from hybrid import CUR, HANDOUT, KEPT, LAG, TH1, TH2, W1, W2, Integrator, Motor

SAMPLE_TIME_S = 0.003
SAMPLES = 5000
EVERY = 20
START_FRACTION = 0.5   # where inside a count the shaft starts: counts = floor(N theta / 2 pi + 1/2)

# (samples, volts): failed breakaways, crawling, reversals with and without a stop, switching off while turning,
# small reversals, and a staircase, within the handout's 4.5 V.
SEGMENTS = [
    (50, 0.0), (200, 4.5), (150, 0.0), (200, -4.5), (100, 4.5), (150, 1.5), (100, 0.5), (100, 0.2), (100, 0.28),
    (150, 0.35), (100, -0.25), (150, -0.6), (150, -2.2), (100, 0.0), (200, 3.0), (100, 1.0), (100, 2.0), (100, -1.0),
    (20, 1.0), (20, -1.0), (20, 1.0), (20, -1.0), (20, 1.0), (20, -1.0), (40, 2.0), (40, -2.0), (40, 2.0), (40, -2.0),
    (150, 0.0), (200, 0.9), (150, -0.9), (200, 3.5), (50, -3.5), (100, 0.0), (150, -3.0), (100, -1.2), (100, 0.4),
    (100, -0.4), (200, 4.5), (100, 2.5), (100, -0.3), (200, -4.0), (100, 0.0), (100, 1.2), (50, 0.0), (100, -1.8),
    (80, 0.7), (60, -0.7),
]

# id of the file -> (class, effects). A class is how a simulated run should be compared: smooth and switching by
# angle, random by mean and variance.
CASES = {
    "nominal": ("switching", {}),
    "transport_delay": ("switching", {"transport_delay": dict(delay_s=0.0065)}),
    "command_offset": ("switching", {"command_offset": dict(offset_s=0.0085)}),
    "dead_zone": ("switching", {"dead_zone": dict(threshold_v=0.75)}),
    "asymmetric_dead_zone": ("switching", {"asymmetric_dead_zone": dict(positive_v=0.45, negative_v=1.1)}),
    "asymmetric_voltage_drop": ("switching", {"asymmetric_voltage_drop": dict(positive_v=0.25, negative_v=0.7)}),
    "asymmetric_gain": ("switching", {"asymmetric_gain": dict(ratio=0.12)}),
    "magnet_weakening": ("switching", {"magnet_weakening": dict(drop=0.3, time_constant_s=4.0)}),
    "winding_heating+magnet_weakening+asymmetric_voltage_drop": ("switching", {
        "winding_heating": dict(resistance_rise_per_w=0.8, time_constant_s=5.0),
        "magnet_weakening": dict(drop=0.3, time_constant_s=5.0),
        "asymmetric_voltage_drop": dict(positive_v=0.25, negative_v=0.7)}),
    "asymmetric_gain+asymmetric_dead_zone+current_limit": ("switching", {
        "asymmetric_gain": dict(ratio=-0.12), "asymmetric_dead_zone": dict(positive_v=0.45, negative_v=1.1),
        "current_limit": dict(limit_a=0.2)}),
    "voltage_drop": ("switching", {"voltage_drop": dict(drop_v=0.6)}),
    "supply_sag": ("switching", {"supply_sag": dict(source_resistance_ohm=4.0)}),
    "supply_error": ("switching", {"supply_error": dict(gain=0.88)}),
    "current_limit": ("switching", {"current_limit": dict(limit_a=0.2)}),
    "coast_at_zero": ("switching", {"coast_at_zero": {}}),
    "pwm_freewheel": ("switching", {"pwm_freewheel": dict(period_ratio=3.0, into_supply=1)}),
    "pwm_freewheel_diode": ("switching", {"pwm_freewheel": dict(period_ratio=3.0, into_supply=0)}),
    "inductance": ("switching", {"inductance": dict(inductance_h=0.1)}),
    "winding_heating": ("switching", {"winding_heating": dict(resistance_rise_per_w=0.8, time_constant_s=5.0)}),
    "torque_ripple": ("switching", {"torque_ripple": dict(amplitude=0.12, cycles_per_rev=11.0, phase_rad=0.7)}),
    "coulomb_friction": ("switching", {"coulomb_friction": dict(torque_nm=0.05)}),
    "viscous_friction": ("switching", {"viscous_friction": dict(coefficient_nm_s_per_rad=0.03)}),
    "asymmetric_viscous": ("switching", {"asymmetric_viscous": dict(ratio=0.4)}),
    "inertia": ("switching", {"inertia": dict(inertia_kg_m2=0.005)}),
    "stribeck": ("switching", {"stribeck": dict(extra_torque_nm=0.03, stribeck_speed_rad_s=0.5)}),
    "asymmetric_friction": ("switching", {"asymmetric_friction": dict(ratio=0.35)}),
    "static_friction": ("switching", {"static_friction": dict(torque_nm=0.0625)}),
    "constant_load": ("switching", {"constant_load": dict(torque_nm=0.015)}),
    "presliding": ("smooth", {"presliding": dict(break_in_angle_rad=0.035)}),
    "load_friction": ("switching", {"load_friction": dict(driving_fraction=0.2, driven_fraction=0.35)}),
    "quadratic_drag": ("switching", {"quadratic_drag": dict(coefficient_nm_s2_per_rad2=0.002)}),
    "gravity_load": ("switching", {"gravity_load": dict(torque_nm=0.04, phase_rad=0.6)}),
    "cogging": ("switching", {"cogging": dict(torque_nm=0.03, cycles_per_rev=12.0, phase_rad=1.1)}),
    "cogging+cogging#2": ("switching", {
        "cogging": dict(torque_nm=0.03, cycles_per_rev=7.0, phase_rad=1.1),
        "cogging#2": dict(torque_nm=0.02, cycles_per_rev=28.0, phase_rad=0.4)}),
    "torque_ripple+torque_ripple#2+coast_at_zero": ("switching", {
        "torque_ripple": dict(amplitude=0.12, cycles_per_rev=11.0, phase_rad=0.7),
        "torque_ripple#2": dict(amplitude=0.06, cycles_per_rev=22.0, phase_rad=0.2), "coast_at_zero": {}}),
    "backlash": ("switching", {"backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=1)}),
    "backlash_heavy_load": ("switching", {
        "backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=1, load_friction_weight=4.5)}),
    "compliance_light_load": ("switching", {
        "compliance": dict(frequency_hz=10.0, damping_ratio=0.05, load_fraction=0.4, encoder_side=0, load_friction_weight=0.2)}),
    "slipping_clutch": ("switching", {"slipping_clutch": dict(torque_nm=0.06, load_share=0.5)}),
    "backlash_motor_side": ("switching", {"backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=0)}),
    "compliance": ("switching", {"compliance": dict(frequency_hz=10.0, damping_ratio=0.05, load_fraction=0.4, encoder_side=1)}),
    "compliance_motor_side": ("switching", {"compliance": dict(frequency_hz=10.0, damping_ratio=0.05, load_fraction=0.4, encoder_side=0)}),
    "resolution_error": ("switching", {"resolution_error": dict(counts_per_rev=1000.0)}),
    "encoder_eccentricity": ("switching", {"encoder_eccentricity": dict(amplitude_rad=0.026, phase_rad=0.4)}),
    "edge_rate_loss": ("switching", {"edge_rate_loss": dict(rate_hz=450.0, exponent=9.0)}),
    "speed_filter": ("switching", {"speed_filter": dict(time_constant_s=0.02)}),
    "clock_error": ("switching", {"clock_error": dict(relative=0.03)}),
    "missed_counts": ("random", {"missed_counts": dict(probability=0.02, max_rate_hz=0.0)}),
    "missed_counts_rate": ("switching", {"missed_counts": dict(probability=0.0, max_rate_hz=400.0)}),
    "sample_jitter": ("random", {"sample_jitter": dict(spread_s=0.0012)}),
    "stribeck+cogging+voltage_drop": ("switching", {
        "stribeck": dict(extra_torque_nm=0.03, stribeck_speed_rad_s=0.5),
        "cogging": dict(torque_nm=0.03, cycles_per_rev=12.0, phase_rad=1.1), "voltage_drop": dict(drop_v=0.3)}),
    "backlash+asymmetric_friction": ("switching", {
        "backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=1), "asymmetric_friction": dict(ratio=0.35)}),
    "backlash+compliance": ("switching", {
        "backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=1),
        "compliance": dict(frequency_hz=10.0, damping_ratio=0.05, load_fraction=0.4, encoder_side=1)}),
    "supply_sag+winding_heating+torque_ripple": ("switching", {
        "supply_sag": dict(source_resistance_ohm=4.0),
        "winding_heating": dict(resistance_rise_per_w=0.8, time_constant_s=5.0),
        "torque_ripple": dict(amplitude=0.12, cycles_per_rev=11.0, phase_rad=0.7)}),
    "voltage_drop+current_limit+coast_at_zero": ("switching", {
        "voltage_drop": dict(drop_v=0.6), "current_limit": dict(limit_a=0.2), "coast_at_zero": {}}),
    "transport_delay+dead_zone+gravity_load": ("switching", {
        "transport_delay": dict(delay_s=0.0065), "dead_zone": dict(threshold_v=0.75),
        "gravity_load": dict(torque_nm=0.04, phase_rad=0.6)}),
    "presliding+inductance+quadratic_drag": ("smooth", {
        "presliding": dict(break_in_angle_rad=0.035), "inductance": dict(inductance_h=0.1),
        "quadratic_drag": dict(coefficient_nm_s2_per_rad2=0.002)}),
    "presliding+stribeck": ("smooth", {
        "presliding": dict(break_in_angle_rad=0.035), "stribeck": dict(extra_torque_nm=0.03, stribeck_speed_rad_s=0.8)}),
    "presliding+load_friction": ("smooth", {
        "presliding": dict(break_in_angle_rad=0.035), "load_friction": dict(driving_fraction=0.2, driven_fraction=0.35)}),
    "compliance+voltage_drop+encoder_eccentricity": ("switching", {
        "compliance": dict(frequency_hz=10.0, damping_ratio=0.05, load_fraction=0.4, encoder_side=1),
        "voltage_drop": dict(drop_v=0.3), "encoder_eccentricity": dict(amplitude_rad=0.026, phase_rad=0.4)}),
    "backlash+asymmetric_viscous+static_friction": ("switching", {
        "backlash": dict(gap_rad=0.07, load_fraction=0.4, encoder_side=1),
        "asymmetric_viscous": dict(ratio=0.4), "static_friction": dict(torque_nm=0.03)}),
    "edge_rate_loss+speed_filter+clock_error": ("switching", {
        "edge_rate_loss": dict(rate_hz=450.0, exponent=9.0), "speed_filter": dict(time_constant_s=0.1),
        "clock_error": dict(relative=0.03)}),
    "slipping_clutch+cogging+voltage_drop": ("switching", {
        "slipping_clutch": dict(torque_nm=0.06, load_share=0.5),
        "cogging": dict(torque_nm=0.03, cycles_per_rev=12.0, phase_rad=1.1), "voltage_drop": dict(drop_v=0.3)}),
    "pwm_freewheel+supply_sag+torque_ripple": ("switching", {
        "pwm_freewheel": dict(period_ratio=1.0, into_supply=1), "supply_sag": dict(source_resistance_ohm=4.0),
        "torque_ripple": dict(amplitude=0.12, cycles_per_rev=11.0, phase_rad=0.7)}),
    "load_friction+inertia+clock_error": ("switching", {
        "load_friction": dict(driving_fraction=0.2, driven_fraction=0.35), "inertia": dict(inertia_kg_m2=0.005),
        "clock_error": dict(relative=0.03)}),
}


def drive():
    """(sample, volts) at which the command changes."""
    assert sum(n for n, _ in SEGMENTS) <= SAMPLES
    out, k = [], 0
    for n, u in SEGMENTS:
        out.append((k, u))
        k += n
    out.append((k, 0.0))
    return out


def integrate(effects, method="DOP853", rtol=1e-12, atol=1e-14, keep_dense=False, instants=None):
    stretch = 1.0 + effects.get("clock_error", {}).get("relative", 0.0)
    delay = effects.get("transport_delay", {}).get("delay_s", 0.0) - effects.get("command_offset", {}).get("offset_s", 0.0)
    switches = [(max(k * SAMPLE_TIME_S * stretch + delay, 0.0), u) for k, u in drive()]
    if instants is None:
        instants = [k * SAMPLE_TIME_S * stretch for k in range(0, SAMPLES, EVERY)]
    motor = Motor(effects)
    trace = Integrator(motor, method, rtol, atol, keep_dense).run(switches, instants)
    return motor, trace


def encoder_angle(motor, x):
    return x[TH2] if motor.encoder_side == 1 else x[TH1]


def encoder_speed(motor, x):
    return x[W2] if motor.encoder_side == 1 else x[W1]


def unrounded_counts(effects, angle):
    """What the encoder would say before rounding; counts = floor(this + start fraction)."""
    ecc = effects.get("encoder_eccentricity")
    if ecc:
        angle = angle + ecc["amplitude_rad"] * np.sin(angle + ecc["phase_rad"])
    n = effects.get("resolution_error", HANDOUT)["counts_per_rev"]
    return n * angle / (2 * pi)


def said(effects, motor, x):
    """The same of a state: what an encoder that remembers says, or one that does not."""
    if "speed_filter" in effects:
        return x[LAG]
    if "edge_rate_loss" in effects:
        return x[KEPT]
    return unrounded_counts(effects, encoder_angle(motor, x))


def edges(trace, motor):
    """Every encoder edge of a run kept dense: (instant, +1 or -1, speed)."""
    quantum = 2 * pi / motor.counts_per_rev
    out = []
    count = floor(START_FRACTION)
    for t0, t1, dense in trace.pieces:
        # A piece is at most one integrator step; between events the speed changes sign only at its ends, and
        # presliding, the exception, has no reference that counts edges.
        a0, a1 = dense(t0)[TH1], dense(t1)[TH1]
        end = floor(a1 / quantum + START_FRACTION)
        while count != end:
            sign = 1 if end > count else -1
            level = (count + (1 if sign > 0 else 0) - START_FRACTION) * quantum
            f = lambda t: dense(t)[TH1] - level
            t = brentq(f, t0, t1, xtol=1e-14) if f(t0) * f(t1) < 0 else (t0 if abs(a0 - level) < abs(a1 - level) else t1)
            out.append((t, sign, dense(t)[W1]))
            count += sign
    return out


def closed_form_difference():
    """The automaton without any friction torque against the closed form of the handout's second-order step: rad."""
    rows = np.genfromtxt(Path(__file__).parent / "handout" / "second_order_viscous.csv", delimiter=",", skip_header=9)[10::10]
    motor = Motor({"coulomb_friction": dict(torque_nm=0.0)})
    trace = Integrator(motor).run([(0.0, HANDOUT["supply_v"])], rows[:, 0])
    return np.abs(np.array(trace.rows)[:, TH1] - rows[:, 2]).max()


def header(f, name, kind, effects, columns):
    f.write(f"# {name}: {kind}; sample_time_s = {SAMPLE_TIME_S}, command in drive.csv, every {EVERY}th sample\n")
    for effect, parameters in effects.items():
        name = f'"{effect}"' if "#" in effect else effect   # no bare key of TOML
        f.write(f"# [effects.{name}]\n")
        for key, value in parameters.items():
            f.write(f"# {key} = {value}\n")
    f.write(columns + "\n")


def trajectory_lines(effects, motor, trace):
    lines = []
    for k, x in zip(range(0, SAMPLES, EVERY), trace.rows):
        angle = encoder_angle(motor, x)
        values = [k * SAMPLE_TIME_S, angle, encoder_speed(motor, x), x[CUR], said(effects, motor, x)]
        lines.append(f"{k}," + ",".join(f"{v:.14g}" for v in values))
    return "sample,t_s,angle_rad,speed_rad_s,current_a,unrounded_counts", lines


def rate_limited_lines(effects, motor, trace):
    """Edges that come faster than the limit are lost; rows say how many counts are left."""
    limit = effects["missed_counts"]["max_rate_hz"]
    all_edges = edges(trace, motor)
    lines, j, kept, lost = [], 0, 0, 0
    for k in range(0, SAMPLES, EVERY):
        while j < len(all_edges) and all_edges[j][0] <= k * SAMPLE_TIME_S:
            _, sign, speed = all_edges[j]
            if abs(speed) * motor.counts_per_rev / (2 * pi) > limit:
                lost += 1
            else:
                kept += sign
            j += 1
        lines.append(f"{k},{k * SAMPLE_TIME_S:.14g},{kept},{lost}")
    return "sample,t_s,counts,lost_edges", lines


def missed_lines(effects, motor, trace):
    """Each edge is kept with probability 1 - p: mean (1 - p) n, variance p (1 - p) edges so far."""
    p = effects["missed_counts"]["probability"]
    all_edges = edges(trace, motor)
    lines, j, net = [], 0, 0
    for k in range(0, SAMPLES, EVERY):
        while j < len(all_edges) and all_edges[j][0] <= k * SAMPLE_TIME_S:
            net += all_edges[j][1]
            j += 1
        lines.append(f"{k},{k * SAMPLE_TIME_S:.14g},{(1 - p) * net:.14g},{p * (1 - p) * j:.14g},{net},{j}")
    return "sample,t_s,mean_counts,variance_counts2,counts,edges", lines


def jitter_lines(effects, motor, trace):
    """The instant is uniform in [k TS, k TS + spread]; the counts in between are known, so mean and variance are exact."""
    spread = effects["sample_jitter"]["spread_s"]
    all_edges = edges(trace, motor)
    lines, j, net = [], 0, 0
    for k in range(0, SAMPLES, EVERY):
        t0 = k * SAMPLE_TIME_S
        while j < len(all_edges) and all_edges[j][0] <= t0:
            net += all_edges[j][1]
            j += 1
        mean = square = 0.0
        at, count, m = t0, net, j
        while at < t0 + spread:
            nxt = min(all_edges[m][0], t0 + spread) if m < len(all_edges) else t0 + spread
            share = (nxt - at) / spread
            mean += share * (count - net)
            square += share * (count - net) ** 2
            if nxt < t0 + spread:
                count += all_edges[m][1]
                m += 1
            at = nxt
        lines.append(f"{k},{t0:.14g},{net + mean:.14g},{square - mean * mean:.14g}")
    return "sample,t_s,mean_counts,variance_counts2", lines


def compute(name):
    """(columns, lines, convergence) of a case."""
    kind, effects = CASES[name]
    counting = {"missed_counts": missed_lines, "missed_counts_rate": rate_limited_lines, "sample_jitter": jitter_lines}
    start = time.perf_counter()
    motor, trace = integrate(effects, keep_dense=name in counting)
    elapsed = time.perf_counter() - start
    columns, lines = counting.get(name, trajectory_lines)(effects, motor, trace)
    if name in counting:
        return columns, lines, None
    counts = HANDOUT["counts_per_rev"] / (2 * pi)
    angle = np.array([encoder_angle(motor, x) for x in trace.rows]) * counts

    def against(method, rtol):
        other, t = integrate(effects, method, rtol, rtol * 1e-2)
        return np.abs(np.array([encoder_angle(other, x) for x in t.rows]) * counts - angle).max()

    return columns, lines, (len(trace.events), against("DOP853", 1e-9), against("Radau", 1e-8), elapsed)


def main(arguments):
    here = Path(__file__).parent / "effects"
    here.mkdir(exist_ok=True)
    check = "--check" in arguments
    names = [a for a in arguments if not a.startswith("--")] or list(CASES)
    if not check:
        with open(here / "drive.csv", "w") as f:
            f.write(f"# command in force from sample `sample` on; sample_time_s = {SAMPLE_TIME_S}, samples = {SAMPLES}\n")
            f.write("sample,t_s,command_v\n")
            f.writelines(f"{k},{k * SAMPLE_TIME_S:.14g},{u}\n" for k, u in drive())
        with open(here / "index.csv", "w") as f:
            f.write("file,effects,class\n")
            f.writelines(f"{n}.csv,{'+'.join(fx)},{kind}\n" for n, (kind, fx) in CASES.items())
    print(f"step without Coulomb friction against its closed form: {closed_form_difference():.1e} rad")
    print("| case | events | DOP853 1e-9 | Radau 1e-8 |\n| --- | --- | --- | --- |")
    failed = False
    for name in names:
        kind, effects = CASES[name]
        columns, lines, convergence = compute(name)
        if convergence:
            print("| {} | {} | {:.1e} | {:.1e} |".format(name, *convergence[:3]), f"  {convergence[3]:.1f} s", flush=True)
        if check:
            there = [row for row in open(here / f"{name}.csv").read().splitlines() if not row.startswith("#")][1:]
            worst = max((abs(float(a) - float(b)) for r, s in zip(there, lines) for a, b in zip(r.split(","), s.split(","))), default=9.9)
            if worst > 1e-6 or len(there) != len(lines):
                print(f"{name}: differs from the file by {worst:.1e}")
                failed = True
        else:
            with open(here / f"{name}.csv", "w") as f:
                header(f, name, kind, effects, columns)
                f.writelines(line + "\n" for line in lines)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
