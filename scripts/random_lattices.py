"""Solves lattice problems by `plan --problem` and by an independent search, and tells where they differ.

    python3 scripts/random_lattices.py --plan target/release/plan --random 1000 --seed 1 --problems ../shared/data/lattice

Every problem is solved by `plan`, and by Dijkstra's method over (pose, uses) in exact fractions. They have to agree on
whether there is a plan and on its cost; the plan is replayed move by move as `check_plan.py` does. Where a problem tells
`expected`, the costs of all its counts are compared with Dijkstra's, too. Prints a line per mismatch and one of sums, and exits
with 1 if there was any. Needs nothing but Python; shares no code with the workspace.
"""

from __future__ import annotations

import argparse
import collections
import json
import random
import subprocess
import sys
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True

from independent.lattice_dijkstra import least_costs, ways_on  # noqa: E402  (no cache before)
from independent.plan_replay import SCHEMA, Problem, check_plan, problem_of, read_json, read_problem  # noqa: E402

NO_ANSWER = 4
CELL = 100
# Share of random problems that some walk solves.
WALKED = 0.75


def main() -> int:
    arguments = parse_arguments()
    tally, mismatches = collections.Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        for path in problems(arguments, Path(folder)):
            problem = read_problem(path)
            costs = least_costs(problem)
            counts = tuple(action.count for action in problem.actions.values() if action.count is not None)
            optimum = costs.get(counts)
            wrongs = expected(path, costs, optimum)
            command = [arguments.plan, "--problem", path, "--quiet", "--out", f"{folder}/plan.json"]
            wrongs += solved(command, problem, optimum)
            for wrong in wrongs:
                print(f"{path.name}: {wrong}")
            tally["infeasible" if optimum is None else "optimal"] += 1
            mismatches += bool(wrongs)
    print(f"{tally.total()} problems: {tally['optimal']} optimal, {tally['infeasible']} infeasible, {mismatches} mismatched")
    return int(mismatches > 0)


def problems(arguments: argparse.Namespace, folder: Path):
    """The files given, then the random ones; a random one is gone when the next is made."""
    for given in arguments.problems:
        yield from sorted(given.glob("*.json")) if given.is_dir() else [given]
    for number in range(arguments.random):
        path = folder / f"random_{arguments.seed}_{number}.json"
        draw = random.Random(f"{arguments.seed} {number}")
        walked = draw.random() < WALKED
        document = random_problem(draw, path.stem)
        while walked and not ask_for_a_walk(draw, document):
            document = random_problem(draw, path.stem)
        path.write_text(json.dumps(document), "utf-8")
        yield path
        path.unlink()


def expected(path: Path, costs: dict[tuple[int, ...], Fraction], optimum: Fraction | None) -> list[str]:
    """What a problem file tells, held against Dijkstra's method."""
    told = read_json(path).get("expected") or {}
    wrongs = []
    if "status" in told and told["status"] != ("infeasible" if optimum is None else "optimal"):
        wrongs.append(f"expected status {told['status']}, Dijkstra's method finds cost {shown(optimum)}")
    rows = [(tuple(row[:-1]), row[-1]) for row in told.get("cost_by_counts", [])]
    found = [(counts, cost, costs.get(counts)) for counts, cost in rows]
    return wrongs + [
        f"expected {shown(cost)} of counts {counts}, Dijkstra's method finds {shown(own)}"
        for counts, cost, own in found
        if cost != own
    ]


def solved(command: list[Any], problem: Problem, optimum: Fraction | None) -> list[str]:
    """What is wrong with the answer of `plan`, whose last argument is where it writes."""
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode == NO_ANSWER and "none (proved)" in ran.stderr:
        return [] if optimum is None else [f"infeasible, Dijkstra's method finds cost {shown(optimum)}"]
    if ran.returncode != 0:
        return [f"exit code {ran.returncode}: {ran.stderr.strip()}"]
    document = read_json(Path(command[-1]))
    data = document["data"]
    wrongs = check_plan(problem, document)
    if data["status"] != "optimal":
        wrongs.append(f"status {data['status']}, expected optimal")
    if optimum is None or abs(Fraction(data["cost"]) - optimum) > Fraction(1, 10**9):
        wrongs.append(f"cost {float(data['cost']):g}, Dijkstra's method finds {shown(optimum)}")
    return wrongs


def shown(cost: Any) -> str:
    return "none" if cost is None else f"{float(cost):g}"


def random_problem(draw: random.Random, name: str) -> dict[str, Any]:
    """A small problem: up to 6 × 6 nodes, 1 to 6 headings, three informative actions of up to three uses, variants, free basic
    moves, costs per move. Edges of swept boxes fall on those of obstacles and bounds now and then."""
    nx, ny, headings = draw.randint(1, 6), draw.randint(1, 6), draw.randint(1, 6)
    origin = [draw.choice([0, 50, -25.5]), draw.choice([0, 50, 1000])]
    low = [value - CELL // 2 for value in origin]
    bounds = [low[0], low[1], low[0] + CELL * nx, low[1] + CELL * ny]
    rule = draw.choice(["paper", "paper", "free", "tenths", "moves"])
    informative = [action(draw, f"zigzag_{k}", headings, rule, True) for k in range(draw.randint(0, 3))]
    basic = [action(draw, f"basic_{k}", headings, rule, False) for k in range(draw.randint(1, 3))]
    pose = lambda: [draw.randrange(nx), draw.randrange(ny), draw.randrange(headings)]  # noqa: E731
    start = pose()
    return {
        "schema": SCHEMA,
        "name": name,
        "lattice": {"nx": nx, "ny": ny, "headings": headings, "cell": CELL, "origin": origin},
        "bounds": bounds,
        "obstacles": [obstacle(draw, bounds) for _ in range(draw.choice([0, 1, 2, 4]))],
        "informative": informative,
        "basic": basic,
        "start": start,
        "goal": start if draw.random() < 0.15 else pose(),
    }


def ask_for_a_walk(draw: random.Random, document: dict[str, Any]) -> bool:
    """Asks for the end and the uses of a random walk of up to twelve moves, so that there is a plan; says whether it leads
    from pose to pose at all and uses something."""
    problem = problem_of(document)
    pose, uses = problem.start, collections.Counter()
    for _ in range(draw.randint(1, 12)):
        ways = [way for way in ways_on(problem, pose) if way[1] is None or uses[way[1]] < 3]
        if ways:
            pose, slot, _ = draw.choice(ways)
            uses[slot] += 1
    document["goal"] = pose
    for slot, own in enumerate(document["informative"]):
        own["count"] = uses[slot]
    return pose != problem.start and any(uses[slot] for slot in range(len(document["informative"])))


def action(draw: random.Random, name: str, headings: int, rule: str, informative: bool) -> dict[str, Any]:
    cost = {
        "paper": 0 if informative else 1,
        "free": 0 if informative else draw.choice([0, 2]),
        "tenths": draw.randint(0, 99) / 10,
        "moves": draw.randint(1, 9),
    }[rule]
    density = draw.choice([1, 2, 2, 3])
    moves = [move(draw, h, headings) for h in range(headings) for _ in range(draw.randint(0, density))]
    if informative and not moves:
        moves = [move(draw, 0, headings)]
    for one in moves if rule == "moves" else []:
        if draw.random() < 0.5:
            one["cost"] = draw.randint(0, 400) / 100
    return {"name": name, "cost": cost, "moves": moves} | ({"count": draw.randint(0, 3)} if informative else {})


def move(draw: random.Random, h: int, headings: int) -> dict[str, Any]:
    di, dj = draw.randint(-2, 2), draw.randint(-2, 2)
    # Half the width of the hull: on whole metres it may touch an obstacle without overlapping it.
    half = draw.choice([9.05, 10, 20.5, 50])
    x, y = sorted([0, CELL * di]), sorted([0, CELL * dj])
    swept = [[x[0] - half, y[0] - half, x[1] + half, y[1] + half]]
    if draw.random() < 0.3:
        swept.append([-30, -half, 30, half])
    return {"h": h, "di": di, "dj": dj, "to_h": draw.randrange(headings), "swept": swept}


def obstacle(draw: random.Random, bounds: list[float]) -> list[int]:
    x, y = (round(draw.uniform(bounds[axis], bounds[axis + 2]), -1) for axis in (0, 1))
    return [int(x), int(y), int(x) + draw.choice([10, 20, 80]), int(y) + draw.choice([10, 40, 150])]


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plan", type=Path, required=True, help="the program `plan`")
    parser.add_argument("--random", type=int, default=0, help="number of random problems")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random problems")
    parser.add_argument("--problems", type=Path, nargs="*", default=[], help="problem files, and folders of them")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
