"""Identities that the oracle's own numbers must satisfy, computed another way."""

from __future__ import annotations

import numpy as np

from .estimate import Estimate
from .motion import regressors, simulate
from .removal import REMOVALS
from .runs import Run
from .study import Vessel

Estimates = dict[str, dict[str, Estimate]]


def worst_difference(vessel: Vessel, run: Run, estimates: Estimates) -> float:
    """Largest relative difference of one run's estimates from the same found through intercept columns:
    Σ ζ̃ (Δy − φ̃ᵀ[θ; c]) = 0 with instruments, an orthogonal projection for least squares."""
    phi = regressors(vessel, run.measured, run.inputs)
    simulated = simulate(vessel, vessel.nominal, tuple(run.states[0]), run.inputs)
    zeta = regressors(vessel, simulated, run.inputs)
    target = np.diff(run.measured, axis=0)
    worst = 0.0
    for removal in REMOVALS:
        columns = _intercepts(removal, run.segment)
        iv, ls = [], []
        for d, (f, z) in enumerate(zip(phi, zeta)):
            wide, instruments = np.column_stack([f, columns]), np.column_stack([z, columns])
            scale = np.sqrt((wide**2).mean(0))
            solved = np.linalg.solve(instruments.T @ (wide / scale), instruments.T @ target[:, d]) / scale
            iv.append(solved[: f.shape[1]])
            ls.append(np.linalg.lstsq(wide / scale, target[:, d])[0][: f.shape[1]] / scale[: f.shape[1]])
        for estimator, other in (("iv", iv), ("ls", ls)):
            found = estimates[estimator][removal].theta
            worst = max(worst, float(np.max(np.abs(np.concatenate(other) - found) / (np.abs(found) + 1e-12))))
    return worst


def _intercepts(removal: str, segment: np.ndarray) -> np.ndarray:
    match removal:
        case "none":
            return np.zeros((len(segment), 0))
        case "complete":
            return np.ones((len(segment), 1))
    return (segment[:, None] == np.unique(segment)[None, :]).astype(float)
