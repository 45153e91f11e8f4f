"""Instrumental-variable and least-squares estimates by definition, with explicit instrument matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .motion import regressors, simulate
from .removal import condition, without_mean
from .runs import Run
from .study import Vessel


@dataclass(frozen=True)
class Estimate:
    """All parameters, surge first; per degree of freedom the scaled condition number and the residual's statistics."""

    theta: np.ndarray
    condition: list[float]
    gamma0: list[float]
    gamma1: list[float]
    variance: np.ndarray
    variance_bounded: np.ndarray


def estimate(vessel: Vessel, run: Run, estimator: str, removal: str) -> Estimate:
    """`iv` (instruments: nominal simulation from the run's true initial state) or `ls` (instruments = regressors)."""
    phi = regressors(vessel, run.measured, run.inputs)
    zeta = phi
    if estimator == "iv":
        simulated = simulate(vessel, vessel.nominal, tuple(run.states[0]), run.inputs)
        zeta = regressors(vessel, simulated, run.inputs)
    target = np.diff(run.measured, axis=0)
    centred = [without_mean(z, removal, run.segment) for z in zeta]
    theta = _solve(_blocks(centred), _blocks(phi), target.T.reshape(-1))
    conditions = [condition(z, f, removal, run.segment) for z, f in zip(zeta, phi)]
    parts = np.split(theta, np.cumsum([f.shape[1] for f in phi])[:-1])
    spreads = [
        _spread(z, f, target[:, d], part, removal, run.segment)
        for d, (z, f, part) in enumerate(zip(centred, phi, parts))
    ]
    gamma0, gamma1, variance, bounded = zip(*spreads)
    return Estimate(theta, conditions, list(gamma0), list(gamma1), np.concatenate(variance), np.concatenate(bounded))


def _blocks(parts: list[np.ndarray]) -> np.ndarray:
    """The paper's Φᵀ (or Zᵀ) of all samples: 3N × p, one block of rows per degree of freedom."""
    rows = sum(len(part) for part in parts)
    out = np.zeros((rows, sum(part.shape[1] for part in parts)))
    row = column = 0
    for part in parts:
        out[row : row + len(part), column : column + part.shape[1]] = part
        row, column = row + len(part), column + part.shape[1]
    return out


def _solve(z: np.ndarray, phi: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The minimiser of ‖Zᵀ(y − Φθ)/N‖: QR of the scaled ZᵀΦ, refined with residuals in extended precision."""
    wide_z, wide_phi, wide_y = (m.astype(np.longdouble) for m in (z, phi, y))
    left, right = np.sqrt((z**2).sum(0)), np.sqrt((phi**2).sum(0))
    q, r = np.linalg.qr(np.asarray(wide_z.T @ wide_phi, float) / left[:, None] / right)
    theta = np.zeros(phi.shape[1], np.longdouble)
    for _ in range(4):
        residual = np.asarray(wide_z.T @ (wide_y - wide_phi @ theta), float) / left
        theta = theta + np.linalg.solve(r, q.T @ residual) / right
    return np.asarray(theta, float)


def _spread(
    zeta: np.ndarray, phi: np.ndarray, target: np.ndarray, theta: np.ndarray, removal: str, segment: np.ndarray
) -> tuple[float, float, np.ndarray, np.ndarray]:
    """γ0, γ1 of the residual and the parameters' variances A⁻¹ ζᵀ Γ ζ A⁻ᵀ, Γ the residual's covariance matrix: γ0 on
    its diagonal, γ1 beside it. Last: the same with γ1 limited to ± γ0/2, the range of a moving average of order 1.

    `zeta` is without its mean; the residual loses the mean that the removal's intercepts take.
    """
    n, p = phi.shape
    residual = without_mean((target - phi @ theta)[:, None], removal, segment)[:, 0]
    intercepts = {"none": 0, "complete": 1, "batch": len(np.unique(segment))}[removal]
    gamma0 = float(residual @ residual) / (n - p - intercepts)
    gamma1 = float(residual[:-1] @ residual[1:]) / (n - p - intercepts)
    inverse = np.linalg.inv(zeta.T @ phi)
    beside = np.eye(n, k=1) + np.eye(n, k=-1)

    def variances(lag: float) -> np.ndarray:
        middle = zeta.T @ (gamma0 * np.eye(n) + lag * beside) @ zeta
        return np.diag(inverse @ middle @ inverse.T)

    return gamma0, gamma1, variances(gamma1), variances(float(np.clip(gamma1, -gamma0 / 2, gamma0 / 2)))
