"""Measures what it costs a trial that an input needs time to change, and that there is no thrust astern.

    python scripts/rates.py --seeds 1 2 3 [--trials 400] [--program target/release/seatrial]

The paper's ship, its parameters known. Of each seed candidates are drawn twice: within limits of motion and inputs, and within
`rates` besides, by which an input goes through its whole range in 2 s, with thrust ahead alone. More are drawn there, so that about
500 keep the limits of either. Each set makes a design of 125 s for an output-error estimate (a-relative). In the limited one inputs
still jump from one maneuver to the next, so `design --refine` slows the whole trial and improves it, again from its own result until it
settles. It may go a tenth beyond the limits of motion there, since the state is carried over. `monte-carlo` estimates so many trials
by `output-error`. Prints the median parameter error of the free trial, and those of the limited one as designed and refined, with
their ratios to the free one. Needs nothing besides Python.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import tempfile
from pathlib import Path

import wrong_nominal

# Longer than any part of these designs: what follows the end of a candidate may be beyond its limits.
CANDIDATE_S = 40.0
FULL_RANGE_S = 2.0
AHEAD = 5978.1
# Drawn candidates of which about 500 are within the limits.
FREE, LIMITED = 600, 870
# Most searches, one after another.
SEARCHES = 4
LIMITS = "u_m_s = 1.43\nv_m_s = 0.33\nr_rad_s = 0.55\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    ratios: dict[str, list[float]] = {"designed": [], "refined": []}
    for seed in a.seeds:
        free = medians(a, seed, FREE, of_inputs())["designed"]
        print(f"seed {seed}: free {free:.3f}", flush=True)
        for stage, limited in medians(a, seed, LIMITED, with_rates(), refines=True).items():
            ratios[stage].append(limited / free)
            print(f"seed {seed}, {stage}: {limited:.3f}, ratio {limited / free:.3f}", flush=True)
    print("mean ratios:", *(f"{stage} {statistics.mean(own):.3f}" for stage, own in ratios.items()))


def of_inputs() -> str:
    """Limits of inputs alone."""
    bounds = ", ".join(f"{name} = {bound}" for name, bound in wrong_nominal.RANGES.items())
    return f"inputs = {{ {bounds} }}\n"


def with_rates() -> str:
    """Thrust ahead alone, and each input through its range in so many seconds."""
    ends = {name: (-bound, bound) for name, bound in wrong_nominal.RANGES.items()} | {"tau1": (0.0, AHEAD)}
    bounds = ", ".join(f"{name} = [{low}, {high}]" for name, (low, high) in ends.items())
    rates = ", ".join(f"{name} = {(high - low) / FULL_RANGE_S}" for name, (low, high) in ends.items())
    return f"inputs = {{ {bounds} }}\nrates = {{ {rates} }}\n"


def medians(a: argparse.Namespace, seed: int, candidates: int, limits: str, refines: bool = False) -> dict[str, float]:
    """The median parameter error of the designed trial, and that of the refined one."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ship(folder)
        head = f'duration_s = {CANDIDATE_S}\ninputs_from = "nominal"\n\n[generate]\ncandidates = {candidates}\nseed = {seed}\n'
        stated = LIMITS + limits
        (folder / "dictionary.toml").write_text(head + wrong_nominal.LIMITS + limits + "\n[limits]\n" + stated)
        wrong_nominal.campaign(folder / "campaign.toml", seed, a.trials, wrong_nominal.FULL_STD)
        wrong_nominal.design(a, folder, "a-relative")
        errors = {"designed": wrong_nominal.found(a, folder)}
        return errors | {"refined": refined(a, folder)} if refines else errors


def ship(folder: Path) -> None:
    """The ship whose nominal parameters are the true ones, with and without the truth."""
    text = re.sub(r"value = (\S+)\nnominal = \S+", r"value = \1\nnominal = \1", wrong_nominal.PRESET.read_text())
    (folder / "true.toml").write_text(text)
    (folder / "nominal.toml").write_text(re.sub(r"value = \S+\n", "", text))


def refined(a: argparse.Namespace, folder: Path) -> float:
    """The median parameter error of the design's trial after `design --refine`."""
    for search in range(SEARCHES):
        own = folder / f"refined-{search}"
        own.mkdir()
        files = [flag.replace("--design", "--refine") for flag in wrong_nominal.sailed("campaign.toml")]
        wrong_nominal.run(a, folder, "design", *files, "--out", f"{own.name}/")
        for file in ("campaign.toml", "true.toml"):
            (own / file).write_text((folder / file).read_text())
        (own / "refined-dictionary.toml").rename(own / "dictionary.toml")
        folder = own
        if json.loads((own / "design.json").read_text())["data"]["refined"]["settled"]:
            break
    return wrong_nominal.found(a, folder)


if __name__ == "__main__":
    main()
