"""The structure of a GeoJSON FeatureCollection (RFC 7946)."""

from __future__ import annotations

from typing import Any

from .geographic import Position, position

# How deep the positions of a geometry are nested, and how many a line or ring needs.
DEPTHS = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
LINES = ("LineString", "MultiLineString")
AREAS = ("Polygon", "MultiPolygon")


def check_geojson(document: Any) -> tuple[list[str], list[list[Position]]]:
    """What is wrong with a document, and its lines in order."""
    if not isinstance(document, dict) or document.get("type") != "FeatureCollection":
        return ["root: found no FeatureCollection, expected one"], []
    features = document.get("features")
    if not isinstance(features, list):
        return ["features: found none, expected a list"], []
    wrongs = _members("root", document, ("coordinates", "geometries", "geometry", "properties"))
    lines: list[list[Position]] = []
    for index, feature in enumerate(features):
        where = f"feature {index}"
        if not isinstance(feature, dict) or feature.get("type") != "Feature":
            wrongs.append(f"{where}: found no Feature, expected one")
            continue
        wrongs += _members(where, feature, ("coordinates", "geometries", "features"))
        missing = [key for key in ("geometry", "properties") if key not in feature]
        wrongs += [f"{where}: found no `{key}`, expected it" for key in missing]
        if not isinstance(feature.get("properties"), dict | None):
            wrongs.append(f"{where}: found properties that are no object, expected an object or null")
        if isinstance(feature.get("id", ""), bool) or not isinstance(feature.get("id", ""), str | int | float):
            wrongs.append(f"{where}: found id {feature['id']!r}, expected text or a number")
        if feature.get("geometry") is not None:
            _geometry(where, feature["geometry"], wrongs, lines)
    return wrongs, lines


def _members(where: str, value: dict[str, Any], forbidden: tuple[str, ...]) -> list[str]:
    """Members that the standard forbids, and a bounding box that it does not allow."""
    wrongs = [f"{where}: found `{key}`, expected none" for key in ("crs", *forbidden) if key in value]
    if "bbox" in value and not _is_box(value["bbox"]):
        wrongs.append(f"{where}: found bbox {value['bbox']}, expected west, south, east, north in range")
    return wrongs


def _is_box(box: Any) -> bool:
    if not isinstance(box, list) or len(box) not in (4, 6) or not all(map(_is_number, box)):
        return False
    half = len(box) // 2
    low, high = position(box[0], box[1]), position(box[half], box[half + 1])
    return low is not None and high is not None and low[1] <= high[1]


def _geometry(where: str, geometry: Any, wrongs: list[str], lines: list[list[Position]]) -> None:
    """Checks one geometry; `lines` gets its lines."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection" and isinstance(geometry.get("geometries"), list):
        for part in geometry["geometries"]:
            _geometry(where, part, wrongs, lines)
        return
    if kind not in DEPTHS:
        wrongs.append(f"{where}: found geometry {kind}, expected one of {', '.join(DEPTHS)}, GeometryCollection")
        return
    wrongs += _members(where, geometry, ("geometry", "properties", "features"))
    try:
        coordinates = _positions(geometry.get("coordinates"), DEPTHS[kind])
    except ValueError as error:
        wrongs.append(f"{where}: found {error}, expected the coordinates of a {kind}")
        return
    if kind in LINES:
        parts = [coordinates] if kind == "LineString" else coordinates
        wrongs += [f"{where}: found a line of {len(p)} positions, expected at least 2" for p in parts if len(p) < 2]
        lines += [part for part in parts if len(part) > 1]
    if kind in AREAS:
        for polygon in [coordinates] if kind == "Polygon" else coordinates:
            wrongs += [f"{where}: {wrong}" for wrong in _polygon(polygon)]


def _positions(value: Any, depth: int) -> Any:
    """Positions nested `depth` deep, as pairs. Raises ValueError for anything else."""
    if not isinstance(value, list):
        raise ValueError(f"{value!r}")
    if depth:
        return [_positions(part, depth - 1) for part in value]
    at = position(value[0], value[1]) if len(value) in (2, 3) and all(map(_is_number, value)) else None
    if at is None:
        raise ValueError(f"{value}")
    return at


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _polygon(rings: list[list[Position]]) -> list[str]:
    """Rings are closed; the first runs counter-clockwise, holes run clockwise."""
    wrongs = []
    for index, ring in enumerate(rings):
        if len(ring) < 4 or ring[0] != ring[-1]:
            wrongs.append(f"found ring {index} of {len(ring)} positions, expected at least 4, the last as the first")
            continue
        if (_doubled_area(ring) > 0) != (index == 0):
            expected = "counter-clockwise" if index == 0 else "clockwise"
            wrongs.append(f"found ring {index} in the wrong direction, expected {expected}")
    return wrongs if rings else ["found a polygon without rings, expected at least 1"]


def _doubled_area(ring: list[Position]) -> float:
    x, y = ring[0]
    pairs = zip(ring, ring[1:])
    return sum((a[0] - x) * (b[1] - y) - (b[0] - x) * (a[1] - y) for a, b in pairs)
