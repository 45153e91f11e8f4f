"""The structure of an RTZ 1.0 route (IEC 61174): distances in nautical miles, speeds in knots."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from .geographic import Position, distance_m, position
from .xml_text import number

NAMESPACE = "http://www.cirm.org/RTZ/1/0"
VERSION = "1.0"
NAUTICAL_MILE_M = 1852.0
# Plausible greatest values: a metre or a metre per second written by mistake lies beyond in most cases.
MOST_XTD_NM, MOST_KNOTS = 10.0, 60.0
DISTANCES = ("starboardXTD", "portsideXTD")
SPEEDS = ("speedMin", "speedMax")
METRES = ("safetyContour", "safetyDepth", "draughtForward", "draughtAft", "staticUKC", "dynamicUKC", "masthead")
TEXTS = ("geometryType", "legReport", "legInfo", "legNote1", "legNote2")
# Files of version 1.0 spell it without the c.
SCHEDULE_ELEMENTS = ("sheduleElement", "scheduleElement")
GEOMETRIES = ("Loxodrome", "Orthodrome")


def check_rtz(root: ET.Element) -> tuple[list[str], list[Position]]:
    """What is wrong with a route, and the positions of its waypoints (none where one is wrong)."""
    if root.tag != _name("route"):
        return [f"root: found {root.tag}, expected {_name('route')}"], []
    wrongs = _only("version", root.get("version"), VERSION)
    wrongs += [f"element: found {tag}, expected one of {NAMESPACE}" for tag in _strangers(root)]
    wrongs += _route_name(root)
    lists = root.findall(_name("waypoints"))
    if len(lists) != 1:
        return wrongs + [f"waypoints: found {len(lists)} lists, expected 1"], []
    waypoints = lists[0].findall(_name("waypoint"))
    if len(waypoints) < 2:
        return wrongs + [f"waypoints: found {len(waypoints)}, expected at least 2"], []
    wrongs += _ids(waypoints) + _legs(lists[0], waypoints)
    positions, misplaced = _positions(waypoints)
    wrongs += misplaced or _radii(lists[0], waypoints, positions)
    return wrongs + _schedules(root, waypoints), [] if misplaced else positions


def _name(tag: str) -> str:
    return f"{{{NAMESPACE}}}{tag}"


def _strangers(element: ET.Element) -> list[str]:
    """Tags of other namespaces outside of extensions."""
    inner = [child for child in element if child.tag != _name("extensions")]
    strange = [child.tag for child in inner if not child.tag.startswith(_name(""))]
    return strange + [tag for child in inner for tag in _strangers(child)]


def _only(thing: str, found: str | None, expected: str) -> list[str]:
    return [] if found == expected else [f"{thing}: found {found}, expected {expected}"]


def _route_name(root: ET.Element) -> list[str]:
    info = root.findall(_name("routeInfo"))
    if len(info) == 1 and info[0].get("routeName"):
        return []
    names = [i.get("routeName") for i in info]
    return [f"routeInfo: found {len(info)} with names {names}, expected 1 with a routeName"]


def _ids(waypoints: list[ET.Element]) -> list[str]:
    """Ids are unique and not negative."""
    wrongs, seen = [], set()
    for index, waypoint in enumerate(waypoints):
        text = waypoint.get("id", "")
        if not (text.isascii() and text.isdigit()):
            wrongs.append(f"waypoint {index}: found id {text!r}, expected a whole number of at least 0")
        elif int(text) in seen:
            wrongs.append(f"waypoint {index}: found id {text} again, expected unique ids")
        else:
            seen.add(int(text))
    return wrongs


def _positions(waypoints: list[ET.Element]) -> tuple[list[Position], list[str]]:
    positions, wrongs = [], []
    for index, waypoint in enumerate(waypoints):
        places = waypoint.findall(_name("position"))
        found = [(place.get("lon"), place.get("lat")) for place in places]
        at = position(*found[0]) if len(found) == 1 else None
        if at is None or None in map(number, found[0]):
            wrongs.append(f"waypoint {index}: found position {found}, expected one lon, lat in ±180, ±90")
        else:
            positions.append(at)
    return positions, wrongs


def _legs(parent: ET.Element, waypoints: list[ET.Element]) -> list[str]:
    """A leg belongs to the waypoint where it ends: the first has none, every other one or the default's."""
    default = parent.find(f"{_name('defaultWaypoint')}/{_name('leg')}")
    wrongs = [] if default is None else _leg("defaultWaypoint", default)
    for index, waypoint in enumerate(waypoints):
        legs = waypoint.findall(_name("leg"))
        if index == 0 and legs:
            wrongs.append("waypoint 0: found a leg, expected none: no leg ends at the first waypoint")
        elif len(legs) > 1 or (index > 0 and not legs and default is None):
            wrongs.append(f"waypoint {index}: found {len(legs)} legs, expected 1")
        for leg in legs:
            wrongs += _leg(f"waypoint {index}", leg)
    return wrongs


def _leg(where: str, leg: ET.Element) -> list[str]:
    """Attributes of a leg: known, numbers in range, a slowest speed that is not above the fastest."""
    known = (*DISTANCES, *SPEEDS, *METRES, *TEXTS)
    unknown = [attribute for attribute in leg.keys() if attribute not in known]
    wrongs = [f"{where}: found leg attribute {name}, expected one of {', '.join(known)}" for name in unknown]
    most = dict.fromkeys(DISTANCES, MOST_XTD_NM) | dict.fromkeys(SPEEDS, MOST_KNOTS) | dict.fromkeys(METRES, 1e4)
    for attribute, limit in most.items():
        value = number(leg.get(attribute))
        if attribute in leg.keys() and (value is None or not 0 <= value <= limit):
            wrongs.append(f"{where}: found {attribute} {leg.get(attribute)!r}, expected a number from 0 to {limit:g}")
    geometry = leg.get("geometryType", GEOMETRIES[0])
    if geometry not in GEOMETRIES:
        wrongs.append(f"{where}: found geometryType {geometry}, expected {' or '.join(GEOMETRIES)}")
    slowest, fastest = (number(leg.get(key)) for key in SPEEDS)
    if slowest is not None and fastest is not None and slowest > fastest:
        wrongs.append(f"{where}: found speedMin {slowest:g} above speedMax {fastest:g}, expected at most that")
    return wrongs


def _radii(parent: ET.Element, waypoints: list[ET.Element], positions: list[Position]) -> list[str]:
    """Turns fit: a radius is below half of the shorter leg beside it."""
    default = parent.find(_name("defaultWaypoint"))
    usual = None if default is None else default.get("radius")
    lengths = [distance_m(a, b) / NAUTICAL_MILE_M for a, b in zip(positions, positions[1:])]
    empty = [index for index, length in enumerate(lengths, 1) if length == 0]
    wrongs = [f"leg to waypoint {index}: found length 0, expected distinct waypoints" for index in empty]
    for index, waypoint in enumerate(waypoints):
        text = waypoint.get("radius", usual)
        radius, shortest = number(text), min(lengths[max(index - 1, 0) : index + 1])
        if text is not None and (radius is None or radius < 0):
            wrongs.append(f"waypoint {index}: found radius {text!r}, expected nautical miles of at least 0")
        elif radius is not None and radius > 0 and radius >= shortest / 2:
            half = f"half the shortest adjacent leg, {shortest / 2:.5f} NM"
            wrongs.append(f"waypoint {index}: found radius {radius:g} NM, expected below {half}")
    return wrongs


def _schedules(root: ET.Element, waypoints: list[ET.Element]) -> list[str]:
    """Elements of schedules name waypoints that exist."""
    ids = {waypoint.get("id") for waypoint in waypoints}
    elements = (element for tag in SCHEDULE_ELEMENTS for element in root.iter(_name(tag)))
    strays = [element.get("waypointId") for element in elements if element.get("waypointId") not in ids]
    return [f"schedule: found waypointId {found}, expected the id of a waypoint" for found in strays]
