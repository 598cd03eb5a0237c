"""Models of a motor that a script fits by least squares of the position: first order, and the friction models M1 to M6.

A model has names of parameters, signs (a parameter with a sign is fitted as its logarithm) and a function that advances the speed.
Parameters have the shape (candidates, 1), speeds (candidates, segments): all candidates of a Jacobian are simulated at once.
"""
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from segments import STEP_S

# A viscous friction below this share of its first value counts as this: the closed form divides by it.
LEAST_SHARE = 1e-6
# Steps of the Jacobian's differences, for logarithms and shares.
DIFFERENCE = 1e-6
# Relative gain, and step, at which a fit ends.
GAIN = 1e-6


@dataclass
class Model:
    """Parameters as names; `positive` are fitted as logarithms. `motion(p, torque, inertia)` gives a function of angle, speed and drive: the speed
    a step on."""

    name: str
    names: tuple
    positive: tuple
    motion: object
    delay: str | None = None

    def values(self, x):
        """Parameters by name, of vectors of shape (candidates, parameters)."""
        x = np.atleast_2d(x)
        return {name: (np.exp(np.clip(x[:, k], -40, 40)) if name in self.positive else x[:, k])[:, None] for k, name in enumerate(self.names)}

    def simulate(self, x, batch):
        """Angles of every candidate and segment on the grid: shape (candidates, segments, steps + 1)."""
        p = self.values(x)
        count = len(np.atleast_2d(x))
        drive = np.broadcast_to(batch.drive, (count, *batch.drive.shape))
        if self.delay:
            late = np.clip(p[self.delay][:, 0] / STEP_S, 0, batch.past - 1)
            whole = late.astype(int)
            part = (late - whole)[:, None, None]
            steps = np.arange(batch.drive.shape[1])
            earlier = [batch.drive[:, np.maximum(steps - k, 0)] for k in range(whole.max() + 2)]
            drive = (1 - part) * np.array([earlier[k] for k in whole]) + part * np.array([earlier[k + 1] for k in whole])
        drive = np.ascontiguousarray(np.moveaxis(drive, -1, 0)[batch.past :])
        angle = np.tile(batch.angle, (count, 1))
        speed = np.tile(batch.speed, (count, 1))
        out = np.empty((batch.steps + 1, *angle.shape))
        out[0] = angle
        motion = self.motion(p, batch.torque_nm, batch.inertia_kg_m2)
        for n in range(batch.steps):
            now = drive[n] if batch.goal is None else batch.driven(n, angle)
            after = motion(angle, speed, now)
            angle = angle + 0.5 * STEP_S * (speed + after)
            speed = after
            out[n + 1] = angle
        return np.moveaxis(out, 0, -1)

    def errors(self, x, batch):
        return batch.errors(self.simulate(x, batch))

    def fit(self, starts, batch, rough=None):
        """The best of the starts is improved on a rough batch, then on the whole one."""
        def jacobian(x, of):
            shifted = x + DIFFERENCE * np.vstack([np.zeros(len(x)), np.eye(len(x))])
            errors = self.errors(shifted, of)
            return (errors[1:] - errors[0]).T / DIFFERENCE

        def improved(x, of, most):
            return least_squares(lambda x: self.errors(x, of)[0], x, lambda x: jacobian(x, of), method="lm", x_scale=1.0, ftol=GAIN, xtol=GAIN, max_nfev=most).x

        rough = rough or batch
        with np.errstate(over="ignore", invalid="ignore"):
            costs = np.nan_to_num(np.mean(self.errors(starts, rough) ** 2, axis=-1), nan=np.inf)
            best = [improved(starts[k], rough, 40) for k in np.argsort(costs)[:3]]
            left = [np.mean(self.errors(x, batch)[0] ** 2) for x in best]
            return improved(best[int(np.argmin(left))], batch, 60)


def first_order_step(by_direction, loaded):
    """Exact steps. `lag` is the inertia in units of the drive, `viscous` its torque per speed; a load adds `per_torque` times inertia and torque."""

    def motion(p, torque, inertia):
        per = p["per_torque"] if loaded else 0.0
        lag = p["lag"] + per * inertia
        share = np.exp(-STEP_S * p["viscous"] / lag)
        reach = -np.expm1(-STEP_S * p["viscous"] / lag) / p["viscous"]
        up = reach * p["friction_up" if by_direction else "friction"]
        down = reach * p["friction_down" if by_direction else "friction"]
        weight = per * torque

        def after(angle, speed, drive):
            """The speed without friction, brought nearer to 0 by what friction takes, and no further."""
            free = speed * share + reach * (drive - weight * np.sin(angle) if loaded else drive)
            return np.maximum(free - up, 0.0) + np.minimum(free + down, 0.0)

        return after

    return motion


def first_order(loaded=False, by_direction=False, delay=False):
    """First order with Coulomb friction."""
    friction = ("friction_up", "friction_down") if by_direction else ("friction",)
    names = ("lag", "viscous", *friction) + (("per_torque",) if loaded else ()) + (("delay_s",) if delay else ())
    name = "friction by direction" if by_direction else "first order"
    return Model(name + (", with delay" if delay else ""), names, names, first_order_step(by_direction, loaded), "delay_s" if delay else None)


def starts(model, batch):
    """Starts of a first-order model, from the size of drive and speed."""
    speeds = [np.abs(np.diff(n) * r / np.diff(t)) for n, r, t in zip(batch.counts, batch.rad_per_count, batch.times)]
    typical = np.sqrt(np.mean(np.concatenate(speeds) ** 2)) + 1e-9
    drive = np.sqrt(np.mean(batch.drive**2))
    found = []
    for viscous in (0.3, 1.0, 3.0):
        for lag_s in (0.02, 0.1, 0.5):
            for friction in (0.02, 0.2):
                for delay in (0.005, 0.05) if model.delay else (None,):
                    p = {"viscous": viscous * drive / typical, "delay_s": delay, "per_torque": 1.0}
                    p |= dict.fromkeys(("friction", "friction_up", "friction_down"), friction * drive)
                    p["lag"] = lag_s * p["viscous"]
                    found.append([np.log(p[name]) for name in model.names])
    return np.array(found)


# Published friction models of servo actuators (Duclusaud, Passault, Padois, Ly: Extended Friction Models for the Physics Simulation of
# Servo Actuators, 2024): what each adds to `viscous |speed| + coulomb`, the most that friction can resist with.
SERVO_TERMS = {
    "M1": (),
    "M2": ("stribeck", "stribeck_speed", "stribeck_exponent"),
    "M3": ("load",),
    "M4": ("load", "stribeck", "stribeck_load", "stribeck_speed", "stribeck_exponent"),
    "M5": ("motor", "external", "stribeck", "stribeck_motor", "stribeck_external", "stribeck_speed", "stribeck_exponent"),
}
SERVO_TERMS["M6"] = (*SERVO_TERMS["M5"], "motor_squared", "external_squared")
SERVO_STARTS = {
    "load": 0.1, "motor": 0.1, "external": 0.1, "stribeck": 0.02, "stribeck_load": 0.05, "stribeck_motor": 0.05, "stribeck_external": 0.05,
    "stribeck_speed": 0.3, "stribeck_exponent": 1.0, "motor_squared": 0.02, "external_squared": 0.02,
}  # fmt: skip


def servo(which):
    """One of M1 to M6 over a motor with torque constant, resistance and the inertia of its rotor, turning a known pendulum."""
    terms = SERVO_TERMS[which]

    def motion(p, torque, inertia):
        whole = p["rotor_inertia"] + inertia

        def after(angle, speed, drive):
            motor = p["torque_constant"] / p["resistance"] * (drive - p["torque_constant"] * speed)
            # No drive at all: the bridge is off, and no current flows.
            motor = np.where(np.isnan(motor), 0.0, motor)
            external = -torque * np.sin(angle)
            most = p["viscous"] * np.abs(speed) + p["coulomb"]
            if "load" in terms:
                most = most + p["load"] * np.abs(motor - external)
            if "motor" in terms:
                most = most + np.abs(p["motor"] * motor - p["external"] * external)
            if "stribeck" in terms:
                slow = p["stribeck"]
                if "stribeck_load" in terms:
                    slow = slow + p["stribeck_load"] * np.abs(motor - external)
                if "stribeck_motor" in terms:
                    slow = slow + np.abs(p["stribeck_motor"] * motor - p["stribeck_external"] * external)
                if "motor_squared" in terms:
                    weaker = np.abs(motor) > np.abs(external)
                    slow = slow + np.where(weaker, p["external_squared"] * external**2, p["motor_squared"] * motor**2)
                most = most + np.exp(-(np.abs(speed / p["stribeck_speed"]) ** p["stribeck_exponent"])) * slow
            stops = -(whole / STEP_S * speed + motor + external)
            return speed + STEP_S / whole * (motor + external + np.clip(stops, -most, most))

        return after

    names = ("torque_constant", "resistance", "rotor_inertia", "viscous", "coulomb", *terms)
    return Model(which, names, names, motion)


def servo_starts(model, before=None):
    """Starts of a friction model: around the data sheet's motor, or from a fitted simpler model with the new terms small."""
    found = []
    if before:
        known = before
        for scale in (0.01, 0.3, 1.0):
            found.append([np.log(max(known.get(name, SERVO_STARTS.get(name, 0) * (1 if "speed" in name or "exponent" in name else scale)), 1e-12)) for name in model.names])
    for constant in (0.35, 0.5):
        for coulomb in (0.01, 0.1):
            p = {"torque_constant": constant, "resistance": 4.0, "rotor_inertia": 0.002, "viscous": 0.005, "coulomb": coulomb} | SERVO_STARTS
            found.append([np.log(p[name]) for name in model.names])
    return np.array(found)
