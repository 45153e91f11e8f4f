"""How often 95 % intervals of single trials by `iv` hold the truth: the first column of docs/criticism.md's table.

    python scripts/coverage.py [--trials 304] [--program target/release/seatrial]

The paper's ship, the optimized trial of `pipelines/scenarios`, seed 1, five kinds of disturbances. Needs pyarrow, and computes
shares with Wilson's intervals, as if all parameters were independent.
"""

from __future__ import annotations

import argparse
import math
import re
import subprocess
import tempfile
from pathlib import Path

import pyarrow.parquet as parquet

VESSEL = Path("crates/model/presets/ljungberg-model-ship.toml")
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
            run("simulate", "campaign", *sailed, *files, "--allow-mixed", out="campaign.parquet")
            trials = ("--trajectories", folder / "campaign.parquet", "--estimator", "iv", "--allow-mixed")
            run("estimate", "--vessel", VESSEL, *trials, out="estimates.parquet")
            print(f"{kind}: {held(folder / 'estimates.parquet', truth)}", flush=True)


def held(path: Path, truth: dict[str, str]) -> str:
    """The share of intervals that hold the truth [%], with its interval."""
    table = parquet.read_table(path)
    hits = []
    for name, value in truth.items():
        estimates, errors = table[name].to_pylist(), table[f"{name}_se"].to_pylist()
        hits += [abs(own - float(value)) <= Z * error for own, error in zip(estimates, errors)]
    n, share = len(hits), sum(hits) / len(hits)
    middle = (share + Z * Z / (2 * n)) / (1 + Z * Z / n)
    half = Z * math.sqrt(share * (1 - share) / n + Z * Z / (4 * n * n)) / (1 + Z * Z / n)
    return f"{100 * share:.1f} ({100 * (middle - half):.1f}–{100 * (middle + half):.1f}), {n} intervals"


if __name__ == "__main__":
    main()
