"""The structure of a GeoPackage 1.3 (OGC 12-128r17) with the layers of a route."""

from __future__ import annotations

import sqlite3
import struct
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from .geographic import Position, position
from .xml_text import Unreadable

APPLICATION_ID, USER_VERSION, WGS84 = 0x47504B47, 10300, 4326
LAYERS = ("corridors", "legs", "waypoints", "track")
# What the times of a waypoint may differ by [s].
SAME_S = 0.001
# Doubles of the extent that a geometry's header holds, by its flags.
EXTENTS = {0: 0, 1: 4, 2: 6, 3: 6, 4: 8}


@dataclass
class Package:
    """Waypoints in their order, and when each is reached [s since 1970]: all of them, or none."""

    waypoints: list[Position] = field(default_factory=list)
    times: list[float] = field(default_factory=list)


def check_gpkg(path: Path) -> tuple[list[str], Package]:
    """What is wrong with a file, and its waypoints (none where one is wrong)."""
    if not path.is_file():
        raise Unreadable("cannot be read: no file")
    file = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        return _checked(file)
    except sqlite3.Error as error:
        raise Unreadable(f"not a GeoPackage: {error}") from error
    finally:
        file.close()


def _checked(file: sqlite3.Connection) -> tuple[list[str], Package]:
    wrongs = []
    expectations = {"application_id": APPLICATION_ID, "user_version": USER_VERSION, "integrity_check": "ok"}
    for pragma, expected in expectations.items():
        found = file.execute(f"PRAGMA {pragma}").fetchone()[0]
        wrongs += [] if found == expected else [f"{pragma}: found {found}, expected {expected}"]
    listed = "SELECT table_name FROM gpkg_contents WHERE data_type = 'features' AND srs_id = ? ORDER BY rowid"
    found = tuple(name for (name,) in file.execute(listed, (WGS84,)))
    if found != LAYERS:
        return wrongs + [f"layers: found {', '.join(found)}, expected {', '.join(LAYERS)}"], Package()
    rows = file.execute("SELECT number, geom, eta, after_departure_s FROM waypoints ORDER BY fid").fetchall()
    if len(rows) < 2:
        return wrongs + [f"waypoints: found {len(rows)}, expected at least 2"], Package()
    numbers = [number for number, *_ in rows]
    if any(not isinstance(n, int) or n < 0 for n in numbers) or any(a >= b for a, b in zip(numbers, numbers[1:])):
        wrongs.append(f"waypoints: found numbers {numbers}, expected whole numbers that increase")
    places = [_point(geometry) for _, geometry, *_ in rows]
    misplaced = [index for index, place in enumerate(places) if place is None]
    wrongs += [f"waypoint {index}: found no point of WGS84 in ±180, ±90" for index in misplaced]
    times, untimely = _times([eta for *_, eta, _ in rows], [after for *_, after in rows])
    wrongs += untimely
    if misplaced or untimely:
        return wrongs, Package()
    return wrongs, Package([place for place in places if place], times)


def _point(geometry: object) -> Position | None:
    """The place of a GeoPackage's binary point, in either order of bytes."""
    if not isinstance(geometry, bytes) or geometry[:3] != b"GP\0" or len(geometry) < 8:
        return None
    order = "<" if geometry[3] & 1 else ">"
    extent = EXTENTS.get(geometry[3] >> 1 & 7)
    if extent is None or struct.unpack_from(f"{order}i", geometry, 4)[0] != WGS84:
        return None
    point = geometry[8 + 8 * extent :]
    if len(point) != 21 or point[0] > 1:
        return None
    kind, lon, lat = struct.unpack_from(f"{'<' if point[0] else '>'}Idd", point, 1)
    return position(lon, lat) if kind == 1 else None


def _times(etas: list[object], afters: list[object]) -> tuple[list[float], list[str]]:
    """Times of arrival that increase as those after the departure do; none of them where no departure is known."""
    if any(not isinstance(after, float) for after in afters):
        return [], [f"waypoints: found after_departure_s {afters}, expected seconds"]
    later = [after - afters[0] for after in afters]
    if any(a >= b for a, b in zip(later, later[1:])):
        return [], [f"waypoints: found after_departure_s {afters}, expected seconds that increase"]
    if all(eta is None for eta in etas):
        return [], []
    try:
        times = [datetime.fromisoformat(str(eta).replace("Z", "+00:00")).timestamp() for eta in etas]
    except ValueError:
        return [], [f"waypoints: found eta {etas}, expected a time of each or of none"]
    off = [i for i, (time, after) in enumerate(zip(times, later)) if abs(time - times[0] - after) > SAME_S]
    wrongs = [f"waypoint {i}: found eta {etas[i]}, expected {later[i]} s after {etas[0]}" for i in off]
    return ([], wrongs) if wrongs else (times, [])
