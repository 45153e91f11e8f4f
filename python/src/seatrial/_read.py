"""Reads tables as frames and documents as dataclasses."""

from __future__ import annotations

import json
import os
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _covariance
from ._envelope import check_table, envelope, path_of, units_of
from ._errors import MissingLibrary, Refused, WrongUsage, missing

if TYPE_CHECKING:
    import pyarrow

# The frames, and the libraries that each needs
FRAMES = {"pandas": ("pyarrow", "pandas"), "polars": ("polars",), "arrow": ("pyarrow",)}


def units(path: str | os.PathLike[str]) -> dict[str, str]:
    """The unit of each column of a table, or of each number of a document by its field. `1` where there is none.

    Needs no library. Raises `Refused` or `Failed`.
    """
    path = path_of(path)
    if path.suffix == ".json":
        from ._document import read_document

        return read_document(path).units
    found = envelope(path)
    check_table(path, found)
    return units_of(path, found)


def read(path: str | os.PathLike[str], frame: str | None = None, columns: list[str] | None = None) -> Any:
    """Reads what a stage wrote: a table as a frame, a document as a `Document` whose `data` are dataclasses.

    `frame` is pandas, polars or arrow; without it the first of these that is installed. Units are in `attrs["units"]`
    of a frame of pandas, and in the metadata of each field of a table of Arrow; a frame of polars has no place for
    them: see `units`. `columns` reads these columns alone.

    Of `covariances.parquet` the column `covariance` is a list of fixed size: for every run a matrix, row-major, with the
    parameters in the order of the model.

    Raises `Refused` for another schema or version, `Failed` for a file that cannot be read, `MissingLibrary` where the
    library of the frame is not installed. Seals are not checked: `seatrial verify` does.
    """
    path = path_of(path)
    if path.suffix == ".json":
        from ._document import read_document

        if columns is not None:
            raise WrongUsage(f"{path}: columns: found some, expected none; a document has no columns")
        return read_document(path)
    found = envelope(path)
    check_table(path, found)
    known = units_of(path, found)
    absent = [name for name in columns or [] if name not in known]
    if absent:
        raise Refused(f"{path}: columns: found {', '.join(known)}, expected also {', '.join(absent)}; name columns of the file")
    return _frame(path, frame or _installed(path), columns, found)


def _installed(path: Path) -> str:
    """The first frame whose libraries are installed."""
    for frame, libraries in FRAMES.items():
        if all(find_spec(library) for library in libraries):
            return frame
    raise missing(f"{path}: frame", "pandas and pyarrow, and no polars", "pandas")


def check_frame(frame: str, thing: str) -> None:
    """Refuses an unknown frame, and one whose libraries are not installed."""
    if frame not in FRAMES:
        raise WrongUsage(f"frame: found {frame}, expected one of {', '.join(FRAMES)}; name one of these")
    absent = [library for library in FRAMES[frame] if not find_spec(library)]
    if absent:
        raise missing(f"{thing}: frame {frame}", " and no ".join(absent), frame)


def _frame(path: Path, frame: str, columns: list[str] | None, found: dict[str, Any]) -> Any:
    check_frame(frame, str(path))
    known = units_of(path, found)
    whole = columns is None and check_table(path, found) == "covariances"
    try:
        if frame == "polars":
            import polars

            rows = polars.read_parquet(path, columns=columns)
            return _covariance.in_polars(rows) if whole else rows
        table = arrow_table(path, columns, found)
        pairs = table.column_names
        if whole:
            table, known = _covariance.in_arrow(table), _covariance.units_of_pairs(known)
    except MissingLibrary:
        raise
    except Exception as error:
        # Its kind depends on the library
        first = str(error).partition("\n")[0]
        raise Refused(
            f"{path}: contents: found {first}, expected a readable table; the file is damaged: write it again"
        ) from error
    if frame == "arrow":
        return table
    data = table.to_pandas()
    data.attrs["units"] = {name: known[name] for name in data.columns}
    if whole:
        data.attrs["parameters"] = _covariance.parameters_of([name for name in pairs if name not in _covariance.KEYS])
    return data


def arrow_table(path: Path, columns: list[str] | None, found: dict[str, Any]) -> pyarrow.Table:
    """A table of Arrow with units in its fields, also of files that lack them there, and the file's envelope, `found`."""
    from pyarrow import parquet

    table = parquet.read_table(path, columns=columns)
    return with_units(table, units_of(path, found)).replace_schema_metadata({"seatrial": json.dumps(found)})


def with_units(table: pyarrow.Table, known: dict[str, str]) -> pyarrow.Table:
    """`table` with the unit of each column in its field."""
    import pyarrow

    return table.cast(pyarrow.schema([own.with_metadata({"unit": known[own.name]}) for own in table.schema]))


def framed(columns: dict[str, list[float]], known: dict[str, str], frame: str) -> Any:
    """Columns in memory as a frame."""
    check_frame(frame, "states")
    if frame == "polars":
        import polars

        return polars.DataFrame(columns)
    import pyarrow

    table = with_units(pyarrow.table(columns), known)
    if frame == "arrow":
        return table
    data = table.to_pandas()
    data.attrs["units"] = known
    return data
