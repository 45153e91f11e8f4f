"""Writes a small cell of an electronic chart (S-57 in ISO 8211) with two updates, for tests: no real waters.

    python3 scripts/make_enc.py fixtures/charts/enc

An island in a bay at 25 E, 60 N, with all that rules of charts tell apart. Standard library alone.
"""

import struct
import sys

COMF, SOMF = 10_000_000, 10
FE, UE = b"\x1e", b"\x1f"
FORMATS = [
    ("0000", "0000;&   ", "", ""),
    ("0001", "0500;&   ", "ISO/IEC 8211 Record Identifier", "(b12)"),
    ("DSID", "1600;&   ", "Data set identification field", "(b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A)"),
    ("DSSI", "1600;&   ", "Data set structure information field", "(3b11,8b14)"),
    ("DSPM", "1600;&   ", "Data set parameter field", "(b11,b14,3b11,b14,4b11,2b14,A)"),
    ("VRID", "1600;&   ", "Vector record identifier field", "(b11,b14,b12,b11)"),
    ("ATTV", "2600;&   ", "Vector record attribute field", "(b12,A)"),
    ("VRPC", "1600;&   ", "Vector record pointer control field", "(b11,b12,b12)"),
    ("VRPT", "2600;&   ", "Vector record pointer field", "(B(40),4b11)"),
    ("SGCC", "1600;&   ", "Coordinate control field", "(b11,2b12)"),
    ("SG2D", "2500;&   ", "2-D coordinate field", "(2b24)"),
    ("SG3D", "2500;&   ", "3-D coordinate (sounding array) field", "(3b24)"),
    ("FRID", "1600;&   ", "Feature record identifier field", "(b11,b14,2b11,2b12,b11)"),
    ("FOID", "1600;&   ", "Feature object identifier field", "(b12,b14,b12)"),
    ("ATTF", "2600;&-A ", "Feature record attribute field", "(b12,A)"),
    ("NATF", "2600;&-A ", "Feature record national attribute field", "(b12,A)"),
    ("FSPC", "1600;&   ", "Feature record to spatial record pointer control field", "(b11,2b12)"),
    ("FSPT", "2600;&   ", "Feature record to spatial record pointer field", "(B(40),3b11)"),
]
LABELS = {
    "0001": "",
    "DSID": "RCNM!RCID!EXPP!INTU!DSNM!EDTN!UPDN!UADT!ISDT!STED!PRSP!PSDN!PRED!PROF!AGEN!COMT",
    "DSSI": "DSTR!AALL!NALL!NOMR!NOCR!NOGR!NOLR!NOIN!NOCN!NOED!NOFA",
    "DSPM": "RCNM!RCID!HDAT!VDAT!SDAT!CSCL!DUNI!HUNI!PUNI!COUN!COMF!SOMF!COMT",
    "VRID": "RCNM!RCID!RVER!RUIN",
    "ATTV": "*ATTL!ATVL",
    "VRPC": "VPUI!VPIX!NVPT",
    "VRPT": "*NAME!ORNT!USAG!TOPI!MASK",
    "SGCC": "CCUI!CCIX!CCNC",
    "SG2D": "*YCOO!XCOO",
    "SG3D": "*YCOO!XCOO!VE3D",
    "FRID": "RCNM!RCID!PRIM!GRUP!OBJL!RVER!RUIN",
    "FOID": "AGEN!FIDN!FIDS",
    "ATTF": "*ATTL!ATVL",
    "NATF": "*ATTL!ATVL",
    "FSPC": "FSUI!FSIX!NSPT",
    "FSPT": "*NAME!ORNT!USAG!MASK",
}
POINT, LINE, AREA, NOWHERE = 1, 2, 3, 255
ISOLATED, CONNECTED, EDGE = 110, 120, 130
INSERT, DELETE, MODIFY = 1, 2, 3
CLASSES = {
    "BRIDGE": 11, "CBLARE": 20, "COALNE": 30, "DEPARE": 42, "FAIRWY": 51, "LNDARE": 71, "OBSTRN": 86, "RESARE": 112,
    "SOUNDG": 129, "TSEZNE": 150, "UWTROC": 153, "WRECKS": 159, "M_COVR": 302, "C_AGGR": 400,
}
ATTRIBUTES = {
    "CATCOV": 18, "DRVAL1": 87, "DRVAL2": 88, "OBJNAM": 116, "RESTRN": 131, "VALSOU": 179, "VERCLR": 181, "WATLEV": 187,
    "NOBJNM": 301, "QUAPOS": 402,
}


def record(kind, fields):
    """One record: leader, directory, fields."""
    directory, area = b"", b""
    for tag, data in fields:
        directory += f"{tag}{len(data):04d}{len(area):05d}".encode()
        area += data
    base = 24 + len(directory) + 1
    first = "3LE1 09" if kind == "L" else " D     "
    leader = f"{base + len(area):05d}{first}{base:05d}{' ! ' if kind == 'L' else '   '}4504".encode()
    assert len(leader) == 24
    return leader + directory + FE + area


def descriptive():
    fields = []
    for tag, controls, name, form in FORMATS:
        if tag == "0000":
            pairs = "0001DSIDDSIDDSSI0001DSPM0001VRIDVRIDATTVVRIDVRPCVRIDVRPTVRIDSGCCVRIDSG2DVRIDSG3D"
            pairs += "0001FRIDFRIDFOIDFRIDATTFFRIDNATFFRIDFSPCFRIDFSPT"
            fields.append((tag, controls.encode() + UE + pairs.encode() + FE))
        else:
            told = [(controls + name).encode(), LABELS[tag].encode(), form.encode()]
            fields.append((tag, UE.join(told) + FE))
    return record("L", fields)


class File:
    def __init__(self, name, update):
        self.name, self.update = name, update
        self.records = []
        self.counts = {ISOLATED: 0, CONNECTED: 0, EDGE: 0, "M_": 0, "C_": 0, "geo": 0}

    def add(self, *fields):
        number = struct.pack("<H", len(self.records) + 2)
        self.records.append(record("D", [("0001", number + FE), *fields]))

    def identification(self):
        name, update, counts = self.name, self.update, self.counts
        numbers = struct.pack("<BIBB", 10, 1, 2 if update else 1, 5)
        texts = name.encode() + UE + b"2" + UE + str(update).encode() + UE
        dates = b"20260101" + f"202601{update + 1:02d}".encode() + b"03.1"
        product = b"\x01" + UE + b"2.0" + UE + struct.pack("<BH", 2 if update else 1, 65535) + b"made for tests" + UE
        objects = [counts["M_"], 0, counts["geo"], counts["C_"]]
        structure = struct.pack("<3B8I", 2, 1, 2, *objects, counts[ISOLATED], counts[CONNECTED], counts[EDGE], 0)
        told = [("0001", struct.pack("<H", 1) + FE), ("DSID", numbers + texts + dates + product + FE)]
        return record("D", [*told, ("DSSI", structure + FE)])

    def parameters(self, scale):
        own = struct.pack("<BI3BI4B2I", 20, 1, 2, 3, 23, scale, 1, 1, 1, 1, COMF, SOMF)
        self.add(("DSPM", own + UE + FE))

    def vector(self, kind, number, places, ends=(), version=1, instruction=INSERT, splice=None, quality=None):
        self.counts[kind] += 1
        fields = [("VRID", struct.pack("<BIHB", kind, number, version, instruction) + FE)]
        if quality is not None:
            fields.append(("ATTV", struct.pack("<H", ATTRIBUTES["QUAPOS"]) + str(quality).encode() + UE + FE))
        if ends:
            own = [struct.pack("<BI4B", CONNECTED, n, 255, 255, t, 255) for n, t in zip(ends, (1, 2))]
            fields.append(("VRPT", b"".join(own) + FE))
        if splice:
            fields.append(("SGCC", struct.pack("<BHH", *splice) + FE))
        flat = [p for p in places if len(p) == 2]
        deep = [p for p in places if len(p) == 3]
        units = lambda p: (round(p[1] * COMF), round(p[0] * COMF))  # noqa: E731
        if flat:
            fields.append(("SG2D", b"".join(struct.pack("<2i", *units(p)) for p in flat) + FE))
        if deep:
            own = [struct.pack("<3i", *units(p), round(p[2] * SOMF)) for p in deep]
            fields.append(("SG3D", b"".join(own) + FE))
        self.add(*fields)

    def feature(self, number, name, primitive, pointers, attributes=(), version=1, instruction=INSERT, splice=None):
        code = CLASSES[name]
        self.counts[name[:2] if name[:2] in self.counts else "geo"] += 1
        group = 1 if name in ("DEPARE", "LNDARE") else 2
        fields = [("FRID", struct.pack("<BIBBHHB", 100, number, primitive, group, code, version, instruction) + FE)]
        if instruction == INSERT:
            fields.append(("FOID", struct.pack("<HIH", 65535, 1000 + number, 1) + FE))
        latin = [(k, v) for k, v in attributes if k != "NOBJNM"]
        national = [(k, v) for k, v in attributes if k == "NOBJNM"]
        if latin:
            own = [struct.pack("<H", ATTRIBUTES[k]) + str(v).encode("latin-1") + UE for k, v in latin]
            fields.append(("ATTF", b"".join(own) + FE))
        if national:
            own = [struct.pack("<H", ATTRIBUTES[k]) + v.encode("utf-16-le") + b"\x1f\x00" for k, v in national]
            fields.append(("NATF", b"".join(own) + b"\x1e\x00"))
        if splice:
            fields.append(("FSPC", struct.pack("<BHH", *splice) + FE))
        if pointers:
            own = [struct.pack("<BI3B", kind, n, turn, usage, 255) for kind, n, turn, usage in pointers]
            fields.append(("FSPT", b"".join(own) + FE))
        self.add(*fields)

    def write(self, path):
        with open(path, "wb") as out:
            out.write(descriptive() + self.identification() + b"".join(self.records))


def base():
    """A bay with an island; depths of 20 m, of 5 m around the island, of 10 m in the east."""
    cell = File("ZZ5BAY01.000", 0)
    cell.parameters(20000)
    corners = {1: (24.9, 59.95), 2: (25.05, 59.95), 3: (25.1, 59.95), 4: (25.1, 60.05), 5: (25.05, 60.05), 6: (24.9, 60.05)}
    corners |= {7: (24.996, 59.998), 8: (24.998, 59.999), 9: (25.012, 60.007), 10: (24.986, 60.007), 11: (25.013, 59.9925)}
    for number, place in corners.items():
        cell.vector(CONNECTED, number, [place])
    lines = [(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1), (2, 5)]
    for number, ends in enumerate(lines, 1):
        cell.vector(EDGE, number, [], ends)

    def box(west, south, east, north):
        """Corners after the south-western one, counter-clockwise."""
        return [(east, south), (east, north), (west, north)]

    # Rings from and to one node each: shoal, island, fairway, restricted area, cables.
    cell.vector(EDGE, 8, box(24.996, 59.998, 25.004, 60.002), (7, 7))
    cell.vector(EDGE, 9, box(24.998, 59.999, 25.002, 60.001), (8, 8), quality=4)
    cell.vector(EDGE, 10, box(25.012, 60.007, 25.018, 60.009), (9, 9))
    cell.vector(EDGE, 11, box(24.986, 60.007, 24.99, 60.009), (10, 10))
    cell.vector(EDGE, 12, box(25.013, 59.9925, 25.016, 59.994), (11, 11))
    nodes = {1: (25.01, 60.005), 2: (25.012, 59.996), 3: (24.99, 59.996), 4: (25.03, 60.0), 5: (24.97, 60.0)}
    for number, place in nodes.items():
        cell.vector(ISOLATED, number, [place], quality=5 if number == 5 else None)
    soundings = [(25.006, 59.994, 21.4), (24.992, 60.004, 3.2), (25.014, 60.001, 24.0)]
    cell.vector(ISOLATED, 6, soundings)
    # A bridge between two nodes of its own, east of everything.
    cell.vector(CONNECTED, 12, [(25.06, 60.0)])
    cell.vector(CONNECTED, 13, [(25.09, 60.01)])
    cell.vector(EDGE, 13, [(25.07, 60.002)], (12, 13))

    along, against, outside, inside = 1, 2, 1, 2

    def ring(edges, usage=outside):
        return [(EDGE, abs(n), along if n > 0 else against, usage) for n in edges]

    def at(number):
        return [(ISOLATED, number, 255, 255)]

    cell.feature(1, "M_COVR", AREA, ring([1, 2, 3, 4, 5, 6]), [("CATCOV", 1)])
    cell.feature(2, "DEPARE", AREA, ring([1, 7, 5, 6]) + ring([-8], inside), [("DRVAL1", 20), ("DRVAL2", 50)])
    cell.feature(3, "DEPARE", AREA, ring([2, 3, 4, -7]), [("DRVAL1", "10.5"), ("DRVAL2", 20)])
    cell.feature(4, "DEPARE", AREA, ring([8]) + ring([-9], inside), [("DRVAL1", 5), ("DRVAL2", 20)])
    cell.feature(5, "LNDARE", AREA, ring([9]), [("OBJNAM", "Tr\xe4holm"), ("NOBJNM", "Tr\xe4holmen")])
    cell.feature(6, "COALNE", LINE, [(EDGE, 9, along, 255)])
    cell.feature(7, "FAIRWY", AREA, ring([10]))
    cell.feature(8, "RESARE", AREA, ring([11]), [("RESTRN", "1,7")])
    cell.feature(9, "CBLARE", AREA, ring([12]), [("RESTRN", 1)])
    cell.feature(10, "WRECKS", POINT, at(1), [("VALSOU", "3.4"), ("WATLEV", 3), ("OBJNAM", "")])
    cell.feature(11, "WRECKS", POINT, at(2), [("VALSOU", 30), ("WATLEV", 3)])
    cell.feature(12, "OBSTRN", POINT, at(3), [("WATLEV", 3)])
    cell.feature(13, "OBSTRN", POINT, at(5), [("VALSOU", 4), ("WATLEV", 3)])
    cell.feature(14, "SOUNDG", POINT, at(6))
    cell.feature(15, "LNDARE", POINT, at(4))
    cell.feature(16, "BRIDGE", LINE, [(EDGE, 13, along, 255)], [("VERCLR", "12.5")])
    cell.feature(17, "RESARE", AREA, ring([12]), [("RESTRN", 1)])
    cell.feature(18, "C_AGGR", NOWHERE, [])
    return cell


def first():
    """The deep wreck is shoaler and has a name no longer; the cables are gone; the fairway has another corner."""
    update = File("ZZ5BAY01.001", 1)
    update.vector(EDGE, 10, [(25.019, 60.008)], version=2, instruction=MODIFY, splice=(INSERT, 2, 1))
    update.vector(ISOLATED, 6, [], version=2, instruction=MODIFY, splice=(DELETE, 3, 1))
    update.feature(11, "WRECKS", POINT, [], [("VALSOU", "7.5")], 2, MODIFY)
    update.feature(10, "WRECKS", POINT, [], [("OBJNAM", "\x7f")], 2, MODIFY)
    update.feature(9, "CBLARE", AREA, [], (), 2, DELETE)
    return update


def second():
    """A rock is new; the islet is elsewhere; the bridge's middle moves."""
    update = File("ZZ5BAY01.002", 2)
    update.vector(ISOLATED, 7, [(24.994, 60.0055)], quality=10)
    update.vector(ISOLATED, 8, [(25.031, 60.001)])
    update.vector(EDGE, 13, [(25.075, 60.003)], version=2, instruction=MODIFY, splice=(MODIFY, 1, 1))
    update.feature(19, "UWTROC", POINT, [(ISOLATED, 7, 255, 255)], [("VALSOU", "-0.5"), ("WATLEV", 4)])
    update.feature(15, "LNDARE", POINT, [(ISOLATED, 8, 255, 255)], (), 2, MODIFY, splice=(MODIFY, 1, 1))
    update.vector(ISOLATED, 4, [], version=2, instruction=DELETE)
    return update


folder = sys.argv[1]
for suffix, file in enumerate([base(), first(), second()]):
    file.write(f"{folder}/ZZ5BAY01.{suffix:03d}")
