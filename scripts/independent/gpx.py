"""The structure of a GPX 1.1 file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from datetime import datetime

from .geographic import Position, position
from .xml_text import number

NAMESPACE = "http://www.topografix.com/GPX/1/1"
VERSION = "1.1"
# Children of the root, in the order that the schema demands.
ORDER = ("metadata", "wpt", "rte", "trk", "extensions")


@dataclass
class Gpx:
    """Points of all routes and of all tracks, in order, and when those of routes are reached [s since 1970]."""

    route: list[Position] = field(default_factory=list)
    track: list[Position] = field(default_factory=list)
    times: list[float] = field(default_factory=list)


def check_gpx(root: ET.Element) -> tuple[list[str], Gpx]:
    """What is wrong with a file, and its points that are right."""
    if root.tag != _name("gpx"):
        return [f"root: found {root.tag}, expected {_name('gpx')}"], Gpx()
    wrongs = []
    if root.get("version") != VERSION:
        wrongs.append(f"version: found {root.get('version')}, expected {VERSION}")
    if not root.get("creator"):
        wrongs.append("creator: found none, expected the name of a program")
    wrongs += _order(root)
    _points(root.findall(_name("wpt")), "wpt", wrongs)
    route = _points(root.findall(f"{_name('rte')}/{_name('rtept')}"), "rtept", wrongs)
    times = _times(root.findall(f"{_name('rte')}/{_name('rtept')}/{_name('time')}"), wrongs)
    track = _points(root.findall(f"{_name('trk')}/{_name('trkseg')}/{_name('trkpt')}"), "trkpt", wrongs)
    for points, place in ((route, "rtept in rte"), (track, "trkpt in trk and trkseg")):
        tag = place.split()[0]
        stray = len(list(root.iter(_name(tag)))) - len(points)
        if stray and not any(wrong.startswith(tag) for wrong in wrongs):
            wrongs.append(f"{tag}: found {stray} elsewhere, expected every {place}")
    if not route and not track:
        wrongs.append("points: found none, expected a route or a track")
    return wrongs, Gpx(route, track, times)


def _name(tag: str) -> str:
    return f"{{{NAMESPACE}}}{tag}"


def _order(root: ET.Element) -> list[str]:
    """Children of the root are known and in the order of the schema."""
    ranks = {_name(tag): rank for rank, tag in enumerate(ORDER)}
    unknown = [child.tag for child in root if child.tag not in ranks]
    if unknown:
        return [f"gpx: found child {tag}, expected one of {', '.join(ORDER)}" for tag in unknown]
    found = [ranks[child.tag] for child in root]
    return [] if found == sorted(found) else [f"gpx: found children out of order, expected {', '.join(ORDER)}"]


def _points(points: list[ET.Element], tag: str, wrongs: list[str]) -> list[Position]:
    """Positions of points in range; `wrongs` gets a line for every other one."""
    positions = []
    for index, point in enumerate(points):
        lon, lat = point.get("lon"), point.get("lat")
        at = position(lon, lat)
        # The schema's longitude ends before 180.
        if at is None or number(lon) is None or number(lat) is None or at[0] == 180:
            wrongs.append(f"{tag} {index}: found lon {lon}, lat {lat}, expected -180 <= lon < 180 and -90 <= lat <= 90")
        else:
            positions.append(at)
    return positions


def _times(elements: list[ET.Element], wrongs: list[str]) -> list[float]:
    """Times of arrival, to the second; `wrongs` gets a line where they run backwards."""
    texts = [element.text or "" for element in elements]
    try:
        times = [datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp() for text in texts]
    except ValueError:
        wrongs.append(f"rtept: found times {texts}, expected those of XML Schema")
        return []
    if any(a > b for a, b in zip(times, times[1:])):
        wrongs.append(f"rtept: found times {texts}, expected times that do not run backwards")
    return times
