"""What the commands of the driver share: flags, and the run over a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from nvcore.cli.options import PairOf, grouped_option, with_options
from nvcore.cli.progress import ShareProgress, TerminalProgress
from nvcore.cli.steps import errors_of
from nvcore.driver.arguments import VIEW
from nvcore.inputs.session_toml import read_session
from nvcore.progress import Progress

# Nothing here imports numpy, pandas or OpenCV: `nvcore --help` need not wait for them.

LIGHT: Final = "Light"


def _gather(context: click.Context, option: click.Parameter, value: Any) -> None:
    """Put the value into the command's ``settings``."""
    if value is not None:
        context.params.setdefault("settings", {})[option.name] = value


def _setting(group: str, *names: str, **known: Any) -> Callable[..., Any]:
    return grouped_option(group, *names, callback=_gather, expose_value=False, **known)


setting_options = with_options(
    _setting(
        VIEW,
        "--surround",
        type=float,
        metavar="FACTOR",
        help="Sides of the region around a pedestrian, as a multiple of the box's. Default: 2.",
    ),
    _setting(
        VIEW,
        "--bin-distance",
        type=float,
        help="Distance of neighbouring bins in the Earth Mover's Distance of colours. Default: 1.",
    ),
    _setting(
        VIEW,
        "--fixation",
        type=PairOf("X,Y"),
        metavar="X,Y",
        help="Where the driver is assumed to look without a gaze file, as shares of the picture's "
        "width and height. Default: 0.5,0.5, its middle.",
    ),
    _setting(
        LIGHT,
        "--drop-factor",
        type=float,
        metavar="FACTOR",
        help="By so much the light falls in a change from bright to dark. Default: 10.",
    ),
    _setting(
        LIGHT,
        "--picture-drop-factor",
        type=float,
        metavar="FACTOR",
        help="The same of the pictures' mean luminance, where it stands in for a light meter. "
        "Default: 3.",
    ),
    _setting(
        LIGHT,
        "--drop-within",
        "within_s",
        type=float,
        metavar="S",
        help="In so many seconds. Default: 2.",
    ),
    _setting(
        LIGHT,
        "--bright-for",
        "bright_for_s",
        type=float,
        metavar="S",
        help="So long it must have been bright before: an oncoming lamp is not. Default: 3.",
    ),
    _setting(
        LIGHT,
        "--smooth",
        "smooth_s",
        type=float,
        metavar="S",
        help="Width of the median that takes out flicker. Default: 0.5.",
    ),
    _setting(
        LIGHT,
        "--least-lux",
        type=float,
        metavar="LUX",
        help="What a light meter reads below that counts as that. Default: 0.1.",
    ),
)
"""Flags for what features and the adaptation period depend on."""
_Written = TypeVar("_Written")


def run_on_session(
    session_file: Path,
    kind: Callable[..., Any],
    job_of: Callable[..., Callable[[Progress], _Written]],
    options: Mapping[str, Any],
) -> _Written:
    """Run a job over a session with the flags that were given, and show how far it is.

    Parameters
    ----------
    kind, job_of
        Class of its arguments, and what makes the job of them.
    """
    session = read_session(session_file, needs_system=False)
    with errors_of(session):
        with TerminalProgress(2 + len(session.systems)) as steps:
            job = job_of(kind(session, **options), inputs=[session_file], loading=steps)
        with ShareProgress() as progress:
            return job(progress)
