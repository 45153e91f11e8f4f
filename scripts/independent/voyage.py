"""A planned trial sailed again: many vessels at once, with their own model, steering and distances to the chart.

Written from the plan's documents, `plan.toml` and `vessel.toml`. Maneuvers are run open loop with the inputs in `track.parquet`;
between them every vessel is steered along the lines and arcs of the plan's steps. Vessels are lanes of numpy's arrays.
"""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from .study import STATES, Vessel

LINE, ARC, HOLD, MANEUVER = range(4)

# How the autopilot is tuned, in parts of the response time, and limits of what it does within a sample.
COURSE, SPEED, YAW_RATE, MEMORY, AT_ONCE, BELIEVED = 4.0, 4.0, 8.0, 8.0, 0.5, 0.3


def wrap(angle: Any) -> Any:
    """In (−π, π]."""
    turned = np.mod(angle, 2.0 * math.pi)
    return np.where(turned > math.pi, turned - 2.0 * math.pi, turned)


@dataclass(frozen=True)
class Phase:
    """A part of a leg; places are north and east of the plane's origin [m]."""

    leg: int
    kind: int
    to: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    speeds: tuple[float, float] = (0.0, 0.0)
    radius: float = 1.0
    side: float = 0.0
    inputs: np.ndarray | None = None


class Voyage:
    """A plan with what it was made from."""

    def __init__(self, folder: Path, config: Path) -> None:
        self.config = tomllib.loads(config.read_text())
        self.plan = json.loads((folder / "plan.json").read_text())["data"]
        self.voyage = self.plan["voyage"]
        self.lattice, self.legs = self.voyage["lattice"], self.voyage["legs"]
        self.handling = self.voyage["handling"]["used"]
        table = pq.read_table(folder / "track.parquet")
        self.track = {name: table[name].to_numpy() for name in table.column_names}
        if self.config.get("known_current"):
            raise SystemExit(f"{config}: a known current, which this script does not sail in")
        self.cell = self.lattice["cell_m"]
        # The plane's origin is not in the documents; the track is on the first node at its begin.
        first = self.plan["steps"][0]["from"]
        north, east = (float(self.track[name][0]) for name in ("x", "y"))
        self.origin = (north - self.cell * first["j"], east - self.cell * first["i"])
        self.phases = [phase for index in range(len(self.legs)) for phase in self.of_leg(index)]

    def node(self, pose: dict[str, Any]) -> tuple[float, float]:
        return self.origin[0] + self.cell * pose["j"], self.origin[1] + self.cell * pose["i"]

    def heading(self, pose: dict[str, Any]) -> float:
        return float(wrap(math.pi / 2 - 2.0 * math.pi * pose["h"] / self.lattice["headings"]))

    def speed(self, pose: dict[str, Any]) -> float:
        return float(self.lattice["modes"][pose["mode"]])

    def of_leg(self, index: int) -> list[Phase]:
        step, leg = self.plan["steps"][index], self.legs[index]
        if leg["informative"]:
            return self.informative(index, step, leg)
        a, b = step["from"], step["to"]
        if a["h"] != b["h"] and self.speed(a) > 0.0:
            return self.turn(index, a, b)
        here, there, v0, v1 = self.node(a), self.node(b), self.speed(a), self.speed(b)
        hold = Phase(index, HOLD, there, self.heading(b))
        if v0 == 0.0 and v1 == 0.0:
            return [hold]
        course = math.atan2(there[1] - here[1], there[0] - here[0])
        line = Phase(index, LINE, there, course, (v0, v1))
        return [line, hold] if v1 == 0.0 else [line]

    def turn(self, index: int, a: dict[str, Any], b: dict[str, Any]) -> list[Phase]:
        """Straight, arc, straight: the arc's radius is that of the handling's turn rate."""
        here, there, speed = self.node(a), self.node(b), self.speed(a)
        first, last = self.heading(a), self.heading(b)
        side = float(np.sign(wrap(last - first)))
        radius = speed / self.handling["turn_rate_rad_s"]
        tangent = radius * math.tan(abs(float(wrap(last - first))) / 2.0)
        north, east = there[0] - here[0], there[1] - here[1]
        det = math.cos(first) * math.sin(last) - math.sin(first) * math.cos(last)
        before = (north * math.sin(last) - east * math.cos(last)) / det - tangent
        begin = (here[0] + before * math.cos(first), here[1] + before * math.sin(first))
        centre = (begin[0] - side * radius * math.sin(first), begin[1] + side * radius * math.cos(first))
        straight = [Phase(index, LINE, begin, first, (speed, speed))] if before > 1e-6 else []
        arc = Phase(index, ARC, centre, last, (speed, speed), radius, side)
        return [*straight, arc, Phase(index, LINE, there, last, (speed, speed))]

    def informative(self, index: int, step: dict[str, Any], leg: dict[str, Any]) -> list[Phase]:
        """Run-in, maneuver, recovery. The run-in is one of the lengths that the planner tries: the one as long as sailed."""
        here, there = self.node(step["from"]), self.node(step["to"])
        heading, speed, end = self.heading(step["from"]), leg["speed_m_s"], self.speed(step["to"])
        own = self.track["step"] == index
        rows = np.flatnonzero(own & self.track["informative"].astype(bool))
        inputs = np.column_stack([self.track[name][rows] for name in leg["largest_inputs"]])
        if speed == 0.0:
            approach = [Phase(index, HOLD, here, heading)]
        else:
            least, response = self.config.get("approach", {}).get("run_in_s", 30.0), self.handling["response_s"]
            tries = [least] + [max(least, response) * 1.5**k for k in range(1, 7)]
            lasted = leg["maneuver_start_s"] - leg["start_s"]
            way = speed * min(tries, key=lambda s: abs(s - lasted))
            to = (here[0] + way * math.cos(heading), here[1] + way * math.sin(heading))
            approach = [Phase(index, LINE, to, heading, (speed, speed))] if way > 0.0 else []
        last = self.heading(step["to"])
        after = float(self.track["u"][rows[-1] + 1])
        from_speed = max(after, self.handling["crawl_m_s"])
        hold, line = Phase(index, HOLD, there, last), Phase(index, LINE, there, last, (from_speed, end))
        return [*approach, Phase(index, MANEUVER, inputs=inputs), hold if end == 0.0 else line]


class Fleet:
    """Vessels of one structure, each with parameters and a current (north, east) of its own."""

    def __init__(self, vessel: Vessel, voyage: Voyage) -> None:
        if vessel.follows:
            raise SystemExit("a vessel whose inputs follow others, which this script does not steer")
        self.vessel, self.voyage = vessel, voyage
        self.nominal = [np.array(row) for row in vessel.nominal]
        zero = {name: 0.0 for name in (*STATES, *vessel.inputs)}
        # Increments of u, v, r by a unit of each input: every input enters linearly.
        self.slopes = np.array([
            [sum(p * t.value(zero | {i: 1.0}) for p, t in zip(row, terms)) for i in vessel.inputs]
            for row, terms in zip(vessel.nominal, vessel.terms)
        ])

    def increments(self, parameters: list[np.ndarray], state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        values = dict(zip(STATES, state)) | dict(zip(self.vessel.inputs, inputs.T))
        rows = [[p * t.value(values) for p, t in zip(row.T, terms)] for row, terms in zip(parameters, self.vessel.terms)]
        return np.array([np.broadcast_to(sum(row), state.shape[1]) for row in rows])

    def sail(self, parameters: np.ndarray, current: np.ndarray, watch: Any) -> "Ends":
        """Sails the plan: `parameters` (vessels × all parameters, surge first), `current` (vessels × 2) [m/s]. Calls
        `watch(leg, pose, informative, under way)` at every sample."""
        return Sailing(self, parameters, current).to_the_end(watch)


@dataclass
class Ends:
    """Pose and motion at the end of every leg: legs × vessels × (x, y, psi, u, v, r)."""

    at: np.ndarray


class Sailing:
    """A fleet on its way."""

    def __init__(self, fleet: Fleet, parameters: np.ndarray, current: np.ndarray) -> None:
        self.fleet, self.voyage = fleet, fleet.voyage
        self.dt = 1.0 / fleet.vessel.rate_hz
        counts = np.cumsum([len(row) for row in fleet.vessel.names])[:-1]
        self.parameters = np.split(parameters, counts, axis=1)
        self.current = current.T
        lanes, track = len(parameters), self.voyage.track
        # Ordered by quantity: x, y, psi; u, v, r.
        self.pose = np.array([np.full(lanes, float(track[name][0])) for name in ("x", "y", "psi")])
        speed = self.voyage.speed(self.voyage.plan["steps"][0]["from"])
        self.state = np.array([np.full(lanes, speed), np.zeros(lanes), np.zeros(lanes)])
        self.unexplained = np.zeros((3, lanes))
        self.phase = np.zeros(lanes, dtype=int)
        self.start, self.elapsed = self.pose.copy(), np.zeros(lanes)
        phases, h = self.voyage.phases, self.voyage.handling
        take = lambda of: np.array([of(phase) for phase in phases] + [of(phases[-1])])  # noqa: E731
        self.kind, self.leg = take(lambda p: p.kind), take(lambda p: p.leg)
        self.to = np.array([take(lambda p: p.to[0]), take(lambda p: p.to[1])])
        self.heading, self.radius, self.side = (take(lambda p: p.heading), take(lambda p: p.radius), take(lambda p: p.side))
        self.v0, self.v1 = take(lambda p: p.speeds[0]), take(lambda p: p.speeds[1])
        self.length = take(lambda p: 0 if p.inputs is None else len(p.inputs))
        self.most = int(self.length.max(initial=0))
        self.table = np.zeros((len(self.kind), max(self.most, 1), len(fleet.vessel.inputs)))
        for index, phase in enumerate(phases):
            if phase.inputs is not None:
                self.table[index, : len(phase.inputs)] = phase.inputs
        self.response, self.lookahead, self.crawl = h["response_s"], h["lookahead_m"], h["crawl_m_s"]
        self.turn_rate = h["turn_rate_rad_s"]
        self.believed = min(1.0 / (self.response / MEMORY * fleet.vessel.rate_hz), BELIEVED)
        self.ends = np.full((len(self.voyage.legs), lanes, 6), np.nan)

    def to_the_end(self, watch: Any) -> Ends:
        longest = 20 * len(self.voyage.track["t"])
        for _ in range(longest):
            self.complete()
            under_way = self.phase < len(self.voyage.phases)
            if not under_way.any():
                return Ends(self.ends)
            maneuver = self.kind[self.phase] == MANEUVER
            watch(self.leg[self.phase], self.pose, maneuver, under_way)
            inputs = self.steer()
            row = np.minimum((self.elapsed / self.dt + 0.5).astype(int), max(self.most - 1, 0))
            inputs = np.where(maneuver[:, None], self.table[self.phase, row], inputs)
            self.advance(inputs, under_way)
        raise SystemExit("a vessel does not arrive")

    def complete(self) -> None:
        """Moves vessels on that have completed their phase."""
        while True:
            under_way = self.phase < len(self.voyage.phases)
            done = self.is_done() & under_way
            if not done.any():
                return
            before = self.leg[self.phase]
            self.phase[done] += 1
            finished = done & ((self.phase >= len(self.voyage.phases)) | (self.leg[self.phase] != before))
            lanes = np.flatnonzero(finished)
            self.ends[before[lanes], lanes, :3] = self.pose[:, lanes].T
            self.ends[before[lanes], lanes, 3:] = self.state[:, lanes].T
            self.start[:, done], self.elapsed[done] = self.pose[:, done], 0.0

    def offset(self, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.to[0, self.phase] - pose[0], self.to[1, self.phase] - pose[1]

    def course(self) -> np.ndarray:
        """Of an arc, abeam of the vessel."""
        north, east = self.offset(self.pose)
        return wrap(np.arctan2(east, north) - self.side[self.phase] * math.pi / 2)

    def is_done(self) -> np.ndarray:
        p, kind = self.phase, self.kind[self.phase]
        north, east = self.offset(self.pose)
        sin, cos = np.sin(self.heading[p]), np.cos(self.heading[p])
        late = self.elapsed > self.patience()
        line = north * cos + east * sin <= np.maximum(self.state[0] * self.dt / 2.0, 0.0)
        arc = self.side[p] * wrap(self.heading[p] - self.course()) <= 0.0
        there = np.hypot(north, east) <= self.crawl * self.response / 20.0
        turned = np.abs(wrap(self.heading[p] - self.pose[2])) <= 0.01
        still = (np.hypot(*self.state[:2]) <= 0.1 * self.crawl) & (np.abs(self.state[2]) <= 0.1 * self.turn_rate)
        maneuver = self.elapsed >= (self.length[p] - 0.5) * self.dt
        return np.select(
            [kind == LINE, kind == ARC, kind == HOLD], [line | late, arc | late, (there & turned & still) | late], maneuver
        )

    def patience(self) -> np.ndarray:
        p, kind, more = self.phase, self.kind[self.phase], 5.0 * self.response
        way = np.hypot(*self.offset(self.start))
        line = 2.0 * way / np.maximum((self.v0[p] + self.v1[p]) / 2.0, self.crawl)
        arc = 2.0 * math.pi * self.radius[p] / np.maximum(self.v0[p], self.crawl)
        hold = way / self.crawl + np.abs(wrap(self.heading[p] - self.start[2])) / self.turn_rate
        return np.select([kind == LINE, kind == ARC], [line, arc], hold) + more

    def steer(self) -> np.ndarray:
        """Inputs, vessels × inputs: line of sight over the ground, and inversion of the nominal model with what it does not
        explain."""
        p, kind = self.phase, self.kind[self.phase]
        u, v, r = self.state
        north, east = self.offset(self.pose)
        sin, cos = np.sin(self.heading[p]), np.cos(self.heading[p])
        whole_north, whole_east = self.offset(self.start)
        whole, left = whole_north * cos + whole_east * sin, north * cos + east * sin
        ahead = whole > 0.0
        part = np.where(ahead, np.clip(1.0 - left / np.where(ahead, whole, 1.0), 0.0, 1.0), 1.0)
        squares = self.v1[p] ** 2 - self.v0[p] ** 2
        line_speed = np.maximum(np.sqrt(np.maximum(self.v0[p] ** 2 + part * squares, 0.0)), self.crawl)
        gained = np.where(ahead & (kind == LINE), squares / (2.0 * np.where(ahead, whole, 1.0)), 0.0)
        line_aim = self.heading[p] - np.arctan((north * sin - east * cos) / self.lookahead)
        astray = self.side[p] * (self.radius[p] - np.hypot(north, east))
        arc_aim = self.course() - np.arctan(astray / self.lookahead)
        track = self.pose[2] + np.arctan2(v, np.maximum(u, self.crawl))
        turning = np.where(kind == ARC, self.side[p] * self.v0[p] / self.radius[p], 0.0)
        off = np.where(kind == HOLD, wrap(self.heading[p] - self.pose[2]), wrap(np.where(kind == ARC, arc_aim, line_aim) - track))
        limit = np.maximum(self.turn_rate, 1.2 * np.abs(turning))
        yaw = np.clip(turning + COURSE * off / self.response, -limit, limit)
        own_sin, own_cos = np.sin(self.pose[2]), np.cos(self.pose[2])
        slow = lambda x: np.clip(x / self.response, -self.crawl, self.crawl)  # noqa: E731
        hold = kind == HOLD
        surge = np.select([hold, kind == ARC], [slow(north * own_cos + east * own_sin), self.v0[p]], line_speed)
        sway = np.where(hold, slow(east * own_cos - north * own_sin), 0.0)
        gain = lambda of: min(of * self.dt / self.response, AT_ONCE)  # noqa: E731
        wanted = np.array([gained * self.dt + gain(SPEED) * (surge - u), gain(SPEED) * (sway - v), gain(YAW_RATE) * (yaw - r)])
        coasting = self.fleet.increments(self.of_nominal(), self.state, np.zeros((len(u), len(self.fleet.vessel.inputs))))
        return np.linalg.solve(self.fleet.slopes, wanted - coasting - self.unexplained).T

    def of_nominal(self) -> list[np.ndarray]:
        return [row[None, :] for row in self.fleet.nominal]

    def advance(self, inputs: np.ndarray, under_way: np.ndarray) -> None:
        sin, cos = np.sin(self.pose[2]), np.cos(self.pose[2])
        north, east = self.current
        water = np.array([north * cos + east * sin, east * cos - north * sin, np.zeros_like(north)])
        before = self.state
        after = before + self.fleet.increments(self.parameters, before - water, inputs)
        expected = self.fleet.increments(self.of_nominal(), before, inputs)
        u, v, r = before
        moved = self.pose + self.dt * np.array([u * cos - v * sin, u * sin + v * cos, r])
        self.pose = np.where(under_way, moved, self.pose)
        self.state = np.where(under_way, after, before)
        learnt = self.believed * (after - before - expected - self.unexplained)
        self.unexplained = np.where(under_way, self.unexplained + learnt, self.unexplained)
        self.elapsed = self.elapsed + self.dt


class Land:
    """Distances from land, on the plane of a voyage's track."""

    SPACING_M, CELL_M, SIGHT_M, BEYOND_M = 2.0, 10.0, 550.0, 1500.0

    def __init__(self, voyage: Voyage, files: list[Path]) -> None:
        rings = [self.on_plane(voyage, np.array(ring)) for file in files for ring in rings_of(json.loads(file.read_text()))]
        low = np.array([min(voyage.track["x"]), min(voyage.track["y"])]) - self.BEYOND_M
        high = np.array([max(voyage.track["x"]), max(voyage.track["y"])]) + self.BEYOND_M
        self.low, self.shape = low, tuple(np.ceil((high - low) / self.CELL_M).astype(int))
        points = np.concatenate([densified(ring, self.SPACING_M, low - 600.0, high + 600.0) for ring in rings])
        self.tree = cKDTree(points)
        centres = np.stack(np.meshgrid(*(low[k] + self.CELL_M * (np.arange(self.shape[k]) + 0.5) for k in (0, 1)), indexing="ij"), -1)
        far, _ = self.tree.query(centres.reshape(-1, 2), distance_upper_bound=self.SIGHT_M)
        self.far = np.minimum(far, self.SIGHT_M).reshape(self.shape)
        self.far[self.inside(rings, centres)] = 0.0

    @staticmethod
    def on_plane(voyage: Voyage, ring: np.ndarray) -> np.ndarray:
        """Longitude and latitude as north and east: the track says how, to second order."""
        track = voyage.track
        lon0, lat0 = float(np.mean(track["longitude"])), float(np.mean(track["latitude"]))

        def rows(lon: np.ndarray, lat: np.ndarray) -> np.ndarray:
            a, b = (lon - lon0) * 20.0, (lat - lat0) * 20.0
            return np.column_stack([np.ones_like(a), a, b, a * a, a * b, b * b])

        places = np.column_stack([track["x"], track["y"]])
        fit, *_ = np.linalg.lstsq(rows(track["longitude"], track["latitude"]), places, rcond=None)
        return rows(ring[:, 0], ring[:, 1]) @ fit

    def inside(self, rings: list[np.ndarray], centres: np.ndarray) -> np.ndarray:
        """Cells within an odd number of rings."""
        odd = np.zeros(self.shape, dtype=bool)
        norths, easts = centres[:, 0, 0], centres[0, :, 1]
        for ring in rings:
            for (n0, e0), (n1, e1) in zip(ring, np.roll(ring, -1, axis=0)):
                rows = np.flatnonzero((norths >= min(n0, n1)) & (norths < max(n0, n1)))
                if len(rows) and max(e0, e1) > easts[0]:
                    cross = e0 + (norths[rows] - n0) / (n1 - n0) * (e1 - e0)
                    odd[rows] ^= easts[None, :] < cross[:, None]
                elif len(rows):
                    continue
        return odd

    def clearance(self, pose: np.ndarray, outline: np.ndarray, least: np.ndarray) -> np.ndarray:
        """The least of `least` and the distance of the hull's outline from land, per vessel."""
        place = pose[:2].T
        cells = np.clip(((place - self.low) / self.CELL_M).astype(int), 0, np.array(self.shape) - 1)
        coarse = self.far[cells[:, 0], cells[:, 1]]
        radius = float(np.hypot(*outline.T).max())
        near = np.flatnonzero(coarse - radius - self.CELL_M < least)
        if len(near):
            sin, cos = np.sin(pose[2, near]), np.cos(pose[2, near])
            corners = np.stack([
                pose[0, near, None] + outline[:, 0] * cos[:, None] - outline[:, 1] * sin[:, None],
                pose[1, near, None] + outline[:, 0] * sin[:, None] + outline[:, 1] * cos[:, None],
            ], -1)
            exact, _ = self.tree.query(corners, distance_upper_bound=self.SIGHT_M)
            on_land = coarse[near] == 0.0
            own = np.where(on_land, 0.0, np.minimum(exact.min(axis=1), self.SIGHT_M))
            least[near] = np.minimum(least[near], own)
        return least


class Depths:
    """Distances from what is too shoal in charts of depth areas and land, on the plane of a voyage's track, by a raster."""

    CELL_M, SIGHT_M, BEYOND_M = 2.0, 400.0, 500.0

    def __init__(self, voyage: Voyage, charts: list[tuple[Path, dict[str, Any]]], depth: float) -> None:
        low = np.array([min(voyage.track["x"]), min(voyage.track["y"])]) - self.BEYOND_M
        high = np.array([max(voyage.track["x"]), max(voyage.track["y"])]) + self.BEYOND_M
        self.low, shape = low, tuple(np.ceil((high - low) / self.CELL_M).astype(int))
        deep, closed = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
        for file, chart in charts:
            only = chart.get("only")
            for feature in json.loads(file.read_text())["features"]:
                own = feature["properties"]
                if only and own.get(only["property"]) not in only["values"]:
                    continue
                rings = [Land.on_plane(voyage, np.array(ring)) for ring in rings_of(feature)]
                least = own.get(chart.get("least", "DRVAL1"))
                if chart["kind"] != "depth" or least in (None, "") or float(least) < depth:
                    closed |= self.inside(rings, shape)
                else:
                    deep |= self.inside(rings, shape)
        self.far = np.minimum(distance_transform_edt(deep & ~closed) * self.CELL_M, self.SIGHT_M)

    def inside(self, rings: list[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
        """Cells whose centres are within an odd number of rings."""
        odd = np.zeros(shape, dtype=bool)
        for ring in rings:
            cells = (ring - self.low) / self.CELL_M - 0.5
            for (n0, e0), (n1, e1) in zip(cells, np.roll(cells, -1, axis=0)):
                rows = np.arange(max(math.ceil(min(n0, n1)), 0), min(math.ceil(max(n0, n1)), shape[0]))
                for row in rows:
                    cross = math.ceil(e0 + (row - n0) / (n1 - n0) * (e1 - e0))
                    odd[row, : min(max(cross, 0), shape[1])] ^= True
        return odd

    def clearance(self, pose: np.ndarray, outline: np.ndarray, least: np.ndarray) -> np.ndarray:
        """The least of `least` and the distance of the hull's outline from what is too shoal, per vessel, to a cell's diagonal."""
        sin, cos = np.sin(pose[2])[:, None], np.cos(pose[2])[:, None]
        corners = np.stack([
            pose[0][:, None] + outline[:, 0] * cos - outline[:, 1] * sin,
            pose[1][:, None] + outline[:, 0] * sin + outline[:, 1] * cos,
        ], -1)
        cells = np.clip(((corners - self.low) / self.CELL_M).astype(int), 0, np.array(self.far.shape) - 1)
        return np.minimum(least, self.far[cells[..., 0], cells[..., 1]].min(axis=1))


def densified(ring: np.ndarray, spacing: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Points along a ring's edges within a box."""
    points = [np.empty((0, 2))]
    for a, b in zip(ring, np.roll(ring, -1, axis=0)):
        if (np.maximum(a, b) >= low).all() and (np.minimum(a, b) <= high).all():
            count = max(int(math.ceil(np.hypot(*(b - a)) / spacing)), 1)
            points.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate(points)


def rings_of(document: dict[str, Any]) -> list[Any]:
    if document["type"] == "FeatureCollection":
        return [ring for feature in document["features"] for ring in rings_of(feature["geometry"])]
    if document["type"] == "Feature":
        return rings_of(document["geometry"])
    if document["type"] == "Polygon":
        return document["coordinates"]
    return [ring for polygon in document["coordinates"] for ring in polygon]
