"""How near the files of two runs are whose bytes differ: `python3 scripts/near.py ONE OTHER FILE...`, folders and paths in them.

Numbers of JSON and GeoJSON, and of Parquet where pyarrow is installed, must agree within 1e-9 of the largest number that
has their name in the file, and all else must be the same but seals. Exits with 1 where anything is not near.
"""

import json
import sys
from pathlib import Path

NEAR = 1e-9


def numbers(value, name="", found=None):
    """All values in `value` by the names of their keys, in order."""
    found = {} if found is None else found
    if isinstance(value, dict):
        for key, each in value.items():
            numbers(each, f"{name}.{key}", found)
    elif isinstance(value, list):
        for each in value:
            numbers(each, name, found)
    else:
        found.setdefault(name, []).append(value)
    return found


def read(path):
    """The columns of the file at `path`; None where they cannot be read here."""
    if path.suffix in (".json", ".geojson"):
        return numbers(json.loads(path.read_text(encoding="utf-8")))
    try:
        import pyarrow.parquet as parquet
    except ImportError:
        return None
    return parquet.read_table(path).to_pydict() if path.suffix == ".parquet" else None


def distance(one, other):
    """The largest difference of two files, by the scale of each column, and its column; infinite where anything else differs."""
    if one.keys() != other.keys():
        return float("inf"), str(one.keys() ^ other.keys())
    worst = 0.0, "none"
    for name in one:
        pairs = list(zip(one[name], other[name]))
        is_number = all(isinstance(each, (int, float)) and not isinstance(each, bool) for pair in pairs for each in pair)
        if len(one[name]) != len(other[name]) or (not is_number and one[name] != other[name] and not sealed(pairs)):
            return float("inf"), name
        if is_number:
            scale = max((abs(each) for pair in pairs for each in pair), default=0.0) or 1.0
            worst = max(worst, (max((abs(a - b) for a, b in pairs), default=0.0) / scale, name))
    return worst


def sealed(pairs):
    """Whether the values are digests of files."""
    return all(a == b or (isinstance(a, str) and a.startswith("blake3:") and b.startswith("blake3:")) for a, b in pairs)


def main():
    far = 0
    for name in sys.argv[3:]:
        one, other = (read(Path(folder) / name) for folder in sys.argv[1:3])
        if one is None:
            print(f"{name}: not compared")
            continue
        worst, column = distance(one, other)
        far += worst > NEAR
        print(f"{name}: {'near' if worst <= NEAR else 'FAR'}, {worst:.1e} of {column.lstrip('.')}")
    return int(far > 0)


if __name__ == "__main__":
    sys.exit(main())
