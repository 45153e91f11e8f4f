"""Figures of merit of logs, computed apart from the workspace.

    python scripts/independent/logged_figures.py ships out/logs
    python scripts/independent/logged_figures.py zig-zags ../shared/data/kvlcc2_hsva 7.0

`ships` writes noisy logs of three published ships, with an approach of 20 or 60 s and to both sides, as CSV, and beside each the
figures of the ship in continuous time. `zig-zags` prints figures of measured zig-zags: splines of heading and place, and orders where
the rudder is 0.1 degrees off the level that it held.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from scipy.interpolate import LSQUnivariateSpline  # noqa: E402

from independent.closed_loop import EAST, HEADING, NORTH, TRACK, R, U, V, Voyage  # noqa: E402
from independent.reference_models import MOST_ASTERN, Ship, kvlcc2, mariner, otter  # noqa: E402
from independent.reference_ships import helm, lengths  # noqa: E402

# Standard deviations: place in a ship of 100 m, heading, helm; speeds as a part of the approach's.
PLACE_M, HEADING_DEG, HELM_DEG, SPEED = 0.5, 0.1, 0.5, 0.005


def sailed(ship: Ship, kind: str, change: float, side: int, heading: float, approach_s: float) -> tuple[Voyage, dict[str, float]]:
    """A voyage after an approach, and its figures."""
    voyage, figures = Voyage(ship), {}
    voyage.order(list(ship.held), approach_s)
    begin, start = voyage.t, voyage.state.copy()
    times = np.linspace(max(0.0, begin - lengths(ship, 1)), begin, 50)
    course = float(np.mean([voyage.at(t)[HEADING] for t in times]))

    def along(state: np.ndarray) -> tuple[float, float]:
        north, east = (state[[NORTH, EAST]] - start[[NORTH, EAST]]) / ship.length_m
        return north * math.cos(course) + east * math.sin(course), east * math.cos(course) - north * math.sin(course)

    if kind == "zig-zag":
        sign, executes = side, [begin]
        for number in range(4):
            reached = lambda state, sign=sign: sign * (state[HEADING] - course) - heading  # noqa: E731
            voyage.order(helm(ship, sign * change), lengths(ship, 200), reached)
            executes.append(voyage.t)
            if number == 0:
                figures["initial_turning"] = (voyage.state[TRACK] - start[TRACK]) / ship.length_m
            elif number < 3:
                peak = voyage.first(lambda state, sign=sign: sign * state[R], executes[number])
                figures[f"overshoot_{number}"] = math.degrees(-sign * (voyage.at(peak)[HEADING] - course) - heading)
                figures[f"check_time_{number}"] = peak - executes[number]
            sign = -sign
        figures["period"] = executes[3] - executes[1]
        voyage.order(helm(ship, sign * change), lengths(ship, 2))
    elif kind == "circle":
        voyage.order(helm(ship, side * change), lengths(ship, 200), lambda state: side * (state[HEADING] - course) - 12.8)
        first = lambda angle: voyage.first(lambda state: side * (state[HEADING] - course) - angle, begin)  # noqa: E731
        quarter, half = (along(voyage.at(first(angle))) for angle in (0.5 * math.pi, math.pi))
        places = np.array([along(voyage.at(t)) for t in np.linspace(begin, first(1.5 * math.pi), 3000)])
        figures |= {"advance": quarter[0], "transfer": side * quarter[1], "tactical_diameter": side * half[1]}
        figures |= {"greatest_advance": places[:, 0].max(), "greatest_transfer": (side * places[:, 1]).max()}
    elif kind == "pull-out":
        for inputs in (helm(ship, side * change), list(ship.held)):
            voyage.order(inputs, lengths(ship, 14))
        tail = np.linspace(voyage.t - lengths(ship, 14) / 5.0, voyage.t, 100)
        figures["residual_yaw_rate"] = math.degrees(np.mean([voyage.at(t)[R] for t in tail]))
    else:
        until = 0.0 if change else 0.05 * ship.speed_m_s
        voyage.order([change] * 2, lengths(ship, 200), lambda state: until - state[U])
        figures["track_reach"] = (voyage.state[TRACK] - start[TRACK]) / ship.length_m
        figures["head_reach"] = along(voyage.state)[0]
        voyage.order([change] * 2, lengths(ship, 1))
    return voyage, figures


def write(out: Path, ship: Ship, voyage: Voyage, figures: dict[str, float], rate_hz: float, seed: int) -> None:
    random, t = np.random.default_rng(seed), np.arange(int(voyage.t * rate_hz)) / rate_hz
    states = np.array([voyage.at(x) for x in t])
    inputs = np.array([voyage.inputs_at(x) for x in t])
    noise = lambda size: size * random.standard_normal(len(t))  # noqa: E731
    place, speed = PLACE_M * min(1.0, ship.length_m / 100.0), SPEED * ship.speed_m_s
    columns = {
        "t": t,
        "x": states[:, NORTH] + noise(place),
        "y": states[:, EAST] + noise(place),
        "psi": (np.degrees(states[:, HEADING]) + noise(HEADING_DEG)) % 360.0,
        "u": states[:, U] + noise(speed),
        "v": states[:, V] + noise(speed),
        "r": states[:, R] + noise(2.0 * speed / ship.length_m),
    }
    for i, name in enumerate(ship.inputs):
        is_rudder = name == "delta"
        columns[name] = np.degrees(inputs[:, i]) + noise(HELM_DEG) if is_rudder else inputs[:, i] + noise(0.003 * ship.held[i])
    np.savetxt(out.with_suffix(".csv"), np.column_stack(list(columns.values())), "%.6f", ",", header=",".join(columns), comments="")
    about = {"ship": ship.name, "length_m": ship.length_m, "rate_hz": rate_hz}
    out.with_suffix(".json").write_text(json.dumps(about | {"figures": {k: float(x) for k, x in figures.items()}}, indent=1))


def ships(out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    tests = []
    for ship, rate_hz in ((mariner(), 10.0), (kvlcc2(11.85), 20.0)):
        for side in (1, -1):
            swings = [(10, 10), (20, 20), (20, 10)]
            tests += [(ship, "zig-zag", math.radians(d), side, math.radians(h), s, rate_hz) for d, h in swings for s in (60.0, 20.0)]
            tests += [(ship, "circle", math.radians(d), side, 0.0, 60.0, rate_hz) for d in (35, 20)]
            tests += [(ship, "pull-out", math.radians(20), side, 0.0, 60.0, rate_hz)]
    boat = otter()
    for side in (1, -1):
        tests += [(boat, "zig-zag", d, side, math.radians(20), s, 50.0) for d in (10.0, 5.0) for s in (60.0, 20.0)]
        tests += [(boat, "circle", d, side, 0.0, 60.0, 50.0) for d in (10.0, 20.0)] + [(boat, "pull-out", 10.0, side, 0.0, 60.0, 50.0)]
    tests += [(boat, "stop", n, 1, 0.0, s, 50.0) for s in (60.0, 20.0, 30.0) for n in (0.0, MOST_ASTERN)]
    for number, (ship, kind, change, side, heading, approach_s, rate_hz) in enumerate(tests):
        voyage, figures = sailed(ship, kind, change, side, heading, approach_s)
        write(out / f"{number:02}-{ship.name.split()[0].lower()}-{kind}", ship, voyage, figures, rate_hz, 100 + number)


def zig_zag(file: Path, length_m: float) -> dict[str, float]:
    log = np.genfromtxt(file, delimiter=",", names=True)
    t, helm_deg, psi = log["t_s"], np.degrees(log["delta_rad"]), np.degrees(np.unwrap(log["psi_rad"]))
    gap = 0.35 * length_m / np.hypot(log["u_mps"], log["v_mps"])[:5].mean()
    knots = np.arange(t[0] + gap, t[-1] - gap, gap)
    heading, north, east = (LSQUnivariateSpline(t, y, knots, k=4) for y in (psi, log["x_m"], log["y_m"]))
    orders, side, since = [], 0.0, 0
    for k, angle in enumerate(helm_deg):
        now = np.sign(angle) if abs(angle) > 0.5 * np.abs(helm_deg).max() else 0.0
        if now and now != side:
            held = side * np.percentile(side * helm_deg[since:k], 75) if side else helm_deg[0]
            first = k
            while abs(helm_deg[first - 1] - held) > 0.1:
                first -= 1
            before, after = abs(helm_deg[first - 1] - held), abs(helm_deg[first] - held)
            orders.append(t[first - 1] + (t[first] - t[first - 1]) * (0.1 - before) / (after - before))
            side, since = now, k
    course = psi[t <= orders[0]].mean()
    first = np.sign(heading(orders[1]) - course)
    signs = [first if number % 2 else -first for number in range(len(orders))]
    executed = [sign * (heading(at) - course) for sign, at in zip(signs, orders)]
    nominal = min((1, 5, 10, 20), key=lambda own: abs(own - np.median(executed[1:])))
    fine = np.arange(orders[0], t[-1], 0.005)
    run = fine[: int(np.argmax(first * (heading(fine) - course) >= nominal)) + 1]
    figures = {"initial_turning": float(np.sum(np.hypot(np.diff(north(run)), np.diff(east(run))))) / length_m}
    for number in (1, 2):
        end = orders[number + 1] if number + 1 < len(orders) else t[-1]
        swing = fine[(fine >= orders[number]) & (fine <= end)]
        turned = signs[number] * (heading(swing) - course)
        if np.argmax(turned) < len(turned) - 100:
            figures[f"execute_{number}"] = float(executed[number])
            figures[f"overshoot_{number}"] = float(turned.max() - executed[number])
    return figures


def main() -> None:
    if len(sys.argv) == 3 and sys.argv[1] == "ships":
        ships(Path(sys.argv[2]))
    elif len(sys.argv) == 4 and sys.argv[1] == "zig-zags":
        for file in sorted(Path(sys.argv[2]).glob("*.csv")):
            print(file.stem, {name: round(value, 3) for name, value in zig_zag(file, float(sys.argv[3])).items()})
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main()
