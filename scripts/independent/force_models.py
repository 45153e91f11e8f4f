"""Accelerations of three published ships in random states, for crates/ship/tests/all/forces/published.rs.

    python scripts/independent/force_models.py --out fixtures/oracle/force_models.json

The right-hand sides are those of reference_models.py. States are drawn where each source's formulas hold: Mariner and KVLCC2
ahead, KVLCC2 with her propeller ahead, Otter in every direction with every mixture of revolutions.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402

from independent.reference_models import Rates, kvlcc2_rates, mariner_rates, otter_rates  # noqa: E402
from independent.text import pretty  # noqa: E402

STATES = 200

# By the preset's name: the right-hand side, and the ranges of u, v, r and inputs.
SHIPS: dict[str, tuple[Rates, list[tuple[float, float]]]] = {
    "mariner": (mariner_rates, [(2.0, 8.5), (-2.5, 2.5), (-0.02, 0.02), (-0.7, 0.7)]),
    "kvlcc2-l7": (kvlcc2_rates, [(0.2, 1.4), (-0.5, 0.5), (-0.12, 0.12), (-0.61, 0.61), (2.0, 18.0)]),
    "otter": (otter_rates, [(-2.0, 3.0), (-1.0, 1.0), (-1.5, 1.5), (-101.0, 103.0), (-101.0, 103.0)]),
}


def ship(name: str, seed: int) -> dict[str, Any]:
    rates, ranges = SHIPS[name]
    draw = np.random.default_rng(seed)
    low, high = np.array(ranges).T
    points = draw.uniform(low, high, (STATES, len(ranges)))
    rows = [[*map(float, row), *map(float, rates(*row[:3], list(row[3:])))] for row in points]
    return {"ship": name, "rows": rows}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    columns = ["u [m/s]", "v [m/s]", "r [rad/s]", "inputs", "changes of u, v [m/s²] and r [rad/s²]"]
    ships = [ship(name, seed) for seed, name in enumerate(SHIPS)]
    out.write_text(pretty({"columns": columns, "ships": ships}) + "\n")


if __name__ == "__main__":
    main()
