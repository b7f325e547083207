"""Declaration of a command's arguments for its flags, its Python call and its job alike.

The arguments are a dataclass. A field made by `argument` is a flag as well, and holds the facts
that click and the help need. Other fields are only parameters of the Python call. The call's
docstring describes only parameters that these fields do not describe.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, MISSING, dataclass, field, fields, is_dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, Final, ParamSpec, TypeVar, dataclass_transform

import click

from nvcore.common.wording import one_line

# Nothing here imports numpy or pandas, so that `nvcore --help` need not wait for them.

PathLike = str | Path
Size = tuple[int, int] | str
"""Width and height in pixels: (640, 480) or "640x480"."""

INPUTS: Final = "Inputs"
READING: Final = "How files are read"
FACTS: Final = "What the files do not say"
CORRECTIONS: Final = "Corrections"
OUTPUT: Final = "Output"
OTHER: Final = "Other"
"""Headings of the help, besides those of the parameters and of click itself."""

FRAMES: Final = (
    "first:last[:step], both included, either may be missing; or a file with a number a line."
)
"""Syntax of evaluated frames."""


class _Folder(click.Path):
    """Path of a folder, shown as DIR in the help."""

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:  # noqa: ARG002
        """Return the placeholder of the value."""
        return "DIR"


FILE: Final = click.Path(dir_okay=False, path_type=Path)
FOLDER: Final = _Folder(file_okay=False, path_type=Path)
"""Types of options that name a file or a folder."""

P = ParamSpec("P")
Arguments = TypeVar("Arguments")
Output = TypeVar("Output")
Owner = TypeVar("Owner")
Call = TypeVar("Call", bound=Callable[..., Any])

_PARAMETERS: Final = re.compile(
    r"(?:\n\n(?:Parameters|Attributes)\n-+\n(.*?))?(?=\n\n\w+\n---|\Z)", re.DOTALL
)
"""Pattern for the section of parameters in a docstring (group 1: its entries), or its place."""


def argument(
    group: str, meaning: str, *, flag: str = "", default: Any = MISSING, **known: Any
) -> Any:
    """Declare a field that has a flag.

    Parameters
    ----------
    group
        Heading in the help.
    meaning
        Text for the help and for the docstring of the call. ``{again}`` says that the argument may
        be given several times. ``{name}`` refers to another argument.
    flag
        Name of the flag. Empty: derived from the field's name.
    default
        Default of field and flag. Without it the argument is required.
    known
        Further arguments of `click.option`.
    """
    facts = {"group": group, "help": meaning, **known}
    return field(default=default, metadata={"flag": flag, "facts": facts})


@dataclass_transform(frozen_default=True, field_specifiers=(argument, field))
def arguments(kind: type[Arguments]) -> type[Arguments]:
    """Make a class a frozen dataclass whose fields are the arguments of a command."""
    return dataclass(frozen=True)(kind)


def called_with(
    kind: Callable[P, Arguments],
) -> Callable[[Callable[[Arguments], Output]], Callable[P, Output]]:
    """Decorate a function of a single object to be called with the parameters that make the object.

    `kind` is the class or function that makes it. ``help``, type checkers and `inspect.signature`
    show these parameters. The function's docstring describes only those that neither the fields'
    help nor the docstring of `kind` describes.
    """

    def decorate(function: Callable[[Arguments], Output]) -> Callable[P, Output]:
        @wraps(function)
        def call(*given: P.args, **named: P.kwargs) -> Output:
            return function(kind(*given, **named))

        return _shown(call, kind, inspect.signature(kind).parameters.values())

    return decorate


def method_with(
    kind: Callable[P, Arguments],
) -> Callable[[Callable[[Owner, Arguments], Output]], Callable[Concatenate[Owner, P], Output]]:
    """Decorate a method like `called_with`."""

    def decorate(
        method: Callable[[Owner, Arguments], Output],
    ) -> Callable[Concatenate[Owner, P], Output]:
        @wraps(method)
        def call(owner: Owner, /, *given: P.args, **named: P.kwargs) -> Output:
            return method(owner, kind(*given, **named))

        owner = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
        own = inspect.signature(kind).parameters.values()
        return _shown(call, kind, [owner, *own])

    return decorate


def _shown(call: Call, kind: Callable[..., Any], parameters: Iterable[inspect.Parameter]) -> Call:
    """Set the signature of a call, and describe the parameters in its docstring."""
    output = call.__annotations__["return"]
    signature = inspect.Signature(list(parameters), return_annotation=output)
    call.__signature__ = signature  # type: ignore[attr-defined]
    if call.__doc__ is not None:  # as without -OO
        texts = _texts_of(kind) | _texts(call)
        entries = dict.fromkeys(texts[name] for name in signature.parameters if name in texts)
        section = "\n".join(["\n\nParameters\n----------", *entries])
        call.__doc__ = _PARAMETERS.sub(lambda _: section, inspect.cleandoc(call.__doc__), count=1)
    return call


def _texts_of(kind: Callable[..., Any]) -> dict[str, str]:
    """Return the docstring entries of a class's fields or a function's parameters, by name."""
    if not is_dataclass(kind):
        return _texts(kind)
    texts = {}
    names = {spec.name: f"`{spec.name}`" for spec in fields(kind)}
    for spec in fields(kind):
        if facts := spec.metadata.get("facts"):
            text = facts["help"].format(again="several may be given", **names)
            match facts.get("type"):
                case click.Choice(choices=choices):
                    text += " One of " + ", ".join(f'"{choice}"' for choice in choices) + "."
                case click.FloatRange(min=float(low), max=float(high)):
                    text += f" From {low:g} to {high:g}."
            text = textwrap.fill(text, 100, initial_indent=" " * 4, subsequent_indent=" " * 4)
            texts[spec.name] = f"{spec.name}\n{text}"
    for base in reversed(inspect.getmro(kind)):
        texts |= _texts(base)
    return texts


def _texts(described: object) -> dict[str, str]:
    """Return the entries of a docstring by parameter. Several parameters may share one."""
    told = _PARAMETERS.findall(inspect.cleandoc(described.__doc__ or ""))[0]
    entries = re.split(r"\n(?=\S)", told)
    return {name: entry for entry in entries for name in entry.partition("\n")[0].split(", ")}


@arguments
class Part:
    """Recordings and frames that a command works on, and facts that the files lack.

    Attributes
    ----------
    size
        (width, height) in pixels, or a text such as "640x480". Default: as in the data.
    """

    _: KW_ONLY
    only: str | Sequence[str] = argument(
        INPUTS, "Only this recording; {again}.", default=(), multiple=True, metavar="RECORDING"
    )
    tags: str | Sequence[str] = argument(
        INPUTS,
        "Only recordings with this tag; {again}: with all of them.",
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
    """Callback of a repeatable flag that takes ``KEY=VALUE``.

    Raises
    ------
    click.UsageError
        If a text has another form.
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
