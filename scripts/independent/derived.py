"""Independent computation of derived channels and their slopes, for the `oracle_*` tests of `model`.

    python scripts/independent/derived.py --out fixtures/oracle/derived.json

Needs numpy. Every formula stands beside a function of numpy that was written by hand; slopes are central differences of it.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Callable

import numpy as np

ahead = lambda n: np.where(n > 0.0, n, 0.0)  # noqa: E731
astern = lambda n: np.where(n < 0.0, n, 0.0)  # noqa: E731

# The formula, its channels in the order of appearance, and the same by hand.
CASES: list[tuple[str, Callable[..., np.ndarray]]] = [
    ("positive(n)", lambda n: ahead(n)),
    ("negative(n)^2", lambda n: astern(n) ** 2),
    ("n |n|", lambda n: n * np.abs(n)),
    ("n |n| delta", lambda n, delta: n * np.abs(n) * delta),
    ("positive(n)^2 delta", lambda n, delta: np.maximum(n, 0.0) ** 2 * delta),
    ("-1 wind^2 cos(gamma)", lambda wind, gamma: -(wind**2) * np.cos(gamma)),
    ("0.5 * wind^2 * sin(gamma)", lambda wind, gamma: 0.5 * np.square(wind) * np.sin(gamma)),
    ("wind^2 sin(gamma) cos(gamma)", lambda wind, gamma: 0.5 * wind**2 * np.sin(2.0 * gamma)),
    ("2 n^3 |delta|^2", lambda n, delta: 2.0 * n * n * n * delta * delta),
    ("delta cos(delta)^2", lambda delta: delta * (1.0 - np.sin(delta) ** 2)),
]
ROWS = 12
STEP = 1e-6


def case(formula: str, by_hand: Callable[..., np.ndarray], generator: np.random.Generator) -> dict:
    channels = by_hand.__code__.co_varnames[: by_hand.__code__.co_argcount]
    rows = generator.normal(0.0, 1.5, (ROWS, len(channels))).round(3)

    def slope(place: int) -> np.ndarray:
        up, down = rows.copy(), rows.copy()
        up[:, place] += STEP
        down[:, place] -= STEP
        return (by_hand(*up.T) - by_hand(*down.T)) / (2.0 * STEP)

    return {
        "formula": formula,
        "channels": list(channels),
        "rows": rows.tolist(),
        "values": by_hand(*rows.T).tolist(),
        "slopes": np.stack([slope(place) for place in range(len(channels))], axis=1).tolist(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    generator = np.random.default_rng(15)
    document = {"cases": [case(formula, by_hand, generator) for formula, by_hand in CASES]}
    out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
