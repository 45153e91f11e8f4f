"""Moments of maneuvers by definition: X̄ = mean φζᵀ, Ȳ = mean φ, Z̄ = mean ζ."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .motion import realize, regressors, simulate
from .study import Study


@dataclass(frozen=True)
class Moments:
    """Of one maneuver and degree of freedom: X̄ (p × p), Ȳ (p), Z̄ (p)."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray

    def lifted(self) -> np.ndarray:
        """M = [[X̄, Ȳ], [Z̄ᵀ, 1]]: the mean of φ̃ ζ̃ᵀ with intercepts last."""
        return np.block([[self.x, self.y[:, None]], [self.z[None, :], np.ones((1, 1))]])

    def batch(self) -> np.ndarray:
        """X̄ − Ȳ Z̄ᵀ: the information under batchwise subtraction."""
        return self.x - np.outer(self.y, self.z)


def maneuver_moments(study: Study, index: int) -> list[Moments]:
    """Moments of maneuver `index`, undisturbed, per degree of freedom."""
    initial, inputs = realize(study, index, study.samples)
    vessel = study.vessel
    truth = regressors(vessel, simulate(vessel, vessel.value, initial, inputs), inputs)
    nominal = regressors(vessel, simulate(vessel, vessel.nominal, initial, inputs), inputs)
    return [_exact(phi, zeta) for phi, zeta in zip(truth, nominal)]


def _exact(phi: np.ndarray, zeta: np.ndarray) -> Moments:
    """By correctly rounded sums, checked against extended precision."""
    n, p = phi.shape
    x = [[math.fsum(phi[:, i] * zeta[:, j]) / n for j in range(p)] for i in range(p)]
    moments = Moments(np.array(x), _means(phi), _means(zeta))
    wide = phi.astype(np.longdouble), zeta.astype(np.longdouble)
    scale = np.sqrt(np.outer((phi**2).mean(0), (zeta**2).mean(0))) + np.finfo(float).tiny
    other = np.einsum("ki,kj->ij", *wide) / n
    assert np.max(np.abs(other - moments.x) / scale) < 1e-14
    lifted = np.einsum("ki,kj->ij", *(np.column_stack([w, np.ones(n)]) for w in wide)) / n
    assert np.allclose(np.asarray(lifted, float), moments.lifted(), rtol=1e-12, atol=1e-13 * np.abs(scale).max())
    return moments


def _means(columns: np.ndarray) -> np.ndarray:
    return np.array([math.fsum(column) / len(columns) for column in columns.T])
