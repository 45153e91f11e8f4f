"""Exceptions: one for each exit code of the program. The message is the program's line."""

from __future__ import annotations


class SeatrialError(Exception):
    """Nothing was written. `exit_code` is the program's, or that which it would have."""

    exit_code = 1

    def __init__(self, message: str, *, exit_code: int | None = None, command: list[str] | None = None) -> None:
        super().__init__(message)
        self.exit_code = type(self).exit_code if exit_code is None else exit_code
        #: The command line, where one was run.
        self.command = command or []


class Failed(SeatrialError):
    """Exit code 1: reading, writing or numerics failed."""


class WrongUsage(SeatrialError):
    """Exit code 2: an unknown stage or flag, or a value that a flag does not take."""

    exit_code = 2


class Refused(SeatrialError):
    """Exit code 3: an input was refused, because of its schema, a unit, a value, or files of different studies."""

    exit_code = 3


class NoAnswer(SeatrialError):
    """Exit code 4: there is no result: not identifiable, not converged, no plan."""

    exit_code = 4


class Interrupted(SeatrialError):
    """Exit code 128 + N: signal N ended the program."""

    exit_code = 130


class MissingLibrary(SeatrialError, ImportError):
    """A Python library is not installed; the message says how to install it."""


def of_exit_code(code: int, message: str, command: list[str]) -> SeatrialError:
    """The exception of a program that ended with `code`; a negative one is that of a signal."""
    if code < 0:
        code = 128 - code
    kinds = {1: Failed, 2: WrongUsage, 3: Refused, 4: NoAnswer}
    kind = kinds.get(code, Interrupted if code > 128 else Failed)
    return kind(message, exit_code=code, command=command)


def missing(thing: str, library: str, extra: str) -> MissingLibrary:
    """The exception of `thing` without `library`, which `extra` of this package brings."""
    return MissingLibrary(
        f"{thing}: found no {library}, expected it to be installed; pip install 'seatrial[{extra}]' installs it"
    )
