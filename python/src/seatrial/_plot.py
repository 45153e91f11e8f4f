"""Figures of a study's files, by matplotlib."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._envelope import check_table, envelope, path_of, units_of
from ._errors import Refused, missing
from ._read import arrow_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .documents import MapDocument, MapLine, MapRaster

STATES = ("u", "v", "r")
NAMES = {"u": "surge speed u", "v": "sway speed v", "r": "yaw rate r"}
COLOURS = {"land": "#e8dcb5", "depth": "#cfe3ee", "no-go": "#e9b9b0"}
UNCHARTED = "#d8d8d8"
TRACKS = {"maneuver": "C3", "run-in": "C1", "basic": "C0"}


def plot(path: str | os.PathLike[str], **choice: Any) -> Figure:
    """A figure of matplotlib of what stands at `path`; `savefig` of it writes a file.

    - trajectories (`campaign.parquet` and others): the states over time, of `run` in `design` (default: the first);
    - `compare.parquet`: measured and simulated over time with 95 % bands, of `source` (default: the first);
    - `scores.parquet`: a dot per run, errors of parameters against errors of simulated motion;
    - `map.json`: the plan on its chart.

    Raises `Refused` for another kind of file, `MissingLibrary` without matplotlib.
    """
    path = path_of(path)
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise missing(f"{path}: plot", "matplotlib", "plot") from error
    figure = Figure(figsize=(8, 6), layout="constrained")
    if path.suffix == ".json":
        _document(figure, path, choice)
        return figure
    found = envelope(path)
    kind = check_table(path, found)
    if kind not in TABLES:
        raise Refused(f"{path}: schema: found {kind}, expected one of {', '.join(TABLES)}, or map; name a file of these")
    draw, own = TABLES[kind]
    _check_choice(path, choice, own)
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise missing(f"{path}: plot", "pyarrow", "plot") from error
    draw(figure, path, _Table(path, arrow_table(path, None, found), units_of(path, found)), choice)
    return figure


class _Table:
    """A table, some of whose rows are drawn."""

    def __init__(self, path: Path, table: Any, units: dict[str, str]) -> None:
        self.path, self.table, self.units = path, table, units

    def values(self, name: str) -> list[Any]:
        """The values of a column; `None` where absent."""
        return list(self.table.column(name).to_pylist())

    def numbers(self, name: str) -> list[float]:
        """The values of a column, NaN where absent."""
        return [float("nan") if value is None else value for value in self.values(name)]

    def of(self, name: str, wanted: Any) -> _Table:
        """The rows whose `name` is `wanted`, or that of the first row."""
        import pyarrow.compute as compute

        if self.table.num_rows == 0:
            raise Refused(f"{self.path}: rows: found none, expected some; write the file again")
        column = self.table.column(name)
        wanted = column[0].as_py() if wanted is None else wanted
        known = compute.unique(column).to_pylist()
        if wanted not in known:
            shown = ", ".join(map(str, known[:8])) + (", ..." if len(known) > 8 else "")
            raise Refused(f"{self.path}: {name}: found no {wanted}, expected one of {shown}; name one of the file")
        return _Table(self.path, self.table.filter(compute.equal(column, wanted)), self.units)

    def label(self, name: str) -> str:
        """What stands at an axis."""
        unit = self.units[name]
        return NAMES.get(name, name.replace("_", " ")) + ("" if unit == "1" else f" [{unit}]")


def _trajectories(figure: Figure, path: Path, table: _Table, choice: dict[str, Any]) -> None:
    own = table.of("design", choice.get("design")).of("run", choice.get("run"))
    time = own.numbers("t")
    for axes, state in zip(_stacked(figure), STATES):
        for name, style, label in ((f"y_{state}", "C7", "measured"), (state, "C0", "true")):
            if name in own.units and any(value is not None for value in own.values(name)):
                axes.plot(time, own.numbers(name), style, linewidth=0.9, label=label)
        axes.set_ylabel(own.label(state if state in own.units else f"y_{state}"))
    figure.axes[0].legend(loc="upper right")
    figure.axes[-1].set_xlabel(own.label("t"))
    figure.suptitle(f"{own.values('design')[0]}, run {own.values('run')[0]}")


def _compare(figure: Figure, path: Path, table: _Table, choice: dict[str, Any]) -> None:
    own = table.of("source", choice.get("source"))
    time = own.numbers("t")
    for axes, state in zip(_stacked(figure), STATES):
        simulated, half = own.numbers(state), own.numbers(f"half_{state}")
        low = [value - width for value, width in zip(simulated, half)]
        high = [value + width for value, width in zip(simulated, half)]
        axes.fill_between(time, low, high, color="C0", alpha=0.2, linewidth=0)
        axes.plot(time, own.numbers(f"y_{state}"), "C7", linewidth=0.9, label="measured")
        axes.plot(time, simulated, "C0", linewidth=0.9, label="simulated")
        axes.set_ylabel(own.label(state))
    figure.axes[0].legend(loc="upper right")
    figure.axes[-1].set_xlabel(own.label("t"))
    figure.suptitle(str(own.values("source")[0]))


def _scores(figure: Figure, path: Path, table: _Table, choice: dict[str, Any]) -> None:
    if "simulation_error" not in table.units:
        raise Refused(f"{path}: columns: found no simulation_error, expected scores of estimates; name those of simulated runs")
    axes = figure.add_subplot()
    designs, across, up = table.values("design"), table.numbers("parameter_error"), table.numbers("simulation_error")
    for design in dict.fromkeys(designs):
        own = [place for place, name in enumerate(designs) if name == design]
        drawn = [place for place in own if math.isfinite(across[place]) and math.isfinite(up[place])]
        without = f", {len(own) - len(drawn)} of them without a score" if len(drawn) < len(own) else ""
        dots = [across[place] for place in drawn], [up[place] for place in drawn]
        axes.plot(*dots, ".", alpha=0.6, label=f"{design}: {len(own)} runs{without}")
    axes.set(xscale="log", yscale="log", xlabel=table.label("parameter_error"))
    axes.set_ylabel("simulation error [m/s]")
    axes.legend()


def _stacked(figure: Figure) -> Sequence[Axes]:
    axes = figure.subplots(len(STATES), sharex=True)
    for own in axes:
        own.grid(alpha=0.3)
    return list(axes)


#: What draws each kind of table, and the choices that it knows.
TABLES: dict[str, tuple[Callable[[Any, Path, _Table, dict[str, Any]], None], tuple[str, ...]]] = {
    "trajectories": (_trajectories, ("design", "run")),
    "compare": (_compare, ("source",)),
    "scores": (_scores, ()),
}


def _check_choice(path: Path, choice: dict[str, Any], known: tuple[str, ...]) -> None:
    unknown = [name for name in choice if name not in known]
    if unknown:
        raise TypeError(f"{path}: plot: found {unknown[0]}, expected {', '.join(known) or 'nothing'} for this kind of file")


def _document(figure: Figure, path: Path, choice: dict[str, Any]) -> None:
    from ._document import read_document

    document = read_document(path)
    if not document.schema.startswith("map/"):
        remedy = "name a map, trajectories, compare or scores"
        raise Refused(f"{path}: schema: found {document.schema}, expected map; {remedy}")
    _check_choice(path, choice, ())
    _map(figure.add_subplot(), document.data)


def _map(axes: Axes, plan: MapDocument) -> None:
    """The plan on its chart; east to the right, north up, in metres."""
    axes.set_facecolor(COLOURS["depth"] if plan.uncharted_is_water else UNCHARTED)
    for cells in [plan.cells] if plan.cells else []:
        for own in cells.classes:
            _raster(axes, cells.raster, own.runs, COLOURS[own.class_], 1.0)
    for area in plan.areas:
        _rings(axes, area.rings, COLOURS[area.class_], 1.0)
    if plan.swept:
        _raster(axes, plan.swept.raster, plan.swept.runs, "C1", 0.25)
    for corridor in plan.corridors:
        _rings(axes, [corridor], "C4", 0.1)
    for contour in plan.contours:
        axes.plot(contour.line.east_m, contour.line.north_m, color="#8aa6b5", linewidth=0.5)
    labels = {"maneuver": "maneuvers", "run-in": "run-ins", "basic": "between them"}
    for track in plan.tracks:
        line = track.line
        axes.plot(line.east_m, line.north_m, color=TRACKS[track.kind], linewidth=1.2, label=labels.pop(track.kind, None))
    for name, place, sign in (("start", plan.start, "o"), ("goal", plan.goal, "s")):
        if place:
            axes.plot(place.east_m, place.north_m, sign, color="black", markersize=5, label=name)
    axes.legend(loc="best", fontsize=8)
    frame = plan.frame
    axes.set(xlim=(frame.west_m, frame.east_m), ylim=(frame.south_m, frame.north_m), aspect="equal")
    axes.set(
        xlabel="east [m]",
        ylabel="north [m]",
        title=plan.statement if plan.safe else f"not safe by its own check: {plan.statement}",
    )
    axes.title.set(fontsize=8, wrap=True)


def _rings(axes: Axes, rings: list[MapLine], colour: str, alpha: float) -> None:
    """Fills the first ring without the others, its holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    outlines = [Outline([*zip(ring.east_m, ring.north_m), (0.0, 0.0)], closed=True) for ring in rings]
    axes.add_patch(PathPatch(Outline.make_compound_path(*outlines), facecolor=colour, alpha=alpha, linewidth=0))


def _raster(axes: Axes, raster: MapRaster, runs: list[int], colour: str, alpha: float) -> None:
    """Fills the cells of `runs`: numbers of cells that are out and in by turns, from the south-west, out first."""
    import numpy
    from matplotlib.colors import ListedColormap

    within = numpy.repeat(numpy.arange(len(runs)) % 2, runs)
    cells = numpy.zeros(raster.rows * raster.columns)
    cells[: len(within)] = within
    masked = numpy.ma.masked_equal(cells.reshape(raster.rows, raster.columns), 0)
    east, north = raster.west_m + raster.columns * raster.cell_m, raster.south_m + raster.rows * raster.cell_m
    extent = (raster.west_m, east, raster.south_m, north)
    axes.imshow(masked, cmap=ListedColormap([colour]), alpha=alpha, origin="lower", extent=extent, interpolation="nearest")
