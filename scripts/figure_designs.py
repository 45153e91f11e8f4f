"""Measures how well figures of merit are known after a trial that was designed for them, over the D-optimal trial of the same time.

    python scripts/figure_designs.py --seed 1 [--trials 200] [--program target/release/seatrial]

The paper's ship turns, does a 20° zig-zag and stops at -3000 N. A trial of random candidates is designed for the D-criterion, for one
of the figures and for all five. Each is simulated with the paper's disturbances and estimated by `output-error`. Every estimated ship
then does the maneuvers under the same orders. Prints the standard deviations of a figure over the trials, divided by that of the
D-optimal trials: predicted, and found with a 95 % interval (bootstrap). Needs pyarrow, which reads the table of estimates.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pyarrow.parquet

PRESET = Path("crates/ship/presets/ljungberg-model-ship.toml")
FIGURES = {
    "tactical": "turn/tactical_diameter",
    "advance": "turn/advance",
    "overshoot 1": "zig-zag/overshoot_1",
    "overshoot 2": "zig-zag/overshoot_2",
    "stop": "stop/track_reach",
}
ALONE = ("tactical", "overshoot 2", "stop")

TESTS = """inputs_from = "nominal"

[[maneuver]]
name = "turn"
kind = "turning-circle"
speed_m_s = 1.0
duration_s = 60.0
helm = { tau3 = 400.0 }

[[maneuver]]
name = "stop"
kind = "stop"
speed_m_s = 1.0
duration_s = 20.0
inputs = { tau1 = -3000.0 }
"""

ZIG_ZAG = """
[[maneuver]]
name = "zig-zag{phase}"
kind = "zig-zag-test"
speed_m_s = 1.0
duration_s = 40.0
hold_s = {hold_s}
helm = {{ tau3 = 400.0 }}
heading_rad = 0.3491
"""

# Parts of a sample of 8 Hz by which the helm goes over later: the overshoots of a ship are means over them, since those of a coarse
# model depend on where within samples the helm goes over.
PHASES = 8

CANDIDATES = """duration_s = {duration_s}
inputs_from = "value"

[generate]
candidates = {candidates}
seed = {seed}
period_s = [3.0, 40.0]

[generate.limits]
u_m_s = 1.2
v_m_s = 0.25
r_rad_s = 0.6
inputs = {{ tau1 = 5978.1, tau2 = 1428.2, tau3 = 696.9 }}
"""

CAMPAIGN = """seed = {seed}
realizations = {trials}
duration_s = {duration_s}

[current]
kind = "white"
std_m_s = 0.15811388300841897

[measurement]
std_u_m_s = 0.15811388300841897
std_v_m_s = 0.15811388300841897
std_r_rad_s = 0.15811388300841897

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


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--candidates", type=int, default=1000)
    parser.add_argument("--candidate-s", type=float, default=40.0)
    parser.add_argument("--duration-s", type=float, default=600.0)
    parser.add_argument("--program", type=Path, default=Path("target/release/seatrial"))
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        study = Study(a, Path(folder))
        study.prepare()
        d_optimal = study.design([])
        base = study.trials(d_optimal)
        print(f"seed {a.seed}, {a.trials} trials of {a.duration_s} s; standard errors over the D-optimal ones")
        for name in (*ALONE, "all"):
            wanted = FIGURES.values() if name == "all" else [FIGURES[name]]
            flags = ["--criterion", "figures", "--weight", "all=0"]
            design = study.design([*flags, *(part for own in wanted for part in ("--weight", f"{own}=1"))])
            report(name, design, study.trials(design), base, random.Random(a.seed))


class Study:
    """The files of one seed."""

    def __init__(self, a: argparse.Namespace, folder: Path) -> None:
        self.a, self.folder = a, folder

    def prepare(self) -> None:
        a, text = self.a, PRESET.read_text()
        self.text = re.sub(r"value = (\S+)\nnominal = \S+", r"value = \1\nnominal = \1", text)
        size = {"seed": a.seed, "trials": a.trials, "duration_s": a.duration_s, "candidates": a.candidates}
        for name, written in {
            "vessel.toml": self.text,
            "tests.toml": TESTS + ZIG_ZAG.format(phase="", hold_s=0.0),
            "phases.toml": TESTS + "".join(
                ZIG_ZAG.format(phase=f"-{k}", hold_s=(k + 0.5) / PHASES / 8.0) for k in range(PHASES)
            ),
            "dictionary.toml": CANDIDATES.format(**{**size, "duration_s": a.candidate_s}),
            "campaign.toml": CAMPAIGN.format(**size),
        }.items():
            (self.folder / name).write_text(written)
        vessel, trajectories = ("--vessel", "vessel.toml"), ("--trajectories", "dictionary.parquet")
        self.run("simulate", "dictionary", *vessel, "--dictionary", "dictionary.toml", "--out", trajectories[1])
        campaign = ("--campaign", "campaign.toml", "--estimator", "output-error")
        self.run("moments", *vessel, *trajectories, *campaign, "--out", "moments.json")
        tests = ("--dictionary", "tests.toml", "--length-m", "1")
        self.run("validate", "merit", *vessel, *tests, "--slopes", "--out", "merit.json")

    def design(self, flags: list[str]) -> dict[str, dict[str, float]]:
        """Predicted standard errors of the design with these flags, in design.json."""
        size = ("--duration-s", str(self.a.duration_s), "--figures", "merit.json")
        always = ("--moments", "moments.json", "--for", "output-error", *size)
        self.run("design", *always, *flags, "--out", "design.json")
        found = json.loads((self.folder / "design.json").read_text())["data"]["figures"]["figures"]
        return {f"{own['maneuver']}/{own['name']}": own for own in found}

    def trials(self, design: dict[str, dict[str, float]]) -> dict[str, list[float]]:
        """The figures of the ships that trials of design.json estimate."""
        of = ("--vessel", "vessel.toml", "--dictionary", "dictionary.toml", "--campaign", "campaign.toml")
        how = ("--design", "design.json", "--estimator", "output-error", "--keep", "estimates")
        self.run("monte-carlo", *of, *how, "--out", "validation.json")
        table = pyarrow.parquet.read_table(self.folder / "estimates.parquet").to_pylist()
        rows = [row for row in table if row["design"] == "optimized" and row["status"] == "identified"]
        if len(rows) < self.a.trials:
            print(f"{self.a.trials - len(rows)} trials without an estimate")
        with ThreadPoolExecutor(2) as pool:
            ships = list(pool.map(self.figures, range(len(rows)), rows))
        return {name: [ship[name] for ship in ships if name in ship] for name in design}

    def figures(self, number: int, row: dict[str, float]) -> dict[str, float]:
        """The figures of a ship with the parameters of a row of estimates, under the orders to the true one."""

        def estimated(match: re.Match[str]) -> str:
            name, rest = match.group(1), match.group(2)
            return f'parameter = "{name}"\n{rest}value = {row[name]!r}\n'

        folder = self.folder / f"ship-{number}"
        folder.mkdir(exist_ok=True)
        text = re.sub(r'parameter = "(\w+)"\n((?:.*\n)*?)value = \S+\n', estimated, self.text)
        (folder / "vessel.toml").write_text(text)
        tests = ("--dictionary", "phases.toml", "--length-m", "1")
        merit = folder / "merit.json"
        self.run("validate", "merit", "--vessel", str(folder / "vessel.toml"), *tests, "--out", str(merit))
        maneuvers = json.loads(merit.read_text())["data"]["maneuvers"]
        values: dict[str, list[float]] = {}
        for own in maneuvers:
            for one in own["figures"]:
                name = re.sub(r"-\d+$", "", own["name"])
                values.setdefault(f"{name}/{one['name']}", []).append(one["value"])
        return {name: statistics.mean(own) for name, own in values.items()}

    def run(self, *arguments: str) -> None:
        done = subprocess.run(
            [self.a.program.resolve(), *arguments, "--quiet"], cwd=self.folder, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(arguments)}: {done.stderr.strip()}")


def report(
    name: str,
    design: dict[str, dict[str, float]],
    own: dict[str, list[float]],
    base: dict[str, list[float]],
    generator: random.Random,
) -> None:
    """Prints the ratios of a design."""
    places = list(FIGURES.values())
    found = ratios(own, base, None)
    draws = [ratios(own, base, generator) for _ in range(1000)]
    for figure, place in FIGURES.items():
        mark = "*" if name in (figure, "all") else " "
        over = statistics.stdev(own[place]) / design[place]["standard_error"]
        number = places.index(place)
        print(
            f"{mark} for {name:12} {figure:12} predicted {design[place]['ratio']:.2f}, found {found[number]:.2f} "
            f"({interval([draw[number] for draw in draws])}), found over predicted error {over:.2f}",
            flush=True,
        )
    if name == "all":
        predicted = statistics.mean(design[place]["ratio"] for place in places)
        means = interval([statistics.mean(draw) for draw in draws])
        print(f"* five together: mean predicted {predicted:.2f}, found {statistics.mean(found):.2f} ({means})")


def ratios(
    own: dict[str, list[float]], base: dict[str, list[float]], generator: random.Random | None
) -> list[float]:
    """Of the standard deviations of every figure; of trials drawn with replacement, if there is a generator."""

    def spreads(of: dict[str, list[float]]) -> list[float]:
        count = min(len(of[place]) for place in FIGURES.values())
        trials = generator.choices(range(count), k=count) if generator else range(count)
        return [statistics.stdev(of[place][k] for k in trials) for place in FIGURES.values()]

    return [one / other for one, other in zip(spreads(own), spreads(base))]


def interval(values: list[float]) -> str:
    ordered = sorted(values)
    last = len(ordered) - 1
    return f"{ordered[round(0.025 * last)]:.2f} to {ordered[round(0.975 * last)]:.2f}"


if __name__ == "__main__":
    main()
