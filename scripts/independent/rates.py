"""The paper's ship at other sampling rates, for crates/ship/tests/all/engine/pace.rs.

    python scripts/independent/rates.py --study pipelines/paper --out fixtures/oracle/rates.json

A step of her terms is divided by Newton's forward formula: the differences are those of the step as a function of the state, taken
by recursion, not weights of states. A slower sample is the step repeated. Inputs are held. The errors are those of ten parts of
every step in runs whose inputs change slowly, in % of the standard deviation of u, v and r, by the order of the formula.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Callable

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402

from independent.motion import increments  # noqa: E402
from independent.study import Vessel, read_vessel  # noqa: E402
from independent.text import pretty  # noqa: E402

ROWS = 40
RUNS = 8
SECONDS = 40
# Amplitudes of the inputs [N, N, N m]: motions as in the paper's maneuvers.
INPUTS = (3.0, 1.0, 0.5)
MOTION = (1.0, 0.3, 0.5)

Step = Callable[[np.ndarray], np.ndarray]


def step_of(ship: Vessel, inputs: np.ndarray) -> Step:
    """The step of the terms with held inputs."""

    def step(state: np.ndarray) -> np.ndarray:
        values = dict(zip("uvr", state.tolist())) | dict(zip(ship.inputs, inputs.tolist()))
        return state + np.array(increments(ship, ship.value, values))

    return step


def difference(step: Step, state: np.ndarray, order: int) -> np.ndarray:
    """Of that order, forward."""
    if order == 0:
        return state
    return difference(step, step(state), order - 1) - difference(step, state, order - 1)


def part(step: Step, state: np.ndarray, by: int, order: int) -> np.ndarray:
    """The state after a `by`-th of the step."""
    share, factor, out = 1.0 / by, 1.0, np.zeros(3)
    for k in range(order + 1):
        out = out + factor * difference(step, state, k)
        factor *= (share - k) / (k + 1)
    return out


def repeated(step: Step, state: np.ndarray, count: int) -> np.ndarray:
    for _ in range(count):
        state = step(state)
    return state


def rows(ship: Vessel) -> list[dict[str, Any]]:
    """Random states and inputs with the samples after them."""
    draw = np.random.default_rng(46)
    out = []
    for _ in range(ROWS):
        state, inputs = draw.uniform(-1, 1, 3) * MOTION, draw.uniform(-1, 1, 3) * INPUTS
        step = step_of(ship, inputs)
        out.append(
            {
                "state": state.tolist(),
                "inputs": inputs.tolist(),
                "tenth": part(step, state, 10, 4).tolist(),
                "tenth_by_order_3": part(step, state, 10, 3).tolist(),
                "half": part(step, state, 2, 4).tolist(),
                "four": repeated(step, state, 4).tolist(),
            }
        )
    return out


def errors(ship: Vessel, order: int) -> list[float]:
    """Of ten parts of every step, in % of the standard deviation."""
    draw, samples = np.random.default_rng(8), int(SECONDS * ship.rate_hz)
    off, whole = [], []
    for _ in range(RUNS):
        periods, phases = draw.uniform(8.0, 25.0, 3), draw.uniform(0, 2 * np.pi, 3)
        one = other = np.array([0.6, 0.0, 0.0])
        for k in range(samples):
            wave = np.sin(2 * np.pi * k / ship.rate_hz / periods + phases)
            step = step_of(ship, np.array(INPUTS) * (wave * (1, 0.3, 1) + (0.5, 0, 0)))
            one = step(one)
            for _ in range(10):
                other = part(step, other, 10, order)
            off.append(other - one)
            whole.append(one)
    return (100 * np.sqrt(np.mean(np.square(off), axis=0)) / np.std(whole, axis=0)).tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--study", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    ship = read_vessel(arguments.study)
    found = {"rows": rows(ship), "errors_percent": {str(order): errors(ship, order) for order in (1, 3, 4)}}
    arguments.out.write_text(pretty(found) + "\n")


if __name__ == "__main__":
    main()
