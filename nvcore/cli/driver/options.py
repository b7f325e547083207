"""What the commands of the driver share: flags, and the run over a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import click

from nvcore.arguments import Part
from nvcore.cli.options import PairOf, grouped_option, options_of
from nvcore.cli.progress import ShareProgress, TerminalProgress
from nvcore.cli.steps import errors_of, part_from
from nvcore.inputs.session_toml import read_session
from nvcore.progress import Progress

# Nothing here imports numpy, pandas or OpenCV: `nvcore --help` need not wait for them.

VIEW: Final = "What is seen"
LIGHT: Final = "Light"

SETTING_OPTIONS: Final = (
    grouped_option(
        VIEW,
        "--surround",
        type=float,
        metavar="FACTOR",
        help="Sides of the region around a pedestrian, as a multiple of the box's. Default: 2.",
    ),
    grouped_option(
        VIEW,
        "--bin-distance",
        type=float,
        help="Distance of neighbouring bins in the Earth Mover's Distance of colours. Default: 1.",
    ),
    grouped_option(
        VIEW,
        "--fixation",
        type=PairOf("X,Y"),
        metavar="X,Y",
        help="Where the driver is assumed to look without a gaze file, as shares of the picture's "
        "width and height. Default: 0.5,0.5, its middle.",
    ),
)
"""What features depend on."""
LIGHT_OPTIONS: Final = (
    grouped_option(
        LIGHT,
        "--drop-factor",
        type=float,
        metavar="FACTOR",
        help="By so much the light falls in a change from bright to dark. Default: 10.",
    ),
    grouped_option(
        LIGHT,
        "--picture-drop-factor",
        type=float,
        metavar="FACTOR",
        help="The same of the pictures' mean luminance, where it stands in for a light meter. "
        "Default: 3.",
    ),
    grouped_option(
        LIGHT,
        "--drop-within",
        "within_s",
        type=float,
        metavar="S",
        help="In so many seconds. Default: 2.",
    ),
    grouped_option(
        LIGHT,
        "--bright-for",
        "bright_for_s",
        type=float,
        metavar="S",
        help="So long it must have been bright before: an oncoming lamp is not. Default: 3.",
    ),
    grouped_option(
        LIGHT,
        "--smooth",
        "smooth_s",
        type=float,
        metavar="S",
        help="Width of the median that takes out flicker. Default: 0.5.",
    ),
    grouped_option(
        LIGHT,
        "--least-lux",
        type=float,
        metavar="LUX",
        help="What a light meter reads below that counts as that. Default: 0.1.",
    ),
)
"""What the adaptation period depends on."""
RUN_OPTIONS: Final = (
    options_of(Part),
    grouped_option(
        VIEW,
        "--threads",
        "n_threads",
        type=click.IntRange(1, 256),
        help="Pictures at a time. Default: as many as there are cores.",
    ),
)
_SETTINGS: Final = (
    *("surround", "bin_distance", "fixation"),
    *("drop_factor", "picture_drop_factor", "within_s", "bright_for_s", "smooth_s", "least_lux"),
)
_Written = TypeVar("_Written")


def run_on_session(
    session_file: Path,
    job_of: Callable[..., Callable[[Progress], _Written]],
    options: Mapping[str, Any],
) -> _Written:
    """Run a job over a session with the flags that were given, and show how far it is.

    Parameters
    ----------
    job_of
        Takes the session and, by name, the arguments of `nvcore.api.driver_run.features_job`.
    """
    session = read_session(session_file, needs_system=False)
    with errors_of(session):
        with TerminalProgress(2 + len(session.systems)) as steps:
            job = job_of(
                session,
                settings=given_settings(options),
                part=part_from(options),
                n_threads=options["n_threads"],
                inputs=[session_file],
                loading=steps,
            )
        with ShareProgress() as progress:
            return job(progress)


def given_settings(options: Mapping[str, Any]) -> dict[str, Any]:
    """The settings among the flags that were given."""
    return {name: options[name] for name in _SETTINGS if options[name] is not None}
