

class Actuator:
    """The bias of MuJoCo's user actuator: the motor's torque on its joint, with data.ctrl in V."""

    def __init__(self, model, name):
        self.number = model.actuator(name).id
        joint = model.actuator_trnid[self.number, 0]
        self.angle, self.speed = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        self.model, self.time = model, None

    def torque(self, data):
        # MuJoCo may call several times at one time: each call starts from the state at that time.
        if self.time is None or data.time < self.time:
            self.state = State(self.model.opt.timestep)
        if self.time != data.time:
            self.before, self.time = self.state, data.time
        self.state = self.before.copy()
        numbers = data.ctrl[self.number], data.qpos[self.angle], data.qvel[self.speed]
        return joint_torque(self.state, *map(float, numbers))


def install(model, names=("voltage",)):
    """Makes MuJoCo call the motor for these actuators of a model; integrators Euler, implicit, implicitfast.

    One simulation at a time. MuJoCo loads no other model while a callback is set: remove() first.
    """
    import mujoco

    actuators = {one.number: one for one in (Actuator(model, name) for name in names)}
    mujoco.set_mjcb_act_bias(lambda _, data, number: actuators[number].torque(data) if number in actuators else 0.0)
    return actuators


def remove():
    """Takes the callback away."""
    import mujoco

    mujoco.set_mjcb_act_bias(None)
