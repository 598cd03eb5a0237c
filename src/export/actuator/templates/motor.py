@HEADER@
from math import ceil, exp, floor, log, sin

@CONSTANTS@
# Events located within one inner step; later ones are applied at its end.
MOST_EVENTS = 8
# Iterations that locate an event.
REFINED = 6


def pick(condition, a, b):
    return a if condition else b


def sgn(x):
    return float(x > 0.0) - float(x < 0.0)


def mag(x):
    return abs(x)


def low(a, b):
    return min(a, b)


def high(a, b):
    return max(a, b)


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
    # One inner step, divided at events.
    for n in range(1, MOST_EVENTS + 1):
        m = mode(y, u, load)
        before = events(y, m)
        end = runge_kutta(y, m, span_s)
        after = events(end, m)
        k, share = -1, 1.0
        for j, (p, q) in enumerate(zip(before, after)):
            if q < 0.0 and q < p:
                at = p / (p - q) if p > 0.0 else 0.0
                if k < 0 or at < share:
                    k, share = j, at
        if k >= 0 and n < MOST_EVENTS:
            # False position, or bisection from an event at the start: it lies between early and late.
            (early, first), (late, last) = (0.0, before[k]), (1.0, after[k])
            for _ in range(REFINED):
                share = early + (late - early) * (first / (first - last) if first > 0.0 else 0.5)
                end = runge_kutta(y, m, share * span_s)
                value = events(end, m)[k]
                if value <= 0.0:
                    late, last = share, value
                if value >= 0.0:
                    early, first = share, value
        y = snap(end, m, k)
        if k < 0:
            break
        span_s *= 1.0 - share
    return y


def hold(y, u, load, span_s):
    # Advances with a voltage held.
    steps = ceil(span_s / INNER_S - 1e-9)
    for _ in range(steps):
        y = inner(y, u, load, span_s / steps)
    return y


class State:
    """y has @NAMES@; load_nm is the external torque on the output shaft, an input."""

    def __init__(self, step_s=STEP_S):
        self.y = (0.0,) * @STATE@
        self.load_nm = 0.0
        self.step_s = step_s
        self.late_s = DELAY_S - floor(DELAY_S / step_s + 1e-9) * step_s
        self.history = [0.0] * (floor(DELAY_S / step_s + 1e-9) + 2)
        self.expected = None

    def copy(self):
        other = State(self.step_s)
        other.y, other.load_nm, other.expected = self.y, self.load_nm, self.expected
        other.history = list(self.history)
        return other

    @property
    def angle_rad(self):
        return self.y[@OUTPUT@]

    @property
    def speed_rad_s(self):
        return self.y[@OUTPUT@ + 1]

    @property
    def encoder_angle_rad(self):
        return self.y[@ENCODER@]


def step(state, voltage):
    """Holds a voltage (V) for state.step_s and returns the mean torque (N m) on the output shaft, whose inertia is OUTPUT_INERTIA_KG_M2."""
    before = state.speed_rad_s
    state.history = state.history[1:] + [voltage]
    late_s = state.late_s if state.late_s > 1e-9 * state.step_s else 0.0
    state.y = hold(state.y, command(state.history[0]), state.load_nm, late_s)
    state.y = hold(state.y, command(state.history[1]), state.load_nm, state.step_s - late_s)
    return OUTPUT_INERTIA_KG_M2 * (state.speed_rad_s - before) / state.step_s - state.load_nm


def joint_torque(state, voltage, angle_rad, speed_rad_s):
    """The torque (N m) to apply to a rigid-body simulator's joint over its next step of state.step_s.

    The joint's own inertia is OUTPUT_INERTIA_KG_M2. The external torque is estimated from how the joint's motion differs from the
    prediction, so that friction can hold it. The simulator's step is semi-implicit: speed += dt torque / inertia, angle += dt speed.
    """
    y, at = list(state.y), @OUTPUT@
    if state.expected is None:
        y[0], y[1], y[at], y[at + 1] = angle_rad, speed_rad_s, angle_rad, speed_rad_s
    else:
        kick = speed_rad_s - state.expected[1]
        y[at] += angle_rad - state.expected[0]
        y[at + 1] += kick
        state.load_nm += OUTPUT_INERTIA_KG_M2 * kick / state.step_s
    state.y = y
    step(state, voltage)
    then = (state.angle_rad - angle_rad) / state.step_s
    state.expected = (state.angle_rad, then)
    return OUTPUT_INERTIA_KG_M2 * (then - speed_rad_s) / state.step_s - state.load_nm
