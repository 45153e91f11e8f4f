"""A planned trial as phases that a vessel is steered along.

Written from the plan's documents, `plan.toml`, `dictionary.toml` and `vessel.toml`. Maneuvers have the inputs in `track.parquet`, or
the orders in the dictionary where these depend on the ship. Between them are the lines and arcs of the plan's steps.
"""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

LINE, ARC, HOLD, MANEUVER = range(4)

# Keys of plan.toml that change how vessels move, and that this program does not know.
UNKNOWN = ("known_current", "tide", "changing_current", "wind")


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
    orders: dict[str, Any] | None = None
    mirrored: bool = False
    program: Any = None

    def with_program(self, program: Any) -> Phase:
        return dataclasses.replace(self, program=program)

    def from_speed(self, speed: float) -> Phase:
        return dataclasses.replace(self, speeds=(speed, self.speeds[1]))


class Voyage:
    """A plan with what it was made from."""

    def __init__(self, folder: Path, config: Path, dictionary: Path | None = None) -> None:
        self.config = tomllib.loads(config.read_text())
        self.plan = json.loads((folder / "plan.json").read_text())["data"]
        self.voyage = self.plan["voyage"]
        self.lattice, self.legs = self.voyage["lattice"], self.voyage["legs"]
        self.handling = self.voyage["handling"]["used"]
        table = pq.read_table(folder / "track.parquet")
        self.track = {name: table[name].to_numpy() for name in table.column_names}
        for key in UNKNOWN:
            if self.config.get(key):
                raise SystemExit(f"{config}: `{key}`, which this script does not simulate")
        maneuvers = tomllib.loads(dictionary.read_text())["maneuver"] if dictionary else []
        # Those that depend on the ship; all others are tables of inputs.
        reacts = lambda own: "helm" in own or own["kind"] == "stop" or own.get("executed") == "feedback"  # noqa: E731
        self.orders = {own["name"]: own for own in maneuvers if reacts(own)}
        self.cell = self.lattice["cell_m"]
        # The plane's origin is not in the documents; the track is on the first node at its begin.
        first = self.plan["steps"][0]["from"]
        north, east = (float(self.track[name][0]) for name in ("x", "y"))
        self.origin = (north - self.cell * first["j"], east - self.cell * first["i"])
        self.phases = [phase for index in range(len(self.legs)) for phase in self.of_leg(index)]

    def aborting(self, index: int) -> Voyage:
        """A leg and then its abort track, as a voyage of its own from the leg's node."""
        step, leg = self.plan["steps"][index], self.legs[index]
        ends = [step["to"], *leg["abort"]["moves"]]
        moves = [{"action": to["action"], "from": here, "to": to} for here, to in zip(ends, ends[1:])]
        own = copy.copy(self)
        own.plan = self.plan | {"steps": [step, *moves]}
        own.legs = [leg, *({"name": move["action"], "informative": False} for move in moves)]
        own.phases = [dataclasses.replace(phase, leg=0) for phase in self.of_leg(index)]
        own.phases += [phase for number in range(1, len(own.legs)) for phase in own.of_leg(number)]
        x, y = self.node(step["from"])
        own.track = {"x": np.array([x]), "y": np.array([y]), "psi": np.array([self.heading(step["from"])]), "t": self.track["t"]}
        return own

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
        # In the order of the vessel's inputs, which is that of the track's columns.
        inputs = np.column_stack([self.track[name][rows] for name in self.track if name in leg["largest_inputs"]])
        orders = self.orders.get(leg["name"])
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
        # The speed after the maneuver follows from the vessel's model.
        hold, line = Phase(index, HOLD, there, last), Phase(index, LINE, there, last, (math.nan, end))
        run = Phase(index, MANEUVER, inputs=inputs)
        if orders is not None:
            pieces = {own["name"]: own for own in self.config.get("maneuver", [])}
            run = Phase(index, MANEUVER, orders=pieces.get(leg["name"], {}) | orders, mirrored=leg["side"] == "mirrored")
        return [*approach, run, hold if end == 0.0 else line]
