"""Writes small grids of depths in the form that agencies publish, and what others read in them, for tests: no real waters.

    python3 scripts/make_grids.py fixtures/charts/grids fixtures/oracle/grids.json

GeoTIFF by rasterio (GDAL), which reads the oracle back. A bank rises to 3 m in
the middle of a basin of 40 m, with an island at one end and a corner without data.
"""

import json
import pathlib
import sys

import numpy as np
import rasterio
from rasterio.transform import from_origin

folder, oracle = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
ROWS, COLUMNS = 18, 24


def depths():
    """Depths from north to south, positive down; NaN where there is no data."""
    row, column = np.mgrid[0:ROWS, 0:COLUMNS]
    bank = 37.0 * np.exp(-(((row - 9) / 3.0) ** 2 + ((column - 12) / 4.0) ** 2))
    island = 55.0 * np.exp(-(((row - 3) / 1.5) ** 2 + ((column - 20) / 2.0) ** 2))
    values = np.round(40.0 - bank - island, 2)
    values[-3:, :4] = np.nan
    return values


def tiff(name, values, crs, transform, **options):
    profile = dict(driver="GTiff", height=ROWS, width=COLUMNS, count=1, crs=crs, transform=transform, **options)
    filled = np.where(np.isnan(values), options["nodata"], values).astype(options["dtype"])
    with rasterio.open(folder / name, "w", **profile) as file:
        if options.get("AREA_OR_POINT"):
            file.update_tags(AREA_OR_POINT="Point")
        file.write(filled, 1)


def read(name):
    """What GDAL finds: values from north to south, south-western corner, side of a cell, EPSG code."""
    with rasterio.open(folder / name) as file:
        values = file.read(1, masked=True).astype("f8")
        scaled = values * file.scales[0] + file.offsets[0]
        transform = file.transform
        return {
            "file": name,
            "crs": f"EPSG:{file.crs.to_epsg()}" if file.crs and file.crs.to_epsg() else None,
            "corner": [transform.c, transform.f + transform.e * file.height], "cell": transform.a,
            "values": [[None if np.ma.is_masked(v) or np.isnan(v) else float(v) for v in row] for row in scaled],
        }


values = depths()
utm = from_origin(400_000.0, 6_655_000.0, 50.0, 50.0)
degrees = from_origin(25.0, 60.0 + ROWS / 240.0, 1.0 / 240.0, 1.0 / 240.0)
tiff("depth_utm.tif", values, "EPSG:32635", utm, dtype="float32", nodata=-9999.0, compress="deflate", predictor=3,
     tiled=True, blockxsize=16, blockysize=16)
tiff("elevation_point.tif", -values, "EPSG:4326", degrees, dtype="int16", nodata=-32768, compress="lzw",
     predictor=2, AREA_OR_POINT="Point")
oracle.write_text(json.dumps([read("depth_utm.tif"), read("elevation_point.tif")]) + "\n")
