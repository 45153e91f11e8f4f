"""What GDAL reads of an S-57 cell with its updates: per object class counts, sums and sizes, as JSON.

    python3 scripts/independent/enc.py ../shared/data/charts/enc/US4MD81M.000 fixtures/oracle/enc.json

Needs GDAL's Python bindings (Debian: python3-gdal). The cell itself is not part of the project.
"""

import json
import math
import os
import sys

os.environ["OGR_S57_OPTIONS"] = "UPDATES=APPLY,SPLIT_MULTIPOINT=OFF,RETURN_LINKAGES=OFF,LNAM_REFS=OFF"
from osgeo import ogr  # noqa: E402

NUMBERS = ["VALSOU", "DRVAL1", "VALDCO", "VERCLR"]
CODES = ["WATLEV", "CATCOV"]


def parts(geometry):
    """Points, lines and polygons, whatever they are wrapped in."""
    if geometry is None:
        return
    if geometry.GetGeometryCount() and ogr.GT_Flatten(geometry.GetGeometryType()) != ogr.wkbPolygon:
        for k in range(geometry.GetGeometryCount()):
            yield from parts(geometry.GetGeometryRef(k))
    else:
        yield geometry


def length(points):
    return math.fsum(math.dist(a[:2], b[:2]) for a, b in zip(points, points[1:]))


def area(points):
    x0, y0 = points[0][:2]
    return abs(math.fsum((a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0) for a, b in zip(points, points[1:]))) / 2


def describe(layer):
    out = {"features": 0, "points": 0, "lines": 0, "areas": 0, "holes": 0}
    lons, lats, depths, lengths, areas = [], [], [], [], []
    numbers = {name: [] for name in NUMBERS}
    codes = {name: {} for name in CODES}
    everything = []
    for feature in layer:
        out["features"] += 1
        for name in NUMBERS + CODES:
            index = feature.GetFieldIndex(name)
            if index >= 0 and feature.IsFieldSetAndNotNull(index):
                if name in NUMBERS:
                    numbers[name].append(feature.GetFieldAsDouble(index))
                else:
                    value = feature.GetFieldAsString(index)
                    codes[name][value] = codes[name].get(value, 0) + 1
        kind = None
        for part in parts(feature.GetGeometryRef()):
            flat = ogr.GT_Flatten(part.GetGeometryType())
            if flat == ogr.wkbPoint:
                kind = "points"
                lons.append(part.GetX())
                lats.append(part.GetY())
                depths.append(part.GetZ())
                everything.append((part.GetX(), part.GetY()))
            elif flat == ogr.wkbLineString:
                kind = "lines"
                lengths.append(length(part.GetPoints()))
                everything += [p[:2] for p in part.GetPoints()]
            else:
                kind = "areas"
                for k in range(part.GetGeometryCount()):
                    ring = part.GetGeometryRef(k).GetPoints()
                    areas.append(area(ring) * (-1 if k else 1))
                    out["holes"] += k > 0
                    everything += [p[:2] for p in ring]
        if kind:
            out[kind] += 1
    if lons:
        out["places"] = len(lons)
        out["sum"] = [math.fsum(lons), math.fsum(lats), math.fsum(depths)]
    if lengths:
        out["length_deg"] = math.fsum(lengths)
    if areas:
        out["area_deg2"] = math.fsum(areas)
    if everything:
        out["box"] = [min(p[0] for p in everything), min(p[1] for p in everything)]
        out["box"] += [max(p[0] for p in everything), max(p[1] for p in everything)]
    out["numbers"] = {k: {"count": len(v), "sum": math.fsum(v)} for k, v in numbers.items() if v}
    out["codes"] = {k: v for k, v in codes.items() if v}
    return out


def main(cell, out):
    source = ogr.Open(cell)
    layers = [source.GetLayer(k) for k in range(source.GetLayerCount())]
    told = {layer.GetName(): describe(layer) for layer in layers if layer.GetName() != "DSID"}
    with open(out, "w") as file:
        json.dump({"cell": os.path.basename(cell), "classes": told}, file, indent=1, sort_keys=True)
        file.write("\n")


main(*sys.argv[1:])
