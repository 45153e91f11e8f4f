"""Independent computation of pooled estimates on a small synthetic data set, for the tests named `oracle_*`.

    python scripts/independent/pooled.py --out fixtures/oracle/pooled.json

Needs numpy and scipy. It shares no code with the workspace and goes another way where there is one: intercepts are
columns of ones per part or for all, the prior is a stacked least-squares problem, the sandwich is written with the whole
matrix of Bartlett's weights, Shea's partial R^2 with explicit residuals.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, Callable

import numpy as np
from scipy import stats

VESSEL = """
name = "small craft"
sample_rate_hz = 1.0
[[input]]
name = "n"
unit = "1/s"
[[input]]
name = "delta"
unit = "rad"
[[surge]]
parameter = "X_u"
term = "u |u|"
nominal = -0.05
[[surge]]
parameter = "X_vr"
term = "v r"
nominal = 0.5
[[surge]]
parameter = "X_n"
term = "n |n|"
nominal = 0.008
[[sway]]
parameter = "Y_v"
term = "v"
nominal = -0.2
[[sway]]
parameter = "Y_ur"
term = "u r"
nominal = -0.2
[[yaw]]
parameter = "N_r"
term = "r"
nominal = -0.25
[[yaw]]
parameter = "N_uv"
term = "u v"
nominal = -0.05
[[yaw]]
parameter = "N_delta"
term = "u^2 delta"
nominal = 0.08
"""
TRUTH = [[-0.06, 0.7, 0.01], [-0.25, -0.3], [-0.2, -0.08, 0.1]]
NOMINAL = [[-0.05, 0.5, 0.008], [-0.2, -0.2], [-0.25, -0.05, 0.08]]
STEADY = [0.003, -0.001, 0.0005]
TERMS: list[list[Callable[..., np.ndarray]]] = [
    [lambda u, v, r, n, d: u * abs(u), lambda u, v, r, n, d: v * r, lambda u, v, r, n, d: n * abs(n)],
    [lambda u, v, r, n, d: v, lambda u, v, r, n, d: u * r],
    [lambda u, v, r, n, d: r, lambda u, v, r, n, d: u * v, lambda u, v, r, n, d: u * u * d],
]
SAMPLES = (60, 45, 60, 52)
SOURCES = ("a", "a", "b", "c")
BANDWIDTH, LAGS, WINDOW, STRENGTH = 4, 5, 20, 0.03
Part = tuple[np.ndarray, np.ndarray]


def regressors(states: np.ndarray, inputs: np.ndarray) -> list[np.ndarray]:
    """Per degree of freedom N x p."""
    rows = (*states[: len(inputs)].T, *inputs.T)
    return [np.stack([term(*rows) for term in terms], axis=1) for terms in TERMS]


def simulate(theta: list[np.ndarray], intercept: list[float], start: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    states = [start]
    for row in inputs:
        phi = regressors(states[-1][None, :], row[None, :])
        states.append(states[-1] + np.array([phi[d][0] @ theta[d] + intercept[d] for d in range(3)]))
    return np.array(states)


def make_parts() -> list[Part]:
    """Square-wave rudder, sweeping propeller, steady force, coloured forces and white measurement noise."""
    rng = np.random.default_rng(20240611)
    parts = []
    for number, samples in enumerate(SAMPLES):
        k = np.arange(samples)
        n = 3.0 + 0.8 * np.sin(2 * np.pi * k / (31 + 5 * number)) + 0.3 * number
        delta = 0.3 * np.sign(np.sin(2 * np.pi * (k + 3 * number) / (17 + 4 * number)))
        inputs = np.round(np.stack([n, delta], axis=1), 6)
        state, force, states = np.array([1.2, 0.0, 0.0]), np.zeros(3), []
        for row in inputs:
            states.append(state)
            phi = regressors(state[None, :], row[None, :])
            force = 0.6 * force + rng.normal(0, [0.004, 0.002, 0.001])
            state = state + np.array([phi[d][0] @ np.array(TRUTH[d]) + STEADY[d] for d in range(3)]) + force
        states.append(state)
        measured = np.round(np.array(states) + rng.normal(0, [0.004, 0.002, 0.001], (samples + 1, 3)), 6)
        parts.append((inputs, measured))
    return parts


def ones(parts: list[Part], removal: str) -> np.ndarray:
    """Columns of the intercepts."""
    lengths = [len(inputs) for inputs, _ in parts]
    if removal == "none":
        return np.zeros((sum(lengths), 0))
    if removal == "complete":
        return np.ones((sum(lengths), 1))
    owner = np.repeat(np.arange(len(parts)), lengths)
    return (owner[:, None] == np.arange(len(parts))).astype(float)


def stacked(parts: list[Part], states: list[np.ndarray]) -> list[np.ndarray]:
    per = [regressors(s, inputs) for (inputs, _), s in zip(parts, states)]
    return [np.concatenate([p[d] for p in per]) for d in range(3)]


def without(columns: np.ndarray, constant: np.ndarray) -> np.ndarray:
    """Columns without their means."""
    return columns if constant.shape[1] == 0 else columns - constant @ np.linalg.lstsq(constant, columns, rcond=None)[0]


def instruments(parts: list[Part], theta: list[np.ndarray], intercept: list[float]) -> list[np.ndarray]:
    return [simulate(theta, intercept, measured[0], inputs) for inputs, measured in parts]


def estimate(parts: list[Part], states: list[np.ndarray], removal: str) -> list[dict[str, Any]]:
    phi, zeta = stacked(parts, [m for _, m in parts]), stacked(parts, states)
    constant, found = ones(parts, removal), []
    for d in range(3):
        y = np.concatenate([np.diff(m[:, d]) for _, m in parts])
        wide_phi, wide_zeta = np.hstack([phi[d], constant]), np.hstack([zeta[d], constant])
        solution = np.linalg.solve(wide_zeta.T @ wide_phi, wide_zeta.T @ y)
        theta, level = solution[: phi[d].shape[1]], solution[phi[d].shape[1] :]
        residual = y - wide_phi @ solution
        found.append({
            "theta": theta,
            "intercept": float(np.mean(y - phi[d] @ theta)) if len(level) else 0.0,
            "residual": residual, "y": y, "phi": phi[d], "zeta": zeta[d], "constant": constant,
        })
    return found


def with_prior(fit: dict[str, Any], nominal: list[float]) -> np.ndarray:
    zeta, phi, y = without(fit["zeta"], fit["constant"]), without(fit["phi"], fit["constant"]), fit["y"]
    left, right = np.sqrt((zeta**2).sum(0)), np.sqrt((phi**2).sum(0))
    a, b = (zeta / left).T @ (phi / right), (zeta / left).T @ y
    rows = np.vstack([a, STRENGTH * np.eye(len(right))])
    target = np.concatenate([b, STRENGTH * np.array(nominal) * right])
    return np.linalg.lstsq(rows, target, rcond=None)[0] / right


def sandwich(fit: dict[str, Any], lengths: list[int]) -> np.ndarray:
    zeta, n = without(fit["zeta"], fit["constant"]), sum(lengths)
    k = np.arange(n)
    weights = np.clip(1 - np.abs(k[:, None] - k[None, :]) / (BANDWIDTH + 1), 0, None)
    owner = np.repeat(np.arange(len(lengths)), lengths)
    weights = weights * (owner[:, None] == owner[None, :])
    middle = zeta.T @ (weights * np.outer(fit["residual"], fit["residual"])) @ zeta
    inverse = np.linalg.inv(zeta.T @ fit["phi"])
    freedom = n - fit["phi"].shape[1] - fit["constant"].shape[1]
    return inverse @ middle @ inverse.T * n / freedom


def shea(fit: dict[str, Any]) -> list[float]:
    """Squared correlation of each regressor with its projection on the instruments, both without what the others tell."""
    phi, zeta = without(fit["phi"], fit["constant"]), without(fit["zeta"], fit["constant"])
    projected = zeta @ np.linalg.lstsq(zeta, phi, rcond=None)[0]
    partial = []
    for i in range(phi.shape[1]):
        others = np.delete(np.arange(phi.shape[1]), i)
        own = without(phi[:, [i]], phi[:, others])[:, 0]
        told = without(projected[:, [i]], projected[:, others])[:, 0]
        partial.append(float(np.dot(own, told) ** 2 / (np.dot(own, own) * np.dot(told, told))))
    return partial


def ljung_box(residual: np.ndarray, lengths: list[int]) -> dict[str, float]:
    parts = np.split(residual, np.cumsum(lengths)[:-1])
    n, q = len(residual), 0.0
    power = sum(float(p @ p) for p in parts)
    for lag in range(1, LAGS + 1):
        rho = sum(float(p[lag:] @ p[:-lag]) for p in parts) / power
        q += rho**2 / sum(len(p) - lag for p in parts)
    q *= n * (n + 2)
    return {"statistic": q, "p_value": float(stats.chi2.sf(q, LAGS))}


def index(fit: dict[str, Any]) -> float:
    zeta, phi = np.hstack([fit["zeta"], fit["constant"]]), np.hstack([fit["phi"], fit["constant"]])
    matrix = (zeta / np.sqrt((zeta**2).sum(0))).T @ (phi / np.sqrt((phi**2).sum(0)))
    return float(np.sqrt(np.linalg.cond(matrix)))


def cross_validation(parts: list[Part], estimator: str) -> dict[str, Any]:
    """Leaves each source out; RMSE over windows of WINDOW samples side by side from the start of each of its parts."""
    errors = []
    for source in sorted(set(SOURCES)):
        train = [p for p, s in zip(parts, SOURCES) if s != source]
        ls = estimate(train, [m for _, m in train], "complete")
        theta, level = [f["theta"] for f in ls], [f["intercept"] for f in ls]
        if estimator == "iv":
            iv = estimate(train, instruments(train, theta, level), "complete")
            theta, level = [f["theta"] for f in iv], [f["intercept"] for f in iv]
        for inputs, measured in (p for p, s in zip(parts, SOURCES) if s == source):
            for start in range(0, len(inputs) - WINDOW + 1, WINDOW):
                window = slice(start, start + WINDOW)
                simulated = simulate(theta, level, measured[start], inputs[window])
                errors.append(simulated[1:] - measured[start + 1 : start + WINDOW + 1])
    stacked_errors = np.concatenate(errors)
    return {"rmse": np.sqrt((stacked_errors**2).mean(0)).tolist(), "windows": len(errors)}


def entry(parts: list[Part], estimator: str, removal: str) -> dict[str, Any]:
    lengths = [len(inputs) for inputs, _ in parts]
    nominal = [np.array(n) for n in NOMINAL]
    states = [m for _, m in parts] if estimator == "ls" else instruments(parts, nominal, [0.0] * 3)
    fits = estimate(parts, states, removal)
    found = {
        "theta": [f["theta"].tolist() for f in fits],
        "intercept": [f["intercept"] for f in fits],
        "prior": [with_prior(f, n).tolist() for f, n in zip(fits, NOMINAL)],
        "covariance": [sandwich(f, lengths).reshape(-1).tolist() for f in fits],
        "strength": [shea(f) for f in fits],
        "whiteness": [ljung_box(f["residual"], lengths) for f in fits],
    }
    if removal != "batch":
        found["index"] = [index(f) for f in fits]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    parts = make_parts()
    document = {
        "conventions": "parts: inputs N x 2 and measured (N+1) x 3, row-major; instruments restart at each part's first "
        "measured state; per degree of freedom: surge, sway, yaw; covariance row-major, Bartlett weights, within parts",
        "vessel": VESSEL,
        "bandwidth": BANDWIDTH, "lags": LAGS, "window": WINDOW, "strength": STRENGTH,
        "nominal": [x for n in NOMINAL for x in n],
        "parts": [
            {"source": s, "inputs": i.reshape(-1).tolist(), "measured": m.reshape(-1).tolist()}
            for s, (i, m) in zip(SOURCES, parts)
        ],
        "fits": {e: {r: entry(parts, e, r) for r in ("none", "batch", "complete")} for e in ("ls", "iv")},
        "cross": {e: cross_validation(parts, e) for e in ("ls", "iv")},
        "chi_square": [[x, f, float(stats.chi2.sf(x, f))] for x, f in
                       ((0.5, 3), (3.8, 1), (18.3, 10), (100, 20), (30, 40), (2.0, 0.5), (7.0, 7))],
    }
    out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
