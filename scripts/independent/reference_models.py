"""Three published ships, each as its changes per second of u, v and r: Mariner, KVLCC2 L7 and Otter.

Each has its own kind of model: polynomials of the nondimensional motion; hull, propeller and rudder apart; linear damping
with cross-flow drag. Positive rudder turns to starboard. The origin is amidships.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Rates = Callable[[float, float, float, list[float]], list[float]]


@dataclass(frozen=True)
class Ship:
    """A ship on her approach, and what her rudder or her propellers do after an order."""

    name: str
    length_m: float
    inputs: list[str]
    # Changes per second of u, v, r by u, v, r and inputs.
    rates: Rates
    # u, v and inputs before the first order.
    approach: list[float]
    held: list[float]
    # Inputs that helm to starboard moves, by one unit of helm.
    helm: list[float]
    # What an input needs to follow an order.
    lag_s: float
    rate_per_s: float

    @property
    def speed_m_s(self) -> float:
        return math.hypot(*self.approach)


# Mariner: Chislett and Strøm-Tejsen (1965), coefficients times 1e5 in the prime system, speed changes over the whole speed.
# Their rudder is positive to port.
MARINER_LENGTH, MARINER_SPEED = 160.93, 7.7175
MARINER_X = {
    "u": -184, "uu": -110, "uuu": -215, "vv": -899, "rr": 18, "rv": 798, "dd": -95, "udd": -190, "vd": 93,
    "uvd": 93,
}
MARINER_Y = {
    "v": -1160, "r": -499, "vvv": -8078, "vvr": 15356, "uv": -1160, "ur": -499, "d": 278, "ddd": -90,
    "ud": 556, "uud": 278, "vdd": -4, "vvd": 1190, "": -4, "u": -8, "uu": -4,
}
MARINER_N = {
    "v": -264, "r": -166, "vvv": 1636, "vvr": -5483, "uv": -264, "ur": -166, "d": -139, "ddd": 45, "ud": -278,
    "uud": -139, "vdd": 13, "vvd": -489, "": 3, "u": 6, "uu": 3,
}
MARINER_MASS = np.array([[798 + 42, 0, 0], [0, 798 + 748, -0.023 * 798 + 9.354], [0, -0.023 * 798 - 4.646, 39.2 + 43.8]])


def polynomial(coefficients: dict[str, float], values: dict[str, float]) -> float:
    return sum(factor * math.prod(values[letter] for letter in term) for term, factor in coefficients.items())


def mariner_rates(u: float, v: float, r: float, inputs: list[float]) -> list[float]:
    speed, length = math.hypot(u, v), MARINER_LENGTH
    values = {"u": (u - MARINER_SPEED) / speed, "v": v / speed, "r": r * length / speed, "d": -inputs[0]}
    forces = [polynomial(own, values) for own in (MARINER_X, MARINER_Y, MARINER_N)]
    change = np.linalg.solve(MARINER_MASS, forces)
    return (change * [speed**2 / length, speed**2 / length, (speed / length) ** 2]).tolist()


def mariner() -> Ship:
    """With her rudder amidships, where constant forces of the propeller begin to turn her."""
    return Ship(
        name="Mariner",
        length_m=MARINER_LENGTH,
        inputs=["delta"],
        rates=mariner_rates,
        approach=[MARINER_SPEED, 0.0],
        held=[0.0],
        helm=[1.0],
        lag_s=1.0,
        rate_per_s=math.radians(5),
    )


# KVLCC2, the model of 7 m: Yasukawa and Yoshimura (2015). Forces over ρ, which cancels.
L, DRAUGHT, VOLUME, X_G = 7.00, 0.46, 3.27, 0.25
D_P, H_R, A_R = 0.216, 0.345, 0.0539
M_X, M_Y, J_Z = (0.5 * L**2 * DRAUGHT * factor for factor in (0.022, 0.223, 0.011 * L**2))
I_Z = VOLUME * (0.25 * L) ** 2
T_P, W_P0, X_P, K_T = 0.220, 0.40, -0.48, (0.2931, -0.2753, -0.1385)
T_R, A_H, X_H, X_R, L_R = 0.387, 0.312, -0.464, -0.5, -0.710
EPSILON, KAPPA, LIFT_SLOPE = 1.09, 0.50, 2.747
KVLCC2_MASS = np.array(
    [[VOLUME + M_X, 0, 0], [0, VOLUME + M_Y, X_G * VOLUME], [0, X_G * VOLUME, I_Z + X_G**2 * VOLUME + J_Z]]
)


def kvlcc2_hull(v: float, r: float) -> np.ndarray:
    """Nondimensional force ahead, to starboard and moment."""
    return np.array(
        [
            -0.022 - 0.040 * v**2 + 0.002 * v * r + 0.011 * r**2 + 0.771 * v**4,
            -0.315 * v + 0.083 * r - 1.607 * v**3 + 0.379 * v**2 * r - 0.391 * v * r**2 + 0.008 * r**3,
            -0.137 * v - 0.049 * r - 0.030 * v**3 - 0.294 * v**2 * r + 0.055 * v * r**2 - 0.013 * r**3,
        ]
    )


def kvlcc2_wake(drift: float, r: float) -> float:
    """1 − w_P by the drift at the propeller, which differs between port and starboard."""
    at_propeller = drift - X_P * r
    most = 1.6 if at_propeller > 0.0 else 1.1
    return (1.0 - W_P0) * (1.0 + (1.0 - math.exp(-2.0 * abs(at_propeller))) * (most - 1.0))


def kvlcc2_rates(u: float, v: float, r: float, inputs: list[float]) -> list[float]:
    rudder, n = inputs
    speed, drift = math.hypot(u, v), math.atan2(-v, u)
    v_prime, r_prime = v / speed, r * L / speed
    inflow = u * kvlcc2_wake(drift, r_prime)
    advance = inflow / (n * D_P)
    thrust_factor = K_T[0] + K_T[1] * advance + K_T[2] * advance**2
    thrust = n**2 * D_P**4 * thrust_factor

    share = D_P / H_R
    jet = 1.0 + KAPPA * (math.sqrt(1.0 + 8.0 * thrust_factor / (math.pi * advance**2)) - 1.0)
    u_rudder = EPSILON * inflow * math.sqrt(share * jet**2 + 1.0 - share)
    at_rudder = drift - L_R * r_prime
    v_rudder = speed * (0.640 if at_rudder > 0.0 else 0.395) * at_rudder
    angle = rudder - math.atan2(v_rudder, u_rudder)
    normal = 0.5 * A_R * (u_rudder**2 + v_rudder**2) * LIFT_SLOPE * math.sin(angle)

    forces = 0.5 * L * DRAUGHT * speed**2 * kvlcc2_hull(v_prime, r_prime) * [1.0, 1.0, L]
    forces += [
        (1.0 - T_P) * thrust - (1.0 - T_R) * normal * math.sin(rudder),
        -(1.0 + A_H) * normal * math.cos(rudder),
        -(X_R + A_H * X_H) * L * normal * math.cos(rudder),
    ]
    turning = [
        (VOLUME + M_Y) * v * r + X_G * VOLUME * r**2,
        -(VOLUME + M_X) * u * r,
        -X_G * VOLUME * u * r,
    ]
    return np.linalg.solve(KVLCC2_MASS, forces + turning).tolist()


def kvlcc2(n: float) -> Ship:
    """At `n` revolutions per second. Only 11.85 hold the speed of the approach."""
    return Ship(
        name=f"KVLCC2 L7, n = {n}",
        length_m=L,
        inputs=["delta", "n"],
        rates=kvlcc2_rates,
        approach=[1.179, 0.0],
        held=[0.0, n],
        helm=[1.0, 0.0],
        lag_s=0.0,
        rate_per_s=math.radians(15.8),
    )


# Otter: Fossen, in the plane, with 25 kg of payload, the Munk moment and the damping of 2024.
HULL_KG, PAYLOAD_KG = 55.0, 25.0
TOTAL_KG = HULL_KG + PAYLOAD_KG
X_HULL, X_PAYLOAD, GYRATION = 0.2, 0.05, 0.5
X_TOTAL = (HULL_KG * X_HULL + PAYLOAD_KG * X_PAYLOAD) / TOTAL_KG
# About the common centre of gravity, as the source has it since April 2026: before, both arms counted from the origin.
I_TOTAL = HULL_KG * (GYRATION**2 + (X_HULL - X_TOTAL) ** 2) + PAYLOAD_KG * (X_PAYLOAD - X_TOTAL) ** 2
ADDED_X, ADDED_Y, ADDED_N = 2.7 * 1025 * (HULL_KG / 1025) ** (5 / 3) / 2.0**2, 1.5 * HULL_KG, 1.7 * I_TOTAL
COUPLED = TOTAL_KG * X_TOTAL
OTTER_MASS = np.array(
    [
        [TOTAL_KG + ADDED_X, 0, 0],
        [0, TOTAL_KG + ADDED_Y, COUPLED],
        [0, COUPLED, I_TOTAL + TOTAL_KG * X_TOTAL**2 + ADDED_N],
    ]
)
# Linear damping: by the greatest speed, 6 knots, and by time constants of a second.
DAMPING = np.array([24.4 * 9.81 / (6 * 0.5144), OTTER_MASS[1, 1], OTTER_MASS[2, 2]])
AHEAD, ASTERN, ARM = 0.02216 / 2, 0.01289 / 2, 0.395
STRIPS, STRIP_M, DRAG = np.linspace(-1.0, 1.0, 21), 0.1, 1.004
STRIP_DRAUGHT = TOTAL_KG / 1025 / (2 * 0.4 * 0.25 * 2.0)
MOST_ASTERN = -math.sqrt(0.5 * 13.6 * 9.81 / ASTERN)


def otter_rates(u: float, v: float, r: float, inputs: list[float]) -> list[float]:
    left, right = ((AHEAD if n > 0.0 else ASTERN) * n * abs(n) for n in inputs)
    across = v + STRIPS * r
    drag = 0.5 * 1025 * STRIP_DRAUGHT * DRAG * STRIP_M * across * np.abs(across)
    forces = [
        left + right - DAMPING[0] * u,
        -DAMPING[1] * v - np.sum(drag),
        ARM * (left - right) - DAMPING[2] * (1.0 + 10.0 * abs(r)) * r - np.sum(STRIPS * drag),
    ]
    turning = [
        OTTER_MASS[1, 1] * v * r + COUPLED * r**2,
        -OTTER_MASS[0, 0] * u * r,
        -(ADDED_Y - ADDED_X) * u * v - COUPLED * u * r,
    ]
    return np.linalg.solve(OTTER_MASS, np.add(forces, turning)).tolist()


def otter(lag_s: float = 0.1) -> Ship:
    speed = 2.0
    n = math.sqrt(DAMPING[0] * speed / (2.0 * AHEAD))
    return Ship(
        name="Otter",
        length_m=2.0,
        inputs=["n1", "n2"],
        rates=otter_rates,
        approach=[speed, 0.0],
        held=[n, n],
        helm=[1.0, -1.0],
        lag_s=lag_s,
        rate_per_s=math.inf,
    )
