"""The three ways of removing the instruments' mean."""

from __future__ import annotations

import numpy as np

REMOVALS = ("complete", "batch", "none")


def without_mean(zeta: np.ndarray, removal: str, segment: np.ndarray) -> np.ndarray:
    """Columns of ζ (N × p) less their mean over the run (`complete`), over each segment (`batch`) or unchanged."""
    match removal:
        case "complete":
            return zeta - zeta.mean(0)
        case "batch":
            out = zeta.copy()
            for s in np.unique(segment):
                out[segment == s] -= zeta[segment == s].mean(0)
            return out
        case "none":
            return zeta
    raise ValueError(removal)


def condition(zeta: np.ndarray, phi: np.ndarray, removal: str, segment: np.ndarray) -> float:
    """Condition number of ζᵀφ with both sides scaled to unit root mean square; infinite without excitation."""
    z, f = without_mean(zeta, removal, segment), without_mean(phi, removal, segment)
    scales = [np.sqrt((m**2).mean(0)) for m in (z, f)]
    if min(scale.min() for scale in scales) < 1e-12:
        return float("inf")
    return float(np.linalg.cond((z / scales[0]).T @ (f / scales[1])))
