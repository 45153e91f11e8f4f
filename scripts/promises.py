"""Measures how far the error that a design promises is from the one that is found, before the trial and after it.

    python scripts/promises.py --draws 20 --seed 1 [--trials 40] [--executed feedback] [--program target/release/seatrial]

Each draw multiplies every nominal parameter of the paper's ship by e^(0.4 z), as `scripts/wrong_nominal.py` does. The nominal ship
designs a trial of 125 s for an output-error estimate (a-relative). The true ship sails it. *Found* is the root mean square of the
errors over so many trials; *promised* is that of `design.json` before a trial, and of `estimate --promised` after each of three others.
With fixed scales, all errors are over the nominal parameters; relative, those found are over the true ones. Prints promised over
found of every draw, then its spread, and the share between 0.8 and 1.25 with a 95 % interval (bootstrap over draws). Needs nothing
besides Python.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import subprocess
import tempfile
from pathlib import Path

import wrong_nominal

DESIGNED = ("--campaign", "campaign.toml", "--estimator", "output-error")
AFTER = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--executed", choices=["feedback", "inputs"], default="feedback")
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    all_draws: list[dict[str, list[float]]] = []
    for draw in range(a.draws):
        seed = 1000 * a.seed + draw
        with tempfile.TemporaryDirectory() as folder:
            wrong_nominal.ships(Path(folder), random.Random(seed))
            try:
                all_draws.append(ratios(a, Path(folder), seed))
            except subprocess.CalledProcessError as refused:
                print(draw, refused.stderr.decode().strip())
                continue
        print(draw, *(f"{what} {' '.join(f'{x:.2f}' for x in own)}" for what, own in all_draws[-1].items()), flush=True)
    for what in all_draws[0]:
        report(what, [own[what] for own in all_draws])


def report(what: str, draws: list[list[float]]) -> None:
    values = sorted(x for own in draws for x in own)
    at = lambda share: values[min(len(values) - 1, math.floor(share * len(values)))]
    generator = random.Random(1)
    shares = sorted(within([generator.choice(draws) for _ in draws]) for _ in range(2000))
    ends = f"{shares[50]:.2f} to {shares[1949]:.2f}"
    spread = f"5 % {at(0.05):.2f}, median {at(0.5):.2f}, 95 % {at(0.95):.2f}"
    print(f"{what}: {spread}; {within(draws):.3f} ({ends}) within 0.8 to 1.25; {len(values)} of {len(draws)} draws")


def within(draws: list[list[float]]) -> float:
    values = [x for own in draws for x in own]
    return sum(0.8 <= x <= 1.25 for x in values) / len(values)


def ratios(a: argparse.Namespace, folder: Path, seed: int) -> dict[str, list[float]]:
    """Promised over found of one ship."""
    limits = wrong_nominal.LIMITS
    if a.executed == "inputs":
        bounds = ", ".join(f"{name} = {bound}" for name, bound in wrong_nominal.RANGES.items())
        limits += f"inputs = {{ {bounds} }}\n"
    head = 'duration_s = 20.0\ninputs_from = "nominal"\n\n[generate]\ncandidates = 600\n'
    (folder / "dictionary.toml").write_text(f'{head}executed = "{a.executed}"\n{limits}')
    wrong_nominal.campaign(folder / "campaign.toml", seed, a.trials, wrong_nominal.FULL_STD)
    run = lambda *arguments: wrong_nominal.run(a, folder, *arguments)
    of_design = ("--vessel", "nominal.toml", "--trajectories", "dictionary.parquet")
    run("simulate", "dictionary", "--vessel", "nominal.toml", "--dictionary", "dictionary.toml", "--out", "dictionary.parquet")
    run("moments", *of_design, *DESIGNED, "--out", "moments.json")
    criterion = ("--for", "output-error", "--criterion", "a-relative", "--duration-s", "125")
    run("design", "--moments", "moments.json", *criterion, "--out", "design.json")
    sail(run, ())
    scales = json.loads((folder / "design.json").read_text())["data"]["covariance"]["weights"]
    found = json.loads((folder / "estimate.json").read_text())["data"]["designs"][0]["parameters"]
    fixed = math.sqrt(sum(square(p) * scales[p["name"]] for p in found))
    relative = math.sqrt(sum(square(p) / p["truth"] ** 2 for p in found))
    promised, after = 0.0, []
    for trial in range(AFTER):
        sail(run, ("--set", "campaign.realizations=1", "--seed", str(100_000 + 10 * seed + trial)), "--promised", "design.json")
        error = json.loads((folder / "estimate.json").read_text())["data"]["promise"]["parameter_error"]
        promised = error["promised"]
        after.append(error["now"] / fixed)
    return {"before, relative": [promised / relative], "before, fixed": [promised / fixed], "after, fixed": after}


def square(found: dict[str, float]) -> float:
    """The mean square of a parameter's errors."""
    return (found["mean"] - found["truth"]) ** 2 + (found["spread"] or 0.0) ** 2


def sail(run, size: tuple[str, ...], *more: str) -> None:
    files = ("--vessel", "true.toml", "--dictionary", "dictionary.toml", "--campaign", "campaign.toml", "--design", "design.json")
    run("simulate", "campaign", "--allow=mixed", *files, *size, "--out", "campaign.parquet")
    estimate = ("--vessel", "true.toml", "--trajectories", "campaign.parquet", *DESIGNED)
    run("estimate", "--allow=mixed", *estimate, *more, "--out", "estimates.parquet")


if __name__ == "__main__":
    main()
