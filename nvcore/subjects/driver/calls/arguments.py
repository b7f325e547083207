"""Arguments of the API calls and commands on the driver's view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.common.arguments import (
    FILE,
    FOLDER,
    INPUTS,
    OUTPUT,
    Part,
    PathLike,
    argument,
    arguments,
)
from nvcore.common.progress import Progress, no_progress

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.inputs.session import Session
    from nvcore.subjects.driver.trials import Judging

VIEW: Final = "What is seen"
SEARCH: Final = "Search"


@arguments
class _RunArguments(Part):
    """Arguments that picture features and the estimates based on them share.

    Attributes
    ----------
    source
        A session file, a session, or a dataset made by `load`. It names the visible-light pictures
        of each recording, its light meter and gaze file, and may have no system.
    settings
        Values that the paper leaves open, by name (docs/driver-reference.md): ``surround``,
        ``drop_factor``, ... ``fixation`` is the assumed point as shares of the picture, with (0.5,
        0.5) in its middle.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`; then
        nothing is written.
    """

    source: PathLike | Session | Dataset
    _: KW_ONLY
    settings: Mapping[str, Any] | None = None
    n_threads: int | None = argument(
        VIEW,
        "Pictures at a time. Default: as many as there are cores.",
        flag="--threads",
        default=None,
        type=click.IntRange(1, 256),
    )
    progress: Progress = no_progress


@arguments
class FeatureArguments(_RunArguments):
    """Arguments of `nvcore.driver_features`."""

    out: PathLike = argument(
        OUTPUT,
        "Write features.csv and driver.json into this folder; of --images the features into this "
        "file, and how they were made beside it.",
        type=click.Path(path_type=Path),
        metavar="DIR|FILE",
    )


@arguments
class EstimateArguments(_RunArguments):
    """Arguments of `nvcore.estimate_driver`."""

    model: PathLike = argument(
        INPUTS,
        "An estimator that nvcore driver train wrote (.npz), or sample: that of the sample's "
        "simulated observer.",
        type=FILE,
    )
    out: PathLike = argument(
        OUTPUT,
        "Write detectability.csv, features.csv, driver.json, and session.toml into this folder.",
        type=FOLDER,
    )
    _: KW_ONLY
    interpolate: bool = argument(
        INPUTS,
        "Between the estimators of the adaptation periods before and after. Default: that of the "
        "nearest.",
        default=False,
        is_flag=True,
    )


@arguments
class TrialArguments:
    """Arguments that training and evaluation on trials with people share.

    Attributes
    ----------
    trials
        CSV file with one row per picture shown to a subject (docs/driver-reference.md).
    features
        CSV file with ``image,pedestrian`` and the eight features of each pedestrian.
    judging
        Criterion for a correct response. None: a square of 200 px around the touch overlaps the
        middle half of the pedestrian.
    progress
        Same as in `driver_features`.
    """

    trials: PathLike
    features: PathLike = argument(
        INPUTS,
        "Features of the pictures, as nvcore driver features --images writes them (CSV).",
        type=FILE,
    )
    _: KW_ONLY
    boxes: PathLike | None = argument(
        INPUTS,
        "Where the pedestrians are: image,pedestrian,x,y,w,h (CSV). Default: the columns x,y,w,h "
        "of the features.",
        default=None,
        type=FILE,
    )
    judging: Judging | None = None
    leave_out: Sequence[str] = argument(
        INPUTS,
        "Without the responses of this subject; {again}.",
        default=(),
        multiple=True,
        metavar="SUBJECT",
    )
    quick: bool = argument(
        SEARCH,
        "Try fewer settings, for a first look: a tenth of the time.",
        default=False,
        is_flag=True,
    )
    seed: int = argument(
        SEARCH,
        "Of all that is drawn at random: the same seed gives the same result.",
        default=0,
        type=click.IntRange(0, 2**32 - 1),
    )
    n_threads: int | None = argument(
        SEARCH,
        "Regressions at a time. Default: as many as there are cores.",
        flag="--threads",
        default=None,
        type=click.IntRange(1, 256),
    )
    progress: Progress = no_progress


@arguments
class TrainArguments(TrialArguments):
    """Arguments of `nvcore.train_driver`."""

    out: PathLike = argument(
        OUTPUT,
        "Write the model into this file (.npz).",
        type=click.Path(path_type=Path),
        metavar="FILE",
    )
    _: KW_ONLY
    name: str | None = None


@arguments
class EvaluateArguments(TrialArguments):
    """Arguments of `nvcore.evaluate_driver`."""

    out: PathLike | None = argument(
        OUTPUT, "Write the tables into this folder (CSV).", default=None, type=FOLDER
    )
    _: KW_ONLY
    html: PathLike | None = argument(
        OUTPUT,
        "Write figures and tables as one HTML page.",
        default=None,
        type=FILE,
        metavar="FILE.html",
    )
