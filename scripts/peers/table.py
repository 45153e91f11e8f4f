"""Writing and reading a million rows with pyarrow on one thread, laid out as the workspace lays out its tables."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

ROWS = 1_000_000
BLOCK = 1 << 16
NOISY, STEPPED, SMOOTH = 6, 3, 4


def content() -> pa.Table:
    """13 floats (6 Gaussian, 3 piecewise constant, 4 smooth), 3 integers, 2 texts with few labels."""
    rng = np.random.default_rng(1)
    k = np.arange(ROWS)
    columns: dict[str, pa.Array] = {
        "design": _labels(k // 500_000, 2, "design"),
        "run": pa.array((k // 1001).astype(np.int32)),
        "segment": pa.array((k // 200 % 5).astype(np.int32)),
        "maneuver": _labels(k // 200 % 11, 11, "maneuver"),
        "sample": pa.array((k % 1001).astype(np.int32)),
    }
    for i in range(NOISY):
        columns[f"noisy{i}"] = pa.array(rng.standard_normal(ROWS))
    for i in range(STEPPED):
        columns[f"stepped{i}"] = pa.array(np.repeat(rng.standard_normal(ROWS // 80), 80))
    for i in range(SMOOTH):
        columns[f"smooth{i}"] = pa.array(np.sin(k * (0.01 + 0.003 * i)) * (1.0 + i))
    fields = [pa.field(name, column.type, nullable=False) for name, column in columns.items()]
    return pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields))


def _labels(codes: np.ndarray, count: int, name: str) -> pa.Array:
    labels = pa.array([f"{name}-{i}" for i in range(count)])
    return pa.DictionaryArray.from_arrays(pa.array(codes.astype(np.int32)), labels)


class TableIo:
    """The table, held in memory, and a folder to write it to."""

    def __init__(self) -> None:
        pa.set_cpu_count(1)
        pa.set_io_thread_count(1)
        self.table = content()
        self.floats = [f.name for f in self.table.schema if pa.types.is_floating(f.type)]
        self.texts = [f.name for f in self.table.schema if pa.types.is_dictionary(f.type)]
        self.others = [f.name for f in self.table.schema if not pa.types.is_floating(f.type)]

    @property
    def raw_bytes(self) -> int:
        """Bytes of the values: 8 per float, 4 per integer and per label."""
        return ROWS * (8 * len(self.floats) + 4 * len(self.others))

    def once(self) -> tuple[float, float, int]:
        """Seconds to write, seconds to read, size of the file [B]."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "table.parquet"
            clock = time.perf_counter()
            self._write(path)
            written = time.perf_counter()
            file = pq.ParquetFile(path, memory_map=True, read_dictionary=self.texts)
            table = file.read(use_threads=False)
            read = time.perf_counter()
            if table.num_rows != ROWS:
                raise SystemExit(f"pyarrow read {table.num_rows} rows of {ROWS}")
            return written - clock, read - written, path.stat().st_size

    def _write(self, path: Path) -> None:
        pq.write_table(
            self.table,
            path,
            row_group_size=BLOCK,
            compression="zstd",
            compression_level=1,
            use_dictionary=self.others,
            column_encoding=dict.fromkeys(self.floats, "BYTE_STREAM_SPLIT"),
            write_statistics=False,
            store_schema=False,
        )

    def best(self, rounds: int = 3) -> tuple[float, float, int]:
        """The fastest write and the fastest read of `rounds`."""
        results = [self.once() for _ in range(rounds)]
        return min(r[0] for r in results), min(r[1] for r in results), results[0][2]
