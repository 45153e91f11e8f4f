"""Measures what a wrong nominal model costs a trial, with maneuvers given as inputs and as motions that are held by feedback.

    python scripts/wrong_nominal.py --draws 30 --seed 1 [--trials 40] [--program target/release/seatrial]

Each draw multiplies every nominal parameter of the paper's ship by e^(0.4 z), z normal. The nominal ship alone decides which of 600
candidates keep the limits and how a trial of 125 s is made of them. The true ship sails it: by the nominal ship's inputs within
limits of inputs, or by feedback with limits of motion alone. `monte-carlo` estimates by `output-error`. Prints the median parameter
error of every draw, then the medians over all of them with the number of draws in which feedback is better. Needs nothing besides
Python; computes nothing but medians.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

PRESET = Path("crates/model/presets/ljungberg-model-ship.toml")
RANGES = {"tau1": 5978.0, "tau2": 2391.0, "tau3": 956.0}
WAYS = ("inputs", "feedback")

CAMPAIGN = """
[current]
kind = "white"
std_m_s = 0.158

[measurement]
std_u_m_s = 0.158
std_v_m_s = 0.158
std_r_rad_s = 0.158

[validation]
parameter_error_bound = 5.0
simulation_error_bound = 0.15

[[validation.maneuver]]
name = "telegraph"
kind = "pseudo-random-binary"
duration_s = 60.0
speed_m_s = 0.6
speed_amplitude_m_s = 0.2
yaw_rate_amplitude_rad_s = 0.1
dwell_s = 8.0
seed = 1
"""

LIMITS = """start_m_s = [0.4, 0.8]

[generate.limits]
u_m_s = 1.3
v_m_s = 0.3
r_rad_s = 0.5
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draws", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    errors: dict[str, list[float]] = {way: [] for way in WAYS}
    for draw in range(a.draws):
        with tempfile.TemporaryDirectory() as folder:
            ships(Path(folder), random.Random(1000 * a.seed + draw))
            for way in WAYS:
                errors[way].append(error(a, Path(folder), way, 1000 * a.seed + draw))
        print(draw, *(f"{way} {errors[way][-1]:.3f}" for way in WAYS), flush=True)
    for way in WAYS:
        ordered = sorted(errors[way])
        high = ordered[math.ceil(0.9 * len(ordered)) - 1]
        print(f"{way}: median {statistics.median(ordered):.3f}, 90 % {high:.3f}, of {len(ordered)} draws")
    better = sum(one > other for one, other in zip(errors["inputs"], errors["feedback"]))
    print(f"feedback is better in {better} of {a.draws}")


def ships(folder: Path, generator: random.Random) -> None:
    """The ship with its true and its wrong nominal parameters, and the same without the truth."""

    def off(match: re.Match[str]) -> str:
        value = float(match.group(1))
        return f"value = {value!r}\nnominal = {value * math.exp(0.4 * generator.gauss(0.0, 1.0))!r}"

    text = re.sub(r"value = (\S+)\nnominal = \S+", off, PRESET.read_text())
    for name in ("tau1", "tau3"):
        bound = RANGES[name]
        text = re.sub(rf'(name = "{name}"\nunit = "[^"]*")', rf"\1\nrange = [{-bound}, {bound}]", text)
    (folder / "true.toml").write_text(text)
    (folder / "nominal.toml").write_text(re.sub(r"value = \S+\n", "", text))


def error(a: argparse.Namespace, folder: Path, way: str, seed: int) -> float:
    """The median parameter error of the designed trial; infinite where the nominal ship cannot hold a part of it."""
    limits = LIMITS
    if way == "inputs":
        limits += "inputs = { " + ", ".join(f"{name} = {bound}" for name, bound in RANGES.items()) + " }\n"
    head = 'duration_s = 20.0\ninputs_from = "nominal"\n\n[generate]\ncandidates = 600\n'
    (folder / "dictionary.toml").write_text(f'{head}executed = "{way}"\n{limits}')
    size = f"seed = {seed}\nrealizations = {a.trials}\nduration_s = 125.0\n"
    (folder / "campaign.toml").write_text(size + CAMPAIGN)
    dictionary = ("--dictionary", "dictionary.toml")
    nominal, true = ("--vessel", "nominal.toml"), ("--vessel", "true.toml")
    run(a, folder, "simulate", "dictionary", *nominal, *dictionary, "--out", "dictionary.parquet")
    run(a, folder, "moments", *nominal, "--trajectories", "dictionary.parquet", "--out", "moments.json")
    run(a, folder, "design", "--moments", "moments.json", "--out", "design.json")
    sailed = (*true, *dictionary, "--campaign", "campaign.toml", "--design", "design.json")
    try:
        run(a, folder, "monte-carlo", "--allow-mixed", *sailed, "--estimator", "output-error", "--out", "tally.json")
    except subprocess.CalledProcessError as refused:
        print(refused.stderr.decode().strip())
        return math.inf
    tally = (folder / "tally.json").read_text()
    median = re.search(r'"parameter_error": \{[^}]*?"median": ([\d.]+)', json.dumps(json.loads(tally)))
    return float(median.group(1)) if median else math.inf


def run(a: argparse.Namespace, folder: Path, *arguments: str) -> None:
    subprocess.run([a.program.resolve(), *arguments, "--quiet"], cwd=folder, check=True, capture_output=True)


if __name__ == "__main__":
    main()
