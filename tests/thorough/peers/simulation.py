"""A thousand motors over the same drive: processor time, and error against event-located integration to tight tolerances."""
import time

import mujoco
import mujoco.rollout
import numpy as np
from scipy.integrate import solve_ivp

import joint
import models
import motors
import page
import segments
import tools
from recordings import run

# Motors, those of them that the slow tools simulate, and the seed of their parameters; s of the drive and between its samples.
MOTORS, FEW, SEED = 1000, 20, 20261129
DURATION_S, SAMPLE_S = 5.0, 3e-3
# V: levels of the drive, held for so many s each.
LEVELS_V, HELD_S = (4.0, -2.0, 0.0, 6.0, 1.0), 0.999
# A motor, and the spread of each parameter as a share.
NOMINAL = {
    "resistance_ohm": 10.0, "back_emf_v_s_per_rad": 0.7, "torque_constant_nm_per_a": 0.7, "viscous_friction_nm_s_per_rad": 0.01,
    "inertia_kg_m2": 0.002, "coulomb_friction_nm": 0.03,
}  # fmt: skip
SPREAD = 0.2


def drawn():
    """Parameters by name, of all motors."""
    random = np.random.default_rng(SEED)
    return {name: value * random.uniform(1 - SPREAD, 1 + SPREAD, MOTORS) for name, value in NOMINAL.items()}


def times():
    return SAMPLE_S * np.arange(round(DURATION_S / SAMPLE_S))


def drive(t):
    return np.take(LEVELS_V, np.minimum((t + 1e-9) // HELD_S, len(LEVELS_V) - 1).astype(int))


def torque(p, u, speed):
    """Of one motor, without Coulomb friction."""
    lost = p["viscous_friction_nm_s_per_rad"] * speed
    return p["torque_constant_nm_per_a"] / p["resistance_ohm"] * (u - p["back_emf_v_s_per_rad"] * speed) - lost


def exact(p):
    """Angles of one motor: each level in pieces from stop to stop, to tolerances of 1e-11."""
    t, friction = times(), p["coulomb_friction_nm"]
    at, state, out = 0.0, np.zeros(2), []
    ends = [HELD_S * (k + 1) for k in range(len(LEVELS_V) - 1)] + [t[-1]]
    for level, end in zip(LEVELS_V, ends):
        while at < end:
            inside = t[(t >= at - 1e-12) & (t < end - 1e-12)]
            sense = np.sign(state[1]) or (np.sign(level) if abs(torque(p, level, 0.0)) > friction else 0.0)
            if sense == 0.0:
                out += [(one, state[0]) for one in inside]
                break

            def slope(_, y):
                return [y[1], (torque(p, level, y[1]) - sense * friction) / p["inertia_kg_m2"]]

            def stops(_, y):
                return sense * y[1] + (1e-12 if state[1] == 0.0 else 0.0)

            stops.terminal, stops.direction = True, -1
            done = solve_ivp(slope, (at, end), state, "DOP853", inside, events=stops, rtol=1e-11, atol=1e-13, dense_output=True)
            last = done.t_events[0][0] if len(done.t_events[0]) else end
            out += [(one, done.sol(one)[0]) for one in inside if one <= last + 1e-12]
            state = np.array([done.sol(last)[0], 0.0 if last < end else done.sol(last)[1]])
            at = last
            if last < end:
                # At rest, until the level changes or at once the other way.
                continue
        at = end
    found = dict(out)
    found[t[-1]] = state[0]
    return np.array([found[one] for one in t])


def by_solve_ivp(p):
    """As a script would: one call a level, default method, friction that opposes or holds."""
    friction = p["coulomb_friction_nm"]

    def slope(_, y, u):
        net = torque(p, u, y[1])
        resists = np.clip(net, -friction, friction) if abs(y[1]) < 1e-3 else np.sign(y[1]) * friction
        return [y[1], (net - resists) / p["inertia_kg_m2"]]

    t = times()
    out, state = np.empty(t.size), np.zeros(2)
    of_level = (t + 1e-9) // HELD_S
    for k, level in enumerate(LEVELS_V):
        inside = np.flatnonzero(np.minimum(of_level, len(LEVELS_V) - 1) == k)
        start, end = HELD_S * k, HELD_S * (k + 1) if k + 1 < len(LEVELS_V) else t[-1] + SAMPLE_S
        done = solve_ivp(slope, (start, end), state, t_eval=np.append(t[inside], end), rtol=1e-6, atol=1e-9, max_step=SAMPLE_S, args=(level,))
        out[inside], state = done.y[0, :-1], done.y[:, -1]
    return out


def in_volts(p):
    """Inertia, viscous and Coulomb friction in V, as the first-order model has them."""
    per = p["resistance_ohm"] / p["torque_constant_nm_per_a"]
    return per * p["inertia_kg_m2"], p["back_emf_v_s_per_rad"] + per * p["viscous_friction_nm_s_per_rad"], per * p["coulomb_friction_nm"]


def one_batch():
    """The drive as a batch of one segment."""
    t = times()
    played = segments.Recording("drive", t, drive(t), np.zeros(t.size), 1.0)
    return segments.batch([played], None, True)


def by_numpy(p, batch):
    x = np.log(np.column_stack(in_volts(p)))
    return models.first_order().simulate(x, batch)[:, 0, :: round(SAMPLE_S / segments.STEP_S)][:, : times().size]


def by_mujoco(p, batch):
    lag, viscous, friction = in_volts(p)
    each = []
    for a, d, f in zip(lag, viscous, friction):
        each.append(joint.spec({"armature": a, "damping": d, "friction": f, "gain": 1.0}, 0.0, 0.0).compile())
    states = np.tile(mujoco_state(each[0]), (len(each), 1))
    control = np.repeat(batch.drive[:, batch.past :, None], len(each), axis=0)
    state, _ = mujoco.rollout.rollout(each, [mujoco.MjData(each[0])], states, control)
    angles = np.concatenate([np.zeros((len(each), 1)), state[:, :, 1]], axis=1)
    return angles[:, :: round(SAMPLE_S / segments.STEP_S)][:, : times().size]


def mujoco_state(model):
    data = mujoco.MjData(model)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state


def motor_file(p):
    return "".join(f"{name} = {float(value)!r}\n" for name, value in p.items()) + "inductance_h = 0.0\ncounts_per_rev = 720\nsupply_v = 12.0\n"


def by_program(program, p, work):
    """One motor, one process: the program simulates and writes the run; counts are what it writes of the angle."""
    (work / "one.toml").write_text(motor_file(p))
    words = ["simulate", "--motor", "one.toml", "--profile", "drive.csv", "--ts", str(SAMPLE_S), "--duration", str(DURATION_S), "-o", "one.csv", "--force", "--threads", "1"]
    run(program, *words, work=work)


def by_export(program, p, file, batch):
    """One motor as the C function that the program writes of it."""
    file.write_text(motor_file(p))
    motor = motors.Motor(program, file, file.parent, "v")
    motor.library(0.0)
    begun = time.process_time()
    angles = motor.simulate(batch)[0]
    return angles[:: round(SAMPLE_S / segments.STEP_S)][: times().size], time.process_time() - begun


def part(program, _, work):
    p, t, batch = drawn(), times(), one_batch()
    few = [{name: float(values[k]) for name, values in p.items()} for k in range(FEW)]
    of_few = {name: values[:FEW] for name, values in p.items()}
    reference = np.array([exact(one) for one in few])
    rows = []

    def timed(name, how, count, function):
        with tools.Clock() as clock:
            angles = function()
        off = None if angles is None else 1e3 * float(np.max(np.abs(np.asarray(angles)[:FEW] - reference)))
        rows.append((name, how, count, clock.cpu_s, off))

    timed("solve_ivp", "RK45, tolerance 1e-6, steps of at most 3 ms", FEW, lambda: np.array([by_solve_ivp(one) for one in few]))
    timed("NumPy, in one batch", "exact steps of 1 ms, all motors at once", MOTORS, lambda: by_numpy(p, batch))
    timed("MuJoCo", "an actuated hinge, steps of 1 ms, `rollout`, one thread", MOTORS, lambda: by_mujoco(p, batch))
    np.savetxt(work / "drive.csv", np.column_stack([t, drive(t)]), delimiter=",", header="t_s,command_v", comments="")
    timed("motorlab, the program", "a process and a run file a motor", FEW, lambda: [by_program(program, one, work) for one in few] and None)
    with_export = [by_export(program, one, work / f"motor{k}.toml", batch) for k, one in enumerate(few)]
    off = 1e3 * float(np.max(np.abs(np.array([angles for angles, _ in with_export]) - reference)))
    rows.append(("motorlab, exported C", "steps of 1 ms; export and compiler not counted", FEW, sum(spent for _, spent in with_export), off))
    try:
        import motorlab as ml
    except ImportError:
        missing = ["", "motorlab's Python package is not installed in the environment (`run --wheel FILE`), so it is not in the table."]
    else:
        missing = []
        base = ml.Motor(inductance_h=0.0)
        call = lambda one: ml.simulate(one, t_s=t, command=drive(t), base=base, output="angle_rad")  # noqa: E731
        timed("motorlab, from Python", "one call for all motors, a sample a row", MOTORS, lambda: call(p))
    text = [
        "## simulation", "",
        f"{MOTORS:,} motors with parameters drawn within {100 * SPREAD:.0f} %, first order with Coulomb friction, {DURATION_S:.0f} s of five voltage levels,",
        f"a sample every 3 ms. Slow tools simulate {FEW} of them. The error is the largest of the angle over {FEW} motors, against integration from stop to",
        "stop to tolerances of 1e-11 (DOP853 with events). Processor time is of one run, with everything a call does.",
        "From Rust the same call for 1,000 motors reaches 87 million samples per second of processor time, 0.019 ms for 5 s of a motor; from Python 60 million ([the simulation](../method/simulation.md)).", "",
        "| tool | how | motors | processor time (s) | per motor (ms) | largest error (mrad) |", "| --- | --- | --- | --- | --- | --- |",
    ]  # fmt: skip
    for name, how, count, cpu_s, off in rows:
        text.append(f"| {name} | {how} | {count:,} | {page.figure(cpu_s)} | {page.figure(1e3 * cpu_s / count)} | {'counts only' if off is None else page.figure(off)} |")
    text += missing + ["", "![simulation: processor time a motor](simulation.svg)"]
    bars = [(name, 1e3 * cpu_s / count) for name, _, count, cpu_s, _ in rows]
    return "\n".join(text), page.picture("Processor time to simulate 5 s of a motor", bars, "ms", [])
