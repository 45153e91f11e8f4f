"""The cost of force models on windows of recordings, and its minimum, for crates/estimation/tests/all/fitting/oracle.rs.

    python scripts/independent/force_fit.py --out fixtures/oracle/force_fit.json

A small ship of terms alone, integrated by steps of order 4 with inputs linear between samples. The cost is the mean over windows
of Huber's function of the window's RMS error in standard deviations, with what priors add. Its minimum is found by scipy.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from scipy.optimize import minimize  # noqa: E402

from independent.text import pretty  # noqa: E402

RHO, LENGTH, DRAUGHT, SPEED = 1000.0, 4.0, 0.25, 1.0
MASS, X_G, GYRATION = 520.0, 0.1, 1.0
ADDED = (0.03, 0.2, 0.012)
SAMPLE_S, WINDOW, KNEE, WEIGHT = 0.5, 40, 0.2, 2.0
NAMES = ["X_uu", "Y_v", "Y_r", "N_v", "N_r", "N_d"]
TRUTH = np.array([-0.03, -0.35, 0.06, -0.11, -0.06, 0.02])
MEANS = np.array([-0.025, -0.3, 0.08, -0.13, -0.05, 0.018])
DEVIATIONS = np.array([0.02, 0.3, 0.1, 0.1, 0.05, 0.01])
VESSEL = f"""density_kg_m3 = {RHO}
surge = [
  {{ parameter = "X_uu", term = "u |u|", prime = {MEANS[0]}, prior = {DEVIATIONS[0]} }},
  {{ parameter = "X_n", term = "n |n|", nominal = 0.15, fixed = true }},
]
sway = [
  {{ parameter = "Y_v", term = "v U", prime = {MEANS[1]}, prior = {DEVIATIONS[1]} }},
  {{ parameter = "Y_r", term = "r U", prime = {MEANS[2]}, prior = {DEVIATIONS[2]} }},
  {{ parameter = "Y_d", term = "u^2 delta", prime = -0.04, fixed = true }},
]
yaw = [
  {{ parameter = "N_v", term = "v U", prime = {MEANS[3]}, prior = {DEVIATIONS[3]} }},
  {{ parameter = "N_r", term = "r U", prime = {MEANS[4]}, prior = {DEVIATIONS[4]} }},
  {{ parameter = "N_d", term = "u^2 delta", prime = {MEANS[5]}, prior = {DEVIATIONS[5]} }},
]
[[input]]
name = "delta"
unit = "rad"
[[input]]
name = "n"
unit = "1/s"
[ship]
length_m = {LENGTH}
draught_m = {DRAUGHT}
speed_m_s = {SPEED}
mass_kg = {MASS}
x_g_m = {X_G}
gyration_m = {GYRATION}
added_mass = {{ surge = {ADDED[0]}, sway = {ADDED[1]}, yaw = {ADDED[2]} }}
"""


def rates(theta: np.ndarray, x: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    u, v, r = x
    delta, n = inputs
    x_uu, y_v, y_r, n_v, n_r, n_d = theta
    q = 0.5 * RHO * LENGTH * DRAUGHT
    speed = np.hypot(u, v)
    m_x, m_y, j_z = (own * q * LENGTH for own in ADDED)
    j_z *= LENGTH**2
    i_z = MASS * (GYRATION**2 + X_G**2)
    force_x = q * x_uu * u * abs(u) + 0.15 * n * abs(n)
    force_y = q * (y_v * v * speed + y_r * LENGTH * r * speed - 0.04 * u**2 * delta)
    moment = q * LENGTH * (n_v * v * speed + n_r * LENGTH * r * speed + n_d * u**2 * delta)
    du = (force_x + (MASS + m_y) * v * r + X_G * MASS * r**2) / (MASS + m_x)
    right = np.array([force_y - (MASS + m_x) * u * r, moment - X_G * MASS * u * r])
    left = np.array([[MASS + m_y, X_G * MASS], [X_G * MASS, i_z + j_z]])
    return np.array([du, *np.linalg.solve(left, right)])


def followed(theta: np.ndarray, start: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """States after each row of inputs but the last."""
    states, h = [np.asarray(start, float)], SAMPLE_S
    for begin, end in zip(inputs[:-1], inputs[1:], strict=True):
        x, middle = states[-1], 0.5 * (begin + end)
        a = rates(theta, x, begin)
        b = rates(theta, x + h / 2 * a, middle)
        c = rates(theta, x + h / 2 * b, middle)
        d = rates(theta, x + h * c, end)
        states.append(x + h / 6 * (a + 2 * b + 2 * c + d))
    return np.array(states)


def recordings() -> list[tuple[np.ndarray, np.ndarray]]:
    draw, found = np.random.default_rng(3), []
    for angle, count in [(0.2, 80), (0.4, 80), (0.3, 50)]:
        k = np.arange(count)
        inputs = np.column_stack([angle * np.sign(np.sin(0.16 * k)), 11 + 2 * np.sin(0.07 * k)])
        states = followed(TRUTH, [1.0, 0, 0], np.vstack([inputs, inputs[-1:]]))
        states += draw.normal(0, [0.004, 0.002, 0.002], states.shape)
        found.append((inputs, states))
    # A recording that the model cannot follow: its windows are beyond the knee.
    found[1][1][45:, 2] += 0.05
    return found


def cost(theta: np.ndarray, all_: list[tuple[np.ndarray, np.ndarray]]) -> float:
    deviations = np.std(np.vstack([states[1:] for _, states in all_]), axis=0)
    samples, total = sum(len(inputs) for inputs, _ in all_), 0.0
    for inputs, states in all_:
        count = -(-len(inputs) // WINDOW)
        ends = [i * len(inputs) // count for i in range(count + 1)]
        for first, end in zip(ends[:-1], ends[1:], strict=True):
            rows = inputs[np.minimum(np.arange(first, end + 1), len(inputs) - 1)]
            left = (followed(theta, states[first], rows) - states[first : end + 1])[1:] / deviations
            rms = np.sqrt(np.mean(left**2))
            rho = rms**2 if rms <= KNEE else 2 * KNEE * rms - KNEE**2
            total += rho * (end - first) / samples
    numbers = 3 * samples * SAMPLE_S
    return float(total + WEIGHT / (0.5 * numbers) * np.sum(((theta - MEANS) / DEVIATIONS) ** 2))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    out, own = parser.parse_args().out, recordings()
    points = [TRUTH, MEANS, 1.2 * MEANS]
    scaled = minimize(
        lambda z: 1e3 * cost(MEANS + DEVIATIONS * z, own), np.zeros(len(MEANS)), method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 20000, "maxfev": 20000, "adaptive": True},
    )
    theta = MEANS + DEVIATIONS * scaled.x
    found = {
        "vessel": VESSEL,
        "settings": {"sample_s": SAMPLE_S, "window_s": WINDOW * SAMPLE_S, "knee": KNEE, "prior_weight": WEIGHT},
        "recordings": [{"inputs": i.ravel().tolist(), "measured": s.ravel().tolist()} for i, s in own],
        "costs": [{"theta": list(map(float, point)), "cost": cost(point, own)} for point in points],
        "minimum": {"theta": list(map(float, theta)), "cost": cost(theta, own)},
    }
    out.write_text(pretty(found) + "\n")


if __name__ == "__main__":
    main()
