"""seatrial from Python: run its stages, read what they write, step its models, plot.

    import seatrial
    seatrial.run("run", "pipelines/smoke", out="out/smoke")      # exceptions are named by the exit code
    scores = seatrial.read("out/smoke/scores.parquet")           # a frame of pandas, polars or Arrow
    design = seatrial.read("out/smoke/design.json")              # dataclasses
    ship = seatrial.Model.load("pipelines/smoke/vessel.toml")    # step, simulate, compare, merit
    ship = seatrial.fit(frame, vessel="vessel.toml")             # from a frame of logged motions and inputs

Modules are imported when they are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import documents as documents
    from ._document import Document as Document
    from ._errors import Failed as Failed
    from ._errors import Interrupted as Interrupted
    from ._errors import MissingLibrary as MissingLibrary
    from ._errors import NoAnswer as NoAnswer
    from ._errors import Refused as Refused
    from ._errors import SeatrialError as SeatrialError
    from ._errors import WrongUsage as WrongUsage
    from ._fit import fit as fit
    from ._model import Model as Model
    from ._plot import plot as plot
    from ._program import Result as Result
    from ._program import program as program
    from ._program import run as run
    from ._read import read as read
    from ._read import units as units

# Where each name is.
_PLACES = {
    "Document": "_document",
    "Failed": "_errors",
    "Interrupted": "_errors",
    "MissingLibrary": "_errors",
    "Model": "_model",
    "NoAnswer": "_errors",
    "Refused": "_errors",
    "Result": "_program",
    "SeatrialError": "_errors",
    "WrongUsage": "_errors",
    "fit": "_fit",
    "plot": "_plot",
    "program": "_program",
    "read": "_read",
    "run": "_program",
    "units": "_read",
}
__all__ = sorted([*_PLACES, "documents"])


def __getattr__(name: str) -> Any:
    if name == "documents":
        return import_module(".documents", __name__)
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_PLACES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
