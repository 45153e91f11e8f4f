"""Noisy runs: random maneuvers one after the other, the state carried over, white current and measurement noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .motion import poses, realize, regressors, simulate
from .removal import REMOVALS, condition
from .study import Study

SEGMENTS = 5
SEGMENT_SAMPLES = 50
SEED = 20240229
WORST_CONDITION = 1e3


@dataclass(frozen=True)
class Run:
    """One run of N samples: maneuver index of each segment, segment of each sample (N), inputs N × 3, true states,
    measured states and poses (N+1) × 3."""

    maneuvers: list[int]
    segment: np.ndarray
    inputs: np.ndarray
    states: np.ndarray
    measured: np.ndarray
    poses: np.ndarray


def draw_runs(study: Study, count: int) -> list[Run]:
    """`count` runs, each from a random stream of its own."""
    return [_draw(study, np.random.default_rng([SEED, run])) for run in range(count)]


def _draw(study: Study, rng: np.random.Generator) -> Run:
    vessel = study.vessel
    maneuvers, initial, inputs = _maneuvers(study, rng)
    n = len(inputs)
    current = study.current_std * rng.standard_normal((n, 2))
    states = simulate(vessel, vessel.value, initial, inputs, current)
    noise = np.array(study.measurement_std) * rng.standard_normal((n + 1, 3))
    segment = np.repeat(np.arange(SEGMENTS), SEGMENT_SAMPLES)
    return Run(maneuvers, segment, inputs, states, states + noise, poses(states, vessel.rate_hz))


def _maneuvers(study: Study, rng: np.random.Generator) -> tuple[list[int], tuple[float, float, float], np.ndarray]:
    """Random maneuvers, drawn again until every estimator is well conditioned: the instruments alone decide."""
    while True:
        maneuvers = rng.integers(0, len(study.maneuvers), SEGMENTS).tolist()
        parts = [realize(study, index, SEGMENT_SAMPLES) for index in maneuvers]
        initial, inputs = parts[0][0], np.concatenate([part[1] for part in parts])
        segment = np.repeat(np.arange(SEGMENTS), SEGMENT_SAMPLES)
        zeta = regressors(study.vessel, simulate(study.vessel, study.vessel.nominal, initial, inputs), inputs)
        if all(condition(z, z, removal, segment) < WORST_CONDITION for z in zeta for removal in REMOVALS):
            return maneuvers, initial, inputs
