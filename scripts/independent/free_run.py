"""Free simulations of estimated models against the true one on an input of its own: a sum of sines."""

from __future__ import annotations

import math

import numpy as np

from .motion import Parameters, simulate
from .study import Vessel

SAMPLES = 200
INITIAL = (0.6, 0.0, 0.0)


def multi_sine() -> np.ndarray:
    """Inputs SAMPLES × 3 [N, N, N m], rounded so that they read well."""
    rows = []
    for k in range(SAMPLES):
        phase = 2.0 * math.pi * k / SAMPLES
        tau1 = 3000.0 + 1200.0 * math.sin(2 * phase) + 600.0 * math.sin(5 * phase + 1.0)
        tau3 = 180.0 * math.sin(3 * phase + 0.5) + 120.0 * math.sin(7 * phase + 2.0)
        tau2 = 400.0 * math.sin(4 * phase) - 300.0 * math.sin(9 * phase + 0.3)
        rows.append([round(tau1, 3), round(tau2, 3), round(tau3, 3)])
    return np.array(rows)


def rmse(vessel: Vessel, theta: np.ndarray, inputs: np.ndarray) -> list[float]:
    """RMSE of u, v [m/s], r [rad/s] over samples 1 … N; the common initial state is no error and is not counted."""
    sizes = np.cumsum([len(terms) for terms in vessel.terms])[:-1]
    estimated: Parameters = tuple(tuple(part.tolist()) for part in np.split(theta, sizes))
    truth = simulate(vessel, vessel.value, INITIAL, inputs)
    error = simulate(vessel, estimated, INITIAL, inputs) - truth
    return [math.sqrt(math.fsum(column**2) / len(inputs)) for column in error[1:].T]
