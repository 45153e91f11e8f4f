"""Independent computation of the average of several models, for the `oracle_*` tests of `validation`.

    python scripts/independent/average.py --out fixtures/oracle/average.json

Needs numpy. Each model is simulated row by row in plain numbers, all trajectories are stacked, and numpy takes mean, standard
deviation, errors and shares over the stack.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

TERMS = {
    "u": lambda u, v, r, a, b: u,
    "u |u|": lambda u, v, r, a, b: u * abs(u),
    "a": lambda u, v, r, a, b: a,
    "v": lambda u, v, r, a, b: v,
    "u r": lambda u, v, r, a, b: u * r,
    "r": lambda u, v, r, a, b: r,
    "b": lambda u, v, r, a, b: b,
}
MODELS = [
    {"surge": {"u": -0.1, "a": 0.05}, "sway": {"v": -0.2, "u r": -0.3}, "yaw": {"r": -0.3, "b": 0.04}},
    {"surge": {"u": -0.08, "u |u|": -0.05, "a": 0.06}, "sway": {"v": -0.25}, "yaw": {"r": -0.28, "b": 0.05}},
    {"surge": {"u": -0.12, "a": 0.04}, "sway": {"v": -0.15, "u r": -0.2}, "yaw": {"r": -0.35, "u r": 0.02, "b": 0.04}},
]
RMSE = [0.02, 0.015, 0.01]


def simulated(model: dict, start: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    rows = [start]
    for a, b in inputs:
        u, v, r = rows[-1]
        gained = [sum(c * TERMS[term](u, v, r, a, b) for term, c in model[d].items()) for d in ("surge", "sway", "yaw")]
        rows.append(rows[-1] + gained)
    return np.array(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="file to write")
    out = parser.parse_args().out
    random = np.random.default_rng(31)
    runs = []
    for samples in (25, 40):
        inputs = np.round(1.0 + random.standard_normal((samples, 2)), 6)
        clean = simulated(MODELS[0], np.array([0.4, 0.1, -0.05]), inputs)
        runs.append((inputs, np.round(clean + 0.03 * random.standard_normal(clean.shape), 6)))
    stacks = [np.array([simulated(model, y[0], x) for model in MODELS]) for x, y in runs]
    means = [stack.mean(axis=0) for stack in stacks]
    spreads = [stack.std(axis=0, ddof=1) for stack in stacks]
    errors = np.concatenate([y[1:] - mean[1:] for (_, y), mean in zip(runs, means)])
    spread = np.concatenate([own[1:] for own in spreads])
    half = 1.959963984540054 * np.sqrt(spread**2 + np.array(RMSE) ** 2)
    document = {
        "models": MODELS,
        "output_rmse": RMSE,
        "runs": [{"inputs": x.ravel().tolist(), "measured": y.ravel().tolist()} for x, y in runs],
        "mean": np.concatenate(means).ravel().tolist(),
        "half": (
            1.959963984540054 * np.sqrt(np.concatenate(spreads) ** 2 + np.array(RMSE) ** 2)
        ).ravel().tolist(),
        "rmse": np.sqrt((errors**2).mean(axis=0)).tolist(),
        "bias": errors.mean(axis=0).tolist(),
        "spread": np.sqrt((spread**2).mean(axis=0)).tolist(),
        "inside": (abs(errors) <= half).mean(axis=0).tolist(),
        "inside_alone": (abs(errors) <= 1.959963984540054 * spread).mean(axis=0).tolist(),
    }
    out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
