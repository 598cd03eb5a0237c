"""A hybrid automaton of the motor with every effect of the signal chain's driver, winding, friction and transmission.

Continuous state x = (theta1, w1, theta2, w2, i, P, F, n, q):
    theta1, w1   motor side (of a rigid motor: the shaft), rad and rad/s
    theta2, w2   load side, of a motor with backlash or compliance
    i, P, F      current (A), filtered copper loss (W), presliding friction torque (N m)
    n, q         counts kept by an encoder that loses a share of its edges, counts of a log of a filtered speed

Discrete state (Mode): what the driver's current does, which side slips which way or sticks, and who touches whom.
A mode's equations are smooth. Its guards are functions of the state that are positive as long as the mode holds; the
instant at which one falls through zero is located on the integrator's dense output, the step is integrated again up to
it, and the instant is polished by Newton's rule. `settle` then picks the mode that follows.

The equations and the laws of sticking, blocking and contact are written out in README.md.
"""

from dataclasses import dataclass, field
from math import copysign, exp, log, pi, sin

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

HANDOUT = dict(
    resistance_ohm=10.0, back_emf_v_s_per_rad=0.7, torque_constant_nm_per_a=0.7, viscous_friction_nm_s_per_rad=0.01,
    inductance_h=0.004, inertia_kg_m2=0.002, coulomb_friction_nm=0.02, counts_per_rev=720.0, supply_v=4.5,
)
TH1, W1, TH2, W2, CUR, HEAT, DAHL, KEPT, LAG = range(9)
METHODS = {"DOP853": DOP853, "Radau": Radau}


@dataclass
class Mode:
    current: str = "flow"      # flow, blocked (inside the drop), limited, open (coasting)
    current_sign: int = 0      # sign of i in `flow` with a drop, and in `limited`
    torque_sign: int = 1       # sign of tau_m, where friction depends on it
    slip1: int = 0             # -1, 0 (stuck), +1
    slip2: int = 0
    contact: int | None = None  # None: no lash; 0: free; +1 / -1: the motor side touches the upper / lower flank
    clutch: int | None = None   # None: no clutch; 0: it holds; +1 / -1: the motor side slips ahead / back


class Motor:
    def __init__(self, effects=None, parameters=None):
        fx = effects or {}
        p = dict(HANDOUT, **(parameters or {}))
        get = lambda effect, key, default=0.0: fx[effect][key] if effect in fx else default
        self.effects = fx
        self.R = p["resistance_ohm"]
        self.Kb = p["back_emf_v_s_per_rad"]
        self.Kt = p["torque_constant_nm_per_a"]
        self.supply = p["supply_v"]
        self.counts_per_rev = p["counts_per_rev"]
        self.L = get("inductance", "inductance_h", p["inductance_h"])
        b = get("viscous_friction", "coefficient_nm_s_per_rad", p["viscous_friction_nm_s_per_rad"])
        J = get("inertia", "inertia_kg_m2", p["inertia_kg_m2"])
        self.Tf = get("coulomb_friction", "torque_nm", p["coulomb_friction_nm"])
        self.dead = get("dead_zone", "threshold_v", -1.0)
        self.gain = get("supply_error", "gain", 1.0)
        self.zones = [get("asymmetric_dead_zone", key, -1.0) for key in ("positive_v", "negative_v")]
        both = get("voltage_drop", "drop_v")
        self.drops = {1: both + get("asymmetric_voltage_drop", "positive_v"),
                      -1: both + get("asymmetric_voltage_drop", "negative_v"), 0: 0.0}
        self.drops_at_all = max(self.drops.values()) > 0.0
        self.direction_gain = get("asymmetric_gain", "ratio")
        self.source = get("supply_sag", "source_resistance_ohm")
        self.limit = get("current_limit", "limit_a", None)
        self.coast = "coast_at_zero" in fx
        self.heat_rise = get("winding_heating", "resistance_rise_per_w")
        self.heat_tau = get("winding_heating", "time_constant_s", get("magnet_weakening", "time_constant_s", None))
        self.magnet_drop = get("magnet_weakening", "drop")
        self.ripples = [[get(name, k) for k in ("amplitude", "cycles_per_rev", "phase_rad")]
                        for name in ("torque_ripple", "torque_ripple#2")]
        self.extra = get("stribeck", "extra_torque_nm")
        self.stribeck_speed = get("stribeck", "stribeck_speed_rad_s", 1.0)
        self.asymmetry = get("asymmetric_friction", "ratio")
        self.viscous_asymmetry = get("asymmetric_viscous", "ratio")
        self.static = get("static_friction", "torque_nm", self.Tf)
        self.constant_load = get("constant_load", "torque_nm")
        self.edge_rate = get("edge_rate_loss", "rate_hz", None)
        self.edge_exponent = get("edge_rate_loss", "exponent")
        self.filter_tau = get("speed_filter", "time_constant_s", None)
        self.sensor_counts_per_rev = get("resolution_error", "counts_per_rev", self.counts_per_rev)
        self.presliding = get("presliding", "break_in_angle_rad", None)
        self.driving = get("load_friction", "driving_fraction")
        self.driven = get("load_friction", "driven_fraction")
        self.load_friction = "load_friction" in fx
        self.drag = get("quadratic_drag", "coefficient_nm_s2_per_rad2")
        self.gravity = [get("gravity_load", k) for k in ("torque_nm", "phase_rad")]
        self.coggings = [[get(name, k) for k in ("torque_nm", "cycles_per_rev", "phase_rad")]
                         for name in ("cogging", "cogging#2")]
        self.pwm = get("pwm_freewheel", "period_ratio", None)
        self.pwm_into_supply = get("pwm_freewheel", "into_supply") >= 0.5
        self.coast = self.coast or self.pwm is not None
        self.lash = get("backlash", "gap_rad", None)
        self.compliant = "compliance" in fx
        # A clutch beside a gap or a spring carries everything.
        alone = self.lash is None and not self.compliant
        self.grip = get("slipping_clutch", "torque_nm", None) if alone else None
        self.two = self.lash is not None or self.compliant or self.grip is not None
        self.sprung = self.lash is not None and self.compliant   # a gap in series with the spring: flanks never weld
        self.frictionless = not (self.two or self.Tf or self.extra or self.load_friction or self.static or self.viscous_asymmetry)
        bodies = fx.get("compliance") or fx.get("backlash") or {}
        share = bodies.get("load_fraction", get("slipping_clutch", "load_share") if self.grip is not None else 0.0)
        self.encoder_side = bodies.get("encoder_side", 0)
        self.J1, self.J2, self.J = (1.0 - share) * J, share * J, J
        # Friction per inertia at the load over that at the motor.
        rubs = bodies.get("load_friction_weight", 1.0) * share
        self.share1, self.share2 = (1.0 - share) / (1.0 - share + rubs), rubs / (1.0 - share + rubs)
        self.b1, self.b2 = self.share1 * b, self.share2 * b
        self.k = self.c = 0.0
        if self.compliant:
            reduced = self.J1 * self.J2 / J
            rate = 2 * pi * fx["compliance"]["frequency_hz"]
            self.k, self.c = rate**2 * reduced, 2 * fx["compliance"]["damping_ratio"] * rate * reduced
        self.command = 0.0     # what reaches the driver, after delay and dead zone
        self.mode = Mode(contact=0 if self.lash is not None else None, clutch=0 if self.grip is not None else None)

    # ---- the chain's pieces ---------------------------------------------------------------------------------------
    def driver_command(self, u):
        forward, back = self.zones
        if abs(u) <= self.dead or 0.0 <= u <= forward or -back <= u <= 0.0:
            return 0.0
        return u

    def emf_gain(self, x):
        warm = 1.0 - self.magnet_drop * x[HEAT] * self.R / self.supply**2
        return warm * (1.0 + sum(A * sin(N * x[TH1] + phase) for A, N, phase in self.ripples if A))

    def resistance(self, x):
        duty = abs(self.command) / self.supply
        return self.R * (1.0 + self.heat_rise * x[HEAT]) + duty * duty * self.source

    def excess(self, x):
        """e = v - Kb w: what drives the current, before the driver's drop."""
        u = self.command
        volts = self.gain * (u + self.direction_gain * abs(u))
        emf = self.Kb * self.emf_gain(x) * x[W1]
        return volts - emf if self.pwm is None or u == 0.0 else self.freewheeling(volts, emf)

    def freewheeling(self, volts, emf):
        """R times the mean current of one period of the pulses, by looking at where it runs dry: R = L = 1, time in L / R."""
        way = copysign(1.0, self.command)
        duty = min(abs(self.command) / self.supply, 1.0)
        on, against = volts * way / duty, emf * way
        target = on - against
        if target <= 0.0 or duty >= 1.0:
            return way * target              # diodes conduct all the time, or no pulses
        resting = (-on if self.pwm_into_supply else 0.0) - against
        t_on, t_off = duty * self.pwm, (1.0 - duty) * self.pwm
        # The current at the start of a pulse, if it never ran dry: a fixed point of the period's linear map.
        fade_on, fade_off = exp(-t_on), exp(-t_off)
        least = (resting * (1.0 - fade_off) + target * (1.0 - fade_on) * fade_off) / (1.0 - fade_on * fade_off)
        if least >= 0.0:
            return way * (duty * on + (1.0 - duty) * (resting + against) - against)
        most = target * (1.0 - fade_on)
        dry = log(1.0 - most / resting)
        return way * (target * t_on + resting * dry) / self.pwm

    def motor_torque(self, x):
        return self.Kt * self.emf_gain(x) * x[CUR]

    def torques(self, x):
        """Net torque on the motor side and on the load side, all but friction, viscous friction and flanks."""
        n1 = self.motor_torque(x) + sum(A * sin(N * x[TH1] + phase) for A, N, phase in self.coggings if A)
        side_angle, side_speed = (x[TH2], x[W2]) if self.two else (x[TH1], x[W1])
        G, phase = self.gravity
        n2 = -(G * sin(side_angle + phase) if G else 0.0) - self.drag * side_speed * abs(side_speed) - self.constant_load
        if self.compliant and self.mode.contact != 0:
            spring = self.spring_torque(x, self.mode.contact or 0)
            return n1 - spring, n2 + spring
        if self.mode.clutch:
            carried = self.mode.clutch * self.grip
            return n1 - carried, n2 + carried
        return n1, n2

    @property
    def joined(self):
        """Both sides move as one."""
        return bool(self.mode.contact and not self.sprung) or self.mode.clutch == 0

    def spring_torque(self, x, flank):
        """Spring and damper, of a transmission with a gap at the upper (+1) or lower (-1) flank."""
        free = flank * self.lash / 2 if self.sprung else 0.0
        return self.k * (x[TH1] - x[TH2] - free) + self.c * (x[W1] - x[W2])

    def friction(self, direction, speed, torque, at_rest=False):
        """Coulomb level of the whole motor against motion in `direction`."""
        level = (max(self.Tf, self.static) if at_rest else self.Tf) * (1.0 + self.asymmetry * direction)
        if self.extra:
            level += self.extra * (1.0 if at_rest else exp(-((speed / self.stribeck_speed) ** 2)))
        if self.load_friction:
            torque_sign = (1 if torque > 0 else -1 if torque < 0 else 0) if at_rest else self.mode.torque_sign
            share = self.driving if direction * torque_sign >= 0 else self.driven
            level += (max(share, self.driving) if at_rest else share) * abs(torque)
        return level

    # ---- the equations of the mode in force -----------------------------------------------------------------------
    def rhs(self, _t, x):
        m = self.mode
        d = [0.0] * 9
        b1, b2 = (b * (1.0 + self.viscous_asymmetry * slip) for b, slip in ((self.b1, m.slip1), (self.b2, m.slip2)))
        self.read(x, d)
        flow = 0.0
        if m.current == "flow":
            flow = (self.excess(x) - m.current_sign * self.drops[m.current_sign] - self.resistance(x) * x[CUR]) / self.L
        d[CUR] = flow
        if self.heat_tau:
            d[HEAT] = (x[CUR] ** 2 * self.R - x[HEAT]) / self.heat_tau
        torque = self.motor_torque(x) if self.load_friction else 0.0
        n1, n2 = self.torques(x)
        w = x[W1]
        if not self.two:
            d[TH1] = w
            if self.presliding is not None:
                d[W1] = (n1 + n2 - b1 * w - x[DAHL]) / self.J1
                d[DAHL] = self.Tf / self.presliding * (w - m.slip1 * w * x[DAHL] / self.friction(m.slip1, w, torque))
            elif m.slip1:
                d[W1] = (n1 + n2 - b1 * w - m.slip1 * self.friction(m.slip1, w, torque)) / self.J1
            else:
                d[TH1] = 0.0
        elif self.joined:
            if m.slip1:
                d[TH1] = d[TH2] = w
                d[W1] = d[W2] = self.joint_acceleration(x)
        else:
            if m.slip1:
                d[TH1] = w
                d[W1] = (n1 - b1 * w - m.slip1 * self.share1 * self.friction(m.slip1, w, torque)) / self.J1
            if m.slip2:
                w = x[W2]
                d[TH2] = w
                d[W2] = (n2 - b2 * w - m.slip2 * self.share2 * self.friction(m.slip2, w, torque)) / self.J2
        return d

    def read(self, x, d):
        """The encoder: counts kept, and the lag of a log of a filtered speed."""
        angle, speed = (x[TH2], x[W2]) if self.two and self.encoder_side == 1 else (x[TH1], x[W1])
        per_rad = self.sensor_counts_per_rev / (2 * pi)
        counts = per_rad * angle
        if self.edge_rate is not None:
            ratio = abs(speed) * per_rad / self.edge_rate
            d[KEPT] = per_rad * speed / (1.0 + ratio**self.edge_exponent)
            counts = x[KEPT]
        if self.filter_tau is not None:
            d[LAG] = (counts - x[LAG]) / self.filter_tau

    def joint_acceleration(self, x):
        n1, n2 = self.torques(x)
        m, w = self.mode, x[W1]
        both = (self.b1 + self.b2) * (1.0 + self.viscous_asymmetry * m.slip1)
        return (n1 + n2 - both * w - m.slip1 * self.friction(m.slip1, w, self.motor_torque(x))) / self.J

    def flank_torque(self, x):
        """Torque by which the motor side pushes the load while both move as one."""
        _, n2 = self.torques(x)
        m, w = self.mode, x[W1]
        level = self.share2 * self.friction(m.slip1, w, self.motor_torque(x))
        return self.J2 * self.joint_acceleration(x) + self.b2 * (1.0 + self.viscous_asymmetry * m.slip1) * w + m.slip1 * level - n2

    def levels(self, x, share):
        torque = self.motor_torque(x)
        return [share * self.friction(s, 0.0, torque, at_rest=True) for s in (1, -1)]

    def stuck_flank_range(self, x):
        """The flank torques that keep both sides stuck while they touch: ((lowest, why), (highest, why))."""
        n1, n2 = self.torques(x)
        up1, down1 = self.levels(x, self.share1)
        up2, down2 = self.levels(x, self.share2)
        low = [(n1 - up1, "motor"), (-down2 - n2, "load")]
        high = [(n1 + down1, "motor"), (up2 - n2, "load")]
        if self.mode.clutch == 0:
            low.append((-self.grip, "flank"))
            high.append((self.grip, "flank"))
        else:
            (low if self.mode.contact > 0 else high).append((0.0, "flank"))
        return max(low), min(high)

    # ---- guards: positive while the mode holds --------------------------------------------------------------------
    def guards(self, x):
        m = self.mode
        g = {}
        if m.current == "flow":
            if m.current_sign:
                g["current zero"] = m.current_sign * x[CUR]
            if self.limit is not None:
                g["limit"] = self.limit - abs(x[CUR])
        elif m.current == "blocked":
            e = self.excess(x)
            g["unblock"] = min(self.drops[1] - e, self.drops[-1] + e)
        elif m.current == "limited":
            pull = self.excess(x) - m.current_sign * (self.drops[m.current_sign] + self.resistance(x) * self.limit)
            g["unlimit"] = m.current_sign * pull
        if self.load_friction and m.current == "flow" and (m.slip1 or m.slip2):
            g["torque zero"] = m.torque_sign * x[CUR]
        if self.presliding is not None:
            g["reverse"] = m.slip1 * x[W1]
            return g
        if not self.two:
            if self.frictionless:
                return g
            if m.slip1:
                g["stop1"] = m.slip1 * x[W1]
            else:
                n1, n2 = self.torques(x)
                up, down = self.levels(x, 1.0)
                g["break1"] = min(up - (n1 + n2), down + (n1 + n2))
            return g
        if self.joined:
            if m.slip1:
                g["stop joint"] = m.slip1 * x[W1]
                if m.clutch is None:
                    g["part"] = m.contact * self.flank_torque(x)
                else:
                    g["give"] = self.grip - abs(self.flank_torque(x))
            else:
                (low, _), (high, _) = self.stuck_flank_range(x)
                g["break joint"] = high - low
            return g
        if self.sprung and m.contact:
            g["part"] = m.contact * self.spring_torque(x, m.contact)
        elif self.lash is not None:
            gap = x[TH1] - x[TH2]
            g["touch +"] = self.lash / 2 - gap
            g["touch -"] = self.lash / 2 + gap
            if self.sprung:   # beyond the flank, but parting: the spring touches when it would push
                g["touch +"] = max(g["touch +"], -self.spring_torque(x, 1))
                g["touch -"] = max(g["touch -"], self.spring_torque(x, -1))
        if m.clutch:
            g["grip"] = m.clutch * (x[W1] - x[W2])
        n1, n2 = self.torques(x)
        for name, slip, speed, net, share in (("1", m.slip1, x[W1], n1, self.share1), ("2", m.slip2, x[W2], n2, self.share2)):
            if slip:
                g["stop" + name] = slip * speed
            else:
                up, down = self.levels(x, share)
                g["break" + name] = min(up - net, down + net)
        return g

    # ---- transitions ----------------------------------------------------------------------------------------------
    def settle(self, x, fired=None):
        """Changes `x` and the mode after guard `fired`, or after a change of the command (None)."""
        m = self.mode
        self.settle_current(x, fired)
        if fired == "torque zero":
            m.torque_sign = -m.torque_sign
        else:
            m.torque_sign = int(copysign(1, x[CUR] if x[CUR] != 0.0 else self.excess(x)))
        if self.presliding is not None:
            if fired == "reverse":
                m.slip1, x[W1] = -m.slip1, 0.0
            elif x[W1] == 0.0:
                n1, n2 = self.torques(x)
                net = n1 + n2 - x[DAHL]
                m.slip1 = int(copysign(1, net if net != 0.0 else self.excess(x)))
            return
        if not self.two:
            if self.frictionless:
                m.slip1 = 1
                return
            if fired == "stop1":
                x[W1] = 0.0
            n1, n2 = self.torques(x)
            m.slip1 = self.slip_after(x, m.slip1 if fired == "break1" else None, x[W1], n1 + n2, 1.0, m.slip1)
            return
        if self.sprung:
            if fired in ("touch +", "touch -", "part"):
                m.contact = {"touch +": 1, "touch -": -1, "part": 0}[fired]
        elif fired in ("touch +", "touch -"):
            m.contact = 1 if fired == "touch +" else -1
            x[W1] = x[W2] = (self.J1 * x[W1] + self.J2 * x[W2]) / self.J
            x[TH2] = x[TH1] - m.contact * self.lash / 2
            m.slip1 = m.slip2 = int(copysign(1, x[W1]))
        if fired == "stop joint":
            x[W1] = x[W2] = 0.0
        if fired == "grip":
            x[W1] = x[W2] = (self.J1 * x[W1] + self.J2 * x[W2]) / self.J
            m.clutch = 0
        if fired == "stop1":
            x[W1] = 0.0
        if fired == "stop2":
            x[W2] = 0.0
        if m.clutch and x[W1] == x[W2] == 0.0 and fired != "break1" and fired != "break2":
            m.clutch = 0
        if m.clutch == 0:
            self.settle_clutch(x, fired)
        elif m.contact and not self.sprung:
            self.settle_contact(x, fired)
        if not self.joined:
            n1, n2 = self.torques(x)
            m.slip1 = self.slip_after(x, m.slip1 if fired == "break1" else None, x[W1], n1, self.share1, m.slip1)
            m.slip2 = self.slip_after(x, m.slip2 if fired == "break2" else None, x[W2], n2, self.share2, m.slip2)

    def settle_clutch(self, x, fired):
        """Of a clutch that has held, or whose sides have come to the same speed: does it hold, and which sides move?"""
        m = self.mode
        if x[W1] != 0.0:
            m.slip1 = m.slip2 = int(copysign(1, x[W1]))
            carried = self.flank_torque(x)
            if fired == "give" or abs(carried) > self.grip:
                m.clutch = int(copysign(1, carried))
            return
        (low, low_by), (high, high_by) = self.stuck_flank_range(x)
        if fired != "break joint" and low <= high:
            m.slip1 = m.slip2 = 0
            return
        if "flank" in (low_by, high_by):
            # The side that asks for more than the clutch carries gives way.
            m.clutch = 1 if high_by == "flank" else -1
            m.slip1 = m.slip2 = 0
            if "motor" in (low_by, high_by):
                m.slip1 = 1 if low_by == "motor" else -1
            else:
                m.slip2 = 1 if high_by == "load" else -1
        else:
            m.slip1 = m.slip2 = 1 if low_by == "motor" else -1
            carried = self.flank_torque(x)
            if abs(carried) > self.grip:
                m.clutch = int(copysign(1, carried))

    def slip_after(self, x, broke, speed, net, share, before):
        """Stuck when the speed is 0 and |net torque| is within the breakaway level; `broke`: it has just left it."""
        if speed != 0.0:
            return int(copysign(1, speed))
        if broke is not None:
            return int(copysign(1, net))
        up, down = self.levels(x, share)
        if before and self.just_broke(before, net, up, down):
            return before
        return 1 if net > up else -1 if net < -down else 0

    @staticmethod
    def just_broke(before, net, up, down):
        """A side that broke away at this very instant still has speed 0 and sits on its level to rounding."""
        edge = net - up if before > 0 else -down - net
        return abs(edge) < 1e-13

    def parts(self, x):
        """Whether sides that touch and slip as one would have to pull; at no torque, its rate of change decides."""
        push = self.mode.contact * self.flank_torque(x)
        if abs(push) < 1e-12:
            ahead = x + 1e-7 * np.array(self.rhs(0.0, x))
            push = self.mode.contact * self.flank_torque(ahead)
        return push < 0.0

    def settle_contact(self, x, fired):
        m = self.mode
        if x[W1] != 0.0:
            m.slip1 = m.slip2 = int(copysign(1, x[W1]))
            if fired == "part" or self.parts(x):
                m.contact = 0
            return
        (low, low_by), (high, high_by) = self.stuck_flank_range(x)
        if fired != "break joint" and low <= high:
            m.slip1 = m.slip2 = 0
            return
        # The two binding limits say what gives way. A flank cannot pull: a side bound against it leaves alone.
        upwards = {"motor": low_by == "motor", "load": high_by == "load"}
        m.slip1 = m.slip2 = 0
        if "flank" in (low_by, high_by):
            m.contact = 0
            if "motor" in (low_by, high_by):
                m.slip1 = 1 if upwards["motor"] else -1
            else:
                m.slip2 = 1 if upwards["load"] else -1
        else:
            m.slip1 = m.slip2 = 1 if low_by == "motor" else -1

    def settle_current(self, x, fired):
        m = self.mode
        if self.coast and self.command == 0.0:
            m.current, x[CUR] = "open", 0.0
            return
        if fired == "limit":
            m.current, m.current_sign = "limited", int(copysign(1, x[CUR]))
            x[CUR] = m.current_sign * self.limit
            return
        if m.current == "limited":
            pull = self.excess(x) - m.current_sign * (self.drops[m.current_sign] + self.resistance(x) * self.limit)
            if fired == "unlimit" or m.current_sign * pull < 0.0:
                m.current = "flow"
                m.current_sign = m.current_sign if self.drops_at_all else 0
            return
        if not self.drops_at_all:
            m.current, m.current_sign = "flow", 0
            return
        if fired == "current zero":
            x[CUR] = 0.0
        if fired == "unblock":
            m.current, m.current_sign = "flow", int(copysign(1, self.excess(x)))
        elif x[CUR] != 0.0:
            m.current, m.current_sign = "flow", int(copysign(1, x[CUR]))
        elif m.current == "flow" and m.current_sign and fired not in ("current zero", None):
            pass  # current has just begun to flow: still 0 at this instant
        else:
            e = self.excess(x)
            if abs(e) > self.drops[1 if e > 0.0 else -1]:
                m.current, m.current_sign = "flow", int(copysign(1, e))
            else:
                m.current, m.current_sign = "blocked", 0


@dataclass
class Trace:
    """Rows at the asked instants, and the dense solution of every step in between."""
    rows: list = field(default_factory=list)
    pieces: list = field(default_factory=list)   # (from, to, dense output)
    events: list = field(default_factory=list)   # (t, guard)
    evaluations: int = 0


class Integrator:
    """Runs a Motor through a list of (instant, command) and lands on every asked instant."""

    def __init__(self, motor, method="DOP853", rtol=1e-12, atol=1e-14, keep_dense=False, max_step=np.inf):
        self.motor, self.method, self.rtol, self.atol = motor, METHODS[method], rtol, atol
        self.keep_dense, self.max_step = keep_dense, max_step
        self.trace = Trace()

    def run(self, switches, instants):
        """`switches`: (instant, command) in order, before the first of which the command is 0."""
        motor = self.motor
        x = np.zeros(9)
        t = 0.0
        marks = sorted({(s, 0, k) for k, (s, _) in enumerate(switches)} | {(s, 1, k) for k, s in enumerate(instants)})
        motor.settle(x)
        for instant, kind, k in marks:
            t, x = self.advance(t, x, instant)
            if kind == 0:
                motor.command = motor.driver_command(switches[k][1])
                motor.settle(x)
            else:
                self.trace.rows.append(x.copy())
        return self.trace

    def solver(self, t, x, end):
        return self.method(self.motor.rhs, t, x, end, rtol=self.rtol, atol=self.atol, max_step=self.max_step)

    def advance(self, t, x, end):
        while t < end:
            solver = self.solver(t, x, end)
            while solver.status == "running":
                before_t, before_x = solver.t, solver.y.copy()
                message = solver.step()
                if solver.status == "failed":
                    raise RuntimeError(message)
                dense = solver.dense_output()
                hit = self.first_crossing(before_t, before_x, solver.t, solver.y, dense)
                if hit is None:
                    self.check(solver.t, solver.y)
                    if self.keep_dense:
                        self.trace.pieces.append((before_t, solver.t, dense))
                    continue
                name, guess = hit
                t, x = self.polish(name, guess, before_t, before_x, end)
                if self.keep_dense:
                    self.trace.pieces.append((before_t, t, dense))
                self.trace.events.append((t, name))
                self.motor.settle(x, name)
                break
            else:
                t, x = solver.t, solver.y.copy()
            self.trace.evaluations += solver.nfev
        return t, x

    def first_crossing(self, t0, x0, t1, x1, dense):
        inner = [t0 + (t1 - t0) * f for f in (0.2, 0.4, 0.6, 0.8)]
        values = [self.motor.guards(x0)] + [self.motor.guards(dense(s)) for s in inner] + [self.motor.guards(x1)]
        times = [t0] + inner + [t1]
        best = None
        for name in values[0]:
            for k in range(1, 6):
                if values[k - 1][name] > 0.0 >= values[k][name]:
                    at = brentq(lambda s: self.motor.guards(dense(s))[name] if t0 < s < t1 else values[0 if s <= t0 else 5][name],
                                times[k - 1], times[k], xtol=1e-15, rtol=8.9e-16) if values[k][name] < 0.0 else times[k]
                    if best is None or at < best[1]:
                        best = (name, at)
                    break
        return best

    def polish(self, name, guess, t0, x0, end):
        """Integrates to the crossing itself and corrects the instant by Newton's rule along the solution."""
        def state_at(s):
            if s <= t0:
                return x0.copy()
            solver = self.solver(t0, x0, s)
            while solver.status == "running":
                solver.step()
            self.trace.evaluations += solver.nfev
            return solver.y.copy()

        t = guess
        x = state_at(t)
        for _ in range(3):
            g = self.motor.guards(x)[name]
            slope = np.array(self.motor.rhs(t, x))
            eps = 1e-7
            rate = (self.motor.guards(x + eps * slope)[name] - g) / eps
            if rate >= 0.0 or abs(g / rate) > 1e-6 or abs(g / rate) < 1e-15:
                break
            nxt = t - g / rate
            if not t0 < nxt < end:
                break
            t, x = nxt, state_at(nxt)
        return t, x

    def check(self, t, x):
        for name, value in self.motor.guards(x).items():
            if value < -1e-8:
                raise AssertionError(f"guard '{name}' is {value:.2e} at t = {t:.9f} s in mode {self.motor.mode}")
