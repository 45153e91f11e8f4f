"""Positions on the sphere."""

from __future__ import annotations

import math
from typing import Any

# Mean radius of the Earth [m].
RADIUS_M = 6_371_008.8

# Longitude, latitude [deg].
Position = tuple[float, float]


def distance_m(a: Position, b: Position) -> float:
    """Length of the great circle between two positions (haversine)."""
    lon_a, lat_a, lon_b, lat_b = map(math.radians, (*a, *b))
    half = math.sin((lat_b - lat_a) / 2) ** 2 + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
    return 2 * RADIUS_M * math.asin(math.sqrt(min(1.0, half)))


def position(lon: Any, lat: Any) -> Position | None:
    """A position in range from numbers or their text, if it is one."""
    try:
        found = (float(lon), float(lat))
    except (TypeError, ValueError):
        return None
    return found if abs(found[0]) <= 180 and abs(found[1]) <= 90 else None
