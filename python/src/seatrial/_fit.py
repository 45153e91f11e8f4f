"""A model fitted to a frame of logged motions and inputs."""

from __future__ import annotations

import csv
import json
import os
import statistics
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ._errors import NoAnswer, WrongUsage
from ._model import Model, columns_of
from ._program import run

#: Columns of the motion with their channels and units.
MOTION = {"u": ("y_u", "m/s"), "v": ("y_v", "m/s"), "r": ("y_r", "rad/s")}
# A pause of so many usual steps is a gap
_PAUSE = 5.0


def fit(frame: Any, vessel: str | os.PathLike[str], out: str | os.PathLike[str] | None = None, **flags: Any) -> Model:
    """The model of `vessel`, a `vessel.toml`, fitted to one recording: `fit(frame, vessel="vessel.toml")`.

    `frame` is one of pandas, polars or Arrow, or columns by name: `t` [s], `u`, `v` [m/s], `r` [rad/s] in body axes, and each input of
    the vessel in its unit. `out` names a folder that keeps the log, ingest.toml, trajectories and model.json; `flags` are those of
    `seatrial estimate --fit together`.

    Raises what `run` raises.
    """
    ship = Model.load(vessel)
    columns = columns_of("frame", frame, ["t", *MOTION, *ship.inputs])
    if columns is None:
        raise WrongUsage(f"frame: found {type(frame).__name__}, expected a frame or columns by name; make one of it")
    steps = [after - before for before, after in zip(columns["t"], columns["t"][1:])]
    if not steps or not statistics.median(steps) > 0:
        raise WrongUsage("t: found no time that passes, expected seconds, one row after the other; correct it")
    with TemporaryDirectory() as folder:
        place = Path(folder if out is None else out)
        (place / "logs").mkdir(parents=True, exist_ok=True)
        with open(place / "logs" / "frame.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(zip(*columns.values()))
        (place / "ingest.toml").write_text(_ingest(ship, statistics.median(steps)), encoding="utf-8")
        trajectories = place / "trajectories.parquet"
        run("ingest", config=place / "ingest.toml", logs=place / "logs", vessel=vessel, out=trajectories, quiet=True)
        run(
            "estimate",
            vessel=vessel,
            trajectories=trajectories,
            out=f"{place}{os.sep}",
            quiet=True,
            **({"structure": "own"} | flags),
        )
        model = place / "model.json"
        if not model.is_file():
            found = "fit: found motions that do not tell all parameters, expected some that do"
            raise NoAnswer(f"{found}; fit a longer frame of more and stronger maneuvers, or fix parameters in {vessel}")
        return Model.load(model)


def _ingest(ship: Model, step_s: float) -> str:
    channels = {name: own for name, own in MOTION.items()} | {name: (name, ship.units[name]) for name in ship.inputs}
    text = f"sample_rate_hz = {1.0 / ship.step_s!r}\nmax_gap_s = {_PAUSE * step_s!r}\n"
    text += '[[file]]\npattern = ["frame.csv"]\n[file.time]\ncolumn = "t"\nunit = "s"\n'
    for column, (channel, unit) in channels.items():
        words = ((key, json.dumps(own)) for key, own in (("column", column), ("channel", channel), ("unit", unit)))
        text += "[[file.channel]]\n" + "".join(f"{key} = {own}\n" for key, own in words)
    return text
