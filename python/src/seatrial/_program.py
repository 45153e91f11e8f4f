"""Runs the program `seatrial`, which the wheel installs beside this module."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from threading import Thread
from typing import IO, Any

from ._errors import Failed, WrongUsage, of_exit_code

#: Names a program in place of the installed one.
VARIABLE = "SEATRIAL_PROGRAM"
NAME = "seatrial.exe" if os.name == "nt" else "seatrial"
# Subcommands that print lines for people alone
PRINTING = ("verify", "completions", "help")


@dataclass(frozen=True)
class Result:
    """What a stage wrote."""

    #: The main file or the folder; `None` of what writes nothing.
    out: Path | None
    #: What the stage says of it: the object that `--json` prints.
    summary: dict[str, Any] = field(default_factory=dict)
    #: The printed lines of a subcommand that has no such object.
    text: str = ""

    def read(self, frame: str | None = None) -> Any:
        """Reads the main file, see `seatrial.read`."""
        from ._read import read

        if self.out is None:
            raise WrongUsage("result: found no file, expected one; the subcommand only prints")
        return read(self.out, frame=frame)


def program() -> Path:
    """The program that `run` calls: that of the variable SEATRIAL_PROGRAM, else the installed one, else one in PATH.

    Raises `Failed` where there is none, or where its version is not this module's.
    """
    return _checked(os.environ.get(VARIABLE))


@lru_cache
def _checked(named: str | None) -> Path:
    path = Path(named) if named else _installed()
    if path is None or not path.is_file():
        found = f"no file {path}" if named else "none"
        raise Failed(f"program seatrial: found {found}, expected an installed one; pip install seatrial, or set {VARIABLE}")
    wanted = _version()
    if wanted is not None and not named:
        _, printed, _ = _called([str(path), "--version"])
        found = printed.strip()
        if found != f"seatrial {wanted}":
            raise Failed(f"{path}: found {found or 'no version'}, expected seatrial {wanted}; install the wheel again")
    return path


def _version() -> str | None:
    """The version of the installed package; `None` where the module is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("seatrial")
    except PackageNotFoundError:
        return None


def _installed() -> Path | None:
    from importlib.metadata import PackageNotFoundError, files

    try:
        for file in files("seatrial") or []:
            if file.name == NAME:
                return Path(str(file.locate()))
    except PackageNotFoundError:
        pass
    beside = Path(sysconfig.get_path("scripts")) / NAME
    if beside.is_file():
        return beside
    found = shutil.which(NAME)
    return Path(found) if found else None


def run(stage: str, /, *arguments: Any, **flags: Any) -> Result:
    """Runs a stage: `run("validate", model="model.json", trajectories="t.parquet", out="validation.json")`.

    `arguments` are those without a name, such as the folder of `run("run", "my-study")`. Flags are those of the
    command line with `_` for `-`: `True` stands for a flag alone, `None` and `False` for none. A list repeats the
    flag, and `set={"campaign.realizations": 100}` changes hand-written files. The stage itself has no keyword, so that
    `stage="design"` is the flag `--stage`.

    Progress and warnings go to `sys.stderr`; `quiet=True` silences progress.

    Raises `Failed`, `WrongUsage`, `Refused`, `NoAnswer` or `Interrupted` by the exit code, with the program's line.
    """
    words = stage.split()
    if not words:
        raise WrongUsage("stage: found none, expected one, such as design; seatrial --help lists them")
    given = {name: value for name, value in flags.items() if name != "json"}
    try:
        command = [str(program()), *words, *command_line(given)]
    except (ValueError, RecursionError) as error:
        raise WrongUsage(f"flags: found {error}, expected values that TOML has; correct them") from error
    if words[0] not in PRINTING:
        command.append("--json")
    if arguments:
        command += ["--", *map(_text, arguments)]
    code, printed, said = _called(command)
    last = _object(printed)
    if code != 0:
        raise of_exit_code(code, _reason(last, said, code), command)
    if last is None:
        return Result(None, text=printed)
    out = last.get("out")
    return Result(Path(out) if out else None, summary=last)


def command_line(flags: Mapping[str, Any]) -> list[str]:
    """The words of a command line for `flags`."""
    words: list[str] = []
    for name, value in flags.items():
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
            continue
        if isinstance(value, Mapping):
            value = [f"{key}={_toml(own)}" for key, own in value.items()]
        several = value if isinstance(value, (list, tuple, set, frozenset)) else [value]
        words += [f"{flag}={_text(own)}" for own in several]
    return words


def _text(value: Any) -> str:
    return os.fsdecode(value) if isinstance(value, os.PathLike) else str(value)


def _toml(value: Any) -> str:
    """A value as TOML has it."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (bool, list)) else _text(value)


def _called(command: list[str]) -> tuple[int, str, list[str]]:
    """Exit code, stdout, and the lines of stderr, which are passed on but for the one that the exception has."""
    said: list[str] = []
    options: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL}
    try:
        process = subprocess.Popen(command, encoding="utf-8", errors="replace", **options)
    except OSError as error:
        raise Failed(f"{command[0]}: start: found {error.strerror}, expected a program; install the wheel again") from error
    except ValueError as error:
        raise WrongUsage(f"command line: found {error}, expected words without it; correct the flags") from error
    with process:
        assert process.stdout is not None and process.stderr is not None
        passing = Thread(target=_pass_on, args=(process.stderr, said), daemon=True)
        passing.start()
        try:
            printed = process.stdout.read()
        except BaseException:
            process.terminate()
            raise
        passing.join()
    return process.returncode, printed, said


def _pass_on(lines: IO[str], said: list[str]) -> None:
    for line in lines:
        said.append(line.rstrip("\n"))
        if not line.startswith("error: "):
            print(line, end="", file=sys.stderr, flush=True)


def _object(printed: str) -> dict[str, Any] | None:
    """The object on the last line of stdout."""
    last = printed.rstrip().rpartition("\n")[2]
    try:
        found = json.loads(last)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None


def _reason(last: dict[str, Any] | None, said: list[str], code: int) -> str:
    """Why the program wrote nothing."""
    if last and "error" in last:
        return str(last["error"])
    errors = [line.removeprefix("error: ") for line in said if line.startswith("error: ")]
    return errors[-1] if errors else (said[-1] if said else f"the program ended with exit code {code}")
