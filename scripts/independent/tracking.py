"""Motions that a controller holds: the nominal vessel's motion, and what corrects another vessel's inputs until it moves so."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .motion import simulate, steady_inputs

if TYPE_CHECKING:
    from .steering import Fleet
    from .study import Vessel

KINDS = ("zig-zag", "sway-zig-zag")
NOT_FOLLOWED = ("every_s",)

# The greatest parts of errors of u, v and r, and of their sums, that are made up for in a sample. A controller is some times as
# fast as the vessel, but not slower than a part of these.
PROPORTIONAL, INTEGRAL = np.array([0.3, 0.15, 0.5]), np.array([0.03, 0.03, 0.25])
FASTER, SLOWEST = 3.0, 0.1


@dataclass(frozen=True)
class Motion:
    """Inputs, N × inputs, and states, (N+1) × 3, of the nominal vessel, to either side by `signs` of inputs and `side` of sway and
    yaw. `corrections`, N × inputs × 3: changes of inputs per increment of u, v and r."""

    inputs: np.ndarray
    reference: np.ndarray
    corrections: np.ndarray
    proportional: np.ndarray
    integral: np.ndarray
    signs: np.ndarray
    side: float

    @property
    def longest(self) -> int:
        return len(self.inputs)

    @classmethod
    def of(cls, own: dict[str, Any], signs: np.ndarray, side: float, fleet: Fleet) -> Motion:
        """The motion of a maneuver of a dictionary, of the whole or of its first `piece_s`."""
        vessel = fleet.vessel
        check(own, vessel)
        samples = round(own.get("piece_s", own["duration_s"]) * vessel.rate_hz)
        held = [steady_inputs(vessel, vessel.nominal, *wanted(own, k / vessel.rate_hz)) for k in range(samples)]
        inputs, begin = np.array(held), (own.get("speed_m_s", 0.0), 0.0, 0.0)
        reference = simulate(vessel, vessel.nominal, begin, inputs)
        corrections = np.linalg.inv(fleet.slopes(reference[:-1].T, inputs))
        decay = np.max(decays(vessel, reference[:-1], inputs), axis=0)
        part = np.clip(FASTER * decay / PROPORTIONAL, SLOWEST, 1.0)
        strength = own.get("feedback", {}).get("strength", 1.0)
        gains = strength * part * PROPORTIONAL, strength * part**2 * INTEGRAL
        return cls(inputs, reference, corrections, *gains, signs, side)


def check(own: dict[str, Any], vessel: Vessel) -> None:
    """Refuses what this script does not track."""
    name, feedback = own["name"], own.get("feedback", {})
    if own["kind"] not in KINDS or own.get("shape", "square") != "sine":
        raise SystemExit(f"maneuver {name}: a motion other than a sine of {', '.join(KINDS)}, which this script does not track")
    if len(vessel.inputs) != 3:
        raise SystemExit(f"maneuver {name}: a motion of a vessel with {len(vessel.inputs)} inputs: this script tracks those with 3")
    for key in NOT_FOLLOWED:
        if key in feedback:
            raise SystemExit(f"maneuver {name}: feedback.{key}, which this script does not follow")
    if feedback.get("sensors", "own") != "own":
        raise SystemExit(f"maneuver {name}: feedback.sensors {feedback['sensors']}, expected own")


def wanted(own: dict[str, Any], seconds: float) -> tuple[float, float, float]:
    """u, v, r to be held at a time."""
    swing = math.sin(2.0 * math.pi * seconds / own["period_s"])
    if own["kind"] == "sway-zig-zag":
        return own.get("speed_m_s", 0.0), own["sway_amplitude_m_s"] * swing, 0.0
    return own["speed_m_s"], 0.0, own["yaw_rate_amplitude_rad_s"] * swing


def decays(vessel: Vessel, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """How fast u, v and r of the nominal vessel decay in a sample, N × 3."""
    values = dict(zip("uvr", states.T)) | dict(zip(vessel.inputs, inputs.T))
    found = np.zeros(states.shape)
    for degree, name in enumerate("uvr"):
        for parameter, term in zip(vessel.nominal[degree], vessel.terms[degree]):
            found[:, degree] -= parameter * term.slope(name, values)
    return found
