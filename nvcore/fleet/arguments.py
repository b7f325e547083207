"""What the commands of the fleet, and their Python calls, are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, field
from typing import TYPE_CHECKING, Final

import click

from nvcore.arguments import INPUTS, OUTPUT, PathLike, argument, arguments
from nvcore.params import Params
from nvcore.progress import Progress, no_progress

if TYPE_CHECKING:
    from nvcore.fleet.scan import Engine
    from nvcore.fleet.store import Store

RUN: Final = "How it is run"
SELECTION: Final = "Selection"
FRAMES_PER_BATCH: Final = 100_000
"""A worker with so many frames takes some 0.9 GB, if there are 11 boxes in each."""


@arguments
class ScanArguments:
    """See `nvcore.scan`."""

    store: PathLike | Store
    out: PathLike = argument(
        OUTPUT,
        "Folder of the results: a path, or a URI such as s3://bucket/results.",
        metavar="URI",
    )
    _: KW_ONLY
    x: str = argument(
        INPUTS,
        "System X, by its name in the store: its newest version, or FIR@2, or FIR@name.",
        metavar="SYSTEM",
    )
    y: str = argument(INPUTS, "System Y, likewise.", metavar="SYSTEM")
    truth: str = argument(
        INPUTS, "The truth, likewise, such as truth@1.", default="truth", metavar="SOURCE"
    )
    params: Params | None = None
    frames: bool = argument(
        OUTPUT, "Keep the table with a row for each frame, too.", default=False, is_flag=True
    )
    workers: int | None = argument(
        RUN,
        "Processes on this machine. Default: one for each core and each free GB of memory.",
        default=None,
        type=click.IntRange(min=1),
    )
    frames_per_batch: int = argument(
        RUN,
        "Frames that a worker compares at a time. Smaller batches take less memory and lose less "
        "when a worker dies, larger ones make fewer files.",
        default=FRAMES_PER_BATCH,
        type=click.IntRange(min=1_000),
    )
    shard: str | None = argument(
        RUN,
        "In this process alone, beginning with its part of the batches: 17/300 is task 17 of an "
        "array job with 300 (counted from 0 or 1). A task ends when all batches are done; those of "
        "tasks that died are done by others.",
        default=None,
        metavar="I/N",
    )
    scheduler: str | None = argument(
        RUN, "Address of a Dask scheduler, whose workers do it.", default=None, metavar="ADDRESS"
    )
    keep: bool = argument(
        OUTPUT,
        "Keep what a later scan with another alpha, sigmoid or threshold of low similarity reuses, "
        "about as large as the boxes. Default: kept.",
        flag="--keep/--no-keep",
        default=True,
    )
    engine: Engine | None = None
    retry: bool = argument(
        RUN,
        "Try again the recordings that are in quarantine.",
        default=False,
        is_flag=True,
    )
    storage: Mapping[str, str] = field(default_factory=dict)
    progress: Progress = no_progress


@arguments
class TopArguments:
    """See `nvcore.top`."""

    results: PathLike
    _: KW_ONLY
    table: str = argument(
        SELECTION,
        "Which results: encounters, events, intervals, episodes, recordings, or frames where the "
        "scan has kept them.",
        default="encounters",
        metavar="TABLE",
    )
    by: str | None = argument(
        SELECTION,
        "A column, with or without its unit and the letter of a system: severity is the larger one "
        "of both. Default: severity; saliency of events, depth of intervals, duration of episodes, "
        "similarity of frames.",
        default=None,
        metavar="COLUMN",
    )
    where: str = argument(
        SELECTION,
        "Only rows for which this holds, such as \"tag.road = 'rural' and n_frames > 10\" "
        "(docs/fleet.md).",
        default="",
        metavar="CONDITION",
    )
    n: int = argument(
        SELECTION, "Number of rows.", flag="-n", default=20, type=click.IntRange(min=1), metavar="N"
    )
    reverse: bool = argument(SELECTION, "The best first.", default=False, is_flag=True)
    storage: Mapping[str, str] = field(default_factory=dict)


@arguments
class OpenArguments:
    """See `nvcore.export_recording`."""

    source: PathLike
    recording: str
    out: PathLike | None = argument(
        OUTPUT,
        "Write the recording as a session into this folder, and start nothing.",
        default=None,
        metavar="DIR",
    )
    _: KW_ONLY
    force: bool = argument(OUTPUT, "Replace files of that folder.", default=False, is_flag=True)
    x: str | None = argument(
        INPUTS,
        "System X of a store, as for scan. Default: those of the scan, or the recording's only two "
        "systems.",
        default=None,
        metavar="SYSTEM",
    )
    y: str | None = argument(INPUTS, "System Y, likewise.", default=None, metavar="SYSTEM")
    truth: str | None = argument(INPUTS, "The truth, likewise.", default=None, metavar="SOURCE")
    storage: Mapping[str, str] = field(default_factory=dict)
