"""Arguments of `nvcore.detect` and `nvcore.train`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, get_args

import click

from nvcore.common.arguments import (
    FACTS,
    FOLDER,
    FRAMES,
    INPUTS,
    OUTPUT,
    Part,
    PathLike,
    argument,
    arguments,
    pairs_of,
)
from nvcore.common.errors import ParameterError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import listed

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.dataset.provenance import Setting
    from nvcore.inputs.session import Session

DETECTOR: Final = "Detector"
SYSTEM: Final = "System"
MODEL: Final = "Model"
HELD_OUT: Final = "Held out"
FOLDERS: Final = "Folders of pictures"

Preset = Literal["pedestrians", "signs", "as-in-report"]
SplitBy = Literal["auto", "object", "recording", "time"]

_PathTo: Final = click.Path(exists=True, file_okay=False, path_type=Path)


@arguments
class DetectArguments(Part):
    """Arguments of a detector run. See `nvcore.detect`."""

    source: PathLike | Session | Dataset
    detector: PathLike = argument(
        DETECTOR,
        "hog, hog:daimler, icf:sample, or a model: one that was trained here (.npz) or an ONNX "
        "file (.onnx).",
        metavar="NAME|FILE",
    )
    out: PathLike = argument(
        OUTPUT,
        "Write the boxes, how they were made, and session.toml into this folder.",
        type=FOLDER,
    )
    _: KW_ONLY
    settings: Mapping[str, Setting | Sequence[Setting]] | None = argument(
        DETECTOR,
        "A setting of the detector, such as upscale=2; {again}. nvcore models NAME or "
        "FILE lists them.",
        flag="--set",
        default=None,
        multiple=True,
        metavar="KEY=VALUE",
        callback=pairs_of,
    )
    trained_on: str | Sequence[str] = argument(
        DETECTOR,
        "A recording, or frames of it (urban_01=0:399), on which the model was trained, where it "
        "does not say so itself; {again}.",
        default=(),
        multiple=True,
        metavar="RECORDING[=F:L]",
    )
    name: str | None = argument(
        SYSTEM, "Name of the new system. Default: the detector's.", default=None, metavar="NAME"
    )
    threshold: float | None = argument(
        SYSTEM, "Its score threshold. Default: the detector's.", default=None, type=float
    )
    against: str | None = argument(
        SYSTEM,
        "The system that it is compared with, as X. Default: the session's X.",
        default=None,
        metavar="SYSTEM",
    )
    n_threads: int | None = argument(
        DETECTOR,
        "Pictures at a time, each in one thread; with 1 a picture may take all cores. Default: as "
        "many as there are cores.",
        flag="--threads",
        default=None,
        type=click.IntRange(1, 256),
    )
    progress: Progress = no_progress


@arguments
class TrainArguments(Part):
    """Arguments of a training. See `nvcore.train`. Raise ParameterError for impossible values."""

    source: PathLike | Session | Dataset | None
    out: PathLike = argument(
        OUTPUT,
        "Write the model into this file (.npz).",
        type=click.Path(path_type=Path),
        metavar="FILE",
    )
    _: KW_ONLY
    frames: str | range | None = argument(
        FACTS,
        f"Only these of the evaluated frames: {FRAMES} Default: the session's.",
        default=None,
        metavar="FILE|F:L[:S]",
    )
    every: int | None = argument(
        INPUTS,
        "Only every Nth evaluated frame, neighbours being much alike. Default: so many that 5,000 "
        "boxes are learned at most.",
        default=None,
        type=click.IntRange(1),
        metavar="N",
    )
    least_height: float | None = argument(
        INPUTS,
        "Boxes lower than so many px are neither learned nor background. Default: those that the "
        "smallest scale is too large for.",
        default=None,
        type=click.FloatRange(0),
        metavar="PX",
    )
    crops: PathLike | None = argument(
        FOLDERS,
        "Folder of pictures with an object in the middle, or with those that its boxes.csv lists "
        "(file,x,y,w,h, and class if there are several: the model then says which a box is).",
        default=None,
        type=_PathTo,
        metavar="DIR",
    )
    crop_share: float | None = argument(
        FOLDERS,
        "Share of a crop's height that its object takes. Default: as in the window.",
        default=None,
        type=float,
    )
    background: PathLike | None = argument(
        FOLDERS, "Folder of pictures without an object.", default=None, type=_PathTo, metavar="DIR"
    )
    hold_out: str | Sequence[str] = argument(
        HELD_OUT, "This recording; {again}.", default=(), multiple=True, metavar="RECORDING"
    )
    split: SplitBy = argument(
        HELD_OUT,
        "Without {hold_out}: by physical object (tracks of the truth), by recording, or the end of "
        "each recording (time); auto: the first that is possible.",
        default="auto",
        type=click.Choice(get_args(SplitBy)),
    )
    share: float = argument(HELD_OUT, "Of the objects, the recordings or the time.", default=0.1)
    gap: int = argument(
        HELD_OUT,
        "Frames before the held-out end of a recording that are left out.",
        default=20,
        type=click.IntRange(0),
        metavar="N",
    )
    preset: Preset | None = argument(
        MODEL,
        "Settings to start from. Default: signs where the session is of speed signs, else "
        "pedestrians.",
        default=None,
        type=click.Choice(get_args(Preset)),
    )
    settings: Mapping[str, Setting | Sequence[Setting]] | None = argument(
        MODEL,
        "A setting of the detector, such as stride=6 or scales=1,1.2,1.4; {again}. "
        "nvcore models icf explains them all.",
        flag="--set",
        default=None,
        multiple=True,
        metavar="KEY=VALUE",
        callback=pairs_of,
    )
    name: str | None = argument(
        MODEL, "Name of the model. Default: that of its file.", default=None, metavar="NAME"
    )
    seed: int = argument(
        MODEL,
        "Of all that is drawn at random: the same seed gives the same file.",
        default=0,
        type=click.IntRange(0),
    )
    progress: Progress = no_progress

    def __post_init__(self) -> None:
        if self.split not in get_args(SplitBy):
            expected = listed(get_args(SplitBy))
            raise ParameterError(f"split: expected one of {expected}, got {self.split!r}")
        if self.every is not None and self.every < 1:
            raise ParameterError(f"every: expected 1 or more frames, got {self.every}")
        if self.gap < 0:
            raise ParameterError(f"gap: expected 0 or more frames, got {self.gap}")
        if not 0 < self.share < 1:
            raise ParameterError(f"share: expected more than 0 and less than 1, got {self.share:g}")
        if self.least_height is not None and not self.least_height >= 0:
            raise ParameterError(f"least_height: expected 0 px or more, got {self.least_height:g}")
