"""Searches vessels and currents within a plan's stated errors that run aground, outside of the planner.

    python scripts/adversarial_vessels.py --plan out/helsinki --config pipelines/helsinki/plan.toml --vessel pipelines/helsinki

Sails the plan with its own model of the ship, its own steering and its own distances from land. First the nominal vessel, whose
track must be the plan's to a millimetre. Then vessels with one parameter at either bound; the corners of the box that these suggest
for every leg; and, until there are `--vessels`, changes of the worst so far. `--uniform` draws that many more, evenly. `--aborts` does
both on every abort track, from the node where its leg begins. `--dictionary`
is for plans that were made with it: zig-zags, circles and pull-outs then are by helm, stops end at rest, and motions are held by
feedback. With `[sensors]` the autopilot sees noise, and 1 % of all ends of legs may be off. A ship with forces has her right-hand
side in independent/force_ship.py; `standard_errors` of her plan are standard deviations of her priors, jointly. Prints what was found,
and exits with 1 where a vessel runs aground, comes nearer than the margin, ends a leg off or does not complete a maneuver. Needs numpy,
scipy and pyarrow. For charts of land, and of depth areas with land, as GeoJSON; and for a cell (S-57), which GDAL reads (pyogrio).
"""

from __future__ import annotations

import argparse
import copy
import math
import sys
import tomllib
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True

import numpy as np  # noqa: E402  (no cache before)

from independent.cell import Cell, Reader  # noqa: E402
from independent.force_fleet import ForceFleet, Spread  # noqa: E402
from independent.force_ship import ForceShip  # noqa: E402
from independent.steering import Fleet, Noise  # noqa: E402
from independent.study import read_vessel  # noqa: E402
from independent.voyage import Voyage, wrap  # noqa: E402
from independent.waters import Depths, Land  # noqa: E402

# Vessels that are simulated together while searching, and while drawing.
BATCH, DRAWN_BATCH = 125, 1000
# By how much the nominal track may differ from the plan's, and a distance from another way of measuring it [m].
SAME_M, ROUNDING_M = 1e-3, 1.0
# Share of the ends of legs that noise of sensors may leave off.
OFF_BY_NOISE = 0.01


class Trial:
    """A plan, and vessels that are tried on it: points from −1 to 1 per parameter, and a current in the unit disc."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.voyage = Voyage(arguments.plan, arguments.config, arguments.dictionary)
        file = tomllib.loads((arguments.vessel / "vessel.toml").read_text())
        is_of_forces = file.get("model") == "forces"
        if "standard_errors" in self.voyage.config["safety"] and not is_of_forces:
            raise SystemExit(f"{arguments.config}: `safety.standard_errors`, expected `parameter_error`: this script reads no covariance")
        self.vessel: Any = ForceShip(arguments.vessel) if is_of_forces else read_vessel(arguments.vessel)
        self.fleet = (ForceFleet if is_of_forces else Fleet)(self.vessel, self.voyage)
        config, folder = self.voyage.config, arguments.config.parent
        self.sensors, self.random = config.get("sensors"), np.random.default_rng(arguments.seed + 1)
        safety, charts = config["safety"], [(folder / chart["file"], chart) for chart in config["chart"]]
        cells = [file for file, _ in charts if file.suffix == ".000"]
        # Under way, and during maneuvers.
        depths = [safety.get(key, 0.0) for key in ("transit_depth_m", "trial_depth_m")]
        if cells and len(charts) > 1:
            raise SystemExit(f"{arguments.config}: {len(charts)} charts, expected one: this script reads a cell alone")
        if cells:
            reader, (_, chart) = Reader(cells[0]), charts[0]
            self.waters = [Cell(self.voyage, reader, chart, depth, bool(number)) for number, depth in enumerate(depths)]
        elif any(chart["kind"] == "depth" for _, chart in charts):
            self.waters = [Depths(self.voyage, charts, depth) for depth in depths]
        else:
            self.waters = [Land(self.voyage, [file for file, _ in charts])]
        self.rounding = ROUNDING_M + 1.5 * getattr(self.waters[0], "RASTER_M", 0.0)
        self.margin = safety["margin_m"]
        self.spread, self.current = Spread.of(self.vessel, safety), safety.get("unknown_current_m_s", 0.0)
        self.nominal = self.spread.nominal
        hull = config["hull"]
        bow, side = hull["length_m"] / 2 - hull.get("reference_m", 0.0), hull["beam_m"] / 2
        stern, shoulder = bow - hull["length_m"], bow - 0.2 * hull["length_m"]
        corners = np.array([[bow, 0], [shoulder, side], [stern, side], [stern, -side], [shoulder, -side]])
        self.outline = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])

    def sail(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Clearance of every leg and vessel [m], the used part of the tolerance at its end, and who did not complete a maneuver."""
        least = np.full((len(self.voyage.legs), len(points)), self.waters[0].SIGHT_M)
        # How far a hull may still move before it can be nearer than it was on this leg, by waters, and where it is.
        slack, last = np.zeros((len(self.waters), len(points))), np.zeros((4, len(points)))
        radius = float(np.hypot(*self.outline.T).max())

        def watch(leg: np.ndarray, pose: np.ndarray, informative: np.ndarray, under_way: np.ndarray) -> None:
            here = np.vstack([pose, leg])
            way = np.hypot(*(here - last)[:2]) + radius * np.abs(here[2] - last[2])
            slack[:] = np.where(here[3] == last[3], slack - way, 0.0)
            last[:] = here
            for number, waters in enumerate(self.waters):
                lanes = np.flatnonzero(under_way & (informative | (number == 0)) & (slack[number] <= 0.0))
                if len(lanes):
                    own = waters.clearance(pose[:, lanes], self.outline)
                    before = least[leg[lanes], lanes]
                    least[leg[lanes], lanes] = np.minimum(before, own)
                    slack[number, lanes] = own - np.minimum(before, own)

        count = len(self.nominal)
        parameters = self.spread.numbers(points[:, :count])
        ends = self.fleet.sail(parameters, self.current * points[:, count:], watch, self.noise())
        return least, self.used(ends.at), ends.unfinished

    def noise(self) -> Noise | None:
        return Noise(self.sensors, self.voyage, 1.0 / self.vessel.rate_hz, self.random) if self.sensors else None

    def used(self, ends: np.ndarray) -> np.ndarray:
        approach, handling = self.voyage.config.get("approach", {}), self.voyage.handling
        speed = approach.get("tolerance_m_s", 0.1)
        distance = approach.get("tolerance_cells", 0.1) * self.voyage.cell
        heading = math.radians(approach.get("tolerance_deg", 6.0))
        rate = approach.get("tolerance_rad_s", 0.15 * handling["turn_rate_rad_s"])
        used = np.zeros(ends.shape[:2])
        for index, step in enumerate(self.voyage.plan["steps"]):
            node, to = self.voyage.node(step["to"]), step["to"]
            x, y, psi, u, v, r = ends[index].T
            parts = [
                np.hypot(x - node[0], y - node[1]) / distance,
                np.abs(wrap(psi - self.voyage.heading(to))) / heading,
                np.abs(u - self.voyage.speed(to)) / speed,
                np.abs(v) / (speed + self.current),
                np.abs(r) / rate,
            ]
            used[index] = np.max(parts, axis=0)
        return used

    def aborting(self, index: int) -> Trial:
        """A leg and its abort track."""
        own = copy.copy(self)
        own.voyage = self.voyage.aborting(index)
        own.fleet = type(self.fleet)(self.vessel, own.voyage)
        return own

    def check_nominal(self) -> None:
        """The nominal vessel must sail the plan's own track."""
        poses: list[np.ndarray] = []
        self.fleet.sail(self.nominal[None, :], np.zeros((1, 2)), lambda _, pose, *__: poses.append(pose[:, 0].copy()))
        own, track = np.array(poses), np.column_stack([self.voyage.track[name] for name in ("x", "y")])
        rows = min(len(own), len(track))
        off = float(np.hypot(*(own[:rows, :2] - track[:rows]).T).max())
        print(f"nominal track: {rows} samples, at most {off:.1e} m from the plan's", flush=True)
        if off > SAME_M or abs(len(own) + 1 - len(track)) > 1:
            raise SystemExit("this script does not sail the plan as it was planned: nothing can be said of it")


class Search:
    """What was tried, and how bad it was."""

    def __init__(self, trial: Trial, seed: int) -> None:
        self.trial, self.random = trial, np.random.default_rng(seed)
        self.count = len(trial.nominal) + 2
        self.points = np.empty((0, self.count))
        legs = len(trial.voyage.legs)
        self.least, self.used = np.empty((legs, 0)), np.empty((legs, 0))
        self.unfinished = np.empty(0, dtype=bool)

    def try_all(self, points: np.ndarray, together: int = BATCH) -> None:
        for begin in range(0, len(points), together):
            batch = points[begin : begin + together]
            least, used, unfinished = self.trial.sail(batch)
            self.points = np.concatenate([self.points, batch])
            self.least, self.used = np.hstack([self.least, least]), np.hstack([self.used, used])
            self.unfinished = np.concatenate([self.unfinished, unfinished])

    def run(self, vessels: int) -> None:
        axes = np.concatenate([np.eye(self.count), -np.eye(self.count)])
        self.try_all(axes)
        corners = [self.corner(quantity[leg]) for quantity in (-self.least, self.used) for leg in range(len(self.least))]
        corners += [self.kept(self.random.choice([-1.0, 1.0], self.count)) for _ in range(40)]
        self.try_all(np.unique(np.array(corners), axis=0))
        while len(self.points) < vessels:
            self.try_all(np.array([self.changed() for _ in range(min(BATCH, vessels - len(self.points)))]))

    def corner(self, badness: np.ndarray) -> np.ndarray:
        slopes = badness[: self.count] - badness[self.count : 2 * self.count]
        point = np.append(self.trial.spread.corner(slopes[:-2]), [0.0, 0.0])
        length = np.hypot(*slopes[-2:])
        point[-2:] = slopes[-2:] / length if length > 0.0 else 0.0
        return point

    def kept(self, point: np.ndarray) -> np.ndarray:
        point[:-2], point[-2:] = self.trial.spread.kept(point[:-2]), np.clip(point[-2:], -1.0, 1.0)
        point[-2:] /= max(1.0, float(np.hypot(*point[-2:])))
        return point

    def changed(self) -> np.ndarray:
        """A change of the worst vessel of a leg, nearer dangers more often."""
        badness = -self.least if self.random.random() < 0.7 else self.used
        worst = badness.max(axis=1)
        order = np.argsort(-worst)
        leg = order[min(int(self.random.exponential(3.0)), len(order) - 1)]
        point = self.points[badness[leg].argmax()].copy()
        kind = self.random.integers(4)
        if kind == 0:
            axes = self.random.choice(self.count - 2, self.random.integers(1, 4), replace=False)
            point[axes] = -point[axes]
        elif kind == 1:
            point[:-2] *= self.random.uniform(0.0, 1.0)
        elif kind == 2:
            angle = self.random.uniform(0.0, 2.0 * math.pi)
            point[-2:] = math.cos(angle), math.sin(angle)
        else:
            axis = self.random.integers(self.count - 2)
            point[axis] = self.random.uniform(-1.0, 1.0)
        return self.kept(point)

    def uniform(self, vessels: int) -> None:
        points = np.hstack([self.trial.spread.drawn(self.random, vessels), np.zeros((vessels, 2))])
        angle, speed = self.random.uniform(0.0, 2.0 * math.pi, vessels), self.random.uniform(0.0, 1.0, vessels)
        points[:, -2], points[:, -1] = speed * np.cos(angle), speed * np.sin(angle)
        self.try_all(points, DRAWN_BATCH)

    def report(self, what: str, begin: int) -> bool:
        """Prints the worst from `begin` on; whether none is bad."""
        least, used = self.least[:, begin:], self.used[:, begin:]
        clearance = least.min(axis=0)
        aground, near = int((clearance <= 0.0).sum()), int((clearance < self.trial.margin - self.trial.rounding).sum())
        off, unfinished = int((used > 1.0).sum()), int(self.unfinished[begin:].sum())
        print(
            f"{what}: {least.shape[1]} vessels, {aground} aground, {near} below {self.trial.margin:g} m, {off} of {used.size} ends of "
            f"legs off, {unfinished} maneuvers not completed",
            flush=True,
        )
        for name, table, pick in (("nearest", least, np.argmin), ("farthest off", used, np.argmax)):
            leg, index = np.unravel_index(int(pick(table)), table.shape)
            print(f"  {name}: {table[leg, index]:.2f} on step {leg + 1} {self.trial.voyage.legs[leg]['name']}, {self.words(begin + index)}")
        allowed = OFF_BY_NOISE * used.size if self.trial.sensors else 0
        return aground == near == unfinished == 0 and off <= allowed

    def words(self, index: int) -> str:
        names = [name for row in self.trial.vessel.names for name in row]
        point = self.points[index]
        numbers, nominal = self.trial.spread.numbers(point[None, :-2])[0], self.trial.nominal
        off = ", ".join(
            f"{name} {100 * (own / best - 1.0):+.0f} %" if best else f"{name} = {own:g}"
            for name, own, best in zip(names, numbers, nominal)
            if own != best
        )
        north, east = self.trial.current * point[-2:]
        return f"{off or 'nominal'}, current {north:+.2f} {east:+.2f} m/s"


def main() -> int:
    arguments = parse_arguments()
    trial = Trial(arguments)
    trial.check_nominal()
    search = Search(trial, arguments.seed)
    search.run(arguments.vessels)
    fine = search.report("searched", 0)
    if arguments.uniform:
        begin = len(search.points)
        search.uniform(arguments.uniform)
        fine &= search.report("drawn", begin)
    for index, leg in enumerate(trial.voyage.legs if arguments.aborts else []):
        if not leg.get("abort"):
            print(f"abort from leg {index + 1} {leg['name']}: none, {leg.get('no_abort', 'not told')}")
        elif leg["abort"]["moves"]:
            search = Search(trial.aborting(index), arguments.seed)
            search.run(arguments.aborts)
            fine &= search.report(f"abort from leg {index + 1}, searched", 0)
            begin = len(search.points)
            search.uniform(arguments.aborts)
            fine &= search.report(f"abort from leg {index + 1}, drawn", begin)
    return 0 if fine else 1


def parse_arguments() -> Any:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plan", type=Path, required=True, help="folder with plan.json and track.parquet")
    parser.add_argument("--config", type=Path, required=True, help="its plan.toml")
    parser.add_argument("--vessel", type=Path, required=True, help="folder with its vessel.toml")
    parser.add_argument("--dictionary", type=Path, help="its dictionary.toml, if the plan was made with it")
    parser.add_argument("--vessels", type=int, default=500, help="how many are searched")
    parser.add_argument("--uniform", type=int, default=0, help="how many more are drawn evenly")
    parser.add_argument("--aborts", type=int, default=0, help="how many are searched, and drawn, on each abort track after its leg")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
