"""Replay of a plan over a problem of schema `experiment-lattice-planning/1`, move by move, in exact arithmetic."""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

SCHEMA = "experiment-lattice-planning/1"
STATUSES = ("optimal", "feasible")
# Costs are sums of decimals in a plan written with binary floats.
TOLERANCE = Fraction(1, 10**9)

Pose = tuple[int, int, int]
Box = tuple[Fraction, Fraction, Fraction, Fraction]
Shift = tuple[Fraction, Fraction]


class Unusable(Exception):
    """A file that cannot be checked at all; the message is one line without the file's name."""


@dataclass(frozen=True)
class Move:
    """A move from heading level `h`: by (`di`, `dj`) nodes to level `to_h`, sweeping boxes relative to its start."""

    h: int
    di: int
    dj: int
    to_h: int
    cost: Fraction
    swept: tuple[Box, ...]


@dataclass(frozen=True)
class Action:
    """`count` is the number of uses that an informative action requires, none for a basic one."""

    count: int | None
    moves: tuple[Move, ...]

    def variants(self, h: int) -> list[Move]:
        """The moves that start at heading level `h`, in the order of the file."""
        return [move for move in self.moves if move.h == h]


@dataclass(frozen=True)
class Problem:
    """What a plan is checked against. `size` is nx, ny and the number of heading levels."""

    size: Pose
    cell: Fraction
    origin: Shift
    bounds: Box
    obstacles: tuple[Box, ...]
    actions: dict[str, Action]
    start: Pose
    goal: Pose
    expected_status: str | None
    expected_cost: Fraction | None

    def holds(self, pose: Pose) -> bool:
        """Whether a pose is one of the lattice's."""
        return all(0 <= index < size for index, size in zip(pose, self.size))

    def node(self, pose: Pose) -> Shift:
        """Position of a pose in metres."""
        return self.origin[0] + self.cell * pose[0], self.origin[1] + self.cell * pose[1]


@dataclass
class Replay:
    """How far a plan led: the pose, the uses of every action and their cost, and what was wrong on the way."""

    pose: Pose
    uses: dict[str, int]
    cost: Fraction
    violations: list[str]
    whole: bool


def read_json(path: Path) -> Any:
    """A document with its decimals as exact fractions. Refuses NaN and infinities."""

    def refused(constant: str) -> None:
        raise Unusable(f"found {constant}, expected finite numbers")

    try:
        return json.loads(path.read_text("utf-8"), parse_float=Fraction, parse_constant=refused)
    except OSError as error:
        raise Unusable(f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Unusable(f"not JSON: {error}") from error


def read_problem(path: Path) -> Problem:
    """Reads a problem file."""
    document = read_json(path)
    try:
        if document["schema"] != SCHEMA:
            raise Unusable(f"found schema {document['schema']}, expected {SCHEMA}")
        return problem_of(document)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise Unusable(f"not a problem of {SCHEMA}: {type(error).__name__}: {error}") from error


def problem_of(document: dict[str, Any]) -> Problem:
    """The problem that a document of the schema tells."""
    lattice, expected = document["lattice"], document.get("expected", {})
    informative, basic = ([(entry["name"], entry) for entry in document[key]] for key in ("informative", "basic"))
    actions = {name: _action(entry, entry["count"]) for name, entry in informative}
    actions |= {name: _action(entry, None) for name, entry in basic}
    if len(actions) < len(informative) + len(basic):
        raise Unusable("found two actions of one name, expected distinct names")
    x, y = lattice["origin"]
    cost = expected.get("cost")
    return Problem(
        size=(lattice["nx"], lattice["ny"], lattice["headings"]),
        cell=Fraction(lattice["cell"]),
        origin=(Fraction(x), Fraction(y)),
        bounds=_box(document["bounds"]),
        obstacles=tuple(map(_box, document["obstacles"])),
        actions=actions,
        start=_pose(document["start"]),
        goal=_pose(document["goal"]),
        expected_status=expected.get("status"),
        expected_cost=None if cost is None else Fraction(cost),
    )


def _action(entry: dict[str, Any], count: int | None) -> Action:
    def move(m: dict[str, Any]) -> Move:
        cost = Fraction(m.get("cost", entry["cost"]))
        return Move(m["h"], m["di"], m["dj"], m["to_h"], cost, tuple(map(_box, m["swept"])))

    return Action(count, tuple(map(move, entry["moves"])))


def _box(values: list[Any]) -> Box:
    low_x, low_y, high_x, high_y = map(Fraction, values)
    return low_x, low_y, high_x, high_y


def _pose(values: list[int]) -> Pose:
    i, j, h = values
    return i, j, h


def check_plan(problem: Problem, document: Any) -> list[str]:
    """Everything that is wrong with a plan: one line each."""
    data = document.get("data") if isinstance(document, dict) else None
    steps = data.get("steps") if isinstance(data, dict) else None
    if not isinstance(steps, list):
        return ["found no list `data.steps`, expected the steps of a plan"]
    done = replay(problem, steps)
    if done.whole:
        done.violations += _end(problem, done)
    return done.violations + _claims(problem, data, done)


def replay(problem: Problem, steps: list[Any]) -> Replay:
    """Follows the steps from the start. A step that names no move ends the replay."""
    done = Replay(problem.start, dict.fromkeys(problem.actions, 0), Fraction(0), [], True)
    for number, step in enumerate(steps):
        move, wrong = _move(problem, done.pose, step)
        if move is None:
            done.violations.append(f"step {number}: {wrong}; the replay ends here")
            done.whole = False
            break
        start, end = done.pose, (done.pose[0] + move.di, done.pose[1] + move.dj, move.to_h)
        wrongs = _told(step, "from", start) + _told(step, "to", end) + blocked(problem, start, end, move)
        done.violations += [f"step {number} ({step['action']}): {wrong}" for wrong in wrongs]
        done.pose = end
        done.uses[step["action"]] += 1
        done.cost += move.cost
    return done


def _move(problem: Problem, pose: Pose, step: Any) -> tuple[Move | None, str]:
    """The move that a step names, or what is wrong with the step."""
    if not isinstance(step, dict) or not isinstance(step.get("action"), str):
        return None, "found no action, expected its name"
    action = problem.actions.get(step["action"])
    if action is None:
        return None, f"found action {step['action']!r}, expected one of {', '.join(problem.actions)}"
    variant, variants = step.get("variant"), action.variants(pose[2])
    if type(variant) is not int or not 0 <= variant < len(variants):
        expected = f"0 to {len(variants) - 1}" if variants else "no use of it"
        return None, f"found variant {variant} of {step['action']} at heading {pose[2]}, expected {expected}"
    return variants[variant], ""


def _told(step: dict[str, Any], key: str, pose: Pose) -> list[str]:
    """Whether the pose that a step tells, if it does, is the one replayed."""
    if key not in step:
        return []
    told = step[key]
    found = tuple(told.get(name) for name in "ijh") if isinstance(told, dict) else told
    return [] if found == pose else [f"found `{key}` {found}, expected {pose}"]


def blocked(problem: Problem, start: Pose, end: Pose, move: Move) -> list[str]:
    """Why a move is not allowed."""
    nx, ny, headings = problem.size
    wrongs = [] if problem.holds(end) else [f"ends at {end}, expected inside {nx} × {ny} × {headings}"]
    x, y = problem.node(start)
    swept = [(box[0] + x, box[1] + y, box[2] + x, box[3] + y) for box in move.swept]
    outside = [box for box in swept if not _inside(box, problem.bounds)]
    wrongs += [f"sweeps {_text(box)}, expected inside {_text(problem.bounds)}" for box in outside[:1]]
    hits = [(box, obstacle) for box in swept for obstacle in problem.obstacles if _overlap(box, obstacle)]
    more = f" and {len(hits) - 1} more such pairs" if len(hits) > 1 else ""
    return wrongs + [f"sweeps {_text(box)}, which meets obstacle {_text(hit)}{more}" for box, hit in hits[:1]]


def _inside(box: Box, bounds: Box) -> bool:
    return box[0] >= bounds[0] and box[1] >= bounds[1] and box[2] <= bounds[2] and box[3] <= bounds[3]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _text(box: Box) -> str:
    return "[" + ", ".join(f"{float(value):g}" for value in box) + "]"


def _end(problem: Problem, done: Replay) -> list[str]:
    """Whether the plan ends at the goal with the counts required."""
    wrongs = [] if done.pose == problem.goal else [f"goal: found {done.pose}, expected {problem.goal}"]
    required = [(name, action.count) for name, action in problem.actions.items() if action.count is not None]
    return wrongs + [
        f"count of {name}: found {done.uses[name]}, expected {count}"
        for name, count in required
        if done.uses[name] != count
    ]


def _claims(problem: Problem, data: dict[str, Any], done: Replay) -> list[str]:
    """Whether what the plan says of itself is true."""
    status = data.get("status")
    wrongs = [] if status in STATUSES else [f"status: found {status!r}, expected {' or '.join(STATUSES)}"]
    if problem.expected_status == "infeasible":
        wrongs.append("found a plan, expected none: the problem is proved infeasible")
    cost, bound = (_number(data, key, wrongs) for key in ("cost", "lower_bound"))
    if cost is not None and done.whole and not _equal(cost, done.cost):
        wrongs.append(f"cost: found {float(cost):g}, expected {float(done.cost):g}, the sum over the steps")
    if cost is not None and bound is not None:
        wrongs += _bounds(status, cost, bound)
    expected = problem.expected_cost
    if expected is not None:
        wrongs += _optimum(status, expected, cost, bound)
    return wrongs


def _number(data: dict[str, Any], key: str, wrongs: list[str]) -> Fraction | None:
    value = data.get(key)
    if type(value) in (int, Fraction):
        return Fraction(value)
    wrongs.append(f"{key}: found {value!r}, expected a number")
    return None


def _bounds(status: Any, cost: Fraction, bound: Fraction) -> list[str]:
    found = f"lower_bound: found {float(bound):g}"
    if bound > cost and not _equal(bound, cost):
        return [f"{found}, expected at most the cost {float(cost):g}"]
    if status == "optimal" and not _equal(bound, cost):
        return [f"{found}, expected the cost {float(cost):g} of an optimal plan"]
    return []


def _optimum(status: Any, expected: Fraction, cost: Fraction | None, bound: Fraction | None) -> list[str]:
    """Whether cost and bound agree with the optimum that the problem file tells. A plan that does not claim to be
    optimal may cost more."""
    wrongs = []
    if cost is not None and not _equal(cost, expected) and (status != "feasible" or cost < expected):
        least = "at least " if status == "feasible" else ""
        wrongs.append(f"cost: found {float(cost):g}, expected {least}{float(expected):g}, the proved optimum")
    if bound is not None and bound > expected and not _equal(bound, expected):
        wrongs.append(f"lower_bound: found {float(bound):g}, expected at most {float(expected):g}, the proved optimum")
    return wrongs


def _equal(a: Fraction, b: Fraction) -> bool:
    return abs(a - b) <= TOLERANCE * max(1, abs(a), abs(b))
