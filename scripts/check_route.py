"""Checks the structure of a route's files, and that they tell the same route.

    python scripts/check_route.py --rtz route.rtz --gpx route.gpx --geojson track.geojson

Prints one line per violation and exits with 1, or one line that begins with `ok` and exits with 0. Needs nothing but
Python. Shares no code with the workspace; lengths are great circles on the sphere.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

sys.dont_write_bytecode = True

from independent.geographic import Position, distance_m  # noqa: E402  (no cache before)
from independent.geojson import check_geojson  # noqa: E402
from independent.gpx import Gpx, check_gpx  # noqa: E402
from independent.rtz import check_rtz  # noqa: E402
from independent.xml_text import Unreadable, read_root  # noqa: E402

# The files round positions each in its own way.
NEAR_M = 5.0


def main() -> int:
    arguments = parse_arguments()
    violations, waypoints = checked(arguments.rtz, read_root, check_rtz, [])
    wrong, gpx = checked(arguments.gpx, read_root, check_gpx, Gpx())
    violations += wrong
    wrong, lines = checked(arguments.geojson, read_document, check_geojson, [])
    violations += wrong
    if not violations:
        violations = differences(waypoints, gpx, lines)
    for violation in violations:
        print(violation)
    if violations:
        return 1
    length = sum(distance_m(a, b) for a, b in zip(waypoints, waypoints[1:]))
    print(f"ok: {len(waypoints)} waypoints over {length / 1852:.2f} NM, {len(lines)} lines of track")
    return 0


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rtz", type=Path, required=True, help="route.rtz: RTZ 1.0")
    parser.add_argument("--gpx", type=Path, required=True, help="route.gpx: GPX 1.1")
    parser.add_argument("--geojson", type=Path, required=True, help="track.geojson: RFC 7946")
    return parser.parse_args()


def checked(path: Path, read: Any, check: Any, nothing: Any) -> tuple[list[str], Any]:
    """What is wrong with one file, each line with its name, and what the file tells."""
    try:
        wrongs, content = check(read(path))
    except Unreadable as error:
        wrongs, content = [str(error)], nothing
    return [f"{path}: {wrong}" for wrong in wrongs], content


def read_document(path: Path) -> Any:
    """A JSON document without NaN and infinities."""

    def refused(constant: str) -> None:
        raise ValueError(f"{constant} is no number")

    try:
        return json.loads(path.read_text("utf-8"), parse_constant=refused)
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise Unreadable(f"not JSON: {error}") from error


def differences(waypoints: list[Position], gpx: Gpx, lines: list[list[Position]]) -> list[str]:
    """Where the files, each right by itself, tell different routes."""
    wrongs = []
    if gpx.route and len(gpx.route) != len(waypoints):
        wrongs.append(f"gpx: found {len(gpx.route)} route points, expected {len(waypoints)} as in the rtz")
    elif gpx.route:
        pairs = enumerate(zip(waypoints, gpx.route))
        wrongs += [w for index, (a, b) in pairs for w in apart(f"gpx: route point {index}", b, a)]
    if gpx.track:
        wrongs += ends("gpx: track", gpx.track[0], gpx.track[-1], waypoints)
    if not lines:
        return wrongs + ["geojson: found no line, expected a track"]
    return wrongs + ends("geojson: track", lines[0][0], lines[-1][-1], waypoints)


def ends(what: str, first: Position, last: Position, waypoints: list[Position]) -> list[str]:
    """Whether a track begins and ends where the waypoints do."""
    return apart(f"{what} begins", first, waypoints[0]) + apart(f"{what} ends", last, waypoints[-1])


def apart(what: str, found: Position, expected: Position) -> list[str]:
    distance = distance_m(found, expected)
    if distance <= NEAR_M:
        return []
    return [f"{what}: found {found}, {distance:.1f} m from the rtz's {expected}, expected within {NEAR_M:g} m"]


if __name__ == "__main__":
    sys.exit(main())
