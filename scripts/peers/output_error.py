"""Output-error estimates by scipy.optimize.least_squares: simulation and sensitivities compiled by numba, one thread.

The realizations, their starts and the minimum are ours (`bench --realizations`): sum over u, v, r of log of the squared
errors of samples 1 to N, over ten parameters and three intercepts. `least_squares` (MINPACK's lm) minimises squares, so
the weights of u, v, r are those of the last errors and a fit is repeated until they stay to 1e-8. It ends where ours does: the
errors' cosine with what the unknowns can change is below 1e-7 standard deviations over the errors' norm. Ours goes on to
standard errors, the peer does not.
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares

DECREMENT = 1e-7
"""Newton decrement in standard deviations of the errors at which ours calls a point a minimum."""
FIRST = 1e-3
"""Cosine that ends the first round."""
STEADY = 1e-8
"""Relative change of the weights that moves the minimum by less than that."""
ROUNDS = 20
AGREEMENT = 1e-4
"""Largest difference of an estimate from ours, in its standard errors."""
TIMINGS = 3
Floats = NDArray[np.float64]


@njit(fastmath=True)
def _errors(x, start, tau, y, weights, out):  # type: ignore[no-untyped-def]
    """Weighted errors of samples 1 to N, N × 3."""
    u, v, r = start[0], start[1], start[2]
    for k in range(tau.shape[0]):
        a = u + (x[0] + x[1] * abs(u)) * u + x[2] * v * r + x[3] * tau[k, 0] + x[10]
        b = v + x[4] * v + x[5] * u * r + x[6] * tau[k, 1] + x[11]
        r = r + x[7] * r + x[8] * u * v + x[9] * tau[k, 2] + x[12]
        u, v = a, b
        out[k, 0] = weights[0] * (u - y[k + 1, 0])
        out[k, 1] = weights[1] * (v - y[k + 1, 1])
        out[k, 2] = weights[2] * (r - y[k + 1, 2])


@njit(fastmath=True)
def _slopes(x, start, tau, weights, out):  # type: ignore[no-untyped-def]
    """Derivatives of the weighted errors, N × 3 × 13, by forward sensitivities."""
    u, v, r = start[0], start[1], start[2]
    du, dv, dr = np.zeros(13), np.zeros(13), np.zeros(13)
    for k in range(tau.shape[0]):
        uu, vv, rr = 1.0 + x[0] + 2.0 * x[1] * abs(u), 1.0 + x[4], 1.0 + x[7]
        uv, ur, vu, vr, ru, rv = x[2] * r, x[2] * v, x[5] * r, x[5] * u, x[8] * v, x[8] * u
        for i in range(13):
            a, b, c = du[i], dv[i], dr[i]
            du[i] = uu * a + uv * b + ur * c
            dv[i] = vu * a + vv * b + vr * c
            dr[i] = ru * a + rv * b + rr * c
        du[0] += u
        du[1] += u * abs(u)
        du[2] += v * r
        du[3] += tau[k, 0]
        dv[4] += v
        dv[5] += u * r
        dv[6] += tau[k, 1]
        dr[7] += r
        dr[8] += u * v
        dr[9] += tau[k, 2]
        du[10] += 1.0
        dv[11] += 1.0
        dr[12] += 1.0
        for i in range(13):
            out[k, 0, i] = weights[0] * du[i]
            out[k, 1, i] = weights[1] * dv[i]
            out[k, 2, i] = weights[2] * dr[i]
        a = u + (x[0] + x[1] * abs(u)) * u + x[2] * v * r + x[3] * tau[k, 0] + x[10]
        b = v + x[4] * v + x[5] * u * r + x[6] * tau[k, 1] + x[11]
        r = r + x[7] * r + x[8] * u * v + x[9] * tau[k, 2] + x[12]
        u, v = a, b


class OutputError:
    """Our realizations, ready to be fitted and timed; checked against our estimates."""

    def __init__(self, file: Path) -> None:
        told = json.loads(file.read_text())
        self.start = np.array(told["initial"])
        self.tau = np.array(told["inputs"]).reshape(-1, 3)
        self.measured = [np.array(run["measured"]).reshape(-1, 3) for run in told["runs"]]
        self.starts = [np.concatenate([run["start"], np.zeros(3)]) for run in told["runs"]]
        for run, (y, x) in enumerate(zip(self.measured, self.starts)):
            fitted = told["runs"][run]["fitted"]
            if fitted is None:
                continue
            away = np.abs(self.fit(y, x)[:10] - fitted["parameters"]) / fitted["standard_errors"]
            if not np.max(away) < AGREEMENT:
                raise SystemExit(f"realization {run}: {np.max(away):.1e} standard errors from our estimate")

    def fit(self, y: Floats, x: Floats) -> Floats:
        """Ten parameters and three intercepts at the minimum."""
        n = len(self.tau)
        errors, slopes = np.empty((n, 3)), np.empty((n, 3, 13))
        flat, matrix = errors.reshape(-1), slopes.reshape(-1, 13)
        weights = np.ones(3)

        def residuals(x: Floats) -> Floats:
            _errors(x, self.start, self.tau, y, weights, errors)
            return flat

        def jacobian(x: Floats) -> Floats:
            _slopes(x, self.start, self.tau, weights, slopes)
            return matrix

        enough = DECREMENT / np.sqrt(3.0 * n)
        # The first weights are far from the last: no need to go far with them.
        tolerance = FIRST
        for _ in range(ROUNDS):
            residuals(x)
            change = 1.0 / np.sqrt(np.mean(errors**2, axis=0))
            weights *= change
            if tolerance == enough and np.max(np.abs(change - 1.0)) < STEADY:
                return x
            found = least_squares(
                residuals, x, jac=jacobian, method="lm", x_scale="jac", gtol=tolerance, xtol=1e-15, ftol=1e-15
            )
            x, tolerance = found.x, enough
        raise SystemExit(f"least_squares: no minimum after {ROUNDS} rounds of weights")

    def best_seconds(self) -> float:
        """Seconds per realization: the best of TIMINGS passes over all."""
        best = np.inf
        for _ in range(TIMINGS):
            clock = time.perf_counter()
            for y, x in zip(self.measured, self.starts):
                self.fit(y, x)
            best = min(best, time.perf_counter() - clock)
        return float(best / len(self.starts))
