"""Standard maneuvers of a ship in continuous time: helm that goes over when a heading is reached.

    python scripts/independent/standard_maneuvers.py --out fixtures/oracle/standard_maneuvers.json

scipy integrates the ship's equations and finds the moment of every order as a root of the heading, where the workspace steps
sample by sample and gives a sample the part of each order that falls into it.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

from independent.text import pretty  # noqa: E402

LENGTH = 7.0
SPEED = 1.2
TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}

Inputs = tuple[float, float]
Condition = Callable[[float, np.ndarray], float]


def rates(state: np.ndarray, thrust: float, rudder: float) -> list[float]:
    """Changes per second of u, v, r, heading, north and east."""
    u, v, r, heading, _, _ = state
    flow = u * abs(u) * rudder
    return [
        -0.015 * u * abs(u) + 0.0216 * thrust + 0.4 * v * r - 0.01 * rudder * abs(rudder),
        -0.25 * v - 0.35 * u * r + 0.02 * flow,
        -0.45 * r + 0.06 * flow - 0.8 * r * abs(r) - 0.05 * v,
        r,
        u * math.cos(heading) - v * math.sin(heading),
        u * math.sin(heading) + v * math.cos(heading),
    ]


class Voyage:
    """A ship that holds inputs until a condition passes zero, then others."""

    def __init__(self) -> None:
        self.t = 0.0
        self.state = np.array([SPEED, 0.0, 0.0, 0.0, 0.0, 0.0])
        self.legs: list = []

    def hold(self, inputs: Inputs, seconds: float, until: Condition | None = None) -> None:
        """Holds `inputs` for so long, or until `until` rises through zero."""
        events = None
        if until is not None:
            event = lambda t, state: until(t, state)  # noqa: E731
            event.terminal, event.direction = True, 1.0
            events = event
        run = lambda t, state: rates(state, *inputs)  # noqa: E731
        leg = solve_ivp(run, (self.t, self.t + seconds), self.state, events=events, dense_output=True, **TIGHT)
        self.t, self.state = float(leg.t[-1]), leg.y[:, -1]
        self.legs.append(leg)

    def fine(self, per_leg: int = 40000) -> tuple[np.ndarray, np.ndarray]:
        """Times and states, finely."""
        times = [np.linspace(leg.t[0], leg.t[-1], per_leg) for leg in self.legs]
        return np.concatenate(times), np.concatenate([leg.sol(t).T for leg, t in zip(self.legs, times)])


def zig_zag(rudder: float, heading: float, first: int, delay: float) -> dict:
    """Times of three orders and the overshoots beyond the headings at which the helm goes over, degrees."""
    voyage, side = Voyage(), first
    orders, overshoots, executed = [], [], heading
    for _ in range(4):
        reached = lambda t, state, side=side: side * state[3] - heading  # noqa: E731
        begin = len(voyage.legs)
        voyage.hold((1.0, side * rudder), 300.0, reached)
        orders.append(voyage.t)
        if delay:
            voyage.hold((1.0, side * rudder), delay)
        if begin:
            t, states = voyage.fine()
            own = (t >= orders[-2]) & (t <= orders[-1])
            overshoots.append(math.degrees(np.max(-side * states[own, 3]) - executed))
        executed = side * voyage.state[3]
        side = -side
    return {
        "rudder": rudder,
        "heading": heading,
        "first": first,
        "delay_s": delay,
        "orders_s": orders[:3],
        "overshoots_deg": overshoots[:3],
    }


def slow_zig_zag(rudder: float, heading: float, lag: float, rate: float) -> dict:
    """A zig-zag, first to starboard, by a rudder with a time constant or a greatest rate; its angle is a state of its own."""
    side, t = 1, 0.0
    state = np.array([SPEED, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    overshoots: list[float] = []
    for order in range(4):
        target = side * rudder

        def change(t: float, x: np.ndarray, target: float = target) -> list[float]:
            angle = x[6]
            if rate:
                turning = math.copysign(rate, target - angle) if abs(target - angle) > 1e-9 else 0.0
            else:
                turning = (target - angle) / lag
            return [*rates(x[:6], 1.0, angle), turning]

        legs = []
        ends = (lambda t, x: side * x[3] - heading,)
        ends[0].terminal, ends[0].direction = True, 1.0  # type: ignore[attr-defined]
        if rate:
            moving = abs(target - state[6]) / rate
            there = solve_ivp(change, (t, t + moving), state, events=ends, dense_output=True, max_step=0.05, **TIGHT)
            legs.append(there)
            t, state = float(there.t[-1]), there.y[:, -1].copy()
            if there.status == 0:
                state[6] = target
        if not legs or legs[-1].status == 0:
            rest = solve_ivp(change, (t, t + 300.0), state, events=ends, dense_output=True, **TIGHT)
            legs.append(rest)
            t, state = float(rest.t[-1]), rest.y[:, -1].copy()
        if order:
            peak = max(np.max(-side * leg.sol(np.linspace(leg.t[0], leg.t[-1], 40000))[3]) for leg in legs)
            overshoots.append(math.degrees(peak - heading))
        side = -side
    return {
        "rudder": rudder,
        "heading": heading,
        "first": 1,
        "delay_s": 0.0,
        "lag_s": lag,
        "rate_rad_s": rate,
        "overshoots_deg": overshoots[:3],
    }


def at_heading(voyage: Voyage, angle: float, side: int) -> np.ndarray:
    """The state where the heading has first changed by `angle`."""
    t, states = voyage.fine()
    k = int(np.argmax(side * states[:, 3] >= angle))
    leg = next(leg for leg in voyage.legs if leg.t[0] <= t[k] <= leg.t[-1])
    low, high = t[k - 1], t[k]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if side * leg.sol(middle)[3] >= angle else (middle, high)
    return leg.sol(high)


def circle(rudder: float, side: int) -> dict:
    voyage = Voyage()
    voyage.hold((1.0, side * rudder), 300.0)
    quarter, half = at_heading(voyage, math.pi / 2, side), at_heading(voyage, math.pi, side)
    u, v, r = voyage.state[:3]
    return {
        "rudder": rudder,
        "side": side,
        "advance_m": quarter[4],
        "transfer_m": side * quarter[5],
        "tactical_diameter_m": side * half[5],
        "steady_diameter_m": 2.0 * math.hypot(u, v) / abs(r),
        "steady_yaw_rate_deg_s": math.degrees(abs(r)),
    }


def stop(thrust: float, rudder: float, until: float) -> dict:
    """Track and head reach until the speed is `until`."""
    voyage = Voyage()
    voyage.hold((thrust, rudder), 2000.0, lambda t, state: until - state[0])
    t, states = voyage.fine(400000)
    speeds = np.hypot(states[:, 0], states[:, 1])
    return {
        "thrust": thrust,
        "rudder": rudder,
        "until_m_s": until,
        "time_s": voyage.t,
        "track_reach_m": float(np.trapezoid(speeds, t)),
        "head_reach_m": states[-1, 4],
        "lateral_m": states[-1, 5],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    degrees = math.radians
    document = {
        "length_m": LENGTH,
        "speed_m_s": SPEED,
        "zig_zags": [
            zig_zag(degrees(10), degrees(10), 1, 0.0),
            zig_zag(degrees(10), degrees(10), -1, 0.0),
            zig_zag(degrees(20), degrees(20), 1, 0.0),
            zig_zag(degrees(20), degrees(10), 1, 0.0),
            zig_zag(degrees(20), degrees(20), 1, 1.7),
        ],
        "slow_rudders": [
            slow_zig_zag(degrees(20), degrees(20), 2.0, 0.0),
            slow_zig_zag(degrees(20), degrees(20), 0.0, degrees(5)),
        ],
        "circles": [circle(degrees(35), 1), circle(degrees(35), -1)],
        "stops": [stop(-1.0, 0.2, 0.0), stop(0.0, 0.0, 0.05 * SPEED)],
    }
    out.write_text(pretty(document) + "\n")


if __name__ == "__main__":
    main()
