"""A model: its equations as `seatrial export` writes them, and the stages that try it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

from ._document import Document, read_document
from ._errors import NoAnswer, Refused, WrongUsage
from ._program import run

State = tuple[float, float, float]


class Model:
    """A ship's model, discrete in time. The state is u, v [m/s] and r [rad/s] in body axes.

    `step` and `simulate` call the Python text of `seatrial export`; there is no second implementation. The program
    refuses names with control characters, so that no name of a file becomes code.
    """

    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._text = text
        self._module = ModuleType("seatrial_model")
        exec(compile(text, f"<seatrial export of {path}>", "exec"), self._module.__dict__)

    @classmethod
    def load(cls, path: str | os.PathLike[str], parameters: str | None = None) -> Model:
        """The model of a `model.json` or a `vessel.toml`; of this `parameters` says which values: value or nominal.

        Raises what `run` raises.
        """
        path = Path(path)
        with TemporaryDirectory() as folder:
            out = Path(folder) / "exported"
            out.mkdir()
            run("export", model=path, to="python", parameters=parameters, out=f"{out}{os.sep}", quiet=True)
            text = next(out.glob("*.py")).read_text(encoding="utf-8")
        return cls(path.resolve(), text)

    @property
    def path(self) -> Path:
        """The file that it was read from."""
        return self._path

    @property
    def text(self) -> str:
        """Its Python text, which needs nothing but Python."""
        return self._text

    @property
    def name(self) -> str:
        """The vessel's name."""
        return str(self._module.VESSEL)

    @property
    def step_s(self) -> float:
        """The time of a step [s], the only one that the parameters hold for."""
        return float(self._module.STEP_S)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(self._module.STATES)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in the order of a row."""
        return tuple(self._module.INPUTS)

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name."""
        return dict(self._module.PARAMETERS)

    @property
    def standard_errors(self) -> dict[str, float | None]:
        """Standard errors of the parameters; `None` where they are not known."""
        return dict(self._module.STANDARD_ERRORS)

    @property
    def units(self) -> dict[str, str]:
        """Units of states, inputs and parameters."""
        return dict(self._module.UNITS)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and largest value of states and inputs in the data; empty where they are not known."""
        return dict(self._module.RANGES)

    def step(self, state: Sequence[float], row: Sequence[float], parameters: Mapping[str, float] | None = None) -> State:
        """The state one step after `state`, while the inputs `row` are held. `parameters` replaces some of its own."""
        u, v, r = self._computed(self._module.step, _state(state), self._row(row), self._with(parameters))
        return u, v, r

    def simulate(
        self,
        inputs: Any,
        initial: Sequence[float] = (0.0, 0.0, 0.0),
        parameters: Mapping[str, float] | None = None,
        frame: str | None = None,
    ) -> Any:
        """The states from `initial` on: one more than rows of `inputs`, which may be a frame with a column per input.

        With `frame` (pandas, polars, arrow) a frame with `t` and the states, else a list of states.
        """
        states = self._computed(self._module.simulate, self._rows(inputs), _state(initial), self._with(parameters))
        if frame is None:
            return states
        from ._read import framed

        columns = {"t": [k * self.step_s for k in range(len(states))]}
        columns |= {name: [float(state[i]) for state in states] for i, name in enumerate(self.states)}
        return framed(columns, {"t": "s", **{name: self.units[name] for name in self.states}}, frame)

    def outside(self, state: Sequence[float], row: Sequence[float]) -> list[str]:
        """Names of what is outside of the range of the data."""
        return list(self._module.outside(_state(state), self._row(row)))

    def compare(self, trajectories: str | os.PathLike[str], out: str | os.PathLike[str] | None = None, **flags: Any) -> Document:
        """Tries the model on runs that it was not fitted to: `seatrial validate --model`; see its help for `flags`.

        Its files stay where `out` names a path.
        """
        return self._stage("validate", "validation.json", out, trajectories=trajectories, **flags)

    def merit(
        self,
        dictionary: str | os.PathLike[str],
        length_m: float,
        out: str | os.PathLike[str] | None = None,
        **flags: Any,
    ) -> Document:
        """Figures of merit of standard maneuvers: `seatrial validate merit`. Length between perpendiculars [m].

        Its files stay where `out` names a path.
        """
        return self._stage("validate merit", "merit.json", out, dictionary=dictionary, length_m=length_m, **flags)

    def _computed(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except (ArithmeticError, ValueError, RecursionError) as error:
            found = f"{self._path}: step: found {error}"
            raise NoAnswer(f"{found}, expected numbers that stay finite; correct state, inputs or parameters") from error

    def _stage(self, stage: str, name: str, out: str | os.PathLike[str] | None, /, **flags: Any) -> Document:
        if "model" in flags:
            raise WrongUsage(f"{stage}: model: found another one, expected none; load that one")
        with TemporaryDirectory() as folder:
            to = Path(folder) / name if out is None else out
            found = run(stage, model=self._path, out=to, **flags).out
            if found is None:
                raise Refused(f"{stage}: out: found none, expected a file; name one with out")
            return read_document(found if found.suffix == ".json" else found / name)

    def _with(self, parameters: Mapping[str, float] | None) -> dict[str, float]:
        own = self._module.PARAMETERS
        unknown = [name for name in parameters or {} if name not in own]
        if unknown:
            raise WrongUsage(f"parameters: found {unknown[0]}, expected some of {', '.join(own)}; correct the name")
        return {**own, **(parameters or {})}

    def _row(self, row: Sequence[float]) -> Sequence[float]:
        if len(row) != len(self.inputs):
            raise WrongUsage(f"inputs: found {len(row)} values, expected one of each of {', '.join(self.inputs)}")
        return row

    def _rows(self, inputs: Any) -> Iterable[Sequence[float]]:
        """The rows of `inputs`, which may be columns by name."""
        columns = columns_of("inputs", inputs, self.inputs)
        if columns is None:
            return (self._row(row) for row in inputs)
        return list(zip(*columns.values()))


def _state(state: Sequence[float]) -> Sequence[float]:
    if len(state) != 3:
        raise WrongUsage(f"state: found {len(state)} values, expected u, v and r; give all three")
    return state


def columns_of(thing: str, table: Any, names: Sequence[str]) -> dict[str, list[float]] | None:
    """The columns `names` of a frame or of columns by name, which messages call `thing`; `None` if it is neither."""
    known = getattr(table, "column_names", None) or getattr(table, "columns", None)
    if isinstance(table, Mapping):
        known = table.keys()
    if known is None:
        return None
    absent = [name for name in names if name not in list(known)]
    if absent:
        raise WrongUsage(f"{thing}: found no column {', '.join(absent)}, expected {', '.join(names)}; add it")
    columns = {name: _values(table[name]) for name in names}
    if len({len(column) for column in columns.values()}) > 1:
        lengths = ", ".join(str(len(column)) for column in columns.values())
        raise WrongUsage(f"{thing}: found columns of {lengths} rows, expected as many in each; correct them")
    return columns


def _values(column: Any) -> list[float]:
    for method in ("to_pylist", "to_list", "tolist"):
        if hasattr(column, method):
            return list(getattr(column, method)())
    return list(column)
