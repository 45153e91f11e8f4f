"""A study folder as written: the vessel's model structure, its dictionary of maneuvers, its disturbances."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

DEGREES = ("surge", "sway", "yaw")
STATES = ("u", "v", "r")


@dataclass(frozen=True)
class Term:
    """A product of variables and moduli: pairs (name, whether the modulus is meant)."""

    factors: tuple[tuple[str, bool], ...]

    @classmethod
    def parse(cls, text: str) -> Term:
        """Reads `u |u|`: factors side by side, bars for the modulus."""
        words = text.split()
        return cls(tuple((word.strip("|"), word.startswith("|")) for word in words))

    def value(self, values: dict[str, Any]) -> Any:
        """The product; `values` holds numbers or arrays by name."""
        product: Any = 1.0
        for name, modulus in self.factors:
            product = product * (abs(values[name]) if modulus else values[name])
        return product

    def slope(self, by: str, values: dict[str, Any]) -> Any:
        """Its derivative by the variable `by`, by the product rule; that of a modulus is the sign."""
        total: Any = 0.0
        for index, (name, modulus) in enumerate(self.factors):
            if name == by:
                rest = Term(self.factors[:index] + self.factors[index + 1 :])
                total = total + (np.sign(values[name]) if modulus else 1.0) * rest.value(values)
        return total


@dataclass(frozen=True)
class Actuator:
    """The range of an input's settings, its time constant [s] and the greatest change per second."""

    range: tuple[float, float] | None
    lag_s: float
    rate_per_s: float | None


@dataclass(frozen=True)
class Vessel:
    """A model structure with true and nominal parameters; per degree of freedom in the order surge, sway, yaw."""

    rate_hz: float
    inputs: tuple[str, ...]
    terms: tuple[tuple[Term, ...], ...]
    names: tuple[tuple[str, ...], ...]
    value: tuple[tuple[float, ...], ...]
    nominal: tuple[tuple[float, ...], ...]
    follows: dict[str, tuple[str, float]]
    actuators: tuple[Actuator, ...]

    @property
    def truth(self) -> list[float]:
        """All true parameters, surge first."""
        return [value for degree in self.value for value in degree]


@dataclass(frozen=True)
class Study:
    """What the oracle needs of a study."""

    vessel: Vessel
    maneuvers: tuple[dict[str, Any], ...]
    samples: int
    inputs_from: str
    current_std: float
    measurement_std: tuple[float, float, float]


HELD = Path(__file__).resolve().parents[2] / "pipelines/scenarios/dictionary.toml"
"""The maneuvers that the oracle's numbers are for: the paper's, held steady."""


def read_vessel(folder: Path) -> Vessel:
    """Reads vessel.toml of `folder`."""
    return _vessel(tomllib.loads((folder / "vessel.toml").read_text()))


def read_study(folder: Path) -> Study:
    """Reads vessel.toml and campaign.toml of `folder`, and the maneuvers of `HELD`."""
    ship = read_vessel(folder)
    dictionary, campaign = (tomllib.loads(file.read_text()) for file in (HELD, folder / "campaign.toml"))
    noise = campaign["measurement"]
    return Study(
        vessel=ship,
        maneuvers=tuple(dictionary["maneuver"]),
        samples=round(dictionary["duration_s"] * ship.rate_hz),
        inputs_from=dictionary["inputs_from"],
        current_std=campaign["current"]["std_m_s"],
        measurement_std=(noise["std_u_m_s"], noise["std_v_m_s"], noise["std_r_rad_s"]),
    )


def _actuator(table: dict[str, Any]) -> Actuator:
    ends = table.get("range")
    return Actuator((ends[0], ends[1]) if ends else None, table.get("lag_s", 0.0), table.get("rate_per_s"))


def _vessel(table: dict[str, Any]) -> Vessel:
    def per_degree(key: str) -> tuple[tuple[Any, ...], ...]:
        return tuple(tuple(entry[key] for entry in table[degree]) for degree in DEGREES)

    follows = {i["name"]: (i["follows"], i["factor"]) for i in table["input"] if "follows" in i}
    return Vessel(
        rate_hz=table["sample_rate_hz"],
        inputs=tuple(i["name"] for i in table["input"]),
        terms=tuple(tuple(Term.parse(text) for text in degree) for degree in per_degree("term")),
        names=per_degree("parameter"),
        value=per_degree("value"),
        nominal=per_degree("nominal"),
        follows=follows,
        actuators=tuple(_actuator(i) for i in table["input"]),
    )
