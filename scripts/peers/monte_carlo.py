"""The Monte Carlo loop of the paper in numba: one realization after the other, one thread.

The instruments, which all realizations share, once. Per realization: white current and measurement noise, the
simulated run, the instrumental-variable estimate with complete mean removal (an intercept), the free simulation
over the validation input, parameter and simulation error. Columns lie one after the other in memory, so that every sum
over the samples is a vectorised pass.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from independent.motion import realize, simulate, steady_inputs
from independent.study import Study, read_study

from .degree import four, instruments, intercept_row, invert, solved, three

# A whole-sample rounding of the optimal shares over 1000 samples.
COUNTS = {
    "decelerate": 193,
    "zig-zag-fast-flat": 43,
    "zig-zag-slow-steep": 229,
    "zig-zag-moderate-steep": 101,
    "zig-zag-fast-steep": 85,
    "spiral-fast": 349,
}
BATCH = 500
BATCHES = 5
Floats = NDArray[np.float64]


@njit(fastmath=True)
def _states(p, start, tau, out):  # type: ignore[no-untyped-def]
    """States, 3 × (N+1), in still water."""
    u, v, r = start[0], start[1], start[2]
    for k in range(tau.shape[1]):
        out[0, k], out[1, k], out[2, k] = u, v, r
        a = u + (p[0] + p[1] * abs(u)) * u + p[2] * v * r + p[3] * tau[0, k]
        b = v + p[4] * v + p[5] * u * r + p[6] * tau[1, k]
        r = r + p[7] * r + p[8] * u * v + p[9] * tau[2, k]
        u, v = a, b
    n = tau.shape[1]
    out[0, n], out[1, n], out[2, n] = u, v, r


@njit(fastmath=True)
def _measured(rng, p, start, tau, s_current, s, out):  # type: ignore[no-untyped-def]
    """Measured states, 3 × (N+1), under a white current."""
    u, v, r = start[0], start[1], start[2]
    n = tau.shape[1]
    for k in range(n):
        out[0, k] = u + s[0] * rng.standard_normal()
        out[1, k] = v + s[1] * rng.standard_normal()
        out[2, k] = r + s[2] * rng.standard_normal()
        ur = u - s_current * rng.standard_normal()
        vr = v - s_current * rng.standard_normal()
        u += (p[0] + p[1] * abs(ur)) * ur + p[2] * vr * r + p[3] * tau[0, k]
        v += p[4] * vr + p[5] * ur * r + p[6] * tau[1, k]
        r += p[7] * r + p[8] * ur * vr + p[9] * tau[2, k]
    out[0, n] = u + s[0] * rng.standard_normal()
    out[1, n] = v + s[1] * rng.standard_normal()
    out[2, n] = r + s[2] * rng.standard_normal()


@njit(fastmath=True)
def _products(x, out):  # type: ignore[no-untyped-def]
    """The nonlinear regressors u|u|, v r, u r, u v, 4 × N."""
    for k in range(out.shape[1]):
        u, v, r = x[0, k], x[1, k], x[2, k]
        out[0, k], out[1, k], out[2, k], out[3, k] = u * abs(u), v * r, u * r, u * v


@njit(fastmath=True)
def _surge(phi, zeta, target, near, work, theta):  # type: ignore[no-untyped-def]
    a, inverse, b = work[0], work[1], work[2, 0]
    for i in range(4):
        four(zeta[i], phi[0], phi[1], phi[2], target, a, near, b, i)
    intercept_row(phi, target, a, near, b)
    invert(a, 5, inverse)
    solved(4, inverse, b, theta)


@njit(fastmath=True)
def _sway_or_yaw(phi, zeta, target, near, work, theta):  # type: ignore[no-untyped-def]
    a, inverse, b = work[0], work[1], work[2, 0]
    for i in range(3):
        three(zeta[i], phi[0], phi[1], target, a, near, b, i)
    intercept_row(phi, target, a, near, b)
    invert(a, 4, inverse)
    solved(3, inverse, b, theta)


@njit(fastmath=True)
def realizations(  # type: ignore[no-untyped-def]
    rng, count, truth, nominal, start, tau, s_current, s, v_start, v_tau, v_truth, out
):
    """`count` realizations; out count × 2: parameter error, simulation error."""
    n = tau.shape[1]
    y, z, free = np.empty((3, n + 1)), np.empty((3, n + 1)), np.empty((3, v_tau.shape[1] + 1))
    f, g, target = np.empty((4, n)), np.empty((4, n)), np.empty((3, n))
    theta, work, near = np.empty(10), np.empty((3, 5, 5)), np.empty((3, 5, 5))
    # Start and inputs are the same in all realizations, and so are the instruments.
    _states(nominal, start, tau, z)
    _products(z, g)
    instruments((z[0, :n], g[0], g[1], tau[0]), near[0])
    for d in range(1, 3):
        instruments((z[d, :n], g[d + 1], tau[d]), near[d])
    for row in range(count):
        _measured(rng, truth, start, tau, s_current, s, y)
        _products(y, f)
        for d in range(3):
            for k in range(n):
                target[d, k] = y[d, k + 1] - y[d, k]
        phi, zeta = (y[0, :n], f[0], f[1], tau[0]), (z[0, :n], g[0], g[1], tau[0])
        _surge(phi, zeta, target[0], near[0], work, theta[:4])
        for d in range(1, 3):
            phi3, zeta3 = (y[d, :n], f[d + 1], tau[d]), (z[d, :n], g[d + 1], tau[d])
            _sway_or_yaw(phi3, zeta3, target[d], near[d], work, theta[3 * d + 1 :])
        _states(theta, v_start, v_tau, free)
        parameter, simulation = 0.0, 0.0
        for i in range(10):
            parameter += ((theta[i] - truth[i]) / truth[i]) ** 2
        for d in range(3):
            for k in range(1, free.shape[1]):
                simulation += (free[d, k] - v_truth[d, k]) ** 2
        out[row, 0], out[row, 1] = np.sqrt(parameter), np.sqrt(simulation / v_tau.shape[1])


class MonteCarlo:
    """The study's optimized experiment, compiled and ready to be timed."""

    def __init__(self, folder: Path) -> None:
        study = read_study(folder)
        vessel = study.vessel
        start, inputs = experiment(study)
        v_start, v_inputs = telegraph(study)
        v_truth = simulate(vessel, vessel.value, v_start, v_inputs)
        flat = lambda parts: np.array([x for part in parts for x in part])  # noqa: E731
        self.rng = np.random.Generator(np.random.SFC64(1))
        self.fixed = (flat(vessel.value), flat(vessel.nominal), np.array(start), _columns(inputs), study.current_std)
        self.fixed += (np.array(study.measurement_std), np.array(v_start), _columns(v_inputs), _columns(v_truth))
        self.run(2)

    def run(self, count: int) -> Floats:
        """`count` realizations, count × 2."""
        out = np.empty((count, 2))
        realizations(self.rng, count, *self.fixed, out)
        return out

    def best_rate(self) -> float:
        """Realizations per second and core: the best of BATCHES batches."""
        best = 0.0
        for _ in range(BATCHES):
            clock = time.perf_counter()
            self.run(BATCH)
            best = max(best, BATCH / (time.perf_counter() - clock))
        return best


def _columns(rows: Floats) -> Floats:
    return np.ascontiguousarray(rows.T)


def experiment(study: Study) -> tuple[tuple[float, float, float], Floats]:
    """Start state and inputs N × 3 of the optimized experiment, the maneuvers in the dictionary's order."""
    used = [(i, COUNTS[m["name"]]) for i, m in enumerate(study.maneuvers) if m["name"] in COUNTS]
    parts = [realize(study, index, samples) for index, samples in used]
    return parts[0][0], np.concatenate([inputs for _, inputs in parts])


def telegraph(study: Study, samples: int = 1000, dwell: int = 80) -> tuple[tuple[float, float, float], Floats]:
    """A validation input: speed and yaw rate switch at random between two levels each."""
    rng = np.random.default_rng(1)
    signs = rng.choice([-1.0, 1.0], (samples // dwell + 1, 2))
    held = [steady_inputs(study.vessel, study.vessel.value, 0.6 + 0.3 * a, None, 0.3 * b) for a, b in signs]
    return (0.6, 0.0, 0.0), np.array([held[k // dwell] for k in range(samples)])
