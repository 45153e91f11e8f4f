"""Writing and reading a million rows with pyarrow on one thread: the rows of our own benchmark, laid out as ours are."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq


class TableIo:
    """The table, held in memory, and a folder to write it to."""

    def __init__(self, rows: Path) -> None:
        """Takes over the rows, blocks, names and types of the file `rows`."""
        pa.set_cpu_count(1)
        pa.set_io_thread_count(1)
        file = pq.ParquetFile(rows)
        self.block = file.metadata.row_group(0).num_rows
        fields = file.schema_arrow
        self.floats = [f.name for f in fields if pa.types.is_floating(f.type)]
        self.texts = [f.name for f in fields if pa.types.is_string(f.type)]
        self.others = [f.name for f in fields if not pa.types.is_floating(f.type)]
        table = pq.ParquetFile(rows, read_dictionary=self.texts).read()
        self.table = table.replace_schema_metadata(None).unify_dictionaries().combine_chunks()

    @property
    def raw_bytes(self) -> int:
        """Bytes of the values: 8 per float, 4 per integer and per label."""
        return self.table.num_rows * (8 * len(self.floats) + 4 * len(self.others))

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
            if table.num_rows != self.table.num_rows:
                raise SystemExit(f"pyarrow read {table.num_rows} rows of {self.table.num_rows}")
            return written - clock, read - written, path.stat().st_size

    def _write(self, path: Path) -> None:
        """Flushed to the disk and renamed, as our own files are."""
        unfinished = path.with_suffix(".part")
        with unfinished.open("wb") as file:
            pq.write_table(
                self.table,
                file,
                row_group_size=self.block,
                compression="zstd",
                compression_level=1,
                use_dictionary=self.others,
                column_encoding=dict.fromkeys(self.floats, "BYTE_STREAM_SPLIT"),
                write_statistics=False,
                store_schema=False,
            )
            file.flush()
            os.fsync(file.fileno())
        unfinished.rename(path)

    def best(self, rounds: int = 7) -> tuple[float, float, int]:
        """The fastest write and the fastest read of `rounds`."""
        results = [self.once() for _ in range(rounds)]
        return min(r[0] for r in results), min(r[1] for r in results), results[0][2]
