"""Independent estimates by free simulation, their covariance, and innovations of an extended Kalman filter.

    python scripts/independent/output_error.py --study pipelines/paper --fixtures fixtures/oracle

Writes output_error.json. Minimises with scipy.optimize.least_squares and numerical Jacobians; covariances by the response
to every single draw; a Kalman filter in plain matrices with numerical Jacobians. Shares no code with the workspace.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any, Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402
from scipy.stats import norm, t  # noqa: E402

from independent.motion import realize, simulate  # noqa: E402
from independent.study import Study, Vessel, read_study  # noqa: E402
from independent.text import pretty  # noqa: E402

SEED = 20250611
PLANS = (((0, 60), (5, 100), (7, 100), (10, 100)), ((1, 80), (6, 120), (10, 120)))
"""Maneuver of the dictionary and samples, one run each."""
REMOVALS = ("complete", "batch", "none")
MARKOV = {"std": 0.12, "time_constant_s": 6.0}
GUSTS = {"std": (0.01, 0.008, 0.006), "time_constant_s": 3.0}
"""Standard deviations of what a sample adds to u, v, r."""
BLOCKS = 10
STUDENT, NORMAL = t.ppf(0.975, BLOCKS - 1), norm.ppf(0.975)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True)
    parser.add_argument("--fixtures", type=Path, required=True)
    arguments = parser.parse_args()
    study = read_study(arguments.study)
    runs = [run_entry(study, number) for number in range(len(PLANS))]
    document = {
        "conventions": "theta: surge, sway, yaw; unknowns: theta, three intercepts, three offsets of the initial state; "
        "minimum of sum over states of log of the squared errors of samples 1 to N (0 to N with an offset); covariance to "
        "first order, white current and measurement noise of the study; innovations at the true parameters, N+1 rows",
        "measurement_std": list(study.measurement_std),
        "current_std": study.current_std,
        "markov": MARKOV,
        "gusts": GUSTS | {"std": list(GUSTS["std"])},
        "runs": runs,
    }
    arguments.fixtures.mkdir(parents=True, exist_ok=True)
    (arguments.fixtures / "output_error.json").write_text(pretty(document) + "\n")


def run_entry(study: Study, number: int) -> dict[str, Any]:
    vessel = study.vessel
    rng = np.random.default_rng([SEED, number])
    parts = [realize(study, index, samples) for index, samples in PLANS[number]]
    initial, inputs = parts[0][0], np.concatenate([part[1] for part in parts])
    current = study.current_std * rng.standard_normal((len(inputs), 2))
    states = simulate(vessel, vessel.value, initial, inputs, current)
    measured = states + np.array(study.measurement_std) * rng.standard_normal(states.shape)
    still = simulate(vessel, vessel.value, initial, inputs, np.zeros_like(current))
    known = minimum(vessel, initial, inputs, measured, False)
    offset = minimum(vessel, initial, inputs, measured, True)
    print(f"run {number}: {len(inputs)} samples, gradients {known[1]:.1e} {offset[1]:.1e}", file=sys.stderr)
    return {
        "initial": list(initial),
        "inputs": inputs.tolist(),
        "measured": measured.tolist(),
        "known": entry(known[0], vessel, initial, inputs, measured, False),
        "estimated": entry(offset[0], vessel, initial, inputs, measured, True),
        "standard_errors": standard_errors(study, known[0], initial, inputs, measured),
        "prefiltered": {removal: prefiltered(vessel, number, removal, inputs, measured, still) for removal in REMOVALS},
        "innovations": {kind: innovations(study, kind, initial, inputs, measured) for kind in ("white", "markov", "all")},
    }


def entry(x: np.ndarray, vessel: Vessel, initial: Any, inputs: np.ndarray, measured: np.ndarray, start: bool) -> dict[str, Any]:
    errors = measured - predicted(vessel, x[None, :], initial, inputs)[:, :, 0]
    counted = errors if start else errors[1:]
    return {"unknowns": x.tolist(), "rmse": np.sqrt(np.mean(counted**2, axis=0)).tolist()}


def predicted(
    vessel: Vessel,
    unknowns: np.ndarray,
    initial: Any,
    inputs: np.ndarray,
    current: np.ndarray | None = None,
) -> np.ndarray:
    """States (N+1) × 3 × m of m simulations side by side. `unknowns`: m × (parameters + 6). `current`: N × 2 × m."""
    count = sum(len(terms) for terms in vessel.terms)
    columns = unknowns.T
    state = np.array(initial)[:, None] + columns[count + 3 : count + 6]
    out = np.empty((len(inputs) + 1, 3, unknowns.shape[0]))
    out[0] = state
    for k, row in enumerate(inputs.tolist()):
        relative = state.copy()
        if current is not None:
            relative[:2] -= current[k]
        values = dict(zip(("u", "v", "r"), relative)) | dict(zip(vessel.inputs, row))
        change, first = columns[count : count + 3].copy(), 0
        for d, terms in enumerate(vessel.terms):
            for i, term in enumerate(terms):
                change[d] += columns[first + i] * term.value(values)
            first += len(terms)
        state = state + change
        out[k + 1] = state
    return out


def minimum(
    vessel: Vessel, initial: Any, inputs: np.ndarray, measured: np.ndarray, start: bool
) -> tuple[np.ndarray, float]:
    """Unknowns at the minimum, by least squares whose weights are those of its own errors, and the scaled gradient left."""
    truth = np.array(vessel.truth)
    free = len(truth) + (6 if start else 3)
    first = 0 if start else 1
    scale = np.concatenate([np.abs(truth), [1e-3] * 3, [1e-1] * 3])[:free]

    def whole(points: np.ndarray) -> np.ndarray:
        full = np.zeros((points.shape[0], len(truth) + 6))
        full[:, :free] = points * scale
        return full

    def errors(points: np.ndarray) -> np.ndarray:
        return measured[first:, :, None] - predicted(vessel, whole(points), initial, inputs)[first:]

    def jacobian(x: np.ndarray) -> np.ndarray:
        steps = 1e-5 * np.eye(free)
        # Fourth-order central differences.
        parts = [errors(x + h * steps) for h in (1.0, -1.0, 2.0, -2.0)]
        return (8.0 * (parts[0] - parts[1]) - (parts[2] - parts[3])) / (12.0 * 1e-5)

    x = np.concatenate([truth, np.zeros(free - len(truth))]) / scale
    weights = np.ones(3)
    for _ in range(200):
        def residual(p: np.ndarray) -> np.ndarray:
            return (errors(p[None, :])[:, :, 0] * weights).ravel()

        def slope(p: np.ndarray) -> np.ndarray:
            return (jacobian(p) * weights[None, :, None]).reshape(-1, free)

        found = least_squares(residual, x, jac=slope, method="lm", x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
        moved = float(np.max(np.abs(found.x - x)))
        x = found.x
        weights = 1.0 / np.sqrt(np.mean(errors(x[None, :])[:, :, 0] ** 2, axis=0))
        if moved < 1e-11:
            break
    gradient = slope(x).T @ residual(x)
    left = float(np.max(np.abs(gradient) / np.linalg.norm(slope(x), axis=0)))
    return whole(x[None, :])[0], left


def prefiltered(
    vessel: Vessel, number: int, removal: str, inputs: np.ndarray, measured: np.ndarray, states: np.ndarray
) -> dict[str, list[float]]:
    """Estimates and standard errors by instruments of `states`, every signal multiplied with the inverse of the bidiagonal
    matrix whose subdiagonal holds minus the poles 1 + d(increment)/d(own state) of the true parameters."""
    n = len(inputs)
    lengths = [samples for _, samples in PLANS[number]] if removal == "batch" else [n]
    segment = np.repeat(np.arange(len(lengths)), lengths)
    values = [dict(zip(("u", "v", "r"), x[:n].T)) | dict(zip(vessel.inputs, inputs.T)) for x in (measured, states)]
    theta, errors = [], []
    for d, terms in enumerate(vessel.terms):
        phi, zeta = (np.column_stack([np.broadcast_to(t.value(v), n) for t in terms]) for v in values)
        h = 1e-6
        sides = [values[1] | {"uvr"[d]: values[1]["uvr"[d]] + e} for e in (h, -h)]
        slope = sum(p * (t.value(sides[0]) - t.value(sides[1])) for p, t in zip(vessel.value[d], terms)) / (2 * h)
        pole = np.where(segment == np.roll(segment, 1), 1.0 + slope, 0.0)
        lower = np.eye(n) - np.diag(pole[1:], -1)
        ones = (segment[:, None] == np.arange(len(lengths))).astype(float)
        if removal == "none":
            ones = ones[:, :0]
        passed = [np.linalg.solve(lower, x) for x in (phi, zeta, np.diff(measured[:, d]), ones)]
        regressors, instruments = (np.hstack([x, passed[3]]) for x in passed[:2])
        solution = np.linalg.solve(instruments.T @ regressors, instruments.T @ passed[2])
        residual = passed[2] - regressors @ solution
        p = len(terms)
        centred = passed[1] - passed[3] @ np.linalg.lstsq(passed[3], passed[1], rcond=None)[0] if len(ones.T) else passed[1]
        middle, normal = np.zeros((p, p)), centred.T @ passed[0]
        for s, length in enumerate(lengths):
            g = (centred * residual[:, None])[segment == s]
            z, f = centred[segment == s], passed[0][segment == s]
            number = (np.arange(length) * BLOCKS) // length
            for b in range(BLOCKS):
                # What the estimate changes without this block, times the normal matrix.
                kept = normal - z[number == b].T @ f[number == b]
                moved = normal @ np.linalg.solve(kept, g[number == b].sum(axis=0))
                middle += (STUDENT / NORMAL) ** 2 * (BLOCKS - 1) / BLOCKS * np.outer(moved, moved)
        inverse = np.linalg.inv(normal)
        variance = np.diag(inverse @ middle @ inverse.T)
        theta += solution[:p].tolist()
        errors += np.sqrt(variance).tolist()
    return {"theta": theta, "standard_errors": errors}


def standard_errors(study: Study, x: np.ndarray, initial: Any, inputs: np.ndarray, measured: np.ndarray) -> list[float]:
    """Of parameters and intercepts, by the response of every sample to every draw of the current."""
    vessel, n = study.vessel, len(inputs)
    free = len(vessel.truth) + 3
    base = predicted(vessel, x[None, :], initial, inputs)[1:, :, 0]
    steps = 1e-5 * np.maximum(np.abs(x), 1e-3)[:free]
    shifts = np.zeros((free, len(x)))
    np.fill_diagonal(shifts, steps)
    s = (predicted(vessel, x + shifts, initial, inputs) - predicted(vessel, x - shifts, initial, inputs))[1:]
    s = (s / (2.0 * steps)).reshape(3 * n, free)
    draws = np.zeros((n, 2, 2 * n))
    for j in range(n):
        draws[j, 0, 2 * j] = draws[j, 1, 2 * j + 1] = 1e-4
    many = np.repeat(x[None, :], 2 * n, axis=0)
    response = predicted(vessel, many, initial, inputs, draws) - predicted(vessel, many, initial, inputs, -draws)
    response = (response[1:] / 2e-4).reshape(3 * n, 2 * n)
    covariance = study.current_std**2 * response @ response.T
    covariance += np.diag(np.tile(np.array(study.measurement_std) ** 2, n))
    weights = np.tile(1.0 / np.mean((measured[1:] - base) ** 2, axis=0), n)
    weighted = s * weights[:, None]
    inverse = np.linalg.inv(s.T @ weighted)
    return np.sqrt(np.diag(inverse @ weighted.T @ covariance @ weighted @ inverse)).tolist()


def innovations(study: Study, kind: str, initial: Any, inputs: np.ndarray, measured: np.ndarray) -> list[list[float]]:
    """Of an extended Kalman filter: white current, or one that is a Markov process in earth axes, and then also gusts."""
    vessel, step = study.vessel, 1.0 / study.vessel.rate_hz
    keep = math.exp(-step / MARKOV["time_constant_s"])
    still = math.exp(-step / GUSTS["time_constant_s"])
    size = {"white": 3, "markov": 5, "all": 8}[kind]

    def move(row: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """Next states of (states, and the white current's draw)."""

        def next_states(z: np.ndarray) -> np.ndarray:
            current = z[3:5]
            values = {"u": z[0] - current[0], "v": z[1] - current[1], "r": z[2]} | dict(zip(vessel.inputs, row))
            out = [z[d] + sum(p * t.value(values) for p, t in zip(vessel.value[d], vessel.terms[d])) for d in range(3)]
            if size >= 5:
                turn = z[2] * step
                rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
                out += list(keep * rotation @ current)
            if size == 8:
                out[:3] = [out[d] + z[5 + d] for d in range(3)]
                out += [still * w for w in z[5:8]]
            return np.array(out)

        return next_states

    noise = np.diag(np.array(study.measurement_std) ** 2)
    z, p = np.zeros(size), np.zeros((size, size))
    z[:3] = initial
    fresh = np.zeros(size)
    if size >= 5:
        p[3, 3] = p[4, 4] = MARKOV["std"] ** 2
        fresh[3:5] = MARKOV["std"] ** 2 * (1.0 - keep**2)
    if size == 8:
        p[5:, 5:] = np.diag(np.array(GUSTS["std"]) ** 2)
        fresh[5:] = np.array(GUSTS["std"]) ** 2 * (1.0 - still**2)
    out = []
    for k, y in enumerate(measured):
        error = y - z[:3]
        out.append(error.tolist())
        if k == len(inputs):
            break
        gain = p[:, :3] @ np.linalg.inv(p[:3, :3] + noise)
        z, p = z + gain @ error, p - gain @ p[:3]
        extended = np.concatenate([z, np.zeros(2)]) if size == 3 else z
        advance = move(inputs[k])
        h = 1e-6
        a = np.column_stack([(advance(extended + e) - advance(extended - e)) / (2 * h) for e in h * np.eye(len(extended))])
        z = advance(extended)
        p = a[:, :size] @ p @ a[:, :size].T + np.diag(fresh)
        if size == 3:
            p += study.current_std**2 * a[:, 3:] @ a[:, 3:].T
    return out


if __name__ == "__main__":
    main()
