"""Standard maneuvers of three published ships, for crates/maneuver/tests/all/reference_ships.rs.

    python scripts/independent/reference_ships.py --out fixtures/oracle/reference_ships.json

scipy integrates each ship in continuous time and finds orders and figures of merit as roots of its dense output. The workspace
measures the same figures in records, of ten samples in the time in which the ship covers her length.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from scipy.optimize import root  # noqa: E402

from independent.closed_loop import EAST, HEADING, NORTH, TRACK, R, U, V, Voyage  # noqa: E402
from independent.reference_models import MOST_ASTERN, Ship, kvlcc2, mariner, otter  # noqa: E402
from independent.text import pretty  # noqa: E402

SAMPLES_PER_LENGTH = 10
# No maneuver takes longer, in ship lengths at the speed of the approach.
LONGEST = 200.0


def lengths(ship: Ship, number: float) -> float:
    """Seconds in which she covers so many of her lengths."""
    return number * ship.length_m / ship.speed_m_s


def helm(ship: Ship, change: float) -> list[float]:
    return [held + change * per_unit for held, per_unit in zip(ship.held, ship.helm)]


def case(ship: Ship, voyage: Voyage, maneuver: dict[str, Any], figures: dict[str, float]) -> dict[str, Any]:
    rate_hz = SAMPLES_PER_LENGTH / lengths(ship, 1)
    return {
        "ship": ship.name,
        "length_m": ship.length_m,
        "maneuver": {"speed_m_s": ship.speed_m_s, **maneuver},
        "figures": {name: round(float(value), 9) for name, value in figures.items()},
        "inputs": ship.inputs,
        "rate_hz": rate_hz,
        "record": voyage.record(rate_hz),
    }


def turning(ship: Ship, kind: str, change: float, side: int) -> dict[str, Any]:
    to = "starboard" if side > 0 else "port"
    by_input = {name: change * per_unit for name, per_unit in zip(ship.inputs, ship.helm) if per_unit}
    return {"kind": kind, "helm": by_input, "to": to}


def zig_zag(ship: Ship, change: float, heading: float, first: int) -> dict[str, Any]:
    """Until the fourth order."""
    voyage, side, figures = Voyage(ship), first, {}
    for number in range(4):
        begin = voyage.t
        reached = lambda state, side=side: side * state[HEADING] - heading  # noqa: E731
        voyage.order(helm(ship, side * change), lengths(ship, LONGEST), reached)
        if number == 0:
            figures["initial_turning"] = voyage.state[TRACK] / ship.length_m
        elif number < 3:
            # The heading is at its peak where the yaw rate changes sides.
            peak = voyage.at(voyage.first(lambda state, side=side: side * state[R], begin))
            figures[f"overshoot_{number}"] = math.degrees(-side * peak[HEADING] - heading)
        side = -side
    return case(ship, voyage, {**turning(ship, "zig-zag-test", change, first), "heading_rad": heading}, figures)


def steady_turn(voyage: Voyage, inputs: list[float]) -> tuple[float, float]:
    """Speed and yaw rate in which the turn ends."""
    found = root(lambda motion: voyage.ship.rates(*motion, inputs), voyage.state[[U, V, R]], tol=1e-13)
    if np.max(np.abs(found.fun)) > 1e-10:
        raise SystemExit(f"{voyage.ship.name}: no steady turn: {found.message}")
    return math.hypot(found.x[0], found.x[1]), float(found.x[2])


def circle(ship: Ship, change: float, side: int) -> dict[str, Any]:
    voyage, ordered = Voyage(ship), helm(ship, side * change)
    end = 3.0 * math.pi + 0.2
    voyage.order(ordered, lengths(ship, LONGEST), lambda state: side * state[HEADING] - end)
    quarter_s, half_s = (
        voyage.first(lambda state, angle=angle: side * state[HEADING] - angle) for angle in (0.5 * math.pi, math.pi)
    )
    quarter, half = voyage.at(quarter_s), voyage.at(half_s)
    speed, rate = steady_turn(voyage, ordered)
    figures = {
        "advance": quarter[NORTH] / ship.length_m,
        "transfer": side * quarter[EAST] / ship.length_m,
        "tactical_diameter": side * half[EAST] / ship.length_m,
        "time_90": quarter_s,
        "time_180": half_s,
        "steady_diameter": 2.0 * speed / abs(rate) / ship.length_m,
        "steady_yaw_rate": math.degrees(abs(rate)),
        "speed_loss": speed / ship.speed_m_s,
    }
    return case(ship, voyage, turning(ship, "turning-circle", change, side), figures)


def stop(ship: Ship, n: float, until_m_s: float) -> dict[str, Any]:
    """Both propellers at `n` until she has slowed down, and another ship's length."""
    voyage, ordered = Voyage(ship), [n, n]
    voyage.order(ordered, lengths(ship, LONGEST), lambda state: until_m_s - state[U])
    end, state = voyage.t, voyage.state
    figures = {
        "track_reach": state[TRACK] / ship.length_m,
        "head_reach": state[NORTH] / ship.length_m,
        "lateral_deviation": state[EAST] / ship.length_m,
        "stopping_time": end,
    }
    voyage.order(ordered, lengths(ship, 1))
    inputs = dict(zip(ship.inputs, ordered)) if n else {}
    return case(ship, voyage, {"kind": "stop", "inputs": inputs}, figures)


def cases() -> list[dict[str, Any]]:
    degrees, sides = math.radians, (1, -1)
    found = []
    for ship in (mariner(), kvlcc2(11.85), kvlcc2(10.4)):
        found += [zig_zag(ship, degrees(angle), degrees(angle), side) for angle in (10, 20) for side in sides]
        found += [circle(ship, degrees(35), side) for side in sides]
    boat = otter()
    found += [zig_zag(boat, change, degrees(20), side) for change in (10.0, 5.0) for side in sides]
    return [*found, stop(boat, 0.0, 0.05 * boat.speed_m_s), stop(boat, MOST_ASTERN, 0.0)]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    motion = ["u [m/s]", "v [m/s]", "r [rad/s]", "north [m]", "east [m]", "heading [rad]"]
    columns = [*motion, "inputs: delta [rad], n [1/s], n1, n2 [rad/s]"]
    out.write_text(pretty({"columns": columns, "cases": cases()}) + "\n")


if __name__ == "__main__":
    main()
