"""How often trials of a design, and of random maneuvers, give a good model: the paper's Monte Carlo study, runs side by side."""

from __future__ import annotations

from typing import Any

import numpy as np

from .motion import increments
from .study import STATES, Vessel

SAMPLES, SEGMENTS, BOUND = 1000, 5, 5.0
STD = 0.025**0.5
"""Of the current at every sample and of every measurement: the paper's variance."""

AT_ONCE = 500

Part = tuple[np.ndarray, np.ndarray]
"""State at the start, and inputs, of a maneuver."""


def optimized(vessel: Vessel, parts: list[Part], runs: int, rng: np.random.Generator) -> float:
    """The share of good models after the parts, one after the other."""
    inputs = np.concatenate([inputs for _, inputs in parts])
    some = [(np.tile(parts[0][0], (AT_ONCE, 1)), np.tile(inputs, (AT_ONCE, 1, 1)))] * (runs // AT_ONCE)
    return float(np.mean([errors(vessel, *one, rng) < BOUND for one in some]))


def random(vessel: Vessel, parts: list[Part], runs: int, rng: np.random.Generator) -> float:
    """The same after segments that are any of the parts."""
    good = []
    for _ in range(runs // AT_ONCE):
        picks = rng.integers(0, len(parts), (AT_ONCE, SEGMENTS))
        starts = np.array([parts[own[0]][0] for own in picks])
        inputs = np.array([np.concatenate([parts[q][1] for q in own]) for own in picks])
        good.append(errors(vessel, starts, inputs, rng) < BOUND)
    return float(np.mean(good))


def errors(vessel: Vessel, starts: np.ndarray, inputs: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The parameter error of every run (root of the sum of squared relative errors), by instrumental variables."""
    measured, nominal = (runs(vessel, theta, starts, inputs, noise) for theta, noise in ((vessel.value, rng), (vessel.nominal, None)))
    theta = []
    for d, (phi, zeta) in enumerate(zip(regressors(vessel, measured, inputs), regressors(vessel, nominal, inputs))):
        zeta = zeta - zeta.mean(1, keepdims=True)
        a = np.einsum("rki,rkj->rij", zeta, phi)
        b = np.einsum("rki,rk->ri", zeta, np.diff(measured[..., d], axis=1))
        # Runs that leave a parameter without excitation get an estimate that is far off, and no error.
        a += 1e-40 * np.eye(a.shape[1])
        theta.append(np.linalg.solve(a, b[..., None])[..., 0])
    relative = np.concatenate(theta, axis=1) / np.array(vessel.truth) - 1.0
    return np.sqrt((relative**2).sum(1))


def runs(vessel: Vessel, theta: Any, starts: np.ndarray, inputs: np.ndarray, rng: np.random.Generator | None) -> np.ndarray:
    """States, runs × (N+1) × 3; with `rng` those measured in a current that is new at every sample."""
    state, out = starts, []
    for k in range(inputs.shape[1] + 1):
        out.append(state + (STD * rng.standard_normal(state.shape) if rng else 0.0))
        if k < inputs.shape[1]:
            seen = state.copy()
            if rng:
                seen[:, :2] -= STD * rng.standard_normal((len(state), 2))
            values = dict(zip(STATES, seen.T)) | dict(zip(vessel.inputs, inputs[:, k].T))
            state = state + np.column_stack(increments(vessel, theta, values))
    return np.stack(out, axis=1)


def regressors(vessel: Vessel, states: np.ndarray, inputs: np.ndarray) -> list[np.ndarray]:
    """φ of every degree of freedom, runs × N × p."""
    values = {name: states[:, :-1, i] for i, name in enumerate(STATES)}
    values |= {name: inputs[..., i] for i, name in enumerate(vessel.inputs)}
    return [np.stack([term.value(values) for term in terms], axis=-1) for terms in vessel.terms]
