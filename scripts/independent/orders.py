"""Standard maneuvers as a crew carries them out: the helm goes over where a heading or a time is reached, within a sample."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .steering import Fleet
    from .study import Vessel
    from .voyage import Phase

KINDS = ("zig-zag-test", "turning-circle", "pull-out")
NOT_FOLLOWED = ("delay_s", "every_s")


@dataclass(frozen=True)
class Order:
    """Inputs until so many seconds have passed, or the course has changed by so much [rad], starboard positive."""

    inputs: np.ndarray
    seconds: float = math.inf
    heading: float = math.nan


@dataclass(frozen=True)
class Program:
    """Orders in their sequence; `again` is the order after the last one. The course is taken when order `course_at` begins. It is
    over after `longest` samples, or once the course has changed by `turn`."""

    orders: tuple[Order, ...]
    again: int | None
    course_at: int
    turn: float
    longest: int
    rate_hz: float

    @classmethod
    def of(cls, phase: Phase, fleet: Fleet) -> Program:
        """The program of a maneuver of a dictionary, to the other side if the leg is mirrored."""
        own, vessel = phase.orders or {}, fleet.vessel
        check(own)
        held = fleet.held(own["speed_m_s"])
        if "approach" in own:
            held = np.array([own["approach"].get(name, 0.0) for name in vessel.inputs])
        helm = np.array([own["helm"].get(name, 0.0) for name in vessel.inputs])
        to, mirrored = {"starboard": 1.0, "port": -1.0}[own.get("to", "starboard")], -1.0 if phase.mirrored else 1.0
        signs = mirror(vessel) if phase.mirrored else np.ones(len(helm))
        over = lambda side: Order(signs * (held + side * helm), heading=mirrored * side * own.get("heading_rad", math.nan))  # noqa: E731
        hold = [Order(signs * held, seconds=own["hold_s"])] if own.get("hold_s", 0.0) > 0.0 else []
        helms = {
            "zig-zag-test": [over(to), over(-to)],
            "turning-circle": [over(to)],
            "pull-out": [Order(signs * (held + to * helm), seconds=own.get("turn_s", 0.0)), over(0.0)],
        }[own["kind"]]
        return cls(
            orders=(*hold, *helms),
            again=len(hold) if own["kind"] == "zig-zag-test" else None,
            course_at=len(hold),
            turn=own.get("turn_rad", 3.0 * math.pi) if own["kind"] == "turning-circle" else math.inf,
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

    def begin(self, program: Program, lanes: np.ndarray, psi: np.ndarray) -> None:
        self.now[lanes], self.samples[lanes], self.since[lanes], self.turned[lanes] = 0, 0, 0.0, 0.0
        self.from_psi[lanes], self.all_given[lanes] = psi, len(program.orders) == 1
        self.course[lanes] = 0.0 if program.course_at == 0 else math.nan

    def command(self, program: Program, lanes: np.ndarray, psi: np.ndarray, r: np.ndarray, _: np.ndarray) -> np.ndarray:
        """Inputs of the next sample: an order executed within it has its part of them."""
        dt = 1.0 / program.rate_hz
        rows = np.array([order.inputs for order in program.orders])
        seconds, headings = (np.array([getattr(o, of) for o in program.orders]) for of in ("seconds", "heading"))
        heading, begun = psi - self.from_psi[lanes], self.samples[lanes] * dt
        inputs, at, open_ = np.zeros((len(lanes), rows.shape[1])), np.zeros(len(lanes)), np.ones(len(lanes), dtype=bool)
        while open_.any():
            now = self.now[lanes]
            by_time = (self.since[lanes] + seconds[now] - begun) / dt
            side = np.sign(headings[now])
            left = side * (headings[now] - (heading - self.course[lanes]))
            change = side * r * dt
            with np.errstate(divide="ignore", invalid="ignore"):
                by_heading = np.where(left <= 0.0, 0.0, np.where(left < change, left / change, math.inf))
            to = np.where(np.isnan(headings[now]), by_time, by_heading)
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
        self.turned[lanes] = heading + r * dt - self.course[lanes]
        return inputs

    def is_over(self, program: Program, lanes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which vessels are done, and which of them give up."""
        late = self.samples[lanes] >= program.longest
        met = self.all_given[lanes] & (self.samples[lanes] > 0)
        if math.isfinite(program.turn):
            met &= np.abs(self.turned[lanes]) >= program.turn
            return met | late, late & ~met
        return late, late & ~met
