"""Ships with forces on a planned trial, and how far their numbers may be off."""

from __future__ import annotations

from typing import Any

import numpy as np

from .force_ship import ForceShip
from .steering import Fleet
from .voyage import Voyage

# Steps of slopes by inputs, in parts of their range, and of Newton's method for steady motion.
SLOPE, STEADY_STEPS = 1e-5, 60


class ForceFleet(Fleet):
    """Vessels of one ship with forces, each with numbers and a current of its own."""

    def __init__(self, vessel: ForceShip, voyage: Voyage) -> None:
        self.ship, self.dt = vessel, 1.0 / vessel.rate_hz
        self.steady: dict[float, np.ndarray] = {}
        super().__init__(vessel, voyage)  # type: ignore[arg-type]

    def increments(
        self, parameters: list[np.ndarray], state: np.ndarray, inputs: np.ndarray, water: np.ndarray | None = None
    ) -> np.ndarray:
        """Changes of u, v, r over the ground in a sample, from `state` through the water. That keeps its course over the earth while
        the ship turns: it turns in her axes by the mean yaw rate of the sample."""
        theta = dict(zip(self.ship.names[0], parameters[0].T))
        own = self.ship.increments(theta, state, inputs, self.dt)
        if water is None:
            return own
        angle = (state[2] + 0.5 * own[2]) * self.dt
        along, across = water[:2]
        turned = [np.cos(angle) * along + np.sin(angle) * across, np.cos(angle) * across - np.sin(angle) * along]
        return own + np.array([turned[0] - along, turned[1] - across, np.zeros_like(along)])

    def slopes(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        slopes = np.zeros((state.shape[1], 3, inputs.shape[1]))
        for index in range(inputs.shape[1]):
            wide = self.high[index] - self.low[index]
            step = SLOPE * (wide if np.isfinite(wide) else 1.0)
            ends = [inputs.copy(), inputs.copy()]
            ends[0][:, index] += step
            ends[1][:, index] -= step
            more, less = (self.increments(self.nominal, state, end) for end in ends)
            slopes[:, :, index] = ((more - less) / (2.0 * step)).T
        return slopes

    def held(self, speed: float) -> np.ndarray:
        """Inputs by which the nominal ship holds a speed on a straight course, with the sway that this takes."""
        if speed not in self.steady:
            self.steady[speed] = self.solved(speed)
        return self.steady[speed]

    def solved(self, speed: float) -> np.ndarray:
        sway = len(self.commanded) == 2
        middle = [0.5 * (a + b) if np.isfinite(b - a) else 0.0 for a, b in zip(self.low, self.high)]
        starts = [middle, *([low + part * (high - low) for low, high in zip(self.low, self.high)] for part in (0.7, 0.9, 0.3))]
        for start in starts:
            unknowns = np.array([0.0, *start] if sway else start, dtype=float)

            def off(x: np.ndarray) -> np.ndarray:
                v, inputs = (x[0], x[1:]) if sway else (0.0, x)
                state = np.array([[speed], [v], [0.0]])
                return self.increments(self.nominal, state, inputs[None, :])[:, 0]

            for _ in range(STEADY_STEPS):
                miss = off(unknowns)
                columns = []
                for index in range(len(unknowns)):
                    step = np.zeros(len(unknowns))
                    step[index] = 1e-6 * max(abs(unknowns[index]), 1e-2)
                    columns.append((off(unknowns + step) - off(unknowns - step)) / (2.0 * step[index]))
                unknowns = unknowns - np.linalg.lstsq(np.array(columns).T, miss, rcond=None)[0]
            inputs = unknowns[1:] if sway else unknowns
            if np.abs(off(unknowns)).max() < 1e-12 and (inputs >= self.low).all() and (inputs <= self.high).all():
                return inputs
        raise SystemExit(f"{speed} m/s, which this script finds no inputs for")

    def begun(self, speed: float) -> np.ndarray:
        return self.held(speed)


class Spread:
    """How far numbers are off nominal ones, from points of a cube from −1 to 1, or of the unit ball where `is_joint`."""

    def __init__(self, nominal: np.ndarray, half: np.ndarray, is_joint: bool, bounds: np.ndarray | None = None) -> None:
        self.nominal, self.half, self.is_joint, self.bounds = nominal, half, is_joint, bounds

    @classmethod
    def of(cls, vessel: Any, safety: dict[str, Any]) -> Spread:
        """Of a vessel, by the keys of plan.toml."""
        nominal = np.array([p for row in vessel.nominal for p in row])
        error, errors = safety.get("parameter_error", 0.0), safety.get("standard_errors")
        if not isinstance(vessel, ForceShip):
            return cls(nominal, error * np.abs(nominal), False)
        bounds = np.array([own.bounds for own in vessel.free]).reshape(-1, 2)
        if errors is None:
            return cls(nominal, error * np.abs(nominal), False, bounds)
        missing = [own.name for own in vessel.free if own.prior is None]
        if missing:
            raise SystemExit(f"{', '.join(missing)}: no prior, which `safety.standard_errors` counts in")
        return cls(nominal, errors * np.array([own.prior for own in vessel.free]), True, bounds)

    def numbers(self, points: np.ndarray) -> np.ndarray:
        found = self.nominal + self.half * points
        return found if self.bounds is None else np.clip(found, *self.bounds.T)

    def corner(self, slopes: np.ndarray) -> np.ndarray:
        if self.is_joint:
            length = np.linalg.norm(slopes)
            return slopes / length if length > 0.0 else slopes
        return np.where(slopes < 0.0, -1.0, 1.0)

    def kept(self, point: np.ndarray) -> np.ndarray:
        if self.is_joint:
            return point / max(1.0, float(np.linalg.norm(point)))
        return np.clip(point, -1.0, 1.0)

    def drawn(self, random: np.random.Generator, vessels: int) -> np.ndarray:
        count = len(self.nominal)
        if not self.is_joint:
            return random.uniform(-1.0, 1.0, (vessels, count))
        directions = random.standard_normal((vessels, count))
        length = np.linalg.norm(directions, axis=1, keepdims=True)
        return directions / length * random.uniform(0.0, 1.0, (vessels, 1)) ** (1.0 / count)
