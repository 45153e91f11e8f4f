"""Replays a plan over its lattice problem and checks what the plan says of itself.

    python scripts/check_plan.py --plan plan.json --problem problem.json

Prints one line per violation and exits with 1, or one line that begins with `ok` and exits with 0. Needs nothing but
Python. Shares no code with the workspace; positions and costs are exact fractions.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True

from independent.plan_replay import Unusable, check_plan, read_json, read_problem  # noqa: E402  (no cache before)


def main() -> int:
    arguments = parse_arguments()
    path = arguments.problem
    try:
        problem = read_problem(path)
        path = arguments.plan
        document = read_json(path)
    except Unusable as error:
        print(f"{path}: {error}")
        return 1
    violations = check_plan(problem, document)
    for violation in violations:
        print(f"{path}: {violation}")
    if violations:
        return 1
    data = document["data"]
    bound = f"lower bound {float(data['lower_bound']):g}"
    print(f"ok: {len(data['steps'])} steps, {data['status']}, cost {float(data['cost']):g}, {bound}")
    return 0


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plan", type=Path, required=True, help="plan.json as written by `plan --problem`")
    parser.add_argument("--problem", type=Path, required=True, help="the problem it was made for")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
