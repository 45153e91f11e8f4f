"""Compares the changes per second of `force_ship.py`, read from the presets' files, with those of the published formulas.

    python scripts/independent/check_force_ship.py

The rows are those of fixtures/oracle/force_models.json, which `force_models.py` writes. Exits with 1 where they differ.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402

from independent.force_ship import ForceShip  # noqa: E402

TOP = Path(__file__).resolve().parents[2]
# Of what is rounded, relative to the greatest change.
SAME = 1e-12


def off(name: str, rows: np.ndarray) -> float:
    """The greatest difference of a preset's changes, relative to the greatest of u, v or r."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(TOP / f"crates/ship/presets/{name}.toml", Path(folder) / "vessel.toml")
        ship = ForceShip(Path(folder))
    theta = {own.name: own.nominal for own in ship.free}
    last = 3 + len(ship.inputs)
    found, expected = ship.rates(theta, rows[:, :3].T, rows[:, 3:last]).T, rows[:, last:]
    return float((np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max())


def main() -> int:
    ships = json.loads((TOP / "fixtures/oracle/force_models.json").read_text())["ships"]
    worst = 0.0
    for own in ships:
        difference = off(own["ship"], np.array(own["rows"]))
        print(f"{own['ship']}: {len(own['rows'])} states, off by {difference:.1e} of the greatest change")
        worst = max(worst, difference)
    return 0 if worst < SAME else 1


if __name__ == "__main__":
    sys.exit(main())
