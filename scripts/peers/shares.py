"""The design problem with Q = 11 in scipy: SLSQP with an analytic gradient, all matrices in one array."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from independent.moments import maneuver_moments
from independent.study import read_study

SOLVES = 20


class Shares:
    """maximise Σ_d log|det Σ_q w_q M_d,q| over the simplex, M_d,q with intercepts (complete mean removal)."""

    def __init__(self, folder: Path) -> None:
        study = read_study(folder)
        per_maneuver = [maneuver_moments(study, i) for i in range(len(study.maneuvers))]
        blocks = [[m.lifted() for m in degrees] for degrees in per_maneuver]
        widest = max(b.shape[0] for b in blocks[0])
        self.count = len(blocks)
        self.dimension = sum(b.shape[0] for b in blocks[0])
        # Smaller blocks are filled up with a unit diagonal, which adds nothing to the determinant of a mixture and
        # one per block to every sensitivity.
        stacked = np.zeros((self.count, len(blocks[0]), widest, widest))
        for q, degrees in enumerate(blocks):
            for d, block in enumerate(degrees):
                n = block.shape[0]
                stacked[q, d, :n, :n] = block
                stacked[q, d, range(n, widest), range(n, widest)] = 1.0
        self.filled = sum(widest - b.shape[0] for b in blocks[0])
        self.shape = stacked.shape[1:]
        self.flat = stacked.reshape(self.count, -1)
        self.turned = np.ascontiguousarray(stacked.transpose(0, 1, 3, 2).reshape(self.count, -1))
        self.bounds = [(0.0, 1.0)] * self.count
        ones = np.ones(self.count)
        self.constraint = {"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": lambda w: ones}

    def negative(self, w: np.ndarray) -> tuple[float, np.ndarray]:
        """Criterion and gradient, both negated."""
        mixture = (w @ self.flat).reshape(self.shape)
        inverse = np.linalg.inv(mixture)
        return -np.linalg.slogdet(mixture)[1].sum(), -(self.turned @ inverse.reshape(-1))

    def solve(self) -> np.ndarray:
        """Shares from equal shares."""
        start = np.full(self.count, 1.0 / self.count)
        found = minimize(
            self.negative,
            start,
            jac=True,
            method="SLSQP",
            bounds=self.bounds,
            constraints=self.constraint,
            options={"ftol": 1e-14, "maxiter": 1000},
        )
        return np.asarray(found.x)

    def relative_gap(self, w: np.ndarray) -> float:
        """(max g_q − p) / p at shares brought back to the simplex."""
        w = np.maximum(w, 0.0) / np.maximum(w, 0.0).sum()
        g = -self.negative(w)[1] - self.filled
        return float(g.max() / self.dimension - 1.0)

    def best_seconds(self) -> tuple[float, float]:
        """Seconds of the fastest of SOLVES solves, and the relative gap that it leaves."""
        best, w = float("inf"), np.empty(0)
        for _ in range(SOLVES):
            clock = time.perf_counter()
            w = self.solve()
            best = min(best, time.perf_counter() - clock)
        return best, self.relative_gap(w)
