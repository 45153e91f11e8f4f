"""The paper's scalar example: y = θ₀ u + e with an input whose offset changes sign halfway."""

from __future__ import annotations

import math

import numpy as np


def scalar_example(
    half: int = 20, offset: float = 1.5, noise_std: float = 0.3, theta: float = 0.7
) -> dict[str, object]:
    """Inputs, data and both estimates, with the variances σ² / (Σ ũ² + N ū²) and σ² / Σ ũ²."""
    varying = np.tile([math.sin(2.0 * math.pi * (k + 0.5) / half) for k in range(half)], 2)
    sign = np.repeat([1.0, -1.0], half)
    u = varying + offset * sign
    e = noise_std * np.random.default_rng(11).standard_normal(2 * half)
    y = theta * u + e
    power, n = math.fsum(varying**2), 2 * half
    variances = {"complete": noise_std**2 / (power + n * offset**2), "batch": noise_std**2 / power}
    instruments = {"complete": u, "batch": varying}
    # θ̂ = Σ ζ y / Σ ζ u is linear in y: its variance is σ² Σ ζ² / (Σ ζ u)².
    for name, zeta in instruments.items():
        linear = noise_std**2 * math.fsum(zeta**2) / math.fsum(zeta * u) ** 2
        assert abs(linear / variances[name] - 1.0) < 1e-13
    estimates = {name: math.fsum(z * y) / math.fsum(z * u) for name, z in instruments.items()}
    return {
        "theta": theta,
        "noise_std": noise_std,
        "offset": offset,
        "u": u.tolist(),
        "y": y.tolist(),
        "variance": variances,
        "estimate": estimates,
    }
