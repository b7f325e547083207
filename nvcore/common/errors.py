"""Errors that a user can fix.

    NvcoreError                     base; the command line shows it without a traceback
    ├── InputError                  a file or folder cannot be used (carries file and line)
    │   ├── FormatError             its content is not what the format says
    │   ├── UnknownFormatError      no reader recognises it, or no reader has that name
    │   ├── MediaError              pictures, a video or an archive cannot be used
    │   ├── EstimatorError          a model of what the driver sees cannot be used
    │   ├── MissingFactError        image size, frame rate, ... are needed and not in the files
    │   ├── SessionError            a session file says something that cannot be done
    │   └── StoreError              people's answers or a store cannot be used; later it may
    ├── ParameterError              a live parameter is outside its range
    └── MissingExtraError           packages of an extra are not installed

Every message states the problem, the place, the expectation, the actual value and the fix.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, Final

from nvcore.common.findings import Remedy, Step


class NvcoreError(Exception):
    """Base class of all errors that a user can fix.

    Attributes
    ----------
    steps
        Suggested fixes, for a medium that has a flag or a field for them.
    needs_all_steps
        True if all of them are needed; otherwise one is enough.
    """

    steps: tuple[Step, ...] = ()
    needs_all_steps = False


class InputError(NvcoreError):
    """A file or folder cannot be used.

    Parameters
    ----------
    message
        Problem, expectation, actual value and fix.
    file
        Name of the file as the user gave it, if one is to blame.
    line
        1-based line in that file, if one is to blame.
    steps
        Suggested fixes, for a medium that has a flag or a field for them.

    Attributes
    ----------
    path
        Path of that file, once it is known, since files of two inputs may have the same name.
    """

    path: Path | None = None

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        steps: tuple[Step, ...] = (),
    ):
        self.message = message
        self.steps = steps
        self.file = None if file is None else str(file)
        self.line = line
        where = ""
        if self.file is not None:
            where = self.file + (f", line {line}" if line is not None else "") + ": "
        super().__init__(where + message)

    def __reduce__(self) -> Any:
        """Keep the keywords when pickled, which an exception by default does not."""
        return partial(type(self), self.message, **self._keywords()), ()

    def _keywords(self) -> dict[str, Any]:
        return {"file": self.file, "line": self.line, "steps": self.steps}


class FormatError(InputError):
    """The content of a file is not what its format says."""


class UnnamedClassesError(FormatError):
    """The files number several classes, and nothing says which of them count."""


class UnknownFormatError(InputError):
    """No reader recognises the file, or no reader has the given name."""


class MediaError(InputError):
    """Pictures, a video or an archive cannot be used."""


class EstimatorError(InputError):
    """A model file that estimates the driver's view cannot be used."""


_OF_FACT: Final = {"size": Remedy.SIZE, "fps": Remedy.RATE, "frames": Remedy.FRAMES}


class MissingFactError(InputError):
    """A needed fact (image size, frame rate, ...) is neither in the files nor given.

    Parameters
    ----------
    message, file, line, steps
        See `InputError`.
    facts
        Facts that the user must specify: ``size``, ``fps``, ``frames``; empty if none of these
        helps. The suggested fixes are to specify all of them, unless `steps` has others.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        facts: tuple[str, ...] = (),
        steps: tuple[Step, ...] = (),
    ):
        self.facts = facts
        of_facts = tuple(Step(_OF_FACT[fact]) for fact in facts)
        super().__init__(message, file=file, line=line, steps=steps or of_facts)
        self.needs_all_steps = self.steps == of_facts

    def _keywords(self) -> dict[str, Any]:
        return {**super()._keywords(), "facts": self.facts}


class SessionError(InputError):
    """A session file asks for something that cannot be done."""


class StoreError(InputError):
    """People's answers or a store cannot be used for now, as when locked or the disk is full."""


class ParameterError(NvcoreError):
    """A live parameter is outside its range."""

    def __init__(self, message: str, *, steps: tuple[Step, ...] = ()):
        super().__init__(message)
        self.steps = steps


class MissingExtraError(NvcoreError, ImportError):
    """Packages of an extra that this part of the program needs are not installed."""
