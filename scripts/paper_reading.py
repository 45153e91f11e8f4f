"""Searches for a reading of the paper's maneuvers whose design has the shares that the paper prints.

    python scripts/paper_reading.py search [--draws 3000] [--climbs 8] [--steps 150] [--seed 1]
    python scripts/paper_reading.py worth
    python scripts/paper_reading.py oracle --out fixtures/oracle/reading.json

The paper (Ljungberg, Linder, Enqvist, Tervo) prints ranges of u, v and r for eleven maneuvers, not their shapes. A `Reading` holds
what is free; every one of them keeps the printed ranges. `search` draws readings at random, then climbs from the best of them, and
prints the readings it ends with. It looks at the shares alone. Afterwards it simulates trials of those that came within 0.05 of the
printed shares, and of the reading of pipelines/paper, and prints how many give a good model. `worth` changes
the choices of pipelines/paper/dictionary.toml one at a time. `oracle` computes that file's inputs, states and design, for the tests
named `oracle_*`. Needs numpy and scipy; shares no code with the workspace.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tomllib
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path
from typing import Any

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402  (one thread is asked for first)

from independent.design import blocks, from_equal_shares, optimal  # noqa: E402
from independent.moments import Moments  # noqa: E402
from independent.motion import increments, regressors, steady_inputs  # noqa: E402
from independent.study import Vessel, read_vessel  # noqa: E402
from independent.text import pretty  # noqa: E402
from independent.trials import SAMPLES as OF_A_TRIAL, SEGMENTS, optimized, random  # noqa: E402

PAPER = Path(__file__).resolve().parent.parent / "pipelines/paper"
RATE_HZ = 8.0

# As printed: u, how far v and r swing to either side; u and v of the spirals.
ZIG_ZAGS = (
    ("slow-flat", 0.35, 0.1, 0.2),
    ("moderate-flat", 0.8, 0.1, 0.2),
    ("fast-flat", 1.15, 0.1, 0.2),
    ("slow-steep", 0.35, 0.15, 0.35),
    ("moderate-steep", 0.7, 0.15, 0.35),
    ("fast-steep", 1.0, 0.15, 0.35),
)
SPIRALS = (("slow", 0.4, 0.05), ("moderate", 0.75, 0.125), ("fast", 1.0, 0.2))
PRINTED = np.array([0.16, 0.04, 0.0, 0.0, 0.09, 0.42, 0.0, 0.04, 0.0, 0.0, 0.25])


@dataclass(frozen=True)
class Reading:
    """The free choices."""

    hold_s: float
    """Before a step of the thrust."""
    steepness: float
    """Of a zig-zag's flanks; 1 is a sine."""
    phase: float
    """Of v after r, in periods; at 0.5 it is the opposite."""
    flat_s: float
    steep_s: float
    """Periods of the flat and the steep zig-zags."""
    exponent: float
    """Of the time, by which r of a spiral grows."""
    sway: float
    """v of a spiral grows from 1 − sway times the printed one to 1 + sway times."""


LOWEST = Reading(0.0, 1.0, 0.4, 5.0, 5.0, 0.1, 0.0)
HIGHEST = Reading(4.0, 15.0, 0.6, 15.0, 15.0, 2.0, 1.0)
CHOSEN = Reading(2.5, 5.0, 0.484, 8.4, 12.0, 0.36, 0.8)
SAMPLES = 320
"""Of every maneuver: the printed "about 40 s" at 8 Hz. ("300 samples" is printed beside it.)"""

TRIALS = 10_000

AT_ONCE = 50
"""Readings that are simulated side by side."""


def maneuvers(own: Reading) -> list[dict[str, Any]]:
    """What dictionary.toml says of this reading's maneuvers."""
    steps = [
        {"kind": kind, "from_m_s": before, "to_m_s": after, "hold_s": own.hold_s}
        for kind, before, after in (("decelerate", 1.0, 0.0), ("accelerate", 0.0, 1.0))
    ]
    swings = []
    for name, u, v, r in ZIG_ZAGS:
        period_s = own.flat_s if name.endswith("flat") else own.steep_s
        swing = {"shape": "flat-sine", "period_s": period_s, "steepness": own.steepness}
        swings.append(combined(u, swing | {"amplitude": r}, swing | {"amplitude": v, "phase": own.phase}))
    whole = {"shape": "ramp", "over_s": SAMPLES / RATE_HZ}
    turn = whole | {"mean": -0.3, "amplitude": -0.3, "exponent": own.exponent}
    spirals = [combined(u, turn, whole | {"mean": v, "amplitude": round(v * own.sway, 12)}) for _, u, v in SPIRALS]
    return steps + swings + spirals


def combined(u: float, r: dict[str, Any], v: dict[str, Any]) -> dict[str, Any]:
    return {"kind": "combined", "exact": True, "speed_m_s": {"mean": u}, "yaw_rate_rad_s": r, "sway_m_s": v}


def signal(own: dict[str, Any], t: np.ndarray) -> np.ndarray:
    """A signal of a combined maneuver at the times t [s]."""
    match own.get("shape", "constant"):
        case "constant":
            swing = np.zeros_like(t)
        case "flat-sine":
            angle = 2.0 * math.pi * (t / own["period_s"] + own.get("phase", 0.0))
            swing = np.minimum(1.0, np.maximum(-1.0, own["steepness"] * np.sin(angle)))
        case "ramp":
            swing = 2.0 * np.minimum(t / own["over_s"], 1.0) ** own.get("exponent", 1.0) - 1.0
        case other:
            raise ValueError(f"a shape that this script does not know: {other}")
    return own.get("mean", 0.0) + own.get("amplitude", 0.0) * swing


def realize(vessel: Vessel, own: dict[str, Any], samples: int) -> tuple[np.ndarray, np.ndarray]:
    """The state at the start (3) and the inputs (samples × 3) of a maneuver, by the true parameters."""
    k = np.arange(samples + 1)
    if own["kind"] != "combined":
        before, after = (
            steady_inputs(vessel, vessel.value, own[key], 0.0, 0.0) for key in ("from_m_s", "to_m_s")
        )
        inputs = np.where((k[:-1] < own["hold_s"] * RATE_HZ)[:, None], before, after)
        return np.array([own["from_m_s"], 0.0, 0.0]), inputs
    keys = ("speed_m_s", "sway_m_s", "yaw_rate_rad_s")
    motion = np.column_stack([signal(own[key], k / RATE_HZ) for key in keys])
    return motion[0], following(vessel, motion)


def following(vessel: Vessel, motion: np.ndarray) -> np.ndarray:
    """The inputs by which the true model goes from row to row of `motion`; each input moves one degree of freedom."""
    at = dict(zip("uvr", motion[:-1].T))
    none = dict.fromkeys(vessel.inputs, 0.0)
    drift = np.array(increments(vessel, vessel.value, at | none))
    still = dict.fromkeys("uvr", 0.0)
    slopes = [increments(vessel, vessel.value, still | none | {name: 1.0})[d] for d, name in enumerate(vessel.inputs)]
    return (np.diff(motion, axis=0) - drift.T) / np.array(slopes)


def simulate(vessel: Vessel, theta: Any, starts: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """States, Q × (N+1) × 3, of Q maneuvers side by side; inputs Q × N × 3."""
    states = [starts]
    for row in inputs.transpose(1, 0, 2):
        values = dict(zip("uvr", states[-1].T)) | dict(zip(vessel.inputs, row.T))
        states.append(states[-1] + np.column_stack(increments(vessel, theta, values)))
    return np.stack(states, axis=1)


def sailed(vessel: Vessel, dictionary: list[dict[str, Any]], samples: int) -> tuple[np.ndarray, ...]:
    """Inputs, true and nominal states of all maneuvers."""
    starts, inputs = (np.array(parts) for parts in zip(*(realize(vessel, own, samples) for own in dictionary)))
    true, nominal = (simulate(vessel, theta, starts, inputs) for theta in (vessel.value, vessel.nominal))
    return inputs, true, nominal


def moments(vessel: Vessel, dictionary: list[dict[str, Any]], samples: int) -> list[list[Moments]]:
    """Of every maneuver and degree of freedom: φ of the true states, ζ of the nominal ones."""
    out = []
    for tau, true, nominal in zip(*sailed(vessel, dictionary, samples)):
        pairs = zip(regressors(vessel, true, tau), regressors(vessel, nominal, tau))
        out.append([Moments(phi.T @ zeta / samples, phi.mean(0), zeta.mean(0)) for phi, zeta in pairs])
    return out


def distances(vessel: Vessel, readings: list[Reading]) -> list[float]:
    """Sums of the absolute differences between a design's shares and the printed ones."""
    out = []
    for first in range(0, len(readings), AT_ONCE):
        some = readings[first : first + AT_ONCE]
        all_of_them = moments(vessel, [maneuver for own in some for maneuver in maneuvers(own)], SAMPLES)
        count = len(PRINTED)
        out += [distance(all_of_them[count * i : count * (i + 1)]) for i in range(len(some))]
    return out


def distance(own: list[list[Moments]]) -> float:
    """Infinite where no design is found."""
    try:
        total = float(np.abs(from_equal_shares(blocks(own, "complete")) - PRINTED).sum())
    except np.linalg.LinAlgError:
        return math.inf
    return total if math.isfinite(total) else math.inf


def drawn(place: np.ndarray) -> Reading:
    """The reading at a place of the unit cube: evenly between the bounds, steepness and exponent in the logarithm."""
    values = []
    for field, x, low, high in zip(fields(Reading), place, astuple(LOWEST), astuple(HIGHEST)):
        logarithmic = field.name in ("steepness", "exponent")
        values.append(low * (high / low) ** x if logarithmic else low + (high - low) * x)
    return Reading(*values)


def search(vessel: Vessel, draws: int, climbs: int, steps: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.random((draws, len(fields(Reading))))
    found = np.array(distances(vessel, [drawn(place) for place in places]))
    within = np.mean(found < 0.05)
    print(f"{draws} readings at random: best {found.min():.3f}, median {np.median(found):.3f}, {within:.2%} within 0.05")
    order = np.argsort(found)[:climbs]
    climbed, best = climb(vessel, places[order], found[order], steps, rng)
    for i in np.argsort(best):
        values = (f"{field.name} {x:.4g}" for field, x in zip(fields(Reading), astuple(drawn(climbed[i]))))
        print(f"from {found[order[i]]:.3f} in {steps} steps to {best[i]:.3f}: {', '.join(values)}", flush=True)
    near = [(f"{best[i]:.3f}", drawn(climbed[i])) for i in np.argsort(best) if best[i] < 0.05]
    for name, own in [("pipelines/paper", CHOSEN), *near]:
        of_design, of_random = trials(vessel, own, rng)
        print(f"{TRIALS} trials each, good ones: {of_design:.1%} and {of_random:.1%} at random  ({name})", flush=True)


def trials(vessel: Vessel, own: Reading, rng: Any) -> tuple[float, float]:
    """The shares of good models after the reading's design, and after random maneuvers."""
    dictionary = maneuvers(own)
    wanted = optimal(moments(vessel, dictionary, SAMPLES), "complete").shares * OF_A_TRIAL
    counts = np.floor(wanted).astype(int)
    counts[np.argsort(counts - wanted)[: OF_A_TRIAL - counts.sum()]] += 1
    design = [realize(vessel, maneuver, n) for maneuver, n in zip(dictionary, counts) if n > 0]
    any_of = [realize(vessel, maneuver, OF_A_TRIAL // SEGMENTS) for maneuver in dictionary]
    return optimized(vessel, design, TRIALS, rng), random(vessel, any_of, TRIALS, rng)


def climb(vessel: Vessel, places: np.ndarray, best: np.ndarray, steps: int, rng: Any) -> tuple[np.ndarray, np.ndarray]:
    """Random steps from every place, kept where they come nearer; they grow with success and shrink without."""
    lengths = np.full(len(places), 0.1)
    for _ in range(steps):
        tried = np.clip(places + lengths[:, None] * rng.standard_normal(places.shape), 0.0, 1.0)
        found = np.array(distances(vessel, [drawn(place) for place in tried]))
        nearer = found < best
        places, best = np.where(nearer[:, None], tried, places), np.where(nearer, found, best)
        lengths *= np.where(nearer, 1.5, 0.9)
    return places, best


def worth(vessel: Vessel) -> None:
    changed = {
        "as in pipelines/paper": CHOSEN,
        "v along the turn": replace(CHOSEN, phase=0.0),
        "v the opposite of r": replace(CHOSEN, phase=0.5),
        "sines": replace(CHOSEN, steepness=1.0),
        "r of a spiral straight in time": replace(CHOSEN, exponent=1.0),
        "v of a spiral constant": replace(CHOSEN, sway=0.0),
        "no hold before a step": replace(CHOSEN, hold_s=0.0),
        "periods of 10 s": replace(CHOSEN, flat_s=10.0, steep_s=10.0),
    }
    for name, own in changed.items():
        found = optimal(moments(vessel, maneuvers(own), SAMPLES), "complete").shares
        shares = " ".join(f"{100.0 * share:5.1f}" for share in found)
        print(f"{name:32} {np.abs(found - PRINTED).sum():.3f}  {shares}")


def oracle(vessel: Vessel, out: Path) -> None:
    """The maneuvers and the design of pipelines/paper/dictionary.toml, computed from that file."""
    file = tomllib.loads((PAPER / "dictionary.toml").read_text())
    assert round(file["duration_s"] * RATE_HZ) == SAMPLES
    dictionary = file["maneuver"]
    for written, own in zip(dictionary, maneuvers(CHOSEN), strict=True):
        assert {key: written[key] for key in own} == own, f"{written['name']} is not the reading of this script"
    inputs, true, nominal = sailed(vessel, dictionary, SAMPLES)
    design = optimal(moments(vessel, dictionary, SAMPLES), "complete")
    assert design.gap < 1e-9
    at = (0, 1, 10, 19, 20, 100, SAMPLES - 1)
    document = {
        "samples": SAMPLES,
        "k": list(at),
        "maneuvers": [
            {
                "name": own["name"],
                "initial": true[q, 0].tolist(),
                "inputs": [inputs[q, k].tolist() for k in at],
                "states": [true[q, k].tolist() for k in at],
                "nominal_states": [nominal[q, k].tolist() for k in at],
            }
            for q, own in enumerate(dictionary)
        ],
        "shares": {own["name"]: float(share) for own, share in zip(dictionary, design.shares)},
        "printed": {own["name"]: float(share) for own, share in zip(dictionary, PRINTED)},
    }
    out.write_text(pretty(document) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=("search", "worth", "oracle"))
    parser.add_argument("--draws", type=int, default=3000, help="readings at random")
    parser.add_argument("--climbs", type=int, default=8, help="how many of the best are climbed from")
    parser.add_argument("--steps", type=int, default=150, help="of each climb")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="where the oracle's numbers go")
    arguments = parser.parse_args()
    vessel = read_vessel(PAPER)
    match arguments.what:
        case "search":
            search(vessel, arguments.draws, arguments.climbs, arguments.steps, arguments.seed)
        case "worth":
            worth(vessel)
        case "oracle":
            if arguments.out is None:
                parser.error("oracle needs --out")
            oracle(vessel, arguments.out)


if __name__ == "__main__":
    main()
