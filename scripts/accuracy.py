"""Measures what `design --accuracy` promises: the error that trials of the promised length have.

    python scripts/accuracy.py --study pipelines/paper --dictionary pipelines/scenarios/dictionary.toml \\
        --estimator iv --accuracies 1,2,3,4,6 --trials 2000 [--program target/release/seatrial]

For every accuracy: `design --accuracy` says how long the trial has to be and from which length on that holds, `monte-carlo` simulates
trials of that length. Prints rows: asked, length, whether the prediction holds there, and the median and the root
mean square of the parameter error. Needs pyarrow; computes nothing but the last two.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True, help="folder of vessel.toml and campaign.toml")
    parser.add_argument("--dictionary", type=Path, required=True)
    parser.add_argument("--estimator", choices=("iv", "output-error"), required=True)
    parser.add_argument("--accuracies", required=True, help="with commas between")
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure(a, Path(folder))


def measure(a: argparse.Namespace, out: Path) -> None:
    vessel = ("--vessel", a.study / "vessel.toml")
    campaign = ("--campaign", a.study / "campaign.toml")
    parameters = truth(a.study / "vessel.toml")
    trajectories, moments, design = out / "dictionary.parquet", out / "moments.json", out / "design.json"
    run(a, "simulate", "dictionary", *vessel, "--dictionary", a.dictionary, "--out", trajectories)
    run(a, "moments", *vessel, "--trajectories", trajectories, *campaign, "--estimator", a.estimator, "--out", moments)
    for accuracy in a.accuracies.split(","):
        asked = ("--for", a.estimator, "--accuracy", accuracy, "--relative-to", "value")
        run(a, "design", "--moments", moments, *asked, "--out", design)
        found = json.loads(design.read_text())["data"]["accuracy"]
        length = ("--set", f"campaign.duration_s={found['duration_s']}", "--set", f"campaign.realizations={a.trials}")
        trials = (*vessel, "--dictionary", a.dictionary, *campaign, "--design", design, "--estimator", a.estimator)
        run(a, "monte-carlo", "--allow=mixed", *trials, *length, "--keep", "estimates", "--out", out / "validation.json")
        errors, without = optimized(out / "estimates.parquet", parameters)
        square = math.sqrt(statistics.fmean(error**2 for error in errors))
        holds = "yes" if found["duration_s"] >= found["holds_from_s"] else f"from {found['holds_from_s']:.0f} s"
        median = statistics.median(errors + [math.inf] * without)
        cells = (a.estimator, accuracy, f"{found['duration_s']:.1f} s", holds, f"{median:.3g}", f"{square:.3g}", without)
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def run(a: argparse.Namespace, *arguments: Any) -> None:
    subprocess.run([a.program, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def truth(vessel: Path) -> dict[str, float]:
    """The true parameters that are estimated, of a vessel that is written out."""
    table = tomllib.loads(vessel.read_text())
    terms = (entry for degree in ("surge", "sway", "yaw") for entry in table[degree])
    return {entry["parameter"]: entry["value"] for entry in terms if not entry.get("fixed")}


def optimized(table: Path, parameters: dict[str, float]) -> tuple[list[float], int]:
    """The parameter errors of the optimized trials, and how many have no estimate."""
    rows = parquet.read_table(table, columns=["design", *parameters]).to_pylist()
    errors, without = [], 0
    for row in rows:
        if row["design"] != "optimized":
            continue
        relative = [row[name] / value - 1.0 if row[name] is not None else math.nan for name, value in parameters.items()]
        error = math.sqrt(sum(x * x for x in relative))
        if math.isfinite(error):
            errors.append(error)
        else:
            without += 1
    return errors, without


if __name__ == "__main__":
    main()
