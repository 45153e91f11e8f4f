"""How often 95 % intervals of `iv` and `output-error` hold the truth (docs/estimators.md has one of these shares).

    python scripts/coverage.py [--trials 304] [--together 8] [--program target/release/seatrial]

The paper's ship, the optimized trial of `pipelines/scenarios`, seed 1, five kinds of disturbances: by single trials, and by
`--together` trials pooled (0: not; they take hours). Needs pyarrow, and computes shares. The parameters of an estimate err together, so an estimate is one
cluster: Wilson's intervals are as wide as the variance of the estimates' shares makes them.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

import pyarrow.parquet as parquet

VESSEL = Path("crates/ship/presets/ljungberg-model-ship.toml")
DICTIONARY = Path("pipelines/scenarios/dictionary.toml")
Z = 1.959963984540054
SENSORS = r"(std_(?:u_m_s|v_m_s|r_rad_s)) = \S+"


def campaigns(trials: int) -> dict[str, str]:
    """The campaign of each kind, with so many trials of the design alone."""
    paper = Path("pipelines/paper/campaign.toml").read_text()
    lasting = ("current-gauss-markov", "current-constant", "wind-bias")
    texts = {"white": paper, "quiet": re.sub(SENSORS, r"\1 = 0.02", paper)}
    texts |= {name: Path(f"pipelines/scenarios/{name}/campaign.toml").read_text() for name in lasting}
    alone = {name: re.sub(r"\[random\][^\[]*", "", text) for name, text in texts.items()}
    return {name: re.sub(r"realizations = \d+", f"realizations = {trials}", text) for name, text in alone.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=304)
    parser.add_argument("--together", type=int, default=8)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    truth = dict(re.findall(r'parameter = "(\w+)"\n.*?\nvalue = (\S+)', VESSEL.read_text()))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run(*arguments: str | Path, out: str) -> None:
            subprocess.run([a.program, *arguments, "--quiet", "--out", folder / out], check=True, capture_output=True)

        sailed = ("--vessel", VESSEL, "--dictionary", DICTIONARY)
        run("simulate", "dictionary", *sailed, out="dictionary.parquet")
        run("moments", "--vessel", VESSEL, "--trajectories", folder / "dictionary.parquet", out="moments.json")
        run("design", "--moments", folder / "moments.json", out="design.json")
        for kind, text in campaigns(a.trials).items():
            (folder / "campaign.toml").write_text(text)
            files = ("--campaign", folder / "campaign.toml", "--design", folder / "design.json", "--seed", "1")
            run("simulate", "campaign", *sailed, *files, "--allow=mixed", out="campaign.parquet")
            sailed_so = ("--vessel", VESSEL, "--trajectories", folder / "campaign.parquet", "--allow=mixed")
            cells = []
            for estimator in ("iv", "output-error"):
                stated = () if estimator == "iv" else ("--campaign", folder / "campaign.toml")
                run("estimate", *sailed_so, *stated, "--estimator", estimator, out="estimates.parquet")
                cells.append(share(single(folder / "estimates.parquet", truth)))
            for estimator in ("iv", "output-error") if a.together else ():
                pooled = []
                for first in range(0, a.trials - a.together + 1, a.together):
                    some = [f"--runs={number}" for number in range(first, first + a.together)]
                    run("estimate", "--fit=together", *sailed_so, *some, "--estimator", estimator, out="")
                    pooled.append(hits_of(folder / "estimate.json", truth))
                cells.append(share(pooled))
            print(f"| `{kind}` | {' | '.join(cells)} |", flush=True)


def single(path: Path, truth: dict[str, str]) -> list[list[bool]]:
    """Of each trial that has an estimate, which intervals hold the truth."""
    rows = parquet.read_table(path).to_pylist()
    held = lambda row, name: abs(row[name] - float(truth[name])) <= Z * row[f"{name}_se"]  # noqa: E731
    return [[held(row, name) for name in truth] for row in rows if all(row[name] is not None for name in truth)]


def hits_of(path: Path, truth: dict[str, str]) -> list[bool]:
    """The same of a pooled estimate, whose parts are the trials."""
    degrees = json.loads(path.read_text())["data"]["trust"]["degrees"]
    found = {own["name"]: own for degree in degrees for own in degree["parameters"]}
    return [abs(found[name]["estimate"] - float(value)) <= Z * found[name]["standard_error"] for name, value in truth.items()]


def share(hits: list[list[bool]]) -> str:
    """The share of intervals that hold the truth [%], with its interval, of as many estimates as lists."""
    shares = [sum(own) / len(own) for own in hits]
    clusters = len(shares)
    mean = sum(shares) / clusters
    variance = sum((own - mean) ** 2 for own in shares) / (clusters - 1) / clusters
    # As many independent intervals would be known as well; Student's t to its first order, for few clusters
    n = mean * (1 - mean) / variance if variance > 0 else clusters
    z = Z * (1 + (Z * Z + 1) / (4 * (clusters - 1)))
    middle = (mean + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(mean * (1 - mean) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return f"{100 * mean:.1f} ({100 * (middle - half):.1f}–{100 * (middle + half):.1f})"


if __name__ == "__main__":
    main()
