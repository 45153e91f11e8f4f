"""Criteria of the covariance of instrumental-variable estimates, for the tests `oracle_*` of the covariance.

    python scripts/independent/criteria.py --study pipelines/paper --fixtures fixtures/oracle

Writes criteria.json: B per maneuver, and shares that make D, A, relative A and E of the covariance smallest. Another way
than the workspace's throughout: the residual's whole covariance matrix from a matrix of its coefficients, slopes by
central differences, shares by SLSQP from many starts with numerical gradients.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any, Callable

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402  (one thread is asked for first)
from scipy.optimize import minimize  # noqa: E402

from independent.moments import maneuver_moments  # noqa: E402
from independent.motion import realize, regressors, simulate  # noqa: E402
from independent.study import Study, read_study  # noqa: E402
from independent.text import pretty  # noqa: E402

STEP = 1e-6
"""Of central differences [m/s, rad/s]."""

STARTS = 12

FAR = 1e3
"""What shares that identify nothing count as."""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True, help="folder with vessel, dictionary and campaign")
    parser.add_argument("--fixtures", type=Path, required=True, help="folder to write to")
    arguments = parser.parse_args()
    study = read_study(arguments.study)
    count = len(study.maneuvers)
    a = [[m.lifted().T for m in maneuver_moments(study, q)] for q in range(count)]
    b = [middle(study, q) for q in range(count)]
    document = {
        "conventions": CONVENTIONS,
        "B": [[matrix.reshape(-1).tolist() for matrix in degrees] for degrees in b],
        "criteria": {name: criterion_entry(study, a, b, f) for name, f in criteria(study).items()},
    }
    path = arguments.fixtures / "criteria.json"
    path.write_text(pretty(document) + "\n")


CONVENTIONS = {
    "B": "per maneuver and degree of freedom (1/N) Σ ζ̃ E[εε] ζ̃ᵀ, row-major, intercept last",
    "criteria": "shares in the order of the maneuvers; value for one sample: d: Σ_d log det cov θ̂_d, a: Σ var, a-relative: "
    "Σ var/θ²; standard_errors for one sample, surge first",
}


def middle(study: Study, index: int) -> list[np.ndarray]:
    """B of maneuver `index`, per degree of freedom: ζ̃ᵀ E[εεᵀ] ζ̃ / N."""
    vessel = study.vessel
    initial, inputs = realize(study, index, study.samples)
    truth = simulate(vessel, vessel.value, initial, inputs)
    nominal = regressors(vessel, simulate(vessel, vessel.nominal, initial, inputs), inputs)
    n = len(inputs)
    out = []
    for degree, zeta in enumerate(nominal):
        lifted = np.column_stack([zeta, np.ones(n)])
        noise = residual_covariance(study, degree, truth[:n], inputs)
        out.append(lifted.T @ noise @ lifted / n)
    return out


def residual_covariance(study: Study, degree: int, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """E[εεᵀ], N × N: rows of coefficients of all draws of the errors (N + 1 each) and the current (N each)."""
    n = len(inputs)
    total = np.zeros((n, n))
    for state in range(3):
        slope = np.diag(slopes(study, degree, state, states, inputs))
        error = np.zeros((n, n + 1))
        error[:, :n] -= slope
        if state == degree:
            error[:, 1:] += np.eye(n)
            error[:, :n] -= np.eye(n)
        total += study.measurement_std[state] ** 2 * error @ error.T
        if state < 2:
            total += study.current_std**2 * slope @ slope.T
    return total


def slopes(study: Study, degree: int, state: int, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """∂(φᵀθ)/∂(state) at every sample."""
    theta = np.array(study.vessel.value[degree])
    moved = []
    for sign in (1.0, -1.0):
        at = states.copy()
        at[:, state] += sign * STEP
        moved.append(regressors(study.vessel, at, inputs)[degree] @ theta)
    return (moved[0] - moved[1]) / (2.0 * STEP)


Blocks = list[np.ndarray]


def criteria(study: Study) -> dict[str, Callable[[Blocks], float]]:
    """What is made small, of the covariance blocks without intercepts."""
    squares = np.array(study.vessel.truth) ** 2
    variances: Callable[[Blocks], np.ndarray] = lambda blocks: np.concatenate([np.diag(c) for c in blocks])
    return {
        "d": lambda blocks: float(sum(np.linalg.slogdet(c)[1] for c in blocks)),
        "a": lambda blocks: float(variances(blocks).sum()),
        "a-relative": lambda blocks: float((variances(blocks) / squares).sum()),
    }


def criterion_entry(
    study: Study, a: list[list[np.ndarray]], b: list[list[np.ndarray]], criterion: Callable[[Blocks], float]
) -> dict[str, Any]:
    stacked = [[np.array(side) for side in zip(*of)] for of in (a, b)]

    def covariance(w: np.ndarray) -> Blocks:
        blocks = []
        for a_q, b_q in zip(*stacked):
            inverse = np.linalg.inv(np.tensordot(w, a_q, 1))
            blocks.append((inverse @ np.tensordot(w, b_q, 1) @ inverse.T)[:-1, :-1])
        return blocks

    positive = criterion(covariance(np.full(len(a), 1.0 / len(a)))) > 0.0

    def objective(w: np.ndarray) -> float:
        try:
            value = criterion(covariance(w))
        except np.linalg.LinAlgError:
            return FAR
        return float(np.log(value)) if positive else value

    rng = np.random.default_rng(11)
    points = [np.full(len(a), 1.0 / len(a))] + [rng.dirichlet(np.ones(len(a))) for _ in range(STARTS - 1)]
    found = [_search(objective, point) for point in points]
    best = min(found, key=objective)
    agreeing = sum(abs(objective(w) - objective(best)) < 1e-6 for w in found)
    blocks = covariance(best)
    print(f"{objective(best):.9f}: {agreeing}/{STARTS} starts", file=sys.stderr)
    return {
        "shares": best.tolist(),
        "value": criterion(blocks),
        "value_equal_shares": criterion(covariance(points[0])),
        "standard_errors": np.sqrt(np.concatenate([np.diag(c) for c in blocks])).tolist(),
        "starts": STARTS,
        "agreeing_starts": agreeing,
    }


def _search(objective: Callable[[np.ndarray], float], start: np.ndarray) -> np.ndarray:
    """SLSQP, started again at what it found until that is no better."""
    w, value = start, objective(start)
    for _ in range(6):
        found = minimize(
            objective,
            w,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(w),
            constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0, "jac": np.ones_like},
            options={"ftol": 1e-15, "maxiter": 1000},
        )
        shares = np.maximum(found.x, 0.0) / np.maximum(found.x, 0.0).sum()
        if objective(shares) >= value - 1e-12:
            break
        w, value = shares, objective(shares)
    return w


if __name__ == "__main__":
    main()
