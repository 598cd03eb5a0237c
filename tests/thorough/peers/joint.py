"""MuJoCo's system identification: a hinge with armature, damping and friction loss, fitted to the same segments."""
import contextlib
import io

import mujoco
import mujoco.rollout
import numpy as np
from mujoco import sysid

from segments import STEP_S

HINGE = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast"><flag contact="disable"/></option>
  <worldbody><body>
    <joint name="shaft" type="hinge" axis="0 1 0" armature="{armature}" damping="{damping}" frictionloss="{friction}"/>
    <geom type="sphere" size="0.01" pos="0 0 -{arm}" mass="{mass}"/>
  </body></worldbody>
  <actuator><general name="motor" joint="shaft" gainprm="{gain}"/></actuator>
  <sensor><jointpos name="angle" joint="shaft"/></sensor>
</mujoco>"""
# Bounds of a parameter, as shares of its start.
LEAST, MOST = 0.01, 10.0
# m/s2, and kg: MuJoCo's gravity, and a mass that does not matter where no load is known.
GRAVITY, NO_MASS = 9.81, 1e-9


def spec(p, torque_nm, inertia_kg_m2):
    """A hinge whose drive is the command; the known load is a point mass: its arm follows from torque and inertia."""
    arm = GRAVITY * inertia_kg_m2 / torque_nm if torque_nm else 0.0
    mass = torque_nm / (GRAVITY * arm) if torque_nm else NO_MASS
    return mujoco.MjSpec.from_string(HINGE.format(step=STEP_S, arm=arm, mass=mass, **p))


def modifiers(gain):
    """How each parameter changes the model."""
    def damping(s, p):
        s.joint("shaft").damping = np.resize([p.value[0], 0.0, 0.0], np.shape(s.joint("shaft").damping)) if np.ndim(s.joint("shaft").damping) else p.value[0]

    def armature(s, p):
        s.joint("shaft").armature = p.value[0]

    def friction(s, p):
        s.joint("shaft").frictionloss = p.value[0]

    def gained(s, p):
        s.actuator("motor").gainprm[0] = p.value[0]

    found = {"armature": armature, "damping": damping, "friction": friction}
    return found | ({"gain": gained} if gain else {})


def models(p, batch):
    """A model per segment: its known load may be another."""
    made = {}
    for key in zip(batch.torque_nm, batch.inertia_kg_m2):
        if key not in made:
            made[key] = spec(p, *key).compile()
    return [made[key] for key in zip(batch.torque_nm, batch.inertia_kg_m2)]


def simulate(p, batch):
    """Angles on the grid: shape (segments, steps + 1)."""
    each = models(p, batch)
    if batch.goal is not None:
        return closed_loop(each, batch)
    states = np.array([sysid.create_initial_state(m, np.array([a]), np.array([v]), np.array([])) for m, a, v in zip(each, batch.angle, batch.speed)])
    drive = np.ascontiguousarray(batch.drive[:, batch.past :, None])
    state, _ = mujoco.rollout.rollout(each, [mujoco.MjData(each[0])], states, drive)
    return np.concatenate([batch.angle[:, None], state[:, :, 1]], axis=1)


def closed_loop(each, batch):
    """Step by step, with the servo's law."""
    datas = [mujoco.MjData(model) for model in each]
    for data, angle, speed in zip(datas, batch.angle, batch.speed):
        data.qpos[0], data.qvel[0] = angle, speed
    out = [batch.angle]
    for n in range(batch.steps):
        drive = batch.driven(n, out[-1])
        for model, data, u in zip(each, datas, drive):
            data.ctrl[0] = u
            mujoco.mj_step(model, data)
        out.append(np.array([data.qpos[0] for data in datas]))
    return np.array(out).T


def fit(batch, starts, gain):
    """The parameters that leave least of the position; `gain` is the torque per unit of the drive, free where a known load tells it."""
    # Its own optimizer, which is the default, and SciPy's behind it: from some starts the first stalls.
    found = [improved(batch, start, gain, optimizer) for start in starts for optimizer in ("mujoco", "scipy")]
    return min(found, key=lambda one: one[0])[1]


def improved(batch, start, gain, optimizer):
    """The squared error that is left, and the parameters."""
    parameters = sysid.ParameterDict()
    for name, modifier in modifiers(gain).items():
        value = start[name]
        parameters.add(sysid.Parameter(name, nominal=value, min_value=value * LEAST, max_value=value * MOST, modifier=modifier))
    sequences = []
    for k, name in enumerate(batch.names):
        of_load = spec(start, batch.torque_nm[k], batch.inertia_kg_m2[k])
        model = of_load.compile()
        grid = STEP_S * np.arange(batch.steps)
        control = sysid.TimeSeries.from_control_names(grid, batch.drive[k, batch.past :, None], model)
        measured = sysid.TimeSeries.from_names(batch.times[k], batch.counts[k][:, None] * batch.rad_per_count[k], model)
        state = sysid.create_initial_state(model, np.array([batch.angle[k]]), np.array([batch.speed[k]]), np.array([]))
        sequences.append(sysid.ModelSequences(f"{name} {k}", of_load, f"{name} {k}", state, control, measured))

    def residual(parameters, predicted, measured, model, return_all, state=None, **rest):
        at = np.interp(measured.times[batch.first :], state[:, 0], state[:, 1])
        return (at - measured.data[batch.first :, 0])[:, None], predicted, predicted

    function = sysid.build_residual_fn(models_sequences=sequences, modify_residual=residual, n_threads=1)
    with contextlib.redirect_stdout(io.StringIO()):
        fitted, _ = sysid.optimize(initial_params=parameters, residual_fn=function, optimizer=optimizer, verbose=False, max_iters=100)
    cost = sum(float(np.sum(np.square(one))) for one in function(fitted.as_vector(), fitted)[0])
    return cost, start | {name: float(fitted[name].value[0]) for name in modifiers(gain)}
