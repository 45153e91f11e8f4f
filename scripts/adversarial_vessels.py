"""Searches vessels and currents within a plan's stated errors that run aground, outside of the planner.

    python scripts/adversarial_vessels.py --plan out/helsinki --config pipelines/helsinki/plan.toml --vessel pipelines/helsinki

Sails the plan with its own model of the ship, its own steering and its own distances from land. First the nominal vessel, whose
track must be the plan's. Then vessels with one parameter at either bound; the corners of the box that these suggest for every leg;
and, until there are `--vessels`, changes of the worst so far. `--uniform` draws that many more, evenly. Prints what was found and exits
with 1 where one runs aground, comes nearer than the margin or ends a leg off. Needs numpy, scipy and pyarrow. For charts of land, and of
depth areas with land, as GeoJSON.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True

import numpy as np  # noqa: E402  (no cache before)

from independent.study import read_vessel  # noqa: E402
from independent.voyage import Depths, Fleet, Land, Voyage, wrap  # noqa: E402

BATCH = 125
# By how much the nominal track may differ from the plan's, and a distance from another way of measuring it [m].
SAME_M, ROUNDING_M = 1.0, 1.0


class Trial:
    """A plan, and vessels that are tried on it: points from −1 to 1 per parameter, and a current in the unit disc."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.vessel = read_vessel(arguments.vessel)
        self.voyage = Voyage(arguments.plan, arguments.config)
        self.fleet = Fleet(self.vessel, self.voyage)
        config, folder = self.voyage.config, arguments.config.parent
        safety, charts = config["safety"], [(folder / chart["file"], chart) for chart in config["chart"]]
        if any(chart["kind"] == "depth" for _, chart in charts):
            # Under way, and during maneuvers.
            depths = safety["transit_depth_m"], safety["trial_depth_m"]
            self.waters = [Depths(self.voyage, charts, depth) for depth in depths]
            self.rounding = ROUNDING_M + 1.5 * Depths.CELL_M
        else:
            self.waters, self.rounding = [Land(self.voyage, [file for file, _ in charts])], ROUNDING_M
        self.margin = safety["margin_m"]
        self.error, self.current = safety.get("parameter_error", 0.0), safety.get("unknown_current_m_s", 0.0)
        self.nominal = np.array([p for row in self.vessel.nominal for p in row])
        hull = config["hull"]
        bow, side = hull["length_m"] / 2 - hull.get("reference_m", 0.0), hull["beam_m"] / 2
        stern, shoulder = bow - hull["length_m"], bow - 0.2 * hull["length_m"]
        corners = np.array([[bow, 0], [shoulder, side], [stern, side], [stern, -side], [shoulder, -side]])
        self.outline = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])

    def sail(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Clearance of every leg and vessel [m], and the used part of the tolerance at its end."""
        least = np.full((len(self.voyage.legs), len(points)), self.waters[0].SIGHT_M)

        def watch(leg: np.ndarray, pose: np.ndarray, informative: np.ndarray, under_way: np.ndarray) -> None:
            for number, waters in enumerate(self.waters):
                lanes = np.flatnonzero(under_way & (informative | (number == 0)))
                if len(lanes):
                    own = waters.clearance(pose[:, lanes], self.outline, least[leg[lanes], lanes])
                    least[leg[lanes], lanes] = own

        count = len(self.nominal)
        parameters = self.nominal * (1.0 + self.error * points[:, :count])
        ends = self.fleet.sail(parameters, self.current * points[:, count:], watch)
        return least, self.used(ends.at)

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

    def check_nominal(self) -> None:
        """The nominal vessel must sail the plan's own track."""
        poses: list[np.ndarray] = []
        self.fleet.sail(self.nominal[None, :], np.zeros((1, 2)), lambda _, pose, *__: poses.append(pose[:, 0].copy()))
        own, track = np.array(poses), np.column_stack([self.voyage.track[name] for name in ("x", "y")])
        rows = min(len(own), len(track))
        off = float(np.hypot(*(own[:rows, :2] - track[:rows]).T).max())
        print(f"nominal track: {rows} samples, at most {off:.3f} m from the plan's")
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

    def try_all(self, points: np.ndarray) -> None:
        for begin in range(0, len(points), BATCH):
            batch = points[begin : begin + BATCH]
            least, used = self.trial.sail(batch)
            self.points = np.concatenate([self.points, batch])
            self.least, self.used = np.hstack([self.least, least]), np.hstack([self.used, used])

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
        point = np.where(slopes < 0.0, -1.0, 1.0)
        length = np.hypot(*slopes[-2:])
        point[-2:] = slopes[-2:] / length if length > 0.0 else 0.0
        return point

    def kept(self, point: np.ndarray) -> np.ndarray:
        point = np.clip(point, -1.0, 1.0)
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
        points = self.random.uniform(-1.0, 1.0, (vessels, self.count))
        angle, speed = self.random.uniform(0.0, 2.0 * math.pi, vessels), self.random.uniform(0.0, 1.0, vessels)
        points[:, -2], points[:, -1] = speed * np.cos(angle), speed * np.sin(angle)
        self.try_all(points)

    def report(self, what: str, begin: int) -> bool:
        """Prints the worst from `begin` on; whether none is bad."""
        least, used = self.least[:, begin:], self.used[:, begin:]
        clearance = least.min(axis=0)
        aground, near = int((clearance <= 0.0).sum()), int((clearance < self.trial.margin - self.trial.rounding).sum())
        # An end beyond its tolerance spoils those after it.
        ends = int((used > 1.0).any(axis=0).sum())
        print(f"{what}: {least.shape[1]} vessels, {aground} aground, {near} below {self.trial.margin:g} m, {ends} off at the end of a leg")
        for name, table, pick in (("nearest", least, np.argmin), ("farthest off", used, np.argmax)):
            leg, index = np.unravel_index(int(pick(table)), table.shape)
            print(f"  {name}: {table[leg, index]:.2f} on step {leg + 1} {self.trial.voyage.legs[leg]['name']}, {self.words(begin + index)}")
        return aground == near == ends == 0

    def words(self, index: int) -> str:
        names = [name for row in self.trial.vessel.names for name in row]
        point = self.points[index]
        off = ", ".join(f"{name} {100 * self.trial.error * own:+.0f} %" for name, own in zip(names, point) if own)
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
    return 0 if fine else 1


def parse_arguments() -> Any:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plan", type=Path, required=True, help="folder with plan.json and track.parquet")
    parser.add_argument("--config", type=Path, required=True, help="its plan.toml")
    parser.add_argument("--vessel", type=Path, required=True, help="folder with its vessel.toml")
    parser.add_argument("--vessels", type=int, default=500, help="how many are searched")
    parser.add_argument("--uniform", type=int, default=0, help="how many more are drawn evenly")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
