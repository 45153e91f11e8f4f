"""What output-error estimates learn from maneuvers, and designs for them, for the tests `oracle_*` of the same.

    python scripts/independent/output_information.py --study pipelines/paper --fixtures fixtures/oracle

Writes output_information.json: F, P and G, and shares that make criteria of F⁻¹(F + P)F⁻¹ smallest. Another way than the
workspace's throughout: sensitivities by central differences of whole simulations, P from what every single draw of the
current moves, shares by SLSQP from many starts with numerical gradients.
"""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from pathlib import Path
from typing import Any, Callable

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402  (one thread is asked for first)

from independent.criteria import _search  # noqa: E402
from independent.motion import increments, realize  # noqa: E402
from independent.study import STATES, Study, Vessel, read_study  # noqa: E402
from independent.text import pretty  # noqa: E402

STEP = 1e-6
"""Of central differences: relative to a parameter, or of a current [m/s]."""

INTERCEPT_STEP = 1e-8

STARTS = 6

FAR = 1e3
"""What shares that identify nothing count as."""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True, help="folder with vessel, dictionary and campaign")
    parser.add_argument("--fixtures", type=Path, required=True, help="folder to write to")
    arguments = parser.parse_args()
    study = read_study(arguments.study)
    found = [information(study, q) for q in range(len(study.maneuvers))]
    f, p = (np.array(side) for side in zip(*found))
    kept = parameter_rows(study.vessel)
    # The validation input is the first maneuver here: any input serves the comparison.
    weights = prediction(study, 0)
    document = {
        "conventions": CONVENTIONS,
        "F": [matrix.reshape(-1).tolist() for matrix in f],
        "P": [matrix.reshape(-1).tolist() for matrix in p],
        "G": weights.reshape(-1).tolist(),
        "criteria": {
            noise: {name: entry(f, f + p if noise == "all" else f, c) for name, c in criteria(study, kept, weights).items()}
            for noise in ("all", "measurement")
        },
    }
    path = arguments.fixtures / "output_information.json"
    path.write_text(pretty(document) + "\n")


CONVENTIONS = {
    "F": "per maneuver (1/N) Σ_k Σ_d s_d s_dᵀ/variance_d, row-major, rows: surge's parameters and intercept, sway's, yaw's",
    "P": "per maneuver what a current of the campaign's standard deviation adds to the middle matrix, as F",
    "G": "(1/N) Σ_k Σ_d s_d s_dᵀ of the first maneuver, rows and columns of intercepts zero",
    "criteria": "shares in the order of the maneuvers; value for one sample: d: log det of the parameters' covariance, a-relative: "
    "Σ var/θ², v: tr(C G); noise: measurement alone or all",
}


def parameter_rows(vessel: Vessel) -> list[int]:
    rows, place = [], 0
    for names in vessel.names:
        rows += range(place, place + len(names))
        place += len(names) + 1
    return rows


def moved(vessel: Vessel, lifted: np.ndarray, initial: tuple[float, float, float], inputs: np.ndarray) -> np.ndarray:
    """States (N+1) × 3 of the model with an intercept in every increment."""
    theta, intercepts, place = [], [], 0
    for names in vessel.names:
        theta.append(tuple(lifted[place : place + len(names)]))
        intercepts.append(lifted[place + len(names)])
        place += len(names) + 1
    states = [np.array(initial, dtype=float)]
    for row in inputs.tolist():
        values = dict(zip(STATES, states[-1])) | dict(zip(vessel.inputs, row))
        states.append(states[-1] + np.array(increments(vessel, tuple(theta), values)) + intercepts)
    return np.array(states)


def sensitivities(study: Study, index: int) -> np.ndarray:
    """∂x_d(k)/∂θ̃, N × 3 × n, k = 1 to N."""
    vessel = study.vessel
    initial, inputs = realize(study, index, study.samples)
    lifted = np.concatenate([[*values, 0.0] for values in vessel.value])
    columns = []
    for place, value in enumerate(lifted):
        step = STEP * abs(value) if value != 0.0 else INTERCEPT_STEP
        sides = []
        for sign in (1.0, -1.0):
            at = lifted.copy()
            at[place] += sign * step
            sides.append(moved(vessel, at, initial, inputs)[1:])
        columns.append((sides[0] - sides[1]) / (2.0 * step))
    return np.stack(columns, axis=-1)


def information(study: Study, index: int) -> tuple[np.ndarray, np.ndarray]:
    """F and P of a maneuver."""
    s = sensitivities(study, index)
    samples, _, n = s.shape
    weighted = s / np.square(study.measurement_std)[None, :, None]
    f = np.einsum("kdi,kdj->ij", s, weighted) / samples
    # All draws side by side: column l is a simulation in which draw l alone is not zero.
    initial, inputs = realize(study, index, study.samples)
    p = np.zeros((n, n))
    for component in range(2):
        shift = np.zeros((samples, 2, samples))
        shift[np.arange(samples), component, np.arange(samples)] = STEP
        change = (drifting(study, initial, inputs, shift) - drifting(study, initial, inputs, -shift)) / (2.0 * STEP)
        g = np.einsum("kdi,kdl->li", weighted, change)
        p += study.current_std**2 * g.T @ g / samples
    return f, p


def drifting(
    study: Study, initial: tuple[float, float, float], inputs: np.ndarray, current: np.ndarray
) -> np.ndarray:
    """States, N × 3 × draws, under currents N × 2 × draws."""
    vessel = study.vessel
    states = np.repeat(np.array(initial, dtype=float)[:, None], current.shape[2], axis=1)
    out = []
    for k, row in enumerate(inputs.tolist()):
        values: dict[str, Any] = {"u": states[0] - current[k, 0], "v": states[1] - current[k, 1], "r": states[2]}
        values |= dict(zip(vessel.inputs, row))
        states = states + np.array(increments(vessel, vessel.value, values))
        out.append(states)
    return np.array(out)


def prediction(study: Study, index: int) -> np.ndarray:
    """G of a maneuver."""
    s = sensitivities(study, index)
    weights = np.einsum("kdi,kdj->ij", s, s) / len(s)
    keep = np.zeros(len(weights))
    keep[parameter_rows(study.vessel)] = 1.0
    return weights * np.outer(keep, keep)


def criteria(study: Study, kept: list[int], weights: np.ndarray) -> dict[str, Callable[[np.ndarray], float]]:
    squares = np.array(study.vessel.truth) ** 2
    own = np.ix_(kept, kept)
    return {
        "d": lambda c: float(np.linalg.slogdet(c[own])[1]),
        "a-relative": lambda c: float((np.diag(c[own]) / squares).sum()),
        "v": lambda c: float(np.trace(c @ weights)),
    }


def entry(f: np.ndarray, b: np.ndarray, criterion: Callable[[np.ndarray], float]) -> dict[str, Any]:
    scale = 1.0 / np.sqrt(np.diag(f.mean(axis=0)))

    def covariance(w: np.ndarray) -> np.ndarray:
        inverse = np.linalg.inv(np.tensordot(w, f, 1) * np.outer(scale, scale)) * np.outer(scale, scale)
        return inverse @ np.tensordot(w, b, 1) @ inverse

    positive = criterion(covariance(np.full(len(f), 1.0 / len(f)))) > 0.0

    def objective(w: np.ndarray) -> float:
        try:
            value = criterion(covariance(w))
        except np.linalg.LinAlgError:
            return FAR
        return float(np.log(value)) if positive and value > 0.0 else value if not positive else FAR

    rng = np.random.default_rng(11)
    points = [np.full(len(f), 1.0 / len(f))] + [rng.dirichlet(np.ones(len(f))) for _ in range(STARTS - 1)]
    found = [_search(objective, point) for point in points]
    best = min(found, key=objective)
    agreeing = sum(abs(objective(w) - objective(best)) < 1e-6 for w in found)
    print(f"{objective(best):.9f}: {agreeing}/{STARTS} starts", file=sys.stderr)
    return {
        "shares": best.tolist(),
        "value": criterion(covariance(best)),
        "value_equal_shares": criterion(covariance(points[0])),
        "starts": STARTS,
        "agreeing_starts": agreeing,
    }


if __name__ == "__main__":
    main()
