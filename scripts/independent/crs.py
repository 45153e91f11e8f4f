"""What PROJ makes of places in coordinate systems by their EPSG code, as JSON.

    python3 scripts/independent/crs.py fixtures/oracle/crs.json

Needs GDAL's Python bindings (Debian: python3-gdal). Systems whose datum is WGS84 within a metre, so that nothing but the
projection is compared.
"""

import json
import sys

from osgeo import osr

PLACES = {
    25832: (9.2, 54.4), 3006: (17.9, 59.3), 26910: (-122.4, 47.3), 3857: (179.5, -41.2), 3067: (24.9, 60.1),
    32635: (24.9, 60.1), 32701: (-179.0, -18.0), 3035: (4.1, 52.0), 2154: (-1.6, 47.2), 3995: (15.6, 88.5),
    3413: (-52.0, 69.2), 3031: (164.0, -77.8), 3879: (24.95, 60.15), 4258: (10.7, 59.9), 2193: (174.8, -41.3),
    3577: (151.2, -33.9), 5041: (30.0, 86.0), 3765: (15.2, 44.1), 3301: (24.7, 59.4),
}


def row(code, place):
    own, wgs84 = osr.SpatialReference(), osr.SpatialReference()
    own.ImportFromEPSG(code)
    wgs84.ImportFromEPSG(4326)
    for system in (own, wgs84):
        system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    x, y, _ = osr.CoordinateTransformation(wgs84, own).TransformPoint(*place)
    return {"crs": f"EPSG:{code}", "place": place, "own": [x, y]}


with open(sys.argv[1], "w") as file:
    json.dump([row(code, place) for code, place in PLACES.items()], file, indent=1)
    file.write("\n")
