@HEADER@
from math import ceil, floor

import torch
from torch import exp, log, sin

try:
    from isaaclab.actuators import ActuatorBase
except ImportError:

    class ActuatorBase:
        """Stands in where Isaac Lab is not installed."""

        def __init__(self, cfg, joint_names, joint_ids, num_envs, device, **_):
            self.cfg, self._joint_names, self._joint_indices = cfg, joint_names, joint_ids
            self._num_envs, self._device = num_envs, device
            self.computed_effort = torch.zeros(num_envs, len(joint_names), device=device)
            self.applied_effort = torch.zeros_like(self.computed_effort)


@CONSTANTS@
# Events located within one inner step; later ones are applied at its end.
MOST_EVENTS = 8
# Iterations that locate an event.
REFINED = 6


def pick(condition, a, b):
    if isinstance(a, float) and isinstance(b, float):
        a = torch.as_tensor(a, dtype=torch.float64, device=condition.device)
    return torch.where(condition, a, b)


def sgn(x):
    return torch.sign(x)


def mag(x):
    return torch.abs(x)


def low(a, b):
    if isinstance(b, float):
        return torch.clamp(a, max=b)
    return torch.clamp(b, max=a) if isinstance(a, float) else torch.minimum(a, b)


def high(a, b):
    if isinstance(b, float):
        return torch.clamp(a, min=b)
    return torch.clamp(b, min=a) if isinstance(a, float) else torch.maximum(a, b)


def command(u):
    return @COMMAND@


@FUNCTIONS@
def runge_kutta(y, m, span_s):
    # One Runge-Kutta step of fourth order within a mode.
    a = rates(y, m)
    b = rates([p + 0.5 * span_s * q for p, q in zip(y, a)], m)
    c = rates([p + 0.5 * span_s * q for p, q in zip(y, b)], m)
    d = rates([p + span_s * q for p, q in zip(y, c)], m)
    return [p + span_s / 6.0 * (e + 2.0 * f + 2.0 * g + h) for p, e, f, g, h in zip(y, a, b, c, d)]


def inner(y, u, load, span_s):
    # One inner step of all motors, each divided at its own events.
    for n in range(1, MOST_EVENTS + 1):
        m = mode(y, u, load)
        before = events(y, m)
        end = runge_kutta(y, m, span_s)
        after = events(end, m)
        k, share, first, last = torch.full_like(u, -1.0), torch.ones_like(u), torch.ones_like(u), -torch.ones_like(u)
        for j, (p, q) in enumerate(zip(before, after)):
            at = pick(p > 0.0, p / pick(p > q, p - q, 1.0), 0.0)
            fires = (q < 0.0) & (q < p) & ((k < 0.0) | (at < share))
            k, share, first, last = pick(fires, float(j), k), pick(fires, at, share), pick(fires, p, first), pick(fires, q, last)
        if not bool((k >= 0.0).any()):
            return snap(end, m, k)
        if n < MOST_EVENTS:
            # False position, or bisection from an event at the start: it lies between early and late.
            early, late = torch.zeros_like(u), torch.ones_like(u)
            for _ in range(REFINED):
                at = early + (late - early) * pick(first > 0.0, first / (high(first, 1e-300) - last), 0.5)
                share = pick(k < 0.0, 1.0, at)
                end = runge_kutta(y, m, share * span_s)
                value = -torch.ones_like(u)
                for j, q in enumerate(events(end, m)):
                    value = pick(k == j, q, value)
                late, last = pick(value <= 0.0, share, late), pick(value <= 0.0, value, last)
                early, first = pick(value >= 0.0, share, early), pick(value >= 0.0, value, first)
        y = snap(end, m, k)
        span_s = span_s * (1.0 - share)
    return y


def hold(y, u, load, span_s):
    # Advances with a voltage held.
    steps = ceil(span_s / INNER_S - 1e-9)
    for _ in range(steps):
        y = inner(y, u, load, span_s / steps)
    return y


class Motor(ActuatorBase):
    """The motor on each joint of a group: control_action.joint_efforts are volts, and become torques (N m).

    The joint's own inertia (armature) is OUTPUT_INERTIA_KG_M2, its friction and damping are 0. The external torque is estimated from how
    the joint's motion differs from the prediction, so that friction can hold it. `step_s` is the physics step in s. Computed in float64.
    """

    step_s = STEP_S

    @property
    def angle_rad(self):
        return self.y[@OUTPUT@]

    @property
    def encoder_angle_rad(self):
        return self.y[@ENCODER@]

    def reset(self, env_ids):
        if getattr(self, "y", None) is not None:
            self.fresh[env_ids] = True

    def compute(self, control_action, joint_pos, joint_vel):
        angle, speed = joint_pos.double(), joint_vel.double()
        volts = control_action.joint_efforts.double()
        at, whole = @OUTPUT@, floor(DELAY_S / self.step_s + 1e-9)
        if getattr(self, "y", None) is None:
            zero = torch.zeros_like(angle)
            self.y = [zero] * @STATE@
            self.load_nm, self.history = zero, [zero] * (whole + 2)
            self.expected, self.fresh = (angle, speed), torch.ones_like(angle, dtype=torch.bool)
        fresh = self.fresh
        y = [pick(fresh, 0.0, value) for value in self.y]
        self.history = [pick(fresh, 0.0, value) for value in self.history[1:]] + [volts]
        kick = speed - self.expected[1]
        y[at], y[at + 1] = y[at] + angle - self.expected[0], y[at + 1] + kick
        for k, value in ((0, angle), (1, speed), (at, angle), (at + 1, speed)):
            y[k] = pick(fresh, value, y[k])
        self.load_nm = pick(fresh, 0.0, self.load_nm + OUTPUT_INERTIA_KG_M2 * kick / self.step_s)
        late_s = DELAY_S - whole * self.step_s
        late_s = late_s if late_s > 1e-9 * self.step_s else 0.0
        y = hold(y, command(self.history[0]), self.load_nm, late_s)
        self.y = list(hold(y, command(self.history[1]), self.load_nm, self.step_s - late_s))
        then = (self.y[at] - angle) / self.step_s
        self.expected, self.fresh = (self.y[at], then), torch.zeros_like(fresh)
        torque = OUTPUT_INERTIA_KG_M2 * (then - speed) / self.step_s - self.load_nm
        self.computed_effort = torque.to(joint_pos.dtype)
        self.applied_effort = self.computed_effort
        control_action.joint_efforts = self.applied_effort
        control_action.joint_positions = control_action.joint_velocities = None
        return control_action
