"""Simulation, and maneuvers turned into inputs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq

from .study import STATES, Study, Vessel

Parameters = tuple[tuple[float, ...], ...]

FAR = 1e6
"""An input [N, N m] so large that its effect stands clear of the rounding of the rest."""


def increments(vessel: Vessel, theta: Parameters, values: dict[str, Any]) -> list[Any]:
    """θᵀφ of surge, sway and yaw at the named values (states relative to the water, inputs)."""
    return [
        sum(parameter * term.value(values) for parameter, term in zip(parameters, terms))
        for parameters, terms in zip(theta, vessel.terms)
    ]


def simulate(
    vessel: Vessel,
    theta: Parameters,
    initial: tuple[float, float, float],
    inputs: np.ndarray,
    current: np.ndarray | None = None,
) -> np.ndarray:
    """States, (N+1) × 3 [m/s, m/s, rad/s], under inputs N × 3 and a current in body axes N × 2 [m/s]."""
    states = [tuple(float(x) for x in initial)]
    for k, row in enumerate(inputs.tolist()):
        u, v, r = states[-1]
        u_c, v_c = current[k].tolist() if current is not None else (0.0, 0.0)
        values = {"u": u - u_c, "v": v - v_c, "r": r} | dict(zip(vessel.inputs, row))
        du, dv, dr = increments(vessel, theta, values)
        states.append((u + du, v + dv, r + dr))
    return np.array(states)


def regressors(vessel: Vessel, states: np.ndarray, inputs: np.ndarray) -> list[np.ndarray]:
    """φ of surge, sway and yaw, N × p each, from states (N+1) × 3 or N × 3 and inputs N × 3."""
    count = len(inputs)
    values = {name: states[:count, i] for i, name in enumerate(STATES)}
    values |= {name: inputs[:, i] for i, name in enumerate(vessel.inputs)}
    return [np.column_stack([term.value(values) for term in terms]) for terms in vessel.terms]


def poses(states: np.ndarray, rate_hz: float) -> np.ndarray:
    """x, y [m] and psi [rad] at every state, (N+1) × 3: explicit Euler from the origin, heading along x."""
    u, v, r = states[:-1].T / rate_hz
    start = np.zeros(1)
    psi = np.concatenate([start, np.cumsum(r)])
    cos, sin = np.cos(psi[:-1]), np.sin(psi[:-1])
    x = np.concatenate([start, np.cumsum(u * cos - v * sin)])
    y = np.concatenate([start, np.cumsum(u * sin + v * cos)])
    return np.column_stack([x, y, psi])


def steady_inputs(vessel: Vessel, theta: Parameters, u: float, v: float | None, r: float) -> list[float]:
    """Inputs that hold u, v, r steady; without v, those that also keep the coupling between the inputs.

    The increments are affine in the inputs: their offset and slopes follow from evaluations at zero and at a large input.
    A free sway speed is the root of the coupling's residual.
    """

    def holding(sway: float) -> np.ndarray:
        at = {"u": u, "v": sway, "r": r}
        zero = dict.fromkeys(vessel.inputs, 0.0)
        offset = np.array(increments(vessel, theta, at | zero))
        steps = [np.array(increments(vessel, theta, at | zero | {name: FAR})) - offset for name in vessel.inputs]
        return np.linalg.solve(np.column_stack(steps), -offset) * FAR

    if v is not None:
        return holding(v).tolist()
    [(follower, (leader, factor))] = vessel.follows.items()
    i, j = vessel.inputs.index(follower), vessel.inputs.index(leader)

    def residual(sway: float) -> float:
        inputs = holding(sway)
        return float(inputs[i] - factor * inputs[j])

    sway = brentq(residual, -10.0, 10.0, xtol=1e-300, rtol=4 * np.finfo(float).eps, maxiter=1000)
    return holding(sway).tolist()


def wanted(
    maneuver: dict[str, Any], k: int, samples: int, rate_hz: float
) -> tuple[float, float | None, float]:
    """The commanded u, v (or nothing) and r at sample k of `samples`."""
    match maneuver["kind"]:
        case "accelerate" | "decelerate":
            return maneuver["to_m_s"], 0.0, 0.0
        case "zig-zag" if maneuver["shape"] == "sine":
            swing = math.sin(2.0 * math.pi * k / (maneuver["period_s"] * rate_hz))
            return maneuver["speed_m_s"], None, maneuver["yaw_rate_amplitude_rad_s"] * swing
        case "spiral":
            start, end = maneuver["yaw_rate_from_rad_s"], maneuver["yaw_rate_to_rad_s"]
            return maneuver["speed_m_s"], maneuver["sway_speed_m_s"], start + (end - start) * (k + 0.5) / samples
    raise ValueError(f"maneuver {maneuver['name']}: a kind that this script does not know")


def realize(study: Study, index: int, samples: int) -> tuple[tuple[float, float, float], np.ndarray]:
    """Start state and inputs, samples × 3, of maneuver `index`."""
    maneuver = study.maneuvers[index]
    theta = study.vessel.value if study.inputs_from == "value" else study.vessel.nominal
    speed = maneuver["from_m_s"] if "from_m_s" in maneuver else maneuver["speed_m_s"]
    motions = [wanted(maneuver, k, samples, study.vessel.rate_hz) for k in range(samples)]
    held = {motion: steady_inputs(study.vessel, theta, *motion) for motion in dict.fromkeys(motions)}
    return (speed, 0.0, 0.0), np.array([held[motion] for motion in motions])
