"""Least squares within bounds, for crates/estimation/tests/all/constraints.rs.

Every combination of parameters at a lower bound, at an upper bound and free is tried: of those whose free parameters stay
within their bounds the one with the least squares is the estimate. Its covariance for white errors of variance 1 is that of
the free ones alone. No pivoting, no multipliers.

    python scripts/independent/bounded.py fixtures/oracle/bounded.json
"""

import itertools
import json
import sys

import numpy as np

PARAMETERS = 4
SAMPLES = 40
# Per case and bounded parameter, the bounds from the true value, in units of its standard error.
CASES = [
    {0: (0.4, 2.0), 1: (-0.2, 9.0)},
    {0: (2.0, 9.0), 1: (-9.0, -2.0), 3: (1.0, 3.0)},
    {0: (3.0, 9.0), 1: (3.0, 9.0), 2: (3.0, 9.0), 3: (-9.0, 0.0)},
]


def cases():
    draw = np.random.default_rng(46)
    for spans in CASES:
        mix = np.eye(PARAMETERS) + 0.6 * draw.normal(size=(PARAMETERS, PARAMETERS))
        phi = draw.normal(size=(SAMPLES, PARAMETERS)) @ mix
        truth = draw.normal(size=PARAMETERS)
        target = phi @ truth + draw.normal(size=SAMPLES)
        free = np.linalg.lstsq(phi, target, rcond=None)[0]
        errors = np.sqrt(np.diag(np.linalg.inv(phi.T @ phi)))
        bounds = {i: (free[i] + low * errors[i], free[i] + high * errors[i]) for i, (low, high) in spans.items()}
        yield phi, target, bounds


def bounded(phi, target, bounds):
    best = None
    for choice in itertools.product([None, 0, 1], repeat=len(bounds)):
        held = {i: bounds[i][end] for i, end in zip(bounds, choice) if end is not None}
        free = [i for i in range(PARAMETERS) if i not in held]
        theta = np.zeros(PARAMETERS)
        for i, value in held.items():
            theta[i] = value
        covariance = np.zeros((PARAMETERS, PARAMETERS))
        if free:
            theta[free] = np.linalg.lstsq(phi[:, free], target - phi @ theta, rcond=None)[0]
            covariance[np.ix_(free, free)] = np.linalg.inv(phi[:, free].T @ phi[:, free])
        if all(low <= theta[i] <= high for i, (low, high) in bounds.items()):
            squares = float(np.sum((target - phi @ theta) ** 2))
            if best is None or squares < best[0]:
                best = squares, theta, covariance
    return best


def main():
    written = []
    for phi, target, bounds in cases():
        squares, theta, covariance = bounded(phi, target, bounds)
        written.append(
            {
                "phi": phi.ravel().tolist(),
                "target": target.tolist(),
                "bounds": {str(i): list(ends) for i, ends in bounds.items()},
                "theta": theta.tolist(),
                "covariance": covariance.ravel().tolist(),
                "squares": squares,
            }
        )
    with open(sys.argv[1], "w") as file:
        json.dump(written, file, indent=1)
        file.write("\n")


main()
