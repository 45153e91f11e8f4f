"""Standard maneuvers as a crew carries them out: orders are given where a heading, a speed or a time is reached, within a sample."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .force_ship import ForceShip
from .tracking import Motion

if TYPE_CHECKING:
    from .steering import Fleet
    from .study import Vessel
    from .voyage import Phase

KINDS = ("zig-zag-test", "turning-circle", "pull-out", "stop")
NOT_FOLLOWED = ("delay_s", "every_s")
# Speed at the end of a stop without thrust, as a part of that before it.
INERTIAL_END = 0.05


@dataclass(frozen=True)
class Order:
    """Inputs until so many seconds have passed, the course has changed by so much [rad], starboard positive, or the speed is no
    greater [m/s]."""

    inputs: np.ndarray
    seconds: float = math.inf
    heading: float = math.nan
    speed: float = math.nan


@dataclass(frozen=True)
class Program:
    """Orders in their sequence; `again` is the order after the last one. The course is taken when order `course_at` begins. It is
    over after `longest` samples, once the course has changed by `turn`, or with the last order if that `ends` it."""

    orders: tuple[Order, ...]
    again: int | None
    course_at: int
    turn: float
    ends: bool
    longest: int
    rate_hz: float

    @classmethod
    def of(cls, phase: Phase, fleet: Fleet) -> Program:
        """The program of a maneuver of a dictionary, to the other side if the leg is mirrored."""
        own, vessel = phase.orders or {}, fleet.vessel
        check(own)
        held, row = fleet.held(own["speed_m_s"]), lambda key: np.array([own.get(key, {}).get(name, 0.0) for name in vessel.inputs])
        if "approach" in own:
            held = row("approach")
        helm, end = row("helm"), 0.0 if own.get("inputs") else INERTIAL_END * own["speed_m_s"]
        to, mirrored = {"starboard": 1.0, "port": -1.0}[own.get("to", "starboard")], -1.0 if phase.mirrored else 1.0
        signs = mirror(vessel) if phase.mirrored else np.ones(len(helm))
        over = lambda side: Order(signs * (held + side * helm), heading=mirrored * side * own.get("heading_rad", math.nan))  # noqa: E731
        hold = [Order(signs * held, seconds=own["hold_s"])] if own.get("hold_s", 0.0) > 0.0 else []
        helms = {
            "zig-zag-test": [over(to), over(-to)],
            "turning-circle": [over(to)],
            "pull-out": [Order(signs * (held + to * helm), seconds=own.get("turn_s", 0.0)), over(0.0)],
            "stop": [Order(signs * row("inputs"), speed=end), Order(0.0 * held)],
        }[own["kind"]]
        return cls(
            orders=(*hold, *helms),
            again=len(hold) if own["kind"] == "zig-zag-test" else None,
            course_at=len(hold),
            turn=own.get("turn_rad", 3.0 * math.pi) if own["kind"] == "turning-circle" else math.inf,
            ends=own["kind"] == "stop",
            longest=round(own.get("piece_s", own["duration_s"]) * vessel.rate_hz),
            rate_hz=vessel.rate_hz,
        )


def check(maneuver: dict[str, Any]) -> None:
    """Refuses what this script does not carry out."""
    name, kind = maneuver["name"], maneuver["kind"]
    if kind not in KINDS:
        raise SystemExit(f"maneuver {name}: kind {kind}, expected one of {', '.join(KINDS)}; this script carries out no other")
    for key in NOT_FOLLOWED:
        if key in maneuver:
            raise SystemExit(f"maneuver {name}: {key}, which this script does not follow")
    if maneuver.get("sensors", "own") != "own":
        raise SystemExit(f"maneuver {name}: sensors {maneuver['sensors']}, expected own")


def mirror(vessel: Vessel) -> np.ndarray:
    """Signs of inputs by which surge is the same to the other side, and sway and yaw are opposite."""
    if isinstance(vessel, ForceShip):
        return vessel.mirror()
    for signs in itertools.product((1.0, -1.0), repeat=len(vessel.inputs)):
        sign = {"u": 1.0, "v": -1.0, "r": -1.0} | dict(zip(vessel.inputs, signs))
        of = lambda term: math.prod(1.0 if modulus else sign[name] for name, modulus in term.factors)  # noqa: E731
        wanted = (1.0, -1.0, -1.0)
        if all(of(term) == side for side, terms in zip(wanted, vessel.terms) for term in terms):
            return np.array(signs)
    raise SystemExit("a mirrored maneuver of a vessel that is not symmetric")


class Helmsmen:
    """One per vessel, each at an order of its program."""

    def __init__(self, lanes: int) -> None:
        self.now, self.samples = np.zeros(lanes, dtype=int), np.zeros(lanes, dtype=int)
        self.since, self.from_psi = np.zeros(lanes), np.zeros(lanes)
        self.course, self.turned = np.full(lanes, math.nan), np.zeros(lanes)
        self.all_given = np.zeros(lanes, dtype=bool)
        # The speed that was seen a sample before; what a controller has learnt.
        self.speed, self.learnt = np.full(lanes, math.nan), np.zeros((lanes, 3))

    def begin(self, program: Program | Motion, lanes: np.ndarray, psi: np.ndarray) -> None:
        self.now[lanes], self.samples[lanes], self.since[lanes], self.turned[lanes] = 0, 0, 0.0, 0.0
        self.speed[lanes], self.learnt[lanes] = math.nan, 0.0
        if isinstance(program, Program):
            self.from_psi[lanes], self.all_given[lanes] = psi, len(program.orders) == 1
            self.course[lanes] = 0.0 if program.course_at == 0 else math.nan

    def track(self, motion: Motion, lanes: np.ndarray, state: np.ndarray, ranges: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Inputs of the next sample by which the nominal motion is held; nothing is learnt while one is at the end of its range."""
        now = np.minimum(self.samples[lanes], motion.longest - 1)
        errors = motion.reference[now] - (state * np.array([1.0, motion.side, motion.side])[:, None]).T
        wanted = motion.proportional * errors + self.learnt[lanes]
        inputs = motion.inputs[now] + np.einsum("kij,kj->ki", motion.corrections[now], wanted)
        reached = np.clip(inputs, *ranges)
        free = (reached == inputs).all(axis=1)
        self.learnt[lanes[free]] += motion.integral * errors[free]
        self.samples[lanes] += 1
        return motion.signs * reached

    def command(self, program: Program, lanes: np.ndarray, psi: np.ndarray, state: np.ndarray) -> np.ndarray:
        """Inputs of the next sample: an order executed within it has its part of them."""
        dt, (u, _, r) = 1.0 / program.rate_hz, state
        rows = np.array([order.inputs for order in program.orders])
        seconds, headings, speeds = (np.array([getattr(o, of) for o in program.orders]) for of in ("seconds", "heading", "speed"))
        slowed = np.where(np.isnan(self.speed[lanes]), 0.0, self.speed[lanes] - u)
        heading, begun = psi - self.from_psi[lanes], self.samples[lanes] * dt
        inputs, at, open_ = np.zeros((len(lanes), rows.shape[1])), np.zeros(len(lanes)), np.ones(len(lanes), dtype=bool)
        while open_.any():
            now = self.now[lanes]
            by_time = (self.since[lanes] + seconds[now] - begun) / dt
            side = np.sign(headings[now])
            turning = within(side * (headings[now] - (heading - self.course[lanes])), side * r * dt)
            slowing = within(u - speeds[now], slowed)
            to = np.select([~np.isnan(headings[now]), ~np.isnan(speeds[now])], [turning, slowing], by_time)
            to = np.where(open_, np.clip(to, at, 1.0), at)
            inputs += (to - at)[:, None] * rows[now]
            following = now + 1
            if program.again is not None:
                following = np.where(following < len(rows), following, program.again)
            on = open_ & (to < 1.0) & (following < len(rows))
            rest = open_ & (to < 1.0) & ~on
            inputs[rest] += (1.0 - to[rest])[:, None] * rows[now[rest]]
            own = lanes[on]
            self.all_given[own] |= (following[on] <= now[on]) if program.again is not None else (following[on] + 1 == len(rows))
            self.now[own], self.since[own] = following[on], begun[on] + to[on] * dt
            taken = on & np.isnan(self.course[lanes]) & (following == program.course_at)
            self.course[lanes[taken]] = heading[taken] + r[taken] * to[taken] * dt
            at, open_ = to, on
        self.samples[lanes] += 1
        self.speed[lanes] = u
        self.turned[lanes] = heading + r * dt - self.course[lanes]
        return inputs

    def is_over(self, program: Program | Motion, lanes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which vessels are done, and which of them give up."""
        late = self.samples[lanes] >= program.longest
        if isinstance(program, Motion):
            return late, np.zeros(len(lanes), dtype=bool)
        met = self.all_given[lanes] & (self.samples[lanes] > 0)
        if math.isfinite(program.turn):
            met &= np.abs(self.turned[lanes]) >= program.turn
        return (met | late if program.ends or math.isfinite(program.turn) else late), late & ~met


def within(left: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The part of a sample after which nothing is left, where it changes by so much in the whole."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(left <= 0.0, 0.0, np.where(left < change, left / change, math.inf))


def program_of(phase: Phase, fleet: Fleet) -> Program | Motion:
    """What holds a maneuver of a dictionary, to the other side if the leg is mirrored."""
    own = phase.orders or {}
    if own.get("executed") != "feedback":
        return Program.of(phase, fleet)
    signs = mirror(fleet.vessel) if phase.mirrored else np.ones(len(fleet.vessel.inputs))
    return Motion.of(own, signs, -1.0 if phase.mirrored else 1.0, fleet)
