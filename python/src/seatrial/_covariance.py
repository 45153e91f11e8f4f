"""The covariance of every run as a fixed-size list, of `covariances.parquet`, which has a column for each pair of parameters."""

from __future__ import annotations

import json
from math import isqrt
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import polars
    import pyarrow

#: The columns that say which estimate a row is of.
KEYS = ("design", "run", "estimator")
UNIT = "the product of the units of both parameters"


def parameters_of(pairs: list[str]) -> list[str]:
    """The parameters, of names of columns such as `X_u X_uu`: each pair once, the first no later than the second."""
    count = (isqrt(8 * len(pairs) + 1) - 1) // 2
    places = [i * count - i * (i - 1) // 2 for i in range(count)]
    # Twice the same name, with a blank between
    return [pairs[place][: len(pairs[place]) // 2] for place in places]


def _entries(pairs: list[str]) -> list[str]:
    """The column of each entry of the matrix, row by row."""
    names = parameters_of(pairs)
    known = set(pairs)
    return [f"{a} {b}" if f"{a} {b}" in known else f"{b} {a}" for a in names for b in names]


def in_arrow(table: pyarrow.Table) -> pyarrow.Table:
    """The keys, and `covariance`: as many rows as parameters, row-major; null where it is not known."""
    import pyarrow

    pairs = [name for name in table.column_names if name not in KEYS]
    names = parameters_of(pairs)
    columns = [table.column(entry).to_pylist() for entry in _entries(pairs)]
    kind = pyarrow.list_(pyarrow.float64(), len(columns))
    rows = pyarrow.array([None if row[0] is None else row for row in zip(*columns)], type=kind)
    metadata = {"unit": UNIT, "parameters": json.dumps(names, ensure_ascii=False)}
    field = pyarrow.field("covariance", kind, metadata=metadata)
    return table.select(list(KEYS)).append_column(field, rows)


def in_polars(table: polars.DataFrame) -> polars.DataFrame:
    """The same as an array column of polars."""
    import polars

    pairs = [name for name in table.columns if name not in KEYS]
    entries = _entries(pairs)
    whole = polars.concat_list(entries).list.to_array(len(entries))
    return table.select(*KEYS, polars.when(polars.col(pairs[0]).is_not_null()).then(whole).alias("covariance"))


def units_of_pairs(known: dict[str, str]) -> dict[str, Any]:
    """The units of the columns of the frame."""
    return {**{name: known[name] for name in KEYS}, "covariance": UNIT}
