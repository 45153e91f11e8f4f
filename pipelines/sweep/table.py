"""Writes the table of a sweep: a row per cell, design and estimator, or the cell's refusal. Needs nothing but Python.

    python3 table.py cells.json sweep.csv     cells.json: what is set in each cell; beside it the folder `cells`
"""

import csv
import json
import sys
from pathlib import Path

ERRORS = ("parameter_error", "simulation_error")
OF_ERROR = ("share", "share_low", "share_high", "median", "median_low", "median_high")
COLUMNS = ("design", "estimator", "runs", "without_estimate_share")
COLUMNS += tuple(f"{error}_{column}" for error in ERRORS for column in OF_ERROR) + ("refusal",)


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def scores(folder):
    """The scores of a cell by every estimator; its estimator stands elsewhere if it is alone."""
    path = folder / "validation.json"
    if not path.exists():
        remedy = "end with the stage monte-carlo, validate or report"
        sys.exit(f"error: {path}: found none, expected the errors of simulated trials; {remedy}")
    data = read(path)["data"]["scored"]
    alone = {"estimator": read(folder / "estimate.json")["settings"]["estimator"], "designs": data["designs"]}
    return data.get("compared") or [alone]


def of_design(estimator, design):
    """The row of a design."""
    row = {"estimator": estimator, **{name: design.get(name) for name in COLUMNS[:1] + COLUMNS[2:4]}}
    for error in ERRORS:
        share, median = design[f"{error}_share"], design[error]["median"]
        ends = design.get(f"{error}_share_interval"), design[error].get("median_interval")
        values = [share, *(ends[0] or [None] * 2), median, *(ends[1] or [None] * 2)]
        row.update({f"{error}_{column}": value for column, value in zip(OF_ERROR, values)})
    return row


def rows(cell, file):
    """The rows of a cell whose end `file` tells."""
    end = read(file)
    if "exit_code" in end:
        return [{"refusal": end["error"]}]
    return [of_design(own["estimator"], design) for own in scores(file.with_suffix("")) for design in own["designs"]]


def main(grid, out):
    cells = read(grid)
    found = {cell: rows(cell, grid.parent / "cells" / f"{cell}.json") for cell in cells}
    refused = {cell: own[0]["refusal"] for cell, own in found.items() if "refusal" in own[0]}
    if len(refused) == len(cells):
        first = next(iter(refused.values()))
        sys.exit(f"error: {grid}: found every cell refused, expected one that is not; the first: {first}")
    with out.open("w", encoding="utf-8", newline="") as file:
        head = ("cell", *next(iter(cells.values())), *COLUMNS)
        table = csv.DictWriter(file, head, lineterminator="\n")
        table.writeheader()
        table.writerows({"cell": cell, **cells[cell], **row} for cell, own in found.items() for row in own)
    print(f"{out}: {len(cells)} cells, {len(refused)} refused", file=sys.stderr)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
