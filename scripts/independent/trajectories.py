"""Runs as a table of kind trajectories/1, as the stages read it. Unsealed: made outside the workspace."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from .runs import Run
from .study import Study

RUNS_PER_BLOCK = 8
DESIGN = "random"
COLUMNS = (
    ("design", "1", "text"),
    ("run", "1", "i32"),
    ("segment", "1", "i32"),
    ("maneuver", "1", "text"),
    ("sample", "1", "i32"),
    ("t", "s", "f64"),
    ("tau1", "N", "f64"),
    ("tau2", "N", "f64"),
    ("tau3", "N m", "f64"),
    ("y_u", "m/s", "f64"),
    ("y_v", "m/s", "f64"),
    ("y_r", "rad/s", "f64"),
    ("u", "m/s", "f64"),
    ("v", "m/s", "f64"),
    ("r", "rad/s", "f64"),
    ("x", "m", "f64"),
    ("y", "m", "f64"),
    ("psi", "rad", "f64"),
)
TYPES = {"text": pa.string(), "i32": pa.int32(), "f64": pa.float64()}


def write_runs(path: Path, study: Study, runs: list[Run]) -> None:
    """One row group per RUNS_PER_BLOCK runs; only inputs may be null (in a run's last row)."""
    envelope = {
        "schema": "trajectories/1",
        "producer": "oracle.py",
        "seal": None,
        "inputs": {},
        "settings": {},
        "columns": [{"name": n, "unit": u, "kind": k} for n, u, k in COLUMNS],
    }
    inputs = study.vessel.inputs
    fields = [pa.field(name, TYPES[kind], nullable=name in inputs) for name, _, kind in COLUMNS]
    text = json.dumps(envelope, separators=(",", ":"))
    schema = pa.schema(fields)
    options = {
        "compression": "zstd",
        "use_dictionary": [name for name, _, kind in COLUMNS if kind == "text"],
        "write_statistics": False,
        "store_schema": False,
    }
    with pq.ParquetWriter(path, schema, **options) as writer:
        for first in range(0, len(runs), RUNS_PER_BLOCK):
            numbers = range(first, min(first + RUNS_PER_BLOCK, len(runs)))
            tables = [_table(study, number, runs[number], schema) for number in numbers]
            block = pa.concat_tables(tables).combine_chunks()
            writer.write_table(block, row_group_size=block.num_rows)
        writer.add_key_value_metadata({"seatrial": text})


def _table(study: Study, number: int, run: Run, schema: pa.Schema) -> pa.Table:
    rows = len(run.inputs) + 1
    segment = np.append(run.segment, run.segment[-1])
    sample = np.arange(rows)
    last = np.arange(rows) == rows - 1
    names = [str(study.maneuvers[run.maneuvers[s]]["name"]) for s in segment]
    time = sample / study.vessel.rate_hz
    columns: list[object] = [[DESIGN] * rows, np.full(rows, number), segment, names, sample, time]
    padded = np.vstack([run.inputs, np.zeros((1, 3))])
    columns += [pa.array(column, mask=last) for column in padded.T]
    columns += [*run.measured.T, *run.states.T, *run.poses.T]
    arrays = [pa.array(column, type=field.type) for column, field in zip(columns, schema)]
    return pa.Table.from_arrays(arrays, schema=schema)
