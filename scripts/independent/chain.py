"""Independent computation of what `simulate logs` makes of forces, for the tests named `oracle_*` of crates/logs.

    python scripts/independent/chain.py --oracle fixtures/oracle

Needs numpy and scipy. It shares no code with the workspace and goes another way where there is one: allocation by numpy's
pseudo-inverse, forces of thrusters as cross products in space, wind as drag along and across the hull in complex numbers,
positions by integrating the interpolated velocities with an adaptive solver. Without noise: random numbers are the
workspace's own.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

RATE = 2.0
# Per sample: X_u, X_uu, X_vr, X_tau, Y_v, Y_ur, Y_tau, N_r, N_uv, N_tau (preset ljungberg-model-ship).
THETA = [-0.06, -0.01, 0.08, 1.4e-5, -0.1, -0.006, 1.4e-5, -0.35, -0.03, 3.0e-4]
PLACES = np.array([[-0.4, -0.15], [-0.4, 0.1], [0.5, 0.02]])
COEFFICIENT, SPEED_LIMIT, SPEED_RATE, ANGLE_RATE = 1.44, 24.0, 12.0, 0.9
HULL = {"frontal_area_m2": 30.0, "lateral_area_m2": 80.0, "length_m": 4.0, "c_x": 0.6, "c_y": 0.9, "c_n": 0.15}
CURRENT = [0.2, -0.1]
WIND = {"speed_m_s": 6.0, "from_rad": 2.2}
HEADING = 0.7
INITIAL = [0.5, 0.1, 0.02]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--oracle", type=Path, required=True)
    arguments = parser.parse_args()
    (arguments.oracle / "chain.json").write_text(json.dumps(recording(), indent=1) + "\n")


def wanted(k: int) -> np.ndarray:
    turn = 150.0 * np.sin(0.4 * k)
    return np.array([3000.0 * np.cos(0.15 * k), -2.0 * turn + 300.0, turn + 40.0])


def allocation(tau: np.ndarray) -> np.ndarray:
    rows = np.zeros((3, 2 * len(PLACES)))
    for i, place in enumerate(PLACES):
        for axis in range(2):
            push = np.eye(3)[axis]
            moment = np.cross([place[0], place[1], 0.0], push)[2]
            rows[:, 2 * i + axis] = [push[0], push[1], moment]
    return (np.linalg.pinv(rows) @ tau).reshape(-1, 2)


def setting(force: np.ndarray, alpha: float) -> tuple[float, float]:
    """Of ahead and reversed the one that turns less."""
    size = np.sqrt(np.hypot(*force) / COEFFICIENT)
    options = []
    for sign in (1.0, -1.0):
        direction = np.angle(sign * complex(force[0], force[1]) * np.exp(-1j * alpha))
        options.append((abs(direction), sign * size, alpha + direction))
    _, n, angle = min(options)
    return n, angle


def wind(state: np.ndarray, psi: float) -> np.ndarray:
    air = -WIND["speed_m_s"] * np.exp(1j * WIND["from_rad"])  # where it blows to, north + i east
    relative = complex(state[0], state[1]) - air * np.exp(-1j * psi)
    pressure = 0.5 * 1.225 * abs(relative) ** 2
    along, across = relative.real / abs(relative), relative.imag / abs(relative)
    return pressure * np.array(
        [
            -HULL["c_x"] * HULL["frontal_area_m2"] * along,
            -HULL["c_y"] * HULL["lateral_area_m2"] * across,
            -HULL["c_n"] * HULL["lateral_area_m2"] * HULL["length_m"] * 2.0 * along * across,
        ]
    )


def recording() -> dict:
    state, pose = np.array(INITIAL), np.array([0.0, 0.0, HEADING])
    settings = None
    out = {"states": [], "poses": [], "settings": [], "forces": []}
    hits = np.zeros((len(PLACES), 3), dtype=int)
    for k in range(40):
        components = allocation(wanted(k))
        near = [0.0] * len(PLACES) if settings is None else [alpha for _, alpha in settings]
        commands = [setting(f, a) for f, a in zip(components, near)]
        nexts = []
        for i, (n, alpha) in enumerate(commands):
            limited = float(np.clip(n, -SPEED_LIMIT, SPEED_LIMIT))
            hits[i, 0] += limited != n
            if settings is not None:
                before, angle = settings[i]
                reach = float(np.clip(limited, before - SPEED_RATE / RATE, before + SPEED_RATE / RATE))
                turned = float(np.clip(alpha, angle - ANGLE_RATE / RATE, angle + ANGLE_RATE / RATE))
                hits[i, 1] += reach != limited
                hits[i, 2] += turned != alpha
                limited, alpha = reach, turned
            nexts.append((limited, alpha))
        settings = nexts
        made = np.zeros(3)
        for place, (n, alpha) in zip(PLACES, settings):
            push = COEFFICIENT * n * abs(n) * np.array([np.cos(alpha), np.sin(alpha), 0.0])
            made += [push[0], push[1], np.cross([place[0], place[1], 0.0], push)[2]]
        out["states"].append(state.tolist())
        out["poses"].append(pose.tolist())
        out["settings"].append([list(s) for s in settings])
        out["forces"].append(made.tolist())
        following = step(state, pose[2], made)
        pose = moved(pose, state, following)
        state = following
    return out | {"hits": hits.tolist()}


def step(state: np.ndarray, psi: float, made: np.ndarray) -> np.ndarray:
    t1, t2, t3 = made + wind(state, psi)
    water = complex(*CURRENT) * np.exp(-1j * psi)
    u, v, r = state[0] - water.real, state[1] - water.imag, state[2]
    xu, xuu, xvr, xt, yv, yur, yt, nr, nuv, nt = THETA
    return state + np.array(
        [
            xu * u + xuu * u * abs(u) + xvr * v * r + xt * t1,
            yv * v + yur * u * r + yt * t2,
            nr * r + nuv * u * v + nt * t3,
        ]
    )


def moved(pose: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    def rate(t: float, p: np.ndarray) -> list[float]:
        u, v, r = start + (end - start) * t * RATE
        body = complex(u, v) * np.exp(1j * p[2])
        return [body.real, body.imag, r]

    return solve_ivp(rate, (0.0, 1.0 / RATE), pose, rtol=1e-12, atol=1e-13).y[:, -1]


if __name__ == "__main__":
    main()
