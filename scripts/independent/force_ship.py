"""A ship with forces as `vessel.toml` describes her: her changes of u, v and r in a sample. Ships are lanes of numpy's arrays.

Terms of the hull, thrusters, propellers ahead, rudders and cross-flow are known; other parts are refused. Formulas are those of the
MMG standard method, and of docs/forces.md.
"""

from __future__ import annotations

import itertools
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .study import Actuator

# Parts of a file that change how a ship moves, and that this program does not compute.
UNKNOWN = ("wind", "measured", "derived")
LEAST_SQUARE = 1e-18
Numbers = dict[str, Any]


@dataclass(frozen=True)
class Number:
    """A free number: its name, nominal value and standard deviation as written, and its bounds."""

    name: str
    nominal: float
    prior: float | None
    bounds: tuple[float, float]


class ForceShip:
    """A ship, with the attributes of `study.Vessel` that a fleet needs."""

    def __init__(self, folder: Path) -> None:
        file = folder / "vessel.toml"
        self.file = table = tomllib.loads(file.read_text())
        for key in UNKNOWN:
            if table.get(key):
                raise SystemExit(f"{file}: `{key}`, which this script does not simulate")
        self.rate_hz, self.ship = table["sample_rate_hz"], table["ship"]
        self.inputs = tuple(own["name"] for own in table["input"])
        self.follows = {own["name"]: own["follows"] for own in table["input"] if "follows" in own}
        self.actuators = tuple(
            Actuator(tuple(own["range"]) if "range" in own else None, own.get("lag_s", 0.0), own.get("rate_per_s"))
            for own in table["input"]
        )
        units = {own["name"]: own["unit"] for own in table["input"]}
        for part, unit in (("propeller", "1/s"), ("rudder", "rad")):
            for own in table.get(part, []):
                if units[own["input"]] != unit:
                    raise SystemExit(f"{file}: {part} {own['name']}: its input in {units[own['input']]}, expected {unit}")
        self.free: list[Number] = []
        self.density = table["density_kg_m3"]
        self.length, self.draught = self.ship["length_m"], self.ship["draught_m"]
        width = self.length if self.ship.get("area") == "LL" else self.draught
        self.force = 0.5 * self.density * self.length * width
        self.parts = self.read()
        self.names = (tuple(own.name for own in self.free),)
        self.nominal = (tuple(own.nominal for own in self.free),)

    def read(self) -> dict[str, Any]:
        """Every number of the file as a plain one in SI units, or as a free one's place and scale."""
        table, length = self.file, self.length
        terms = [[self.term(own, degree) for own in table.get(name, [])] for degree, name in enumerate(("surge", "sway", "yaw"))]
        mass = self.force * length
        ship = {
            "mass": self.number("ship", "mass_kg", self.ship, mass),
            "x_g": self.number("ship", "x_g_m", self.ship, length, 0.0),
            "gyration": self.number("ship", "gyration_m", self.ship, length, 0.0),
            "inertia": self.number("ship", "inertia_kg_m2", self.ship, mass * length**2, 0.0),
        }
        powers = {"surge": 0, "sway": 0, "yaw": 2, "sway_yaw": 1, "yaw_sway": 1}
        for key, power in powers.items():
            # Plain numbers are in the prime system here.
            ship[key] = self.number("ship.added_mass", key, self.ship["added_mass"], mass * length**power, 0.0, plain_prime=True)
        return {
            "terms": terms,
            "ship": ship,
            "propellers": {own["name"]: (own, self.propeller(own)) for own in table.get("propeller", [])},
            "rudders": [(own, self.rudder(own)) for own in table.get("rudder", [])],
            "thrusters": [(own, self.thruster(own)) for own in table.get("thruster", [])],
            "crossflows": [(own, self.crossflow(own)) for own in table.get("crossflow", [])],
        }

    def number(
        self, part: str, key: str, table: dict[str, Any], prime: float, default: float | None = None, plain_prime: bool = False
    ) -> Any:
        written = table.get(key, default)
        return self.one(f"{part}.{key}", written, prime, plain_prime)

    def one(self, name: str, written: Any, prime: float, plain_prime: bool = False) -> Any:
        """A function of the numbers of θ: the value in SI units."""
        if not isinstance(written, dict):
            value = float(written) * (prime if plain_prime else 1.0)
            return lambda _: value
        if "tied_to" in written:
            raise SystemExit(f"{name}: `tied_to`, which this script does not read")
        scale = prime if "prime" in written else 1.0
        nominal = written.get("prime", written.get("nominal"))
        if written.get("fixed"):
            return lambda _: nominal * scale
        name = written.get("parameter", name)
        low, high = written.get("bounds", (-math.inf, math.inf))
        self.free.append(Number(name, nominal, written.get("prior"), (low, high)))
        return lambda theta: theta[name] * scale

    def term(self, written: dict[str, Any], degree: int) -> Any:
        factors = parsed(written["term"])
        speeds = sum(power for name, _, power in factors if name not in self.inputs)
        rates = sum(power for name, _, power in factors if name == "r")
        arm = self.length if degree == 2 else 1.0
        # Of the second power of the speed; others are scaled by that of the approach.
        prime = self.force * arm * self.length**rates * self.ship["speed_m_s"] ** (2 - speeds)
        return factors, self.one(written["parameter"], written, prime)

    def propeller(self, own: dict[str, Any]) -> dict[str, Any]:
        if "astern" in own:
            raise SystemExit(f"propeller {own['name']}: `astern`, which this script does not compute")
        name = own["name"]
        found = {f"k{i}": self.one(f"{name}.thrust.{i}", value, 1.0) for i, value in enumerate(own["thrust"])}
        for key in ("deduction", "wake", "wake_change"):
            found[key] = self.number(name, key, own, 1.0, 0.0)
        for i, value in enumerate(own.get("wake_ratio", (1.0, 1.0))):
            found[f"ratio{i}"] = self.one(f"{name}.wake_ratio.{i}", value, 1.0)
        for key in ("diameter_m", "x_m", "y_m"):
            found[key] = self.number(name, key, own, self.length, 0.0)
        return found

    def rudder(self, own: dict[str, Any]) -> dict[str, Any]:
        name, length = own["name"], self.length
        found = {"area": self.number(name, "area_m2", own, length * self.draught)}
        defaults = {"epsilon": 1.0, "kappa": 0.0, "ell": -0.5, "deduction": 0.0, "interaction": 0.0, "reversed_flow": 0.0}
        for key, value in {"lift_slope": None, **defaults}.items():
            found[key] = self.number(name, key, own, 1.0, value)
        for i, value in enumerate(own.get("gamma", (1.0, 1.0))):
            found[f"gamma{i}"] = self.one(f"{name}.gamma.{i}", value, 1.0)
        for key, value in {"height_m": 1.0, "interaction_x_m": 0.0, "x_m": None, "y_m": 0.0}.items():
            found[key] = self.number(name, key, own, length, value)
        return found

    def thruster(self, own: dict[str, Any]) -> dict[str, Any]:
        if own.get("curve", "square") != "square" or "angle" in own or "loss" in own:
            raise SystemExit(f"thruster {own['name']}: expected a square law at a fixed angle without loss")
        found = {key: self.number(own["name"], key, own, self.length, 0.0) for key in ("x_m", "y_m")}
        found |= {key: self.number(own["name"], key, own, 1.0, own["ahead"]) for key in ("ahead", "astern")}
        found["angle"] = self.number(own["name"], "angle_deg", own, 1.0, 0.0)
        return found

    def crossflow(self, own: dict[str, Any]) -> dict[str, Any]:
        draught = self.number(own["name"], "draught_m", own, self.draught)
        return {"draught": draught, "drag": self.number(own["name"], "drag", own, 1.0)}

    def rates(self, theta: Numbers, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Changes per second of u, v, r, where u and v are through the water; `inputs` lanes × inputs."""
        u, v, r = state
        channel = dict(zip(self.inputs, inputs.T))
        speed = np.sqrt(u * u + v * v + LEAST_SQUARE)
        approach = self.ship["speed_m_s"]
        motion = {"u": u, "v": v, "r": r, "U": speed, "U_s": speed * u / np.sqrt(u * u + (0.05 * approach) ** 2), "du": u - approach}
        forces = [np.zeros_like(u) for _ in range(3)]
        for degree, terms in enumerate(self.parts["terms"]):
            for factors, number in terms:
                product = np.ones_like(u) * number(theta)
                for name, modulus, power in factors:
                    own = motion.get(name, channel.get(name))
                    product = product * (np.abs(own) if modulus else own) ** power
                forces[degree] = forces[degree] + product
        washes = {}
        for name, (own, numbers) in self.parts["propellers"].items():
            force, washes[name] = self.push(theta, numbers, (u, v, r, speed), channel[own["input"]])
            forces = [a + b for a, b in zip(forces, force)]
        for own, numbers in self.parts["rudders"]:
            wash = washes.get(own.get("behind"))
            angle = own.get("inflow", "velocity") == "angle"
            force = self.steer(theta, numbers, (u, v, r, speed), channel[own["input"]], wash, angle)
            forces = [a + b for a, b in zip(forces, force)]
        for own, numbers in self.parts["thrusters"]:
            n = channel[own["input"]]
            size = np.where(n > 0.0, numbers["ahead"](theta), numbers["astern"](theta)) * n * np.abs(n)
            angle = np.radians(numbers["angle"](theta))
            x, y = size * np.cos(angle), size * np.sin(angle)
            forces = [forces[0] + x, forces[1] + y, forces[2] + numbers["x_m"](theta) * y - numbers["y_m"](theta) * x]
        for own, numbers in self.parts["crossflows"]:
            strips = own.get("strips", 21)
            width, factor = self.length / (strips - 1), 0.5 * self.density * numbers["draught"](theta) * numbers["drag"](theta)
            for x in np.linspace(-0.5, 0.5, strips) * self.length:
                drag = factor * width * (v + x * r) * np.abs(v + x * r)
                forces = [forces[0], forces[1] - drag, forces[2] - x * drag]
        return self.accelerated(theta, (u, v, r), forces)

    def push(self, theta: Numbers, own: dict[str, Any], motion: tuple[np.ndarray, ...], n: np.ndarray) -> tuple[list[Any], Any]:
        """Forces of a propeller, and its inflow, jet and diameter."""
        u, v, r, speed = motion
        drift = np.arctan2(-v, np.abs(u)) - own["x_m"](theta) * r / speed
        ratio = np.where(drift > 0.0, own["ratio0"](theta), own["ratio1"](theta))
        share = 1.0 - np.exp(-own["wake_change"](theta) * np.abs(drift))
        inflow = (1.0 - own["wake"](theta)) * (1.0 + share * (ratio - 1.0)) * u
        diameter = own["diameter_m"](theta)
        tip = np.maximum(n, 0.0) * diameter
        thrust = own["k0"](theta) * tip**2 + own["k1"](theta) * tip * inflow + own["k2"](theta) * inflow**2
        jet = np.sqrt(inflow**2 + 8.0 / math.pi * thrust)
        ahead = (1.0 - own["deduction"](theta)) * self.density * diameter**2 * thrust
        return [ahead, 0.0, -own["y_m"](theta) * ahead], (inflow, jet, diameter)

    def steer(
        self, theta: Numbers, own: dict[str, Any], motion: tuple[np.ndarray, ...], angle: np.ndarray, wash: Any, by_angle: bool
    ) -> list[Any]:
        """Forces of a rudder."""
        u, v, r, speed = motion
        if wash is None:
            along = own["epsilon"](theta) * u
        else:
            inflow, jet, diameter = wash
            stream = inflow + own["kappa"](theta) * (jet - inflow)
            share = diameter / own["height_m"](theta)
            square = share * stream * np.abs(stream) + (1.0 - share) * inflow * np.abs(inflow)
            along = own["epsilon"](theta) * np.sign(square) * np.sqrt(np.abs(square))
        drift = speed * np.arctan2(-v, u) if by_angle else -v
        across = drift - own["ell"](theta) * r * self.length
        across = across * np.where(across > 0.0, own["gamma0"](theta), own["gamma1"](theta))
        sign = np.where(along < 0.0, -1.0, 1.0)
        flow = np.arctan2(across, np.abs(along))
        size = 0.5 * self.density * own["area"](theta) * (along**2 + across**2) * own["lift_slope"](theta)
        normal = sign * size * np.sin(angle - sign * flow)
        ahead = -(1.0 - own["deduction"](theta)) * normal * np.sin(angle)
        starboard, more = normal * np.cos(angle), own["interaction"](theta)
        arm = own["x_m"](theta) + more * own["interaction_x_m"](theta)
        return [ahead, -(1.0 + more) * starboard, -own["y_m"](theta) * ahead - arm * starboard]

    def accelerated(self, theta: Numbers, motion: tuple[np.ndarray, ...], forces: list[Any]) -> np.ndarray:
        (u, v, r), own = motion, {key: number(theta) for key, number in self.parts["ship"].items()}
        mass, x_g = own["mass"], own["x_g"]
        inertia = own["inertia"] if "inertia_kg_m2" in self.ship else mass * (own["gyration"] ** 2 + x_g**2)
        surge, sway, first = mass + own["surge"], mass + own["sway"], mass * x_g
        coriolis, both = self.ship.get("coriolis", "without-munk"), 0.5 * (own["sway_yaw"] + own["yaw_sway"])
        x, y, n = forces
        if coriolis != "none":
            x, y, n = x + sway * v * r + first * r**2, y - surge * u * r, n - first * u * r
        if coriolis == "full":
            x, n = x + both * r**2, n - (sway - surge) * u * v - both * u * r
        a, b, c, d = sway, first + own["sway_yaw"], first + own["yaw_sway"], inertia + own["yaw"]
        return np.array([x / surge, (d * y - b * n) / (a * d - b * c), (a * n - c * y) / (a * d - b * c)])

    def mirror(self) -> np.ndarray:
        """Signs of inputs by which the nominal ship's surge is the same to the other side, and sway and yaw are opposite."""
        random, theta = np.random.default_rng(1), {own.name: own.nominal for own in self.free}
        state, inputs = random.uniform(0.1, 1.0, (3, 20)), random.uniform(0.1, 1.0, (20, len(self.inputs)))
        side = np.array([[1.0], [-1.0], [-1.0]])
        own = self.rates(theta, state, inputs)
        for signs in itertools.product((1.0, -1.0), repeat=len(self.inputs)):
            if np.allclose(self.rates(theta, side * state, inputs * signs), side * own, rtol=1e-9, atol=0.0):
                return np.array(signs)
        raise SystemExit("a mirrored maneuver of a ship that is not symmetric")

    def increments(self, theta: Numbers, state: np.ndarray, inputs: np.ndarray, seconds: float) -> np.ndarray:
        """Changes of u, v, r through the water in `seconds` with held inputs, by a classical step of Runge and Kutta."""
        count = max(math.ceil(seconds / self.file["step_s"] - 1e-9), 1) if "step_s" in self.file else 1
        h, now = seconds / count, state
        for _ in range(count):
            one = self.rates(theta, now, inputs)
            two = self.rates(theta, now + 0.5 * h * one, inputs)
            three = self.rates(theta, now + 0.5 * h * two, inputs)
            four = self.rates(theta, now + h * three, inputs)
            now = now + h / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        return now - state


def parsed(text: str) -> list[tuple[str, bool, int]]:
    """The factors of a term: name, whether the modulus is meant, power."""
    factors, sign = [], 1
    for word in text.replace("/", " / ").split():
        if word == "/":
            sign = -1
            continue
        word, _, power = word.partition("^")
        if word != "1":
            factors.append((word.strip("|"), word.startswith("|"), sign * int(power or 1)))
        sign = 1
    return factors
