"""Measures what a wrong nominal model costs a trial, with maneuvers given as inputs and as motions that are held by feedback.

    python scripts/wrong_nominal.py --draws 70 --seeds 1 2 [--trials 40] [--ways feedback] [--criterion a-relative]
        [--program target/release/seatrial]

Each draw multiplies every nominal parameter of the paper's ship by e^(0.4 z), z normal. The nominal ship alone decides which of 600
candidates keep the limits and how a trial of 125 s is made of them, by the paper's criterion or by another one for an output-error
estimate. The true ship sails it: by the nominal ship's inputs within limits of inputs, or by feedback with limits of motion alone.

Two errors are measured, each the root of Σ (error/true parameter)². *Found* is the median over so many trials by `monte-carlo` with
`output-error`. *First order* has the standard errors at the truth: those of one trial whose noise and current are a thousandth,
times a thousand. Prints both for every draw, then median and 90 % over all draws with 95 % intervals by order statistics. Needs
nothing besides Python, and computes nothing but these sums and quantiles.
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

PRESET = Path("crates/ship/presets/ljungberg-model-ship.toml")
RANGES = {"tau1": 5978.0, "tau2": 2391.0, "tau3": 956.0}
WAYS = ("inputs", "feedback")
ERRORS = ("first order", "found")
PAPERS = "d-hessian"
QUIET = 1e-3
FULL_STD = 0.158

# The validation maneuver is one that every nominal ship can hold; nothing here depends on it.
CAMPAIGN = """
[current]
kind = "white"
std_m_s = {std}

[measurement]
std_u_m_s = {std}
std_v_m_s = {std}
std_r_rad_s = {std}

[validation]
parameter_error_bound = 5.0
simulation_error_bound = 0.15

[[validation.maneuver]]
name = "slow"
kind = "accelerate"
duration_s = 20.0
from_m_s = 0.2
to_m_s = 0.3
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
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--ways", choices=WAYS, nargs="+", default=WAYS)
    parser.add_argument("--criterion", default=PAPERS)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    draws: dict[str, list[tuple[float, float]]] = {way: [] for way in a.ways}
    for seed in (1000 * seed + draw for seed in a.seeds for draw in range(a.draws)):
        with tempfile.TemporaryDirectory() as folder:
            ships(Path(folder), random.Random(seed))
            for way in a.ways:
                draws[way].append(errors(a, Path(folder), way, seed))
        print(seed, *(f"{way} {draws[way][-1][0]:.3f} {draws[way][-1][1]:.3f}" for way in a.ways), flush=True)
    for way in a.ways:
        for which, name in enumerate(ERRORS):
            values = sorted(pair[which] for pair in draws[way])
            print(f"{way}, {name}: median {quantile(values, 0.5)}, 90 % {quantile(values, 0.9)}, of {len(values)} draws")
    if len(a.ways) < 2:
        return
    better = sum(one[1] > other[1] for one, other in zip(draws["inputs"], draws["feedback"]))
    print(f"feedback is better in {better} of {len(draws['inputs'])}")


def quantile(ordered: list[float], share: float) -> str:
    """A quantile with its 95 % interval by order statistics: the number of draws below it is binomial."""
    count = len(ordered)
    ranks, below = [], 0.0
    for rank in range(count + 1):
        below += math.comb(count, rank) * share**rank * (1.0 - share) ** (count - rank)
        ranks.append(below)
    low = sum(chance <= 0.025 for chance in ranks)
    high = sum(chance < 0.975 for chance in ranks)
    middle = statistics.median(ordered) if share == 0.5 else ordered[math.ceil(share * count) - 1]
    ends = [-math.inf, *ordered, math.inf]
    return f"{middle:.3f} ({ends[low]:.3f} to {ends[high + 1]:.3f})"


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


def errors(a: argparse.Namespace, folder: Path, way: str, seed: int) -> tuple[float, float]:
    """The first-order and the found error of the designed trial; infinite where the nominal ship cannot hold a part of it."""
    limits = LIMITS
    if way == "inputs":
        limits += "inputs = { " + ", ".join(f"{name} = {bound}" for name, bound in RANGES.items()) + " }\n"
    head = 'duration_s = 20.0\ninputs_from = "nominal"\n\n[generate]\ncandidates = 600\n'
    (folder / "dictionary.toml").write_text(f'{head}executed = "{way}"\n{limits}')
    campaign(folder / "campaign.toml", seed, a.trials, FULL_STD)
    design(a, folder, a.criterion)
    try:
        return first_order(a, folder, seed), found(a, folder)
    except subprocess.CalledProcessError as refused:
        print(refused.stderr.decode().strip())
        return math.inf, math.inf


def campaign(path: Path, seed: int, trials: int, std: float) -> None:
    size = f"seed = {seed}\nrealizations = {trials}\nduration_s = 125.0\n"
    path.write_text(size + CAMPAIGN.format(std=std))


def design(a: argparse.Namespace, folder: Path, criterion: str) -> None:
    """The trial that the nominal ship alone gives, `design.json`."""
    nominal = ("--vessel", "nominal.toml")
    run(a, folder, "simulate", "dictionary", *nominal, "--dictionary", "dictionary.toml", "--out", "dictionary.parquet")
    noise, chosen = (), ()
    if criterion != PAPERS:
        noise = ("--campaign", "campaign.toml", "--estimator", "output-error")
        chosen = ("--for", "output-error", "--criterion", criterion, "--duration-s", "125")
    run(a, folder, "moments", *nominal, "--trajectories", "dictionary.parquet", *noise, "--out", "moments.json")
    run(a, folder, "design", "--moments", "moments.json", *chosen, "--out", "design.json")


def sailed(noise: str) -> tuple[str, ...]:
    files = ("--vessel", "true.toml", "--dictionary", "dictionary.toml", "--campaign", noise, "--design", "design.json")
    return ("--allow=mixed", *files)


def first_order(a: argparse.Namespace, folder: Path, seed: int) -> float:
    """The error that standard errors at the truth say of the trial as the true ship sails it."""
    campaign(folder / "quiet.toml", seed, 1, FULL_STD * QUIET)
    run(a, folder, "simulate", "campaign", *sailed("quiet.toml"), "--out", "quiet.parquet")
    runs = ("--vessel", "true.toml", "--trajectories", "quiet.parquet", "--campaign", "quiet.toml")
    run(a, folder, "estimate", "--allow=mixed", *runs, "--estimator", "output-error", "--out", "quiet-estimates.parquet")
    estimate = json.loads((folder / "quiet-estimates-estimate.json").read_text())
    parameters = estimate["data"]["designs"][0]["parameters"]
    return math.sqrt(sum((one["predicted_se"] / QUIET / one["truth"]) ** 2 for one in parameters))


def found(a: argparse.Namespace, folder: Path) -> float:
    """The median error over trials of the true ship."""
    run(a, folder, "monte-carlo", *sailed("campaign.toml"), "--estimator", "output-error", "--out", "validation.json")
    counted = (folder / "validation.json").read_text()
    median = re.search(r'"parameter_error": \{[^}]*?"median": ([\d.]+)', json.dumps(json.loads(counted)))
    return float(median.group(1)) if median else math.inf


def run(a: argparse.Namespace, folder: Path, *arguments: str) -> None:
    subprocess.run([a.program.resolve(), *arguments, "--quiet"], cwd=folder, check=True, capture_output=True)


if __name__ == "__main__":
    main()
