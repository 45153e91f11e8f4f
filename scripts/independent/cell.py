"""Dangers of an S-57 cell on the plane of a planned trial, read by GDAL through pyogrio, which brings its own GDAL.

By the table of `docs/own-chart.md`: what every class of objects is judged by, and what it then means for the ship.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import Any, Iterator

import numpy as np
from scipy.ndimage import distance_transform_edt

from .voyage import Voyage
from .waters import Depths, Plane, densified

OPTIONS = "UPDATES=APPLY,SPLIT_MULTIPOINT=OFF,RETURN_PRIMITIVES=ON,RETURN_LINKAGES=ON,LNAM_REFS=OFF"

DEPTHS = "DEPARE DRGARE".split()
DANGERS = "OBSTRN WRECKS UWTROC".split()
BODIES = (
    "PONTON HULKES FLODOC SLCONS DRYDOC CAUSWY DAMCON DYKCON GATCON PYLONS OFSPLF PILPNT MORFAC OILBAR FSHFAC MARCUL LOGPON ICEARE "
    "OSPARE PRDARE LITFLT LITVES RAPIDS WATFAL LNDMRK BUISGL SILTNK CRANES DAYMAR DISMAR FORSTC FNCLNE CTRPNT RUNWAY VEGATN BOYCAR "
    "BOYINB BOYISD BOYLAT BOYSAW BOYSPP BCNCAR BCNISD BCNLAT BCNSAW BCNSPP NEWOBJ"
).split()
OVERHEAD = "BRIDGE CBLOHD PIPOHD CONVYR".split()
CLOSED_PLACES = "UNSARE TSEZNE TSSRON RESARE".split()
FOR_TRANSIT = (
    "FAIRWY TSSLPT TSSCRS TSSBND TSELNE ISTZNE PRCARE DWRTPT TWRTPT ACHARE ACHBRT PILBOP MIPARE SUBTLN SPLARE CTNARE"
).split()
# WATLEV: dry, awash at times or afloat; QUAPOS: positions that are good enough; RESTRN: no entry, and no maneuvers.
DRY, GOOD, NO_ENTRY, NO_MANEUVERS = {1, 2, 7}, {1, 4, 10, 11}, {7, 8, 14}, {13, 25, 27}
# Half a millimetre on paper, and radii where `plan.toml` states none [m].
DRAWN, RADIUS_M, DOUBTFUL_M = 0.5e-3, 50.0, 500.0
# Types of geometries in well-known binary.
POINT, LINE, POLYGON, MANY = 1, 2, 3, (4, 5, 6, 7)
# By how much a place on an edge is moved to see on which side of it an object is [°].
LITTLE_DEG = 1e-7
# Codes of S-57 for isolated and connected nodes and edges, and GDAL's names for them.
PRIMITIVES = {110: "IsolatedNode", 120: "ConnectedNode", 130: "Edge"}


class Reader:
    """A cell with its updates. Says why it cannot be read."""

    def __init__(self, cell: Path) -> None:
        os.environ["OGR_S57_OPTIONS"] = OPTIONS
        try:
            import pyogrio
        except ImportError as error:
            raise SystemExit(f"{cell}: {error}; an S-57 cell needs GDAL: pip install pyogrio") from error
        if "S57" not in pyogrio.list_drivers():
            raise SystemExit(f"{cell}: this GDAL ({pyogrio.__gdal_version_string__}) has no driver for S-57")
        self.cell, self.raw = cell, pyogrio.raw
        layers = {str(name) for name, _ in pyogrio.list_layers(cell)}
        _, _, _, fields = self.read("DSID")
        self.scale = int(fields["DSPM_CSCL"][0])
        self.quality = {code: self.qualities(name) for code, name in PRIMITIVES.items() if name in layers}
        self.layers = layers - {"DSID", "Face", *PRIMITIVES.values()}

    def read(self, layer: str) -> tuple[Any, Any, Any, dict[str, Any]]:
        meta, ids, geometries, values = self.raw.read(self.cell, layer=layer)
        return meta, ids, geometries, dict(zip(meta["fields"], values))

    def qualities(self, name: str) -> dict[int, int]:
        """QUAPOS of the nodes or edges that state it."""
        _, _, _, fields = self.read(name)
        pairs = zip(fields["RCID"], fields["QUAPOS"])
        return {int(record): int(value) for record, value in pairs if value is not None and not np.isnan(float(value))}

    def objects(self, layer: str) -> Iterator[dict[str, Any]]:
        """Objects of a class, each with its attributes and its parts: (type, rings or points)."""
        _, _, geometries, fields = self.read(layer)
        if geometries is None:
            return
        for index, geometry in enumerate(geometries):
            own = {name: values[index] for name, values in fields.items()}
            yield own | {"parts": list(parts_of(geometry))}

    def is_doubtful(self, own: dict[str, Any]) -> bool:
        """Whether the position of any of its nodes or edges is not known well."""
        kinds, records = own.get("NAME_RCNM"), own.get("NAME_RCID")
        if kinds is None or records is None:
            return False
        stated = (self.quality.get(int(kind), {}).get(int(record)) for kind, record in zip(kinds, records))
        return any(value is not None and value not in GOOD for value in stated)


class Cell(Depths):
    """Distances from what a cell charts as too shoal or closed, by a raster."""

    def __init__(self, voyage: Voyage, reader: Reader, chart: dict[str, Any], depth: float, in_maneuvers: bool) -> None:
        self.lay(voyage)
        self.plane = Plane(voyage)
        self.voyage, self.chart, self.depth, self.in_maneuvers = voyage, chart, depth, in_maneuvers
        self.reader, cell = reader, reader.cell
        unknown = [key for key in ("rules", "depth_unit") if chart.get(key)]
        if unknown or voyage.config.get("uncharted", "obstacle") != "obstacle":
            raise SystemExit(f"{cell}: `{(unknown or ['uncharted'])[0]}`, which this script does not apply")
        self.marks: dict[float, list[np.ndarray]] = {}
        self.counts: dict[str, int] = {}
        deep, closed = np.zeros(self.shape, dtype=bool), np.zeros(self.shape, dtype=bool)
        self.land = [part for own in self.reader.objects("LNDARE") for part in own["parts"] if part[0] == POLYGON]
        for layer in sorted(self.reader.layers):
            for own in self.reader.objects(layer):
                if self.is_near(own):
                    self.take(layer, own, deep, closed)
        blocked = ~deep | closed
        for radius, places in self.marks.items():
            blocked |= self.around(np.concatenate(places), radius)
        self.far = np.minimum(distance_transform_edt(~blocked) * self.CELL_M, self.SIGHT_M)

    def is_near(self, own: dict[str, Any]) -> bool:
        """Whether any of it may be on the raster, with the largest radius."""
        rings = [self.flat(ring) for _, rings in own["parts"] for ring in rings]
        if not rings:
            return False
        places, most = np.concatenate(rings), max(DOUBTFUL_M, self.chart.get("doubtful_radius_m", 0.0))
        high = self.low + self.CELL_M * np.array(self.shape)
        return bool((places.max(axis=0) > self.low - most).all() and (places.min(axis=0) < high + most).all())

    def take(self, layer: str, own: dict[str, Any], deep: np.ndarray, closed: np.ndarray) -> None:
        if layer in DEPTHS:
            is_deep = number(own, "DRVAL1", -np.inf) >= self.depth
            for _, rings in (part for part in own["parts"] if part[0] == POLYGON):
                self.fill([self.flat(ring) for ring in rings], deep if is_deep else closed)
        elif layer == "SOUNDG":
            shoal = [ring[ring[:, 2] < self.depth] for _, rings in own["parts"] for ring in rings]
            self.mark(layer, own, [(POINT, [ring]) for ring in shoal if len(ring)], closed)
        elif self.is_avoided(layer, own):
            self.mark(layer, own, own["parts"], closed)

    def is_avoided(self, layer: str, own: dict[str, Any]) -> bool:
        """Whether the ship keeps out, under way or in maneuvers."""
        restrictions = codes(own, "RESTRN")
        if layer == "LNDARE":
            return True
        if layer in OVERHEAD and self.passes_under(own):
            return False
        if restrictions & NO_ENTRY:
            return True
        if layer == "RESARE" and restrictions:
            return self.in_maneuvers and bool(restrictions & NO_MANEUVERS)
        if layer == "DISMAR" and codes(own, "CATDIS") == {1}:
            return False
        if layer in DANGERS:
            known = number(own, "VALSOU", -np.inf)
            return known < self.depth or bool(codes(own, "WATLEV") & DRY)
        if layer in BODIES + OVERHEAD:
            return not self.is_on_land(own)
        if layer in CLOSED_PLACES:
            return True
        return self.in_maneuvers and (layer in FOR_TRANSIT or bool(restrictions & NO_MANEUVERS))

    def passes_under(self, own: dict[str, Any]) -> bool:
        least = min(number(own, name, np.inf) for name in ("VERCLR", "VERCCL", "VERCSA"))
        return bool(np.isfinite(least)) and self.voyage.config["hull"].get("air_draught_m", np.inf) <= least

    def is_on_land(self, own: dict[str, Any]) -> bool:
        """Whether all of it is within land areas: its corners and points of its edges, also if moved a little."""
        rings = [along(ring[:, :2], kind) for kind, rings in own["parts"] for ring in rings]
        corners = np.concatenate(rings)
        places = np.concatenate([corners + shift for shift in LITTLE_DEG * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])])
        on, low, high = np.zeros(len(places), dtype=bool), places.min(axis=0), places.max(axis=0)
        for _, rings in self.land:
            if (rings[0][:, :2].max(axis=0) < low).any() or (rings[0][:, :2].min(axis=0) > high).any():
                continue
            odd = np.zeros(len(places), dtype=bool)
            for ring in rings:
                odd ^= within(places, ring[:, :2])
            on |= odd
        return bool(on.all())

    def mark(self, layer: str, own: dict[str, Any], parts: list[Any], closed: np.ndarray) -> None:
        """Closes areas, and notes points and lines with their radius."""
        self.counts[layer] = self.counts.get(layer, 0) + 1
        for kind, rings in parts:
            flat = [self.flat(ring) for ring in rings]
            if kind == POLYGON:
                self.fill(flat, closed)
                continue
            low, high = self.low - DOUBTFUL_M, self.low + self.CELL_M * np.array(self.shape) + DOUBTFUL_M
            places = [densified(ring, self.CELL_M, low, high, closed=False) if kind == LINE else ring for ring in flat]
            self.marks.setdefault(self.radius(layer, own, kind), []).extend(places)

    def radius(self, layer: str, own: dict[str, Any], kind: int) -> float:
        drawn = DRAWN * self.reader.scale
        reaches = layer in [*DANGERS, "SOUNDG"] or (kind == POINT and layer in BODIES + OVERHEAD)
        if not reaches:
            return drawn
        doubtful = self.reader.is_doubtful(own)
        stated = ("doubtful_radius_m", DOUBTFUL_M) if doubtful else ("radius_m", RADIUS_M)
        return max(drawn, self.chart.get(*stated))

    def around(self, places: np.ndarray, radius: float) -> np.ndarray:
        """Cells whose centres are within a radius of a place."""
        reach = int(np.ceil(radius / self.CELL_M)) + 1
        padded = np.ones(tuple(np.array(self.shape) + 2 * reach), dtype=bool)
        cells = np.floor((places - self.low) / self.CELL_M).astype(int) + reach
        cells = cells[((cells >= 0) & (cells < padded.shape)).all(axis=1)]
        padded[cells[:, 0], cells[:, 1]] = False
        near = distance_transform_edt(padded) * self.CELL_M <= radius
        return near[reach:-reach, reach:-reach]

    def flat(self, ring: np.ndarray) -> np.ndarray:
        return self.plane.flat(ring)


def number(own: dict[str, Any], name: str, otherwise: float) -> float:
    value = own.get(name)
    return otherwise if value is None or np.isnan(float(value)) else float(value)


def codes(own: dict[str, Any], name: str) -> set[int]:
    """Values of an attribute that may be a list."""
    value = own.get(name)
    if value is None:
        return set()
    values = [value] if np.isscalar(value) else list(value)
    return {int(float(one)) for one in values if str(one) not in ("", "nan")}


def along(ring: np.ndarray, kind: int) -> np.ndarray:
    """Corners, and places on the edges between them."""
    if kind == POINT:
        return ring
    after = np.roll(ring, -1, axis=0) if kind == POLYGON else ring[1:]
    before = ring[: len(after)]
    return np.concatenate([ring, *(before + part * (after - before) for part in np.linspace(0.0, 1.0, 40)[1:-1])])


def within(places: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Whether places are inside a ring, by the number of edges to their right."""
    (x0, y0), (x1, y1) = ring.T, np.roll(ring, -1, axis=0).T
    slope = (x1 - x0) / np.where(y0 == y1, 1.0, y1 - y0)
    low, high = np.minimum(y0, y1), np.maximum(y0, y1)
    counts = [((y >= low) & (y < high) & (x < x0 + (y - y0) * slope)).sum() for x, y in places]
    return np.array(counts) % 2 == 1


def parts_of(binary: bytes | None) -> Iterator[tuple[int, list[np.ndarray]]]:
    """Points, lines and polygons of a geometry in well-known binary: a type, and rings of places."""
    if binary is None:
        return

    def take(at: int) -> tuple[list[tuple[int, list[np.ndarray]]], int]:
        order = "<" if binary[at] else ">"
        (code,) = struct.unpack_from(order + "I", binary, at + 1)
        kind, width = (code & 0x7FFFFFFF) % 1000, 3 if code >= 0x80000000 or 1000 <= code < 2000 else 2
        at += 5

        def places(at: int, count: int) -> tuple[np.ndarray, int]:
            values = np.frombuffer(binary, order + "f8", count * width, at).reshape(count, width)
            return values, at + 8 * count * width

        if kind == POINT:
            own, at = places(at, 1)
            return [(POINT, [own])], at
        (count,) = struct.unpack_from(order + "I", binary, at)
        at += 4
        if kind == LINE:
            own, at = places(at, count)
            return [(LINE, [own])], at
        if kind == POLYGON:
            rings = []
            for _ in range(count):
                (length,) = struct.unpack_from(order + "I", binary, at)
                own, at = places(at + 4, length)
                rings.append(own[:-1])
            return [(POLYGON, rings)], at
        if kind not in MANY:
            raise SystemExit(f"a geometry of type {code}, which this script does not read")
        found = []
        for _ in range(count):
            own, at = take(at)
            found += own
        return found, at

    yield from take(0)[0]
