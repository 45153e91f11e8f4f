"""Instrumental-variable and least-squares estimates by definition, with explicit instrument matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dst
from scipy.optimize import minimize_scalar

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
    # Of each degree of freedom
    covariance: list[np.ndarray]

    @property
    def variance(self) -> np.ndarray:
        """Of all parameters."""
        return np.concatenate([np.diag(own) for own in self.covariance])


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
    gamma0, gamma1, covariance = zip(*spreads)
    return Estimate(theta, conditions, list(gamma0), list(gamma1), list(covariance))


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
) -> tuple[float, float, np.ndarray]:
    """γ0, γ1 of the residual and the parameters' covariance A⁻¹ ζᵀ Γ ζ A⁻ᵀ, Γ the residual's covariance matrix: γ0 on
    its diagonal, γ1 beside it, those of the likeliest moving average of order 1.

    `zeta` is without its mean; the residual loses the mean that the removal's intercepts take.
    """
    n, p = phi.shape
    residual = without_mean((target - phi @ theta)[:, None], removal, segment)[:, 0]
    intercepts = {"none": 0, "complete": 1, "batch": len(np.unique(segment))}[removal]
    gamma0, gamma1 = (gamma * n / (n - p - intercepts) for gamma in _moving_average(residual))
    inverse = np.linalg.inv(zeta.T @ phi)
    beside = np.eye(n, k=1) + np.eye(n, k=-1)
    middle = zeta.T @ (gamma0 * np.eye(n) + gamma1 * beside) @ zeta
    return gamma0, gamma1, inverse @ middle @ inverse.T


def _moving_average(sequence: np.ndarray) -> tuple[float, float]:
    """γ0, γ1 of the moving average of order 1 that makes a sequence likeliest.

    Sines are the eigenvectors of its covariance matrix, which is tridiagonal and Toeplitz: 1 + θ² + 2 θ cos(π j/(n + 1)).
    """
    n = len(sequence)
    angles = np.pi * np.arange(1, n + 1) / (n + 1)
    squares = (dst(sequence, type=1) / np.sqrt(2.0 * (n + 1))) ** 2

    def likelihood(theta: float) -> tuple[float, float]:
        eigenvalues = 1.0 + theta * theta + 2.0 * theta * np.cos(angles)
        variance = float(np.mean(squares / eigenvalues))
        return n * np.log(variance) + float(np.log(eigenvalues).sum()), variance

    grid = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 401))
    best = int(np.argmin([likelihood(theta)[0] for theta in grid]))
    between = (grid[max(best - 1, 0)], grid[min(best + 1, 400)])
    theta = minimize_scalar(lambda t: likelihood(t)[0], bounds=between, method="bounded", options={"xatol": 1e-9}).x
    variance = likelihood(theta)[1]
    return variance * (1.0 + theta * theta), variance * theta
