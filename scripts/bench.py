"""Measures the workspace against what one would otherwise use, in one run on one machine. Called by `make bench`.

    python scripts/bench.py [--study pipelines/paper] [--ours target/release/examples/bench] [--rounds 2] [--tables]

Builds nothing: `--ours` is run as it is with `--json`, or with `--tables` for writing and reading tables alone. The peers are numba (Monte Carlo loop), scipy's least_squares over
numba (output error), scipy SLSQP (design) and pyarrow (tables), all on one thread. Peers and ours take turns and the best of each counts. Needs numpy, scipy, numba
and pyarrow; without them only our own figures are shown.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True

INSTALL = "python3 -m venv .venv && .venv/bin/pip install numpy scipy numba pyarrow"

# A figure by name; what is better, more or less, is a matter of the line that shows it.
Figures = dict[str, float]


@dataclass(frozen=True)
class Line:
    """One line of the table: which figure, its unit, whether more is better, the ratio that is aimed at."""

    what: str
    key: str
    unit: str
    more_is_better: bool
    target: float | None


LINES = (
    Line("Monte Carlo, realizations per core", "monte_carlo", "1/s", True, None),
    Line("  optimized run of `monte-carlo`", "stage_optimized", "us", False, 3.5),
    Line("  random run of `monte-carlo`", "stage_random", "us", False, None),
    Line("  beside rand_distr's normals alone", "stage_drawn", "us", False, 1.0),
    Line("output error, realization of 1000", "output_error", "ms", False, 20.0),
    Line("forces, derivatives by 39 numbers", "forces_jacobian", "x errors", False, None),
    Line("  fit of 23 recordings", "forces_fit", "ms", False, None),
    Line("design, 11 maneuvers", "design_q11", "ms", False, 50.0),
    Line("  its relative gap", "design_q11_gap", "", False, None),
    Line("design, 10000 maneuvers", "design_q10000", "ms", False, None),
    Line("  its relative gap", "design_q10000_gap", "", False, None),
    Line("table, write", "write", "MB/s", True, 1.0),
    Line("table, read", "read", "MB/s", True, 1.0),
    Line("table, size of the file", "size", "MB per 100 MB", False, 1.0),
    Line("planner, 35x44x4 3x3, and dijkstra", "planner_35x44x4_3x3", "ms", False, 5.0),
    Line("  beside A*", "planner_a_star", "ms", False, None),
    Line("  its allowed moves", "planner_table", "ms", False, None),
    Line("planner, 140x176x16 3x3", "planner_140x176x16_3x3", "ms", False, None),
    Line("planner, 35x44x4 11x1", "planner_35x44x4_11x1", "ms", False, None),
    Line("planner, 35x44x4 11x2", "planner_35x44x4_11x2", "ms", False, None),
)


def main() -> None:
    arguments = parse_arguments()
    if not arguments.ours.is_file():
        raise SystemExit(f"{arguments.ours}: no such program; build it with `cargo build --release -p seatrial-cli --example bench`")
    peers = load_peers(arguments.study, arguments.ours, arguments.tables)
    ours: list[Figures] = []
    theirs: list[Figures] = []
    for _ in range(arguments.rounds):
        if peers is not None:
            theirs.append(peers())
        own, inside = run_ours(arguments.ours, arguments.tables)
        ours.append(own)
        theirs.append(inside)
    print(machine())
    show(best_of(ours), best_of(theirs))
    if peers is None:
        print(f"no peers: Python packages are missing; get them with: {INSTALL}")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, default=Path("pipelines/paper"), help="study folder")
    parser.add_argument("--ours", type=Path, default=Path("target/release/examples/bench"), help="our own benchmark")
    parser.add_argument("--rounds", type=int, default=2, help="turns of peers and ours")
    parser.add_argument("--tables", action="store_true", help="writing and reading tables alone")
    return parser.parse_args()


def load_peers(study: Path, program: Path, tables: bool) -> Callable[[], Figures] | None:
    """A measurement of all peers, compiled and warm; nothing if a package is missing."""
    if tables:
        return load_table(program)
    try:
        from peers.monte_carlo import MonteCarlo
        from peers.output_error import OutputError
        from peers.shares import Shares
    except ImportError as error:
        print(f"peers are left out: {error}", file=sys.stderr)
        return None
    print("compiling the peers", file=sys.stderr)
    monte_carlo, shares, table = MonteCarlo(study), Shares(study), load_table(program)
    with tempfile.TemporaryDirectory() as folder:
        realizations = Path(folder) / "realizations.json"
        call_ours(program, "--realizations", str(realizations))
        output_error = OutputError(realizations)

    def measure() -> Figures:
        print("measuring the peers", file=sys.stderr)
        seconds, gap = shares.best_seconds()
        return {
            "monte_carlo": (rate := monte_carlo.best_rate()),
            "stage_optimized": 1e6 / rate,
            "output_error": 1e3 * output_error.best_seconds(),
            "design_q11": 1e3 * seconds,
            "design_q11_gap": gap,
            **(table() if table else {}),
        }

    return measure


def load_table(program: Path) -> Callable[[], Figures] | None:
    """A measurement of pyarrow on the rows that ours writes and reads; nothing if it is missing."""
    try:
        from peers.table import TableIo
    except ImportError as error:
        print(f"pyarrow is left out: {error}", file=sys.stderr)
        return None
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.parquet"
        call_ours(program, "--table", str(rows))
        table = TableIo(rows)

    def measure() -> Figures:
        write, read, size = table.best()
        return table_figures(table.raw_bytes, write, read, size)

    return measure


def run_ours(program: Path, tables: bool) -> tuple[Figures, Figures]:
    """The figures of our own benchmark, from the JSON object that it prints, and of the peers that it runs itself."""
    print("measuring ours", file=sys.stderr)
    found: dict[str, Any] = json.loads(call_ours(program, "--tables" if tables else "--json"))
    table = found["table"]
    of_table = table_figures(table["raw_bytes"], table["write_s"], table["read_s"], table["file_bytes"])
    if tables:
        return of_table, {}
    own = {
        "monte_carlo": found["monte_carlo"]["realizations_per_s_per_core"],
        "stage_optimized": found["stage"]["optimized"]["us_per_run"],
        "stage_random": found["stage"]["random"]["us_per_run"],
        "stage_drawn": found["stage"]["optimized"]["us_per_run"],
        "output_error": 1e3 * found["output_error"]["seconds_per_realization"],
        "forces_jacobian": found["forces"]["jacobian_in_errors"],
        "forces_fit": 1e3 * found["forces"]["fit_s"],
        "design_q11": 1e3 * found["design_q11"]["seconds"],
        "design_q11_gap": found["design_q11"]["relative_gap"],
        "design_q10000": 1e3 * found["design_q10000"]["seconds"],
        "design_q10000_gap": found["design_q10000"]["relative_gap"],
        **of_table,
    }
    planner, inside = planner_figures(found["planner"])
    stage = {"stage_drawn": found["stage"]["rand_distr"]["us_per_run"]}
    return {**own, **planner}, {**inside, **stage}


def call_ours(program: Path, *flags: str) -> bytes:
    """What our own benchmark prints."""
    done = subprocess.run([program.resolve(), *flags], stdout=subprocess.PIPE, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{program}: failed with exit code {done.returncode}")
    return done.stdout


def planner_figures(found: dict[str, Any]) -> tuple[Figures, Figures]:
    """Times of plans in milliseconds, ours and those of Rust's pathfinding, which the benchmark runs itself."""
    peer = found["pathfinding"]
    ours = {f"planner_{size}": 1e3 * times["plan_s"] for size, times in found.items() if size != "pathfinding"}
    paper = found["35x44x4_3x3"]
    ours |= {"planner_a_star": 1e3 * paper["plan_s"], "planner_table": 1e3 * paper["table_s"]}
    return ours, {"planner_35x44x4_3x3": 1e3 * peer["dijkstra_s"], "planner_a_star": 1e3 * peer["astar_s"]}


def table_figures(raw_bytes: int, write_s: float, read_s: float, file_bytes: int) -> Figures:
    """Throughput in bytes of values, and what 100 MB of values take in the file."""
    return {
        "write": raw_bytes / write_s / 1e6,
        "read": raw_bytes / read_s / 1e6,
        "size": 100.0 * file_bytes / raw_bytes,
    }


def best_of(rounds: list[Figures]) -> Figures:
    """The best of every figure (of gaps and sizes: the largest, which is what can be relied on)."""
    best: Figures = {}
    for line in LINES:
        values = [figures[line.key] for figures in rounds if line.key in figures]
        if values:
            relied_on = line.key.endswith("_gap") or line.key == "size"
            best[line.key] = max(values) if line.more_is_better or relied_on else min(values)
    return best


def show(ours: Figures, theirs: Figures) -> None:
    """The table on stdout. A ratio above 1 says that ours is better."""
    row = "{:<36} {:>14} {:>12} {:>12} {:>7} {:>7}"
    print(row.format("what", "unit", "ours", "peer", "ratio", "target"))
    for line in LINES:
        if line.key not in ours:
            continue
        own, peer = ours[line.key], theirs.get(line.key)
        ratio = "-"
        if peer and own and line.unit:
            ratio = f"{own / peer if line.more_is_better else peer / own:.2f}"
        target = "-" if line.target is None else f"{line.target:.2f}"
        shown = "-" if peer is None else number(peer)
        print(row.format(line.what, line.unit or "1", number(own), shown, ratio, target))


def number(value: float) -> str:
    return f"{value:.4g}"


def machine() -> str:
    """Model of the processor and number of cores."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        names = [line.split(":", 1)[1].strip() for line in information.read_text().splitlines() if "model name" in line]
        model = names[0] if names else model
    return f"machine: {model}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"


if __name__ == "__main__":
    main()
