"""The arguments of a command, declared once: its flags, the parameters of its Python call, its job.

They are a dataclass. A field made by `argument` is a flag, too, and holds what click and the help
have to know of it; other fields are parameters of the Python call alone.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, MISSING, dataclass, field
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, Final, ParamSpec, TypeVar, dataclass_transform

import click

from nvcore.wording import one_line

# Nothing here imports numpy or pandas: `nvcore --help` need not wait for them.

PathLike = str | Path
Size = tuple[int, int] | str
"""Width and height in pixels: (640, 480) or "640x480"."""

INPUTS: Final = "Inputs"
READING: Final = "How files are read"
FACTS: Final = "What the files do not say"
CORRECTIONS: Final = "Corrections"
OUTPUT: Final = "Output"
OTHER: Final = "Other"
"""Headings of the help, beside those of the parameters and click's own."""

FRAMES: Final = (
    "first:last[:step], both included, either may be missing; or a file with a number a line."
)
"""How frames are named."""

P = ParamSpec("P")
Arguments = TypeVar("Arguments")
Output = TypeVar("Output")
Owner = TypeVar("Owner")
Call = TypeVar("Call", bound=Callable[..., Any])


def argument(
    group: str, meaning: str, *, flag: str = "", default: Any = MISSING, **known: Any
) -> Any:
    """A field that has a flag.

    Parameters
    ----------
    group
        Heading of the help that it stands under.
    meaning
        What the help says of it.
    flag
        Empty: by the field's name.
    default
        Of both; without it the argument is required.
    known
        As of `click.option`.
    """
    facts = {"group": group, "help": meaning, **known}
    return field(default=default, metadata={"flag": flag, "facts": facts})


@dataclass_transform(frozen_default=True, field_specifiers=(argument, field))
def arguments(kind: type[Arguments]) -> type[Arguments]:
    """A class whose fields are the arguments of a command."""
    return dataclass(frozen=True)(kind)


def called_with(
    kind: Callable[P, Arguments],
) -> Callable[[Callable[[Arguments], Output]], Callable[P, Output]]:
    """A function of what a class or another function makes, called with the parameters of that.

    So ``help``, type checkers and `inspect.signature` show it.
    """

    def decorate(function: Callable[[Arguments], Output]) -> Callable[P, Output]:
        @wraps(function)
        def call(*given: P.args, **named: P.kwargs) -> Output:
            return function(kind(*given, **named))

        return _shown(call, inspect.signature(kind).parameters.values())

    return decorate


def method_with(
    kind: Callable[P, Arguments],
) -> Callable[[Callable[[Owner, Arguments], Output]], Callable[Concatenate[Owner, P], Output]]:
    """As `called_with`, for a method."""

    def decorate(
        method: Callable[[Owner, Arguments], Output],
    ) -> Callable[Concatenate[Owner, P], Output]:
        @wraps(method)
        def call(owner: Owner, /, *given: P.args, **named: P.kwargs) -> Output:
            return method(owner, kind(*given, **named))

        owner = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
        own = inspect.signature(kind).parameters.values()
        return _shown(call, [owner, *own])

    return decorate


def _shown(call: Call, parameters: Iterable[inspect.Parameter]) -> Call:
    """The call, shown with these parameters."""
    output = call.__annotations__["return"]
    signature = inspect.Signature(list(parameters), return_annotation=output)
    call.__signature__ = signature  # type: ignore[attr-defined]
    return call


@arguments
class Part:
    """Which recordings and frames of a session a command works on, and what its files lack.

    Attributes
    ----------
    only, tags
        Names of recordings, and tags that they all have; empty: all that the session compares.
    frames, size, fps
        See `nvcore.load`.
    """

    _: KW_ONLY
    only: str | Sequence[str] = argument(
        INPUTS,
        "Only this recording; may be given again.",
        default=(),
        multiple=True,
        metavar="RECORDING",
    )
    tags: str | Sequence[str] = argument(
        INPUTS,
        "Only recordings with this tag; may be given again: with all of them.",
        flag="--tag",
        default=(),
        multiple=True,
        metavar="TAG",
    )
    frames: str | range | None = argument(
        FACTS,
        f"Evaluated frames: {FRAMES} Default: the session's.",
        default=None,
        metavar="FILE|F:L[:S]",
    )
    size: Size | None = argument(
        FACTS,
        "Image size in pixels, such as 640x480. Default: as in the data.",
        default=None,
        metavar="WxH",
    )
    fps: float | None = argument(
        FACTS,
        "Frames per second of the camera, also where only every n-th frame is annotated. Default: "
        "as in the data.",
        default=None,
        type=float,
    )


def pairs_of(_: click.Context, option: click.Parameter, texts: Sequence[str]) -> dict[str, str]:
    """Callback of a flag that takes ``KEY=VALUE`` again and again.

    Raises
    ------
    click.UsageError
        If one is of another form; with the flag's name.
    """
    pairs = {}
    for text in texts:
        key, sign, value = text.partition("=")
        if not sign or not key.strip():
            raise click.UsageError(
                f"{option.opts[0]}: expected KEY=VALUE, found {one_line(text)!r}"
            )
        pairs[key.strip()] = value.strip()
    return pairs
