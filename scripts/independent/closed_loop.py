"""A ship in continuous time whose orders are given where a condition passes zero, for reference_ships.py."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from independent.reference_models import Ship

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12, "dense_output": True}
U, V, R, HEADING, NORTH, EAST, TRACK = range(7)

Condition = Callable[[np.ndarray], float]


class Answer:
    """How an input follows an order, in closed form: at its greatest rate, then with its lag."""

    def __init__(self, start: float, target: float, lag_s: float, rate_per_s: float) -> None:
        self.start, self.target, self.lag_s = start, target, lag_s
        away = target - start
        self.rate = math.copysign(rate_per_s, away)
        # Until here the rate is at its limit.
        self.limited_s = max(0.0, abs(away) / rate_per_s - lag_s)

    def at(self, seconds: float) -> float:
        if seconds < self.limited_s:
            return self.start + self.rate * seconds
        if self.lag_s == 0.0:
            return self.target
        reached = self.start + (self.rate * self.limited_s if self.limited_s else 0.0)
        return self.target + (reached - self.target) * math.exp((self.limited_s - seconds) / self.lag_s)


class Voyage:
    """From a steady approach, heading north from the origin."""

    def __init__(self, ship: Ship) -> None:
        self.ship, self.t = ship, 0.0
        self.state = np.array([*ship.approach, 0.0, 0.0, 0.0, 0.0, 0.0])
        self.inputs = [(0.0, [Answer(held, held, ship.lag_s, ship.rate_per_s) for held in ship.held])]
        self.pieces: list = []

    def order(self, targets: list[float], seconds: float, until: Condition | None = None) -> None:
        """Orders inputs and waits for so long, or until `until` rises through zero."""
        ship, now = self.ship, self.inputs_at(self.t)
        answers = [Answer(a, b, ship.lag_s, ship.rate_per_s) for a, b in zip(now, targets)]
        self.inputs.append((self.t, answers))
        begin, end = self.t, self.t + seconds
        # Pieces end where a rate leaves its limit, so that an integrator never steps across a kink.
        kinks = sorted({begin + own.limited_s for own in answers if 0.0 < own.limited_s < seconds})
        for stop in [*kinks, end]:
            if self.integrate(stop, begin, answers, until):
                return
        if until is not None:
            raise SystemExit(f"{ship.name}: nothing happens within {seconds} s")

    def integrate(self, end: float, begin: float, answers: list[Answer], until: Condition | None) -> bool:
        """Whether `until` ended it."""

        def change(t: float, state: np.ndarray) -> list[float]:
            u, v, r, heading = state[:4]
            sin, cos = math.sin(heading), math.cos(heading)
            motion = self.ship.rates(u, v, r, [own.at(t - begin) for own in answers])
            return [*motion, r, u * cos - v * sin, u * sin + v * cos, math.hypot(u, v)]

        events = []
        if until is not None:
            event = lambda _, state: until(state)  # noqa: E731
            event.terminal, event.direction = True, 1.0
            events = [event]
        piece = solve_ivp(change, (self.t, end), self.state, events=events, **TIGHT)
        self.t, self.state = float(piece.t[-1]), piece.y[:, -1]
        self.pieces.append(piece)
        return piece.status == 1

    def at(self, t: float) -> np.ndarray:
        begins = [piece.t[0] for piece in self.pieces]
        return self.pieces[max(0, bisect_right(begins, t) - 1)].sol(t)

    def inputs_at(self, t: float) -> list[float]:
        begins = [begin for begin, _ in self.inputs]
        begin, answers = self.inputs[bisect_right(begins, t) - 1]
        return [own.at(t - begin) for own in answers]

    def first(self, condition: Condition, begin: float = 0.0) -> float:
        """When `condition` first rises through zero after `begin`."""
        times = np.linspace(begin, self.t, 2001)
        values = np.array([condition(self.at(t)) for t in times])
        rises = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
        if not len(rises):
            raise SystemExit(f"{self.ship.name}: nothing rises through zero after {begin} s")
        low, high = times[rises[0]], times[rises[0] + 1]
        return float(brentq(lambda t: condition(self.at(t)), low, high, xtol=1e-11))

    def record(self, rate_hz: float) -> list[list[float]]:
        """u, v, r, north, east, heading and inputs of every sample."""
        times = np.arange(math.floor(self.t * rate_hz + 1e-9) + 1) / rate_hz
        return [self.row(float(t)) for t in times]

    def row(self, t: float) -> list[float]:
        state = self.at(t)
        places = [(U, 6), (V, 6), (R, 8), (NORTH, 4), (EAST, 4), (HEADING, 7)]
        return [round(float(state[i]), digits) for i, digits in places] + [round(x, 5) for x in self.inputs_at(t)]
