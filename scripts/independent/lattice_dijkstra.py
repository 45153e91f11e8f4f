"""Dijkstra's method over (pose, uses) of a problem of schema `experiment-lattice-planning/1`, in exact arithmetic."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from fractions import Fraction

from independent.plan_replay import Pose, Problem, blocked

Uses = tuple[int, ...]
# Where an allowed move leads, the number of its informative action (none of a basic one), its cost.
Way = tuple[Pose, int | None, Fraction]


def least_costs(problem: Problem) -> dict[Uses, Fraction]:
    """The least cost of reaching the goal pose with exactly these uses, for all that can be had with at most the counts
    required, in the file's order of actions."""
    counts = tuple(action.count for action in problem.actions.values() if action.count is not None)
    ways: dict[Pose, list[Way]] = {}
    begin = (problem.start, (0,) * len(counts))
    known, settled, at_goal = {begin: Fraction(0)}, set(), {}
    # The number keeps states that cost the same from being compared.
    queue, pushed = [(Fraction(0), 0, begin)], 1
    while queue:
        cost, _, state = heapq.heappop(queue)
        if state in settled:
            continue
        settled.add(state)
        pose, uses = state
        if pose == problem.goal:
            at_goal[uses] = cost
        if pose not in ways:
            ways[pose] = list(ways_on(problem, pose))
        for end, slot, step in ways[pose]:
            if slot is not None and uses[slot] == counts[slot]:
                continue
            after = uses if slot is None else uses[:slot] + (uses[slot] + 1,) + uses[slot + 1 :]
            if cost + step < known.get((end, after), cost + step + 1):
                known[end, after] = cost + step
                heapq.heappush(queue, (cost + step, pushed, (end, after)))
                pushed += 1
    return at_goal


def ways_on(problem: Problem, pose: Pose) -> Iterator[Way]:
    """The allowed moves from a pose."""
    slot = 0
    for action in problem.actions.values():
        for move in action.variants(pose[2]):
            end = (pose[0] + move.di, pose[1] + move.dj, move.to_h)
            if not blocked(problem, pose, end, move):
                yield end, None if action.count is None else slot, move.cost
        slot += action.count is not None
